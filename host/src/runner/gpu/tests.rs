//! Tests of the GPU runner on any available Vulkan device, with the validation layer if it is installed.

use caustics_kernels::declare::{Pass, Work};
use caustics_kernels::interface::frame::{Dispatch, FrameParams};

use rspirv::binary::Assemble;
use rspirv::dr::Operand;

use super::*;
use crate::vulkan::{devices, test_module};

const COUNT: usize = 1000;
const FEATURES: Features = Features(100);

/// Returns the input of a structure over this number of triangles.
fn world(triangles: u32) -> Instanced {
    Instanced::for_world(triangles as usize)
}

/// Opens a runner over `values`, `doubled` and `index_0`. `None` if the test is to be skipped.
fn runner(hardware: bool, tables: &[(&'static str, &[u8])], triangles: u32) -> Option<GpuRunner> {
    open(hardware, COUNT, tables, triangles)
}

fn open(hardware: bool, count: usize, tables: &[(&'static str, &[u8])], triangles: u32) -> Option<GpuRunner> {
    let buffers = [("values", 4 * count), ("doubled", 4 * count), ("index_0", 24 * count), ("no_lights", 0)];
    let buffers = buffers.map(|(name, bytes)| BufferSpec { name, bytes });
    let open = |validation| {
        let (base, rayquery) = (test_module::base(), Some(test_module::rayquery()));
        let options = DeviceOptions { device: None, hardware, validation, base, rayquery };
        GpuRunner::new(&options, FEATURES, &buffers, tables, &world(triangles))
    };
    let opened = match open(true) {
        Err(error @ VulkanError::NoValidationLayer) => {
            eprintln!("without validation: {error}");
            open(false)
        }
        opened => opened,
    };
    match opened {
        Err(error) if error.is_no_device() => {
            test_module::skip(&error);
            None
        }
        opened => Some(opened.unwrap()),
    }
}

fn dispatch(name: &'static str, count: usize) -> Step {
    let pass = Pass { name, work: Work::Step, traces: false, over: |_| 0, buffers: &[], cpu: None };
    let dispatch = Dispatch { first: 1000, count: count as u32, ..Dispatch::default() };
    Step::dispatch(Box::leak(Box::new(pass)), dispatch)
}

fn run(runner: &mut GpuRunner, steps: &[Step]) -> Result<Vec<StepTime>, RunError> {
    runner.run(&FrameParams::default(), steps)
}

fn build(count: usize) -> Step {
    Step::Structure { side: Side::Points, count: count as u32 }
}

fn read(runner: &mut GpuRunner, buffer: &str) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(&runner.read(buffer).unwrap())
}

#[test]
fn devices_are_listed_or_the_reason_is_given() {
    match devices() {
        Ok(devices) => {
            for device in devices {
                eprintln!("{device:?}");
            }
        }
        Err(error) => assert!(error.is_no_device(), "{error}"),
    }
}

#[test]
fn steps_run_in_order_over_buffers_bound_by_name() {
    let Some(mut runner) = runner(false, &[("triangles", &[])], 0) else { return };
    let steps = [dispatch("fill", COUNT), dispatch("twice", COUNT), Step::Clear { buffer: "values" }];
    let times = run(&mut runner, &steps).unwrap();
    if runner.context.info().timestamps {
        let passes: Vec<_> = times.iter().map(|time| time.pass.as_str()).collect();
        assert_eq!(passes, ["fill", "twice", "clear.values"]);
    }
    let doubled = read(&mut runner, "doubled");
    assert!(doubled.iter().enumerate().all(|(i, &value)| value == 2 * (i as u32 + 1000 + FEATURES.0)));
    assert_eq!(read(&mut runner, "values"), vec![0; COUNT]);
}

/// Returns the kernels of `test_module` with the names `fill` and `twice` exchanged.
fn exchanged() -> Vec<u32> {
    let mut module = rspirv::dr::load_words(test_module::base()).unwrap();
    for operand in module.entry_points.iter_mut().flat_map(|entry| &mut entry.operands) {
        if let Operand::LiteralString(name) = operand {
            *name = if name == "fill" { "twice".into() } else { "fill".into() };
        }
    }
    module.assemble()
}

#[test]
fn kernels_are_exchanged_and_unused_ones_are_released() {
    let Some(mut old) = runner(false, &[], 0) else { return };
    let buffers = ["values", "doubled"].map(|name| BufferSpec { name, bytes: 4 * COUNT });
    // Open two devices that no other test opens.
    let plain = DeviceOptions { device: Some("0".into()), ..DeviceOptions::default() };
    let [first, second] = [
        DeviceOptions { base: test_module::base(), ..plain.clone() },
        DeviceOptions { base: exchanged(), ..plain },
    ];
    let open = |options| GpuRunner::new(options, FEATURES, &buffers, &[], &world(0)).unwrap();
    let known = |options| Arc::downgrade(&Kernels::open(options).unwrap());

    // Run both side by side.
    let mut new = open(&second);
    run(&mut old, &[dispatch("fill", COUNT)]).unwrap();
    run(&mut new, &[dispatch("twice", COUNT), dispatch("fill", COUNT)]).unwrap();
    let values: Vec<u32> = (0..COUNT as u32).map(|i| i + 1000 + FEATURES.0).collect();
    assert_eq!(read(&mut old, "values"), values);
    assert_eq!(read(&mut new, "doubled"), values.iter().map(|value| 2 * value).collect::<Vec<_>>());

    let in_use = known(&second);
    let unused = known(&first);
    assert!(in_use.upgrade().is_some());
    drop(new);
    assert!(unused.upgrade().is_some(), "the last kernels are kept for the next runner");
    known(&second);
    assert!(unused.upgrade().is_none(), "older kernels are released");
    assert!(in_use.upgrade().is_some());
}

#[test]
fn indices_go_on_after_a_row_of_workgroups() {
    let count = crate::vulkan::pipeline::INVOCATIONS_PER_ROW as usize + 100;
    let Some(mut runner) = open(false, count, &[], 0) else { return };
    let start = std::time::Instant::now();
    let times = run(&mut runner, &[dispatch("fill", count)]).unwrap();
    assert!(!times[0].time.is_zero() && times[0].time <= start.elapsed(), "{times:?}");
    let values = read(&mut runner, "values");
    assert!(values.iter().enumerate().all(|(i, &value)| value == i as u32 + 1000 + FEATURES.0));
}

#[test]
fn written_bytes_are_read_back() {
    let table: Vec<u32> = (0..100).collect();
    let Some(mut runner) = runner(false, &[("table", bytemuck::cast_slice(&table))], 0) else { return };
    assert_eq!(read(&mut runner, "table"), table);
    assert!(read(&mut runner, "no_lights").is_empty());
    runner.write("values", bytemuck::cast_slice(&[5u32, 6])).unwrap();
    assert_eq!(read(&mut runner, "values")[..3], [5, 6, 0]);
}

#[test]
fn errors_name_the_buffer_and_the_pass() {
    let Some(mut runner) = runner(false, &[], 0) else { return };
    let message = |result: Result<Vec<StepTime>, RunError>| result.unwrap_err().to_string();
    assert!(message(run(&mut runner, &[dispatch("shoot", 1)])).contains("`shoot`; there are: fill, twice"));
    assert!(message(run(&mut runner, &[Step::Clear { buffer: "texels" }])).contains("`texels`"));
    assert!(message(run(&mut runner, &[build(1)])).contains("build.points"));
    assert!(runner.write("no_lights", &[1]).unwrap_err().to_string().contains("`no_lights` of 0 bytes"));

    let options = || DeviceOptions { base: test_module::base(), ..DeviceOptions::default() };
    let huge = [BufferSpec { name: "texels", bytes: 1 << 40 }];
    let error =
        GpuRunner::new(&options(), FEATURES, &huge, &[], &Instanced::default()).err().unwrap().to_string();
    assert!(error.contains("`texels` needs 1099511627776 bytes"), "{error}");
    let mut unbound = GpuRunner::new(&options(), FEATURES, &[], &[], &Instanced::default()).unwrap();
    assert!(message(run(&mut unbound, &[dispatch("fill", 1)])).contains("`fill` binds `values`"));
    let other = DeviceOptions { device: Some("no such device".into()), ..options() };
    assert!(GpuRunner::new(&other, FEATURES, &[], &[], &Instanced::default()).err().unwrap().is_no_device());
}

#[test]
fn ray_queries_find_triangles_and_boxes() {
    // Put a triangle before every third ray, a box around every second.
    let corner = |x: usize| [[x as f32, 0.0, 0.0], [x as f32 + 1.5, 0.0, 0.0], [x as f32, 2.0, 0.0]];
    let triangles: Vec<_> = (0..COUNT).step_by(3).map(corner).collect();
    let boxes: Vec<_> =
        (0..COUNT / 2).map(|i| [2.0 * i as f32, 0.0, 0.0, 2.0 * i as f32 + 1.0, 1.0, 1.0]).collect();
    let table: &[u8] = bytemuck::cast_slice(&triangles);
    let Some(mut runner) = runner(true, &[("triangles", table)], triangles.len() as u32) else { return };

    // With ray queries the second module is used: its `fill` writes 7.
    run(&mut runner, &[dispatch("fill", COUNT)]).unwrap();
    assert_eq!(read(&mut runner, "values"), vec![7; COUNT]);

    run(&mut runner, &[dispatch("trace.scene", COUNT)]).unwrap();
    let expected: Vec<_> = (0..COUNT).map(|i| u32::from(i % 3 == 0)).collect();
    assert_eq!(read(&mut runner, "values"), expected);

    // Rebuild in the same storage.
    let empty = vec![0; COUNT];
    runner.write("index_0", bytemuck::cast_slice(&boxes)).unwrap();
    run(&mut runner, &[build(0), dispatch("trace.points", COUNT)]).unwrap();
    assert_eq!(read(&mut runner, "values"), empty);
    for count in [COUNT / 2, 10, 0, COUNT / 2] {
        run(&mut runner, &[build(count), dispatch("trace.points", COUNT)]).unwrap();
        let expected: Vec<_> = (0..COUNT).map(|i| 16 * u32::from(i % 2 == 0 && i / 2 < count)).collect();
        assert_eq!(read(&mut runner, "values"), expected, "{count} boxes");
    }
    let error = run(&mut runner, &[build(COUNT + 1)]).unwrap_err();
    assert!(error.to_string().contains("1001 primitives, but at most 1000"));

    // The validation layer also reports leaks.
    let messages = runner.context.messages().clone();
    drop(runner);
    messages.check().unwrap();
}
