//! `#[pass]`: makes of one function the entry points of a GPU, the call on a CPU, and the description that the host reads. An
//! example from `kernels/src/pass/resolve.rs`, which imports all names in it:
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
//! The first parameter is the index of an invocation. The type of every other parameter gives its role:
//!
//! | type | role |
//! |---|---|
//! | `&FrameParams` | the frame's settings |
//! | `Dispatch` | the position of this dispatch in its pass |
//! | `Features` | the features that the scene needs, a specialisation constant |
//! | `SceneTables` | the scene's tables |
//! | `&mut impl Tracer` | the tracer; the pass has an entry point for each tracer |
//! | `&mut impl Atomics` | the counters |
//! | `&[T]` | a buffer that is read; the parameter has the buffer's name, as in all further rows |
//! | `Slots<T>` | a buffer that is written, a slot by one invocation |
//! | `AtomicWords` | a buffer of words that invocations add to |
//! | `&AccelerationStructure` | a structure; only with `hardware` |
//!
//! `#[len = expression]` before a buffer gives its number of elements, by `params`. Without it, a buffer that is written has an
//! element for each invocation. A buffer that is read has as many elements as other passes give it. Arguments of the attribute:
//!
//! - `name = "resolve"`, or `name = ["gather.", points_bvh]`, which is joined.
//! - `over = expression`: number of invocations of a frame, by `params`.
//! - `work = Variant` of `Work`: kind of work that its time counts for.
//! - `limit = expression`: number of invocations where only the device knows it, by `dispatch`, `params` and the buffers that are
//!   read. Default: `dispatch.count`.
//! - `hardware`: the pass has an entry point with ray queries only, and no call on the CPU.
//! - `shared_entry`: a function that several passes share provides its entry points.
//!
//! `#[shared_entry(mine = "pass.mine", other = "pass.other")]` makes such a function. Its parameters are those of all of its
//! passes, each buffer once, and a `bool` for each pass (`mine`, `other`): whether that pass runs. The `bool`s are specialisation
//! constants, so that the code of the other passes is dead. A pass does not bind the buffers of the others.

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

/// Makes of a function an entry point that several passes share, for a GPU only; see the crate.
#[proc_macro_attribute]
pub fn shared_entry(passes: TokenStream, item: TokenStream) -> TokenStream {
    expanded(|| Ok(expand::expand_joint(&syn::parse(passes)?, &Declaration::new(syn::parse(item)?)?)))
}

fn expanded(expand: impl FnOnce() -> syn::Result<proc_macro2::TokenStream>) -> TokenStream {
    expand().unwrap_or_else(|error| error.to_compile_error()).into()
}

/// Keeps a function apart in a module: all entry points call it until a driver inlines it. On a CPU it is always inlined.
///
/// The function takes and returns values without references or slices, and cannot panic. rust-gpu inlines any other function,
/// with a warning.
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
