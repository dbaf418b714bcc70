//! Summary of a run configuration's timed frames: medians and quartiles, ratios to the first configuration, rates.

use std::collections::{BTreeMap, BTreeSet};

use caustics_kernels::declare::Work;

use super::memory::memory;
use super::plan::MeasurementPlan;
use super::record::FrameRecord;
use super::result::{Quartiles, TimeResult};
use super::run_config::RunConfig;
use caustics::metric::percentile::quantile;
use caustics::scene::Scene;
use caustics_kernels::method::frame::work;

/// Work of the camera.
const CAMERA: [Work; 3] = [Work::Camera, Work::Denoiser, Work::Display];
/// Work of the gather.
const GATHER: [Work; 2] = [Work::Index, Work::Gather];
/// Work that traces the counted rays.
const TRACERS: [Work; 2] = [Work::Camera, Work::Light];

/// Times of a run configuration, from the records of all that took turns; the scene is posed at the first frame. None
/// without timed frames.
pub fn time_result(
    plan: &MeasurementPlan,
    scene: &Scene,
    run: &RunConfig,
    first: &RunConfig,
    records: &[FrameRecord],
) -> Option<TimeResult> {
    let timed_frames = |run: &RunConfig| -> BTreeMap<u32, &FrameRecord> {
        let own = records.iter().filter(|record| record.run == run.name && record.get("total_ms").is_some());
        own.map(|record| (record.frame, record)).collect()
    };
    let (own, firsts) = (timed_frames(run), timed_frames(first));
    let total = |record: &FrameRecord| record.get("total_ms").unwrap_or_default();
    let totals: Vec<f64> = own.values().map(|record| total(record)).collect();
    let ratios: Vec<f64> =
        own.iter().filter_map(|(frame, record)| Some(total(record) / total(firsts.get(frame)?))).collect();

    let names: BTreeSet<&str> =
        own.values().flat_map(|record| record.passes().map(|(name, _)| name)).collect();
    // A pass that a frame skips takes no time in it.
    let times = |name: &str| -> Vec<f64> {
        own.values().map(|record| record.get(&format!("pass.{name}_ms")).unwrap_or(0.0)).collect()
    };
    let pass_ms = names.iter().map(|&name| Some((name.to_string(), quartiles(&times(name))?)));
    let pass_ms = pass_ms.collect::<Option<BTreeMap<_, _>>>()?;

    let mean =
        |name: &str| own.values().filter_map(|record| record.get(name)).sum::<f64>() / own.len() as f64;
    // Compute rates from medians, which disturbed frames do not change.
    let rate = |amount: f64, chosen: &dyn Fn(&str) -> bool| {
        let ms: f64 = pass_ms.iter().filter(|(name, _)| chosen(name)).map(|(_, ms)| ms.median).sum();
        (amount > 0.0 && ms > 0.0).then(|| 1e3 * amount / ms)
    };
    let is = |name: &str, kinds: &[Work]| work(name).is_some_and(|work| kinds.contains(&work));
    let config = run.config.with_image_of(&plan.config);
    let rays = mean("camera_rays") + mean("shadow_rays") + mean("light_rays");
    let points = own.values().find_map(|record| record.get("points")).unwrap_or(0.0);
    Some(TimeResult {
        width: config.width,
        height: config.height,
        light_paths: mean("light_paths") as u32,
        triangles: scene.triangles.len() as u64,
        frames: own.len() as u32,
        total_ms: quartiles(&totals)?,
        ratio_to_first: quartiles(&ratios).map(|ratio| ratio.median),
        first: first.name.clone(),
        rays,
        rays_per_s: rate(rays, &|name| is(name, &TRACERS)).unwrap_or(0.0),
        points_per_s: rate(points, &|name| is(name, &GATHER)),
        light_paths_per_s: rate(mean("light_paths"), &|name| !is(name, &CAMERA)),
        memory_bytes: memory(plan, run, scene)
            .into_iter()
            .flat_map(|memory| memory.buffers_bytes)
            .map(|(name, bytes)| (name.to_string(), bytes as u64))
            .collect(),
        pass_ms,
        costs: BTreeMap::new(),
    })
}

/// Median and quartiles; none without values.
pub fn quartiles(values: &[f64]) -> Option<Quartiles> {
    let at = |part| quantile(values, part);
    (!values.is_empty()).then(|| Quartiles { lower: at(0.25), median: at(0.5), upper: at(0.75) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Compared;
    use caustics::render_config::RenderConfig;
    use caustics_kernels::method::basic::BASIC;

    fn plan() -> MeasurementPlan {
        MeasurementPlan {
            config: RenderConfig { width: 40, height: 25, ..RenderConfig::default() },
            camera: String::new(),
            frames: 0..4,
            fps: 24.0,
            moment: Some(0.0),
            warm_up: 0,
            time: true,
            compared: Compared::Last,
            reference_pixel_filter: None,
            seeds: 1,
        }
    }

    fn record(run: &str, frame: u32, slow: f64) -> FrameRecord {
        let values = [
            ("total_ms", 11.0),
            ("pass.collect_ms", 4.0),
            ("pass.shoot.store_ms", 2.0),
            ("pass.index.photons_grid.fill_ms", 1.0),
            ("pass.gather.photons_grid_ms", 1.0),
            ("pass.resolve_ms", 1.0),
            ("pass.display_ms", 1.0),
        ];
        let times = values.map(|(name, ms)| (name.to_string(), ms * slow));
        let counts = [
            ("camera_rays", 2000.0),
            ("shadow_rays", 1000.0),
            ("light_rays", 3000.0),
            ("light_paths", 1000.0),
        ];
        let counts = counts.into_iter().chain((frame == 3).then_some(("points", 800.0)));
        let values = times.into_iter().chain(counts.map(|(name, count)| (name.to_string(), count))).collect();
        FrameRecord { frame, run: run.into(), values }
    }

    #[test]
    fn rates_are_those_of_the_passes_that_do_the_work() {
        let [first, other] =
            ["first", "other"].map(|name| RunConfig { name: name.into(), ..RunConfig::new(&BASIC) });
        let plan = plan();
        // The machine slows down by half in the last frame.
        let slow = [1.0, 1.0, 1.0, 1.5];
        let records: Vec<FrameRecord> = (0..4)
            .zip(slow)
            .flat_map(|(frame, slow)| [record("first", frame, 2.0 * slow), record("other", frame, slow)])
            .collect();
        let time = time_result(&plan, &Scene::default(), &other, &first, &records).unwrap();
        assert_eq!(time.total_ms, Quartiles { lower: 11.0, median: 11.0, upper: 12.375 });
        assert_eq!(time.ratio_to_first, Some(0.5));
        assert_eq!((time.rays, time.rays_per_s), (6000.0, 1e6), "6000 in collect and shoot");
        assert_eq!(time.points_per_s, Some(4e5), "800 in index and gather");
        assert_eq!(time.light_paths_per_s, Some(2e5), "1000 in shoot, index, gather and resolve");
        assert_eq!((time.light_paths, time.frames), (1000, 4));

        // Kim's method has no gather points.
        let records: Vec<FrameRecord> = records
            .into_iter()
            .map(|mut record| {
                record.values.retain(|name, _| !name.contains("gather") && !name.contains("index"));
                record.set("pass.splat.kim2019_ms", Some(1.0));
                record
            })
            .collect();
        let time = time_result(&plan, &Scene::default(), &other, &first, &records).unwrap();
        assert_eq!(time.points_per_s, None);
        assert!(time_result(&plan, &Scene::default(), &other, &first, &[]).is_none());
    }
}
