//! A folder of synthetic results: every part of a report has data, and all data follows from formulas.

use std::collections::BTreeMap;
use std::path::Path;

use caustics::output::png;
use caustics_bench::error::{FLIP, FLIP_CAUSTICS, RELMSE, RELMSE_CAUSTICS};
use caustics_bench::parameter::{
    DENOISER, FEATURES, GATHER, HISTORY, MAX_BOUNCES, METHOD, PATHS_PER_PIXEL, RADIUS_PX, RUNNER,
};
use caustics_bench::result::{
    ConfigValues, ErrorResult, FrameResult, Provenance, Quartiles, RunResult, TimeResult,
};
use glam::Vec3;

/// A name that is markup unless it is escaped.
pub const ROUGH: &str = "moving <b> & \"glass\"";
/// Size of the images (px).
const SIZE: (u32, u32) = (240, 135);

/// Method, gather, history, time (ms) at one path a pixel, error at one path a pixel.
const CONFIGURATIONS: [(&str, &str, &str, f64, f64); 7] = [
    ("kim2019", "photons-grid", "none", 24.0, 0.21),
    ("basic", "photons-grid", "none", 25.0, 0.16),
    ("basic", "points-grid", "none", 21.0, 0.16),
    ("basic", "points-grid", "paper", 22.5, 0.12),
    ("basic", "points-grid", "validated", 23.0, 0.10),
    ("progressive", "photons-grid", "none", 26.0, 0.14),
    ("yang2021", "photons-grid", "none", 38.0, 0.13),
];

/// Writes the results of two scenes into `folder/cells` and returns them.
pub fn write(folder: &Path) -> Vec<RunResult> {
    let mut runs = Vec::new();
    for (scene, is_moving) in [("mirror-room", false), (ROUGH, true)] {
        for (method, gather, history, ms, error) in CONFIGURATIONS {
            for paths in [0.25, 0.5, 1.0, 2.0, 4.0] {
                runs.push(run(scene, [method, gather, history, "scene"], paths, ms, error, is_moving));
            }
        }
        runs.push(run(scene, ["basic", "photons-grid", "none", "all"], 1.0, 29.0, 0.16, false));
        runs.push(run(scene, ["basic", "points-grid", "none", "all"], 1.0, 25.0, 0.16, false));
        runs.push(run(scene, ["path", "", "none", "scene"], 0.0, 60.0, 0.42, is_moving));
    }
    for run in &mut runs {
        save(folder, run);
    }
    runs
}

/// Result of a run configuration whose time grows with its paths and whose error falls with them.
fn run(scene: &str, names: [&str; 4], paths: f64, ms: f64, error: f64, is_moving: bool) -> RunResult {
    let [method, gather, history, features] = names;
    let total = if paths == 0.0 { ms } else { 30.0 + ms * paths };
    let flip = if paths == 0.0 { error } else { error * paths.powf(-0.28) };
    let quartiles = |median: f64| Quartiles { lower: 0.97 * median, median, upper: 1.05 * median };
    let mut pass_ms = BTreeMap::from([
        ("collect".to_string(), quartiles(0.9 * total.min(28.0))),
        ("resolve".to_string(), quartiles(1.2)),
        ("display".to_string(), quartiles(0.1)),
    ]);
    if paths > 0.0 {
        let light = total - 0.9 * total.min(28.0) - 1.3;
        for (pass, share) in
            [("shoot.store", 0.6), ("grid.size", 0.05), ("grid.fill", 0.1), ("gather.photons_grid", 0.25)]
        {
            pass_ms.insert(pass.into(), quartiles(share * light));
        }
    }
    let frames = (0..24).filter(|_| is_moving && paths <= 1.0).map(|frame| {
        let turn = (f64::from(frame) * 0.4).sin();
        let flip = Some(flip * (1.0 + 0.2 * turn + f64::from(u8::from(history == "paper" && frame == 12))));
        let values = [(FLIP.key.to_string(), flip), (FLIP_CAUSTICS.key.to_string(), None)].into();
        FrameResult { frame, total_ms: Some(total * (1.0 + 0.05 * turn)), values }
    });
    let mut config = ConfigValues::new(scene, "main");
    config.texture_filter = "cone".into();
    for (parameter, value) in [
        (&METHOD, method),
        (&GATHER, gather),
        (&HISTORY, history),
        (&DENOISER, "none"),
        (&RUNNER, "cpu"),
        (&FEATURES, features),
        (&PATHS_PER_PIXEL, &paths.to_string()),
        (&RADIUS_PX, "1"),
        (&MAX_BOUNCES, "5"),
    ] {
        config.set(parameter, value);
    }
    let of_light = |value: f64| (paths > 0.0).then_some(value);
    RunResult {
        identity: format!("{:016x}", hash(&format!("{scene}{names:?}{paths}"))),
        config,
        time: Some(TimeResult {
            width: 1920,
            height: 1080,
            light_paths: (paths * 1920.0 * 1080.0) as u32,
            triangles: 12_345,
            frames: 9,
            total_ms: quartiles(total),
            ratio_to_first: (paths == 1.0).then(|| if method == "kim2019" { 1.0 } else { total / 54.0 }),
            first: "kim2019".into(),
            pass_ms,
            rays: 4.5e6 + 1.6 * paths * 1920.0 * 1080.0,
            rays_per_s: 9.1e6,
            points_per_s: of_light(6.2e6),
            light_paths_per_s: of_light(1.9e6),
            memory_bytes: BTreeMap::from([("points".into(), 33_177_600), ("photons".into(), 16_000_000)]),
            costs: BTreeMap::new(),
        }),
        error: Some(ErrorResult {
            width: 480,
            height: 270,
            light_paths: (paths * 480.0 * 270.0) as u32,
            seeds: 4,
            reference_frames: 256,
            values: [
                (&FLIP, Some(flip)),
                (&FLIP_CAUSTICS, of_light(0.6 * flip)),
                (&RELMSE, Some(4.0 * flip * flip)),
                (&RELMSE_CAUSTICS, None),
            ]
            .map(|(measure, value)| (measure.key.to_string(), value))
            .into(),
            ..ErrorResult::default()
        }),
        frames: frames.collect(),
        note: None,
        provenance: Provenance {
            commit: "0123abc".into(),
            kernels: "8f3c5b7a90d1e2f4".into(),
            device: "CPU, 2 threads".into(),
            machine: "Some CPU, 2 threads, 16.0 GiB, Debian GNU/Linux 12, x86_64, rustc 1.95.0".into(),
            seed: 0,
            wall_s: 12.5,
            unix_s: 1_790_000_000 + (paths * 600.0) as u64,
        },
    }
}

