//! The kernels of caustics: one source for SPIR-V (through rust-gpu) and for the CPU. This page is the method
//! [Moreau and Doggett 2022], step by step; each step links to its code.
//!
//! # The problem
//!
//! A *caustic* is light that a specular surface (glass, metal, a smooth coat) has focused. It is *indirectly visible* where the
//! viewer sees it by way of another specular surface: in a mirror, through glass. Paths from the camera find the small light
//! behind the glass only at random, and photons splatted onto the screen cannot be seen in mirrors. So paths are traced from
//! both ends, and meet where neither end is specular.
//!
//! # A frame
//!
//! ```text
//! camera ──► mirror ──► ● collection point        light ──► glass ──► ○ photon
//!           (prefix)    a disc of one pixel                (caster)   flux in W
//!
//! collect ──► index ──► shoot ──► gather ──► resolve ──► display
//! ```
//!
//! 1. **Collect** ([`pass::collect`]): from each pixel a camera path follows specular events, the *prefix*
//!    ([`path::camera_path::trace_camera_path`]), to its first vertex that is not specular. That vertex becomes the pixel's *collection point*
//!    ([`interface::point`]): a disc whose radius a ray cone gives ([`math::cone`]), so that it is about one pixel wide however
//!    it is seen. All light on the way that is no caustic is path traced in the same walk.
//! 2. **Denoise**, if asked for ([`denoiser`]): smooths that path-traced light. Caustics are not touched.
//! 3. **Reuse**, if there is a history ([`history`]): finds the point of the frame before that is this one's
//!    ([`history::window`], [`history::reprojected`]), and how much of its light still holds ([`history::cells`]).
//! 4. **Shoot** ([`pass::shoot`]): light paths leave the lights by power ([`light::power`], behind the trait of [`light::emit`]),
//!    or where earlier ones were seen to give the image something ([`light::guided`], [`emission::guided`]).
//!    Those whose first surface is a *caster* (specular) go on; each later hit on a *receiver* deposits a *photon*: a position, a
//!    direction, a flux.
//! 5. **Gather** ([`mod@gather`]): a point takes the photons that lie on its disc ([`gather::contribution`]). Points are indexed and
//!    each photon looks for them, or the other way round; every variant sums the same integers ([`gather::accumulator`]).
//! 6. **Resolve** ([`pass::resolve`], or [`history::resolve_history`]): summed flux through the area of the disc, times what the
//!    prefix lets through, is radiance.
//! 7. **Display** ([`pass::display`]): tone mapping for PNG files.
//!
//! [`method`] says which of these passes a frame consists of; [`method::path`] traces everything from the camera instead and is
//! what the others are tested against.
//!
//! # Who computes which light
//!
//! One function decides which lobes are specular ([`surface::class`]). Light that meets a specular lobe first, and then, by
//! whatever way, a collection point, belongs to the light paths; all else to the camera paths, which behind their point follow
//! every lobe, and find lights by those that are not specular ([`path::camera_path::CameraSuffix`]). So one thing decides a path, the lobe
//! next to the light: no path is counted twice, none is missing, and the sum is full light transport up to `max_bounces`. The
//! published method gives the light paths what meets a specular lobe first *or later* (`Caustics::Any`), which is exact too, and
//! noisier: light of a matte wall is found from the camera with ease.
//!
//! # What stands where
//!
//! | module | what |
//! |---|---|
//! | [`interface`] | types that host and kernels share, a unit on every field |
//! | [`math`] | random numbers, warps, cones, pencils, fixed point |
//! | [`texture`], [`surface`], [`light`] | what is at a hit: texels, lobes, lights |
//! | [`trace`] | the trait of tracers: our own BVH, ray queries |
//! | [`path`] | the loops of camera paths and light paths |
//! | [`mod@gather`], [`pass`], [`history`], [`denoiser`], [`method`] | what frames are made of, each variant a file and a line |
//! | [`declare`], [`platform`], [`memory`] | how one function runs on a GPU and on a CPU |
//! | `shared_entry` | entry points that passes share on a GPU |
#![cfg_attr(target_arch = "spirv", no_std)]
#![cfg_attr(target_arch = "spirv", feature(asm_experimental_arch))]

// A gather's file is the same inside and outside of this crate.
extern crate self as caustics_kernels;

pub mod declare;
pub mod denoiser;
pub mod emission;
pub mod gather;
pub mod history;
pub mod interface;
pub mod light;
pub mod math;
#[cfg(not(target_arch = "spirv"))]
pub mod memory;
pub mod method;
pub mod pass;
pub mod path;
pub mod platform;
#[cfg(target_arch = "spirv")]
pub mod shared_entry;
pub mod surface;
pub mod texture;
pub mod trace;
