//! The kernels of caustics: one source for SPIR-V (through rust-gpu) and for the CPU. This page describes the method [Moreau and
//! Doggett 2022] step by step; each step links to its code.
//!
//! # The problem
//!
//! A *caustic* is light that a specular surface (glass, metal, a smooth coat) has focused. It is *indirectly visible* where the
//! viewer sees it by way of another specular surface: in a mirror, through glass. Paths from the camera find the small light
//! behind the glass only at random, and photons splatted onto the screen are invisible in mirrors. So paths are traced from both
//! ends, and meet where neither end is specular.
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
//!    ([`path::camera_path::trace_camera_path`]), to its first vertex that is not specular. That vertex becomes the pixel's
//!    *collection point* ([`interface::point`]). It is a disc whose radius comes from a ray cone ([`math::cone`]): about one pixel wide,
//!    seen directly or in a mirror. All other light on the way is path traced in the same walk.
//! 2. **Denoise**, on request ([`denoiser`]): smooths that path-traced light. Caustics stay as they are.
//! 3. **Reuse**, with a history ([`history`]): finds this point in the previous frame ([`history::window`],
//!    [`history::reprojected`]), and how much of its light still holds ([`history::cells`]).
//! 4. **Shoot** ([`pass::shoot`]): light paths start by power ([`light::power`], behind the trait of [`light::emit`]), or where earlier
//!    ones contributed to the image ([`light::guided`], [`emission::guided`]). Paths whose first surface is a *caster* (specular) go on.
//!    Each later hit on a *receiver* deposits a *photon*: a position, a direction, a flux.
//! 5. **Gather** ([`mod@gather`]): a point takes the photons that lie on its disc ([`gather::contribution`]). Photons look for points in
//!    an index, or points for photons. Every variant sums the same integers ([`gather::accumulator`]).
//! 6. **Resolve** ([`pass::resolve`], or [`history::resolve_history`]): radiance is the summed flux over the area of the disc, times the
//!    throughput of the prefix.
//! 7. **Display** ([`pass::display`]): tone mapping for PNG files.
//!
//! [`method`] defines the passes of a frame. [`method::path`] traces everything from the camera instead; tests compare the other
//! methods with it.
//!
//! # Partition of the light
//!
//! One function decides which lobes are specular ([`surface::class`]). Each path is assigned by its first interaction after the
//! light. Light that meets a specular lobe first, and then reaches a collection point in any way, belongs to the light paths. All
//! other light belongs to the camera paths. Behind their point these follow every lobe, and sample lights at the non-specular
//! ones ([`path::camera_path::CameraSuffix`]). The partition is exact: no path is counted twice, none is missing, and the sum is
//! full light transport up to `max_bounces`.
//!
//! The published method also gives the light paths all light that meets a specular lobe *later* (`Caustics::Any`). That is exact
//! too, but noisier: camera paths find light of a matte wall with ease.
//!
//! # Modules
//!
//! | module | contents |
//! |---|---|
//! | [`interface`] | types that host and kernels share, a unit on every field |
//! | [`math`] | random numbers, warps, cones, pencils, fixed point |
//! | [`texture`], [`surface`], [`light`] | texels, lobes and lights at a hit |
//! | [`trace`] | the trait of tracers: our own BVH, ray queries |
//! | [`path`] | the loops of camera paths and light paths |
//! | [`mod@gather`], [`pass`], [`emission`], [`history`], [`denoiser`], [`method`] | parts of frames, each variant a file and a line |
//! | [`declare`], [`platform`], [`memory`] | one function on a GPU and on a CPU |
//! | `shared_entry` | entry points that passes share on a GPU |
#![cfg_attr(target_arch = "spirv", no_std)]
#![cfg_attr(target_arch = "spirv", feature(asm_experimental_arch))]

// A gather's file names this crate alike inside and outside of it.
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