fn hash(text: &str) -> u64 {
    text.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Writes a result and its images; results of 0.25 paths have no images.
pub fn save(folder: &Path, run: &mut RunResult) {
    let results = folder.join("cells");
    std::fs::create_dir_all(&results).unwrap();
    if let Some(error) = &mut run.error
        && run.config.number(&PATHS_PER_PIXEL) != 0.25
    {
        let noise = error.get(&FLIP).unwrap_or(0.1) as f32;
        let turn = if run.config.scene == ROUGH { 0.8 } else { 0.0 };
        // Configurations that differ only in features give the same bits.
        let [method, history] = [&METHOD, &HISTORY].map(|parameter| run.config.text(parameter));
        let seed = hash(&format!("{method}{history}{}", run.config.number(&PATHS_PER_PIXEL)));
        let id = &run.identity;
        let write = |name: String, colors: &dyn Fn(u32, u32) -> Vec3| {
            let (width, height) = SIZE;
            let colors: Vec<Vec3> =
                (0..width * height).map(|pixel| colors(pixel % width, pixel / width)).collect();
            std::fs::write(results.join(&name), png::encode(width, height, &colors).unwrap()).unwrap();
            Some(name)
        };
        let grain = |x: u32, y: u32| {
            let bits = (seed ^ u64::from(y * SIZE.0 + x)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            noise * ((bits >> 40) as f32 / 8_388_608.0 - 1.0)
        };
        error.reference = write(format!("{id}-reference.png"), &|x, y| room(x, y, turn));
        error.image = write(format!("{id}.png"), &|x, y| {
            (room(x, y, turn) * (1.0 + 2.0 * grain(x, y))).clamp(Vec3::ZERO, Vec3::ONE)
        });
        error.error_map = write(format!("{id}-flip.png"), &|x, y| {
            let t = (5.0 * grain(x, y).abs()).min(1.0);
            Vec3::new(t, t * t * 0.8, 0.3 * t)
        });
    }
    let path = results.join(format!("{}.json", run.identity));
    std::fs::write(path, serde_json::to_vec_pretty(run).unwrap()).unwrap();
}

/// Radiance of a wall, a floor, and a bright cusp on the floor.
fn room(x: u32, y: u32, turn: f32) -> Vec3 {
    let (u, v) = (x as f32 / SIZE.0 as f32 * 2.0 - 1.0, y as f32 / SIZE.1 as f32);
    let (warm, cool) = (Vec3::new(0.62, 0.55, 0.47), Vec3::new(0.35, 0.38, 0.42));
    if v < 0.45 {
        return cool * (0.7 + 0.3 * v) * (1.0 - 0.4 * u.abs());
    }
    let depth = (v - 0.45) / 0.55;
    let bend = u - 0.25 * turn;
    let cusp = (-(depth - 0.3 - 1.5 * bend.abs().powf(0.667)).powi(2) * 220.0).exp();
    let glow = (-(bend * bend * 6.0 + (depth - 0.5).powi(2) * 4.0)).exp();
    (warm * (0.35 + 0.4 * depth) + Vec3::new(1.0, 0.93, 0.78) * (0.75 * cusp + 0.18 * glow)).min(Vec3::ONE)
}
