//! `#[pass]`: from one function, the entry points of a GPU, the call on a CPU, and the description that the host reads. From
//! `kernels/src/pass/resolve.rs`, where the names are in scope that this crate does not know:
//!
//! ```ignore
//! /// Radiance of the caustic at each pixel.
//! #[pass(name = "resolve", over = params.pixel_count(), work = Resolve)]
//! pub fn resolve(
//!     pixel: u32,
//!     params: &FrameParams,
//!     point_geometry: &[PointGeometry],
//!     point_shading: &[PointShading],
//!     #[len = params.pixel_count() * accumulator::WORDS] accumulator: &[u32],
//!     mut caustic_radiance: Slots<'_, Vec3>,
//! ) {
//!     let point = &point_geometry[pixel as usize];
//!     let mut caustic = Vec3::ZERO;
//!     if point.exists() {
//!         let (sum, _) = GatheredSum::read(accumulator, pixel, params.quantum);
//!         caustic = estimate_radiance(point, &point_shading[pixel as usize], sum);
//!     }
//!     caustic_radiance.write(pixel, caustic);
//! }
//! ```
//!
//! The first parameter is the index of an invocation; every other one is told by its type:
//!
//! | type | what it is |
//! |---|---|
//! | `&FrameParams` | the frame's settings |
//! | `Dispatch` | where this dispatch stands in its pass |
//! | `Features` | what the scene needs, a constant while kernels are compiled |
//! | `SceneTables` | the scene's tables |
//! | `&mut impl Tracer` | what traces; the pass has an entry point for each tracer |
//! | `&mut impl Atomics` | the counters |
//! | `&[T]` | a buffer that is read; the parameter has the buffer's name, as in all that follow |
//! | `Slots<T>` | a buffer that is written, a slot by one invocation |
//! | `AtomicWords` | a buffer of words that invocations add to |
//! | `&AccelerationStructure` | a structure; with `hardware` alone |
//!
//! `#[len = expression]` before a buffer says how many elements it has, by `params`; without, one that is written has as many
//! as the pass has invocations, and one that is read as many as others say. Arguments of the attribute:
//!
//! - `name = "resolve"`, or `name = ["gather.", points_bvh]`, which is joined.
//! - `over = expression`: the invocations of a frame, by `params`.
//! - `work = Variant` of `Work`: what its time counts for.
//! - `limit = expression`: invocations there are where only the device knows, by `dispatch`, `params` and what is read;
//!   without, `dispatch.count`.
//! - `hardware`: there is an entry point with ray queries alone, and no call on the CPU.
//! - `shared_entry`: its entry points are those of a function that several passes share.
//!
//! Such a function is made by `#[shared_entry(mine = "pass.mine", other = "pass.other")]`: its parameters are those of all of these passes,
//! each buffer once, and a `bool` for each pass, `mine` and `other`, which says whether it runs: constants while kernels are compiled, so
//! that the code of the others is dead. A pass does not bind the buffers of the others.

mod declaration;
mod expand;

use declaration::{Arguments, Declaration, Role};
use proc_macro::TokenStream;

/// Makes a pass of a function; see the crate.
#[proc_macro_attribute]
pub fn pass(arguments: TokenStream, item: TokenStream) -> TokenStream {
    expanded(|| {
        let (arguments, declaration): (Arguments, _) =
            (syn::parse(arguments)?, Declaration::new(syn::parse(item)?)?);
        let structure = declaration.find(|role| matches!(role, Role::Structure));
        if let (Some(structure), false) = (structure, arguments.hardware) {
            return Err(syn::Error::new(structure.name.span(), "a structure is for `hardware` alone"));
        }
        if let Some(runs) = declaration.find(|role| matches!(role, Role::Runs)) {
            return Err(syn::Error::new(runs.name.span(), "a `bool` is for `shared_entry` functions alone"));
        }
        Ok(expand::expand(&arguments, &declaration))
    })
}

/// Makes an entry point that several passes share of a function, for a GPU alone; see the crate.
#[proc_macro_attribute]
pub fn shared_entry(passes: TokenStream, item: TokenStream) -> TokenStream {
    expanded(|| Ok(expand::expand_joint(&syn::parse(passes)?, &Declaration::new(syn::parse(item)?)?)))
}

fn expanded(expand: impl FnOnce() -> syn::Result<proc_macro2::TokenStream>) -> TokenStream {
    expand().unwrap_or_else(|error| error.to_compile_error()).into()
}

/// Makes a function one of its own in a module, which all entry points call until a driver inlines it; on a CPU it is inlined
/// as ever.
///
/// It takes and gives values, neither references nor slices, and cannot panic: rust-gpu inlines all else, with a warning.
#[proc_macro_attribute]
pub fn shared(_: TokenStream, item: TokenStream) -> TokenStream {
    let function = proc_macro2::TokenStream::from(item);
    quote::quote! {
        #[cfg_attr(target_arch = "spirv", inline(never))]
        #[cfg_attr(not(target_arch = "spirv"), inline(always))]
        #function
    }
    .into()
}
