//! Provokes a panic in a kernel, for the CI step that looks for reports of panics. The test is ignored, since the committed
//! kernels end a panicking invocation without a report.

use bytemuck::{Zeroable, cast_slice};
use caustics::kernels::Source;
use caustics::runner::Runner;
use caustics::runner::gpu::GpuRunner;
use caustics::scene::Instanced;
use caustics::vulkan::passes::DeviceOptions;
use caustics_kernels::declare::buffers;
use caustics_kernels::gather::variant::POINTS_RT;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::point::PointGeometry;
use caustics_kernels::method::frame::{self as gather};

#[test]
#[ignore = "needs a GPU and kernels built by `cargo kernels --panics`"]
fn an_index_out_of_bounds_is_reported() {
    // One pixel, and an order of pixels that names pixel 1000. More reports would overflow the validation layer's buffer.
    let points = [PointGeometry::zeroed(); 64];
    let order = [1000_u32; 64];
    let tables: [(&'static str, &[u8]); 2] =
        [("pixel_order", cast_slice(&order)), ("point_geometry", cast_slice(&points))];
    let params = FrameParams { width: 1, height: 1, photon_capacity: 1, ..FrameParams::default() };
    let step = gather::prepare(&POINTS_RT, &params).remove(0);
    assert_eq!(step.label(), "index.points_rt.bound");
    let mut buffers = buffers(&[step], &params);
    buffers.retain(|spec| tables.iter().all(|(name, _)| *name != spec.name));
    // Turn on the validation layer, as in tests that must not panic.
    let base = Source::from_environment().modules().unwrap().base;
    let options = DeviceOptions { base, validation: true, ..DeviceOptions::default() };
    let mut runner =
        GpuRunner::new(&options, Features::ALL, &buffers, &tables, &Instanced::default()).unwrap();
    runner.run(&params, &[step]).unwrap();
}
