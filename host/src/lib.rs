//! caustics as a library: load a glTF scene, render frames on the CPU or on a Vulkan device, read their layers.
//!
//! ```no_run
//! # fn main() -> anyhow::Result<()> {
//! use caustics::{Scene, Session, output::exr, scene};
//!
//! let scene = Scene::load(&scene::resolve("mirror-room")?)?;
//! let mut session = Session::builder(&scene).build()?;
//! // Render the first frame.
//! session.frame(0)?;
//! let image = session.image()?;
//! std::fs::write("room.exr", exr::encode(&image, None, &Default::default())?)?;
//! # Ok(())
//! # }
//! ```
//!
//! | to | see |
//! |---|---|
//! | load a scene, move it to a time | [`Scene`] |
//! | add a camera, a light or a floor to a scene without one | [`scene::Staging`], [`Scene::place_camera`], [`Scene::add_default_light`] |
//! | choose runner, method and gather, render frames | [`Session`], [`SessionBuilder`], [`RenderConfig`] |
//! | exchange the compiled kernels of a GPU while a program runs | [`kernels::Source`], [`kernels::Watch`] |
//! | read the layers of a frame | [`RenderedImage`] |
//! | inspect a pixel: its camera path, its photons, their light paths | [`Session::inspect`], [`inspect::Inspection`] |
//! | average frames, with the variance of the mean | [`accumulation`] |
//! | denoise a finished image by Open Image Denoise | [`oidn`] |
//! | write EXR and PNG, read them | [`output`], [`image_file`] |
//! | compare images | [`metric`] |
//!
//! The first page of [`caustics_kernels`] describes the steps of a frame. All other modules serve the program `caustics`.
//! They are public for its binary and its tests, and change without notice.

#![cfg_attr(not(test), deny(clippy::print_stderr, clippy::print_stdout))]
#![deny(unsafe_code)]

pub mod accumulation;
pub mod checkpoint;
pub mod counters;
pub mod energy;
pub mod exposure;
mod frame_memory;
#[doc(hidden)]
pub mod fuzzing;
pub mod inspect;
pub mod kernels;
pub mod machine;
pub mod metric;
pub mod named;
#[allow(unsafe_code)]
pub mod oidn;
pub mod render_config;
pub mod runner;
pub mod session;
pub mod shard;
pub mod threads;
pub mod trace_rate;
pub mod upload;
#[allow(unsafe_code)]
pub mod vulkan;

mod builder;

pub use builder::SessionBuilder;
pub use caustics_files::{
    RenderedImage, exact, file, hash, image_file, memory, output, program, rendered_image, sealed, shell,
    text,
};
pub use caustics_kernels::{denoiser, gather, history, method};
pub use caustics_scene as scene;
pub use caustics_scene::{Scene, SceneCamera, SceneError};
pub use render_config::{Paths, Radius, RenderConfig};
pub use session::{RunnerChoice, Session, SessionError};
