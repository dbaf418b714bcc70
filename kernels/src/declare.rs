//! Declarations: a pass with its attribute [`pass`], its call on a CPU, and the steps and variants that frames consist of.
//! Imports `interface`, `platform`, `math` and the trait of `light`. The attribute makes its items in the pass's own file.

pub use caustics_kernel_macros::pass;
#[cfg(target_arch = "spirv")]
pub use caustics_kernel_macros::shared_entry;

#[cfg(not(target_arch = "spirv"))]
pub use described::{Access, Bound, OnCpu, Pass, Work};
#[cfg(not(target_arch = "spirv"))]
pub(crate) use kinds::equal_by_name;
#[cfg(not(target_arch = "spirv"))]
pub use kinds::{Denoiser, Emission, FrameStage, History, Pilot, Starts, Steps};
#[cfg(not(target_arch = "spirv"))]
pub use on_cpu::{BufferError, Buffers, Call, LocalCounters};
#[cfg(not(target_arch = "spirv"))]
pub use step::{BufferSpec, INDEX, Step, buffers};

#[cfg(not(target_arch = "spirv"))]
mod described;
#[cfg(not(target_arch = "spirv"))]
mod kinds;
#[cfg(not(target_arch = "spirv"))]
mod on_cpu;
#[cfg(not(target_arch = "spirv"))]
mod step;

/// Declares the variants of a kind, a line for each file with its constants. `ALL` lists them, and
/// [`Named`](crate::interface::named::Named) finds them by name.
macro_rules! variants {
    ($kind:ident { $($file:ident: $($constant:ident)+;)* }) => {
        $(pub mod $file;)*

        $($(
            #[cfg(not(target_arch = "spirv"))]
            pub use $file::$constant;
        )+)*

        /// Every variant.
        #[cfg(not(target_arch = "spirv"))]
        pub const ALL: &[&$kind] = &[$($(&$constant,)+)*];

        #[cfg(not(target_arch = "spirv"))]
        $crate::interface::named::listed!($kind in ALL.to_vec());
    };
}
pub(crate) use variants;
