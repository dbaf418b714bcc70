//! Counters of a frame, from the kernels.

use std::collections::BTreeMap;

use caustics_kernels::interface::counters::{COUNTER_NAMES, Counter};

/// Number of light paths per photon above which caustics starve. At the default of 2^20 light paths a frame has a hundred
/// photons then. This is a noise of 10 % even where one pixel takes all of them.
const PATHS_PER_PHOTON: u64 = 10_000;
/// Number of light paths below which too few photons may be a random event.
const STARVING_PATHS: u64 = 1 << 16;

/// Counters of one or more frames, by name.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(transparent)]
pub struct Counters(BTreeMap<&'static str, u64>);

impl Counters {
    /// Reads the counters from the words of the buffer `counters`.
    pub fn from_words(words: &[u32]) -> Counters {
        let value = |slot: Counter| words.get(slot as usize).copied().unwrap_or(0);
        Counters(COUNTER_NAMES.iter().map(|&(slot, name)| (name, u64::from(value(slot)))).collect())
    }

    /// Returns the value of a counter.
    pub fn get(&self, counter: Counter) -> u64 {
        let name = COUNTER_NAMES.iter().find(|(slot, _)| *slot == counter).map(|(_, name)| *name);
        name.and_then(|name| self.0.get(name).copied()).unwrap_or(0)
    }

    /// Adds the counters of another frame.
    pub fn add(&mut self, other: &Counters) {
        for (name, value) in &other.0 {
            *self.0.entry(name).or_default() += value;
        }
    }

    /// Returns warnings for the user.
    pub fn warnings(&self) -> Vec<String> {
        let faults = [
            (Counter::PhotonsDropped, "photons found no room and are missing"),
            (Counter::Clamped, "addends were clamped by the accumulator"),
            (Counter::NonFinite, "non-finite values were left out"),
            (Counter::MediaOverflow, "paths were inside more than four nested media"),
            (
                Counter::UnexpectedFaces,
                "times a path met the back of a medium that it was not in: is a mesh open?",
            ),
        ]
        .iter()
        .filter(|(counter, _)| self.get(*counter) > self.tolerated(*counter))
        .map(|(counter, what)| format!("{} {what}", self.get(*counter)));
        faults.chain(self.starvation()).collect()
    }

    /// Returns a warning if caustics starve: casters, receivers and lights exist, but too few light paths reach a receiver
    /// through a caster.
    fn starvation(&self) -> Option<String> {
        let (paths, photons) = (self.get(Counter::LightPaths), self.get(Counter::Photons));
        let starves = paths >= STARVING_PATHS && photons * PATHS_PER_PHOTON < paths;
        starves.then(|| {
            format!(
                "caustics starve: {photons} photons of {paths} light paths; give more --light-paths, make the scene \
                 smaller around what casts caustics (a directional light shines on all of its bounds), or, where walls \
                 light what casts them, take --caustics any"
            )
        })
    }

    /// Returns the maximum value of a counter without a warning. For one ray in a hundred thousand, rounding at an edge
    /// lets a path leave a solid beside the face that it should meet.
    fn tolerated(&self, counter: Counter) -> u64 {
        if counter != Counter::UnexpectedFaces {
            return 0;
        }
        (self.get(Counter::CameraRays) + self.get(Counter::LightRays)) / 100_000
    }
}
