//! Times and counters of a run.

use std::collections::BTreeMap;
use std::time::Duration;

use caustics::counters::Counters;
use caustics::energy::EnergyLedger;
use caustics::runner::StepTime;
use caustics_kernels::declare::Work;
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::method::frame::work;

/// Times and counters of all frames.
#[derive(Default)]
pub struct RunReport {
    frames: u32,
    /// Time of all frames.
    pub wall: Duration,
    passes: BTreeMap<String, Duration>,
    /// Counters of the kernels.
    pub counters: Counters,
    energy: EnergyLedger,
}

impl RunReport {
    /// Adds a frame.
    pub fn add(&mut self, times: &[StepTime], wall: Duration, counters: &Counters, energy: EnergyLedger) {
        self.frames += 1;
        self.wall += wall;
        for step in times {
            *self.passes.entry(step.pass.clone()).or_default() += step.time;
        }
        self.counters.add(counters);
        self.energy = self.energy.plus(energy);
    }

    /// Number of frames.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// Mean number of light paths per frame.
    pub fn light_paths(&self) -> u64 {
        self.counters.get(Counter::LightPaths) / u64::from(self.frames.max(1))
    }

    /// Mean time per frame (ms).
    pub fn frame_ms(&self) -> f64 {
        self.wall.as_secs_f64() * 1e3 / f64::from(self.frames.max(1))
    }

    /// Mean energy ledger per frame (W).
    pub fn energy(&self) -> EnergyLedger {
        self.energy.times(1.0 / f64::from(self.frames.max(1)))
    }

    /// Mean time of each pass per frame (ms).
    pub fn pass_ms(&self) -> BTreeMap<&str, f64> {
        let mean = |time: &Duration| time.as_secs_f64() * 1e3 / f64::from(self.frames.max(1));
        self.passes.iter().map(|(name, time)| (name.as_str(), mean(time))).collect()
    }

    /// Rates over the time of the passes that do the work (1/s).
    pub fn rates(&self, pixels: u64) -> BTreeMap<&'static str, f64> {
        let seconds = |kind: Work| -> f64 {
            let passes = self.passes.iter().filter(|(name, _)| work(name) == Some(kind));
            passes.map(|(_, time)| time.as_secs_f64()).sum()
        };
        let rate = |counters: &[Counter], kind: Work| {
            let count: u64 = counters.iter().map(|&counter| self.counters.get(counter)).sum();
            if count == 0 { 0.0 } else { count as f64 / seconds(kind) }
        };
        let samples = pixels as f64 * f64::from(self.frames);
        let mut rates = BTreeMap::from([
            ("camera_rays_per_s", rate(&[Counter::CameraRays, Counter::ShadowRays], Work::Camera)),
            ("camera_paths_per_s", if samples == 0.0 { 0.0 } else { samples / seconds(Work::Camera) }),
        ]);
        if self.passes.keys().any(|name| work(name) == Some(Work::Light)) {
            rates.insert("light_rays_per_s", rate(&[Counter::LightRays], Work::Light));
            rates.insert("light_paths_per_s", rate(&[Counter::LightPaths], Work::Light));
        }
        rates
    }
}
