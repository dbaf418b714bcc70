//! What a pass declares about itself (see the attribute [`pass`]), how a CPU calls it, and what frames are made of passes.
//! Imports `interface`, `platform`, `math` and the trait of `light`; what the attribute makes stands in the pass's own file.

pub use caustics_kernel_macros::pass;
#[cfg(target_arch = "spirv")]
pub use caustics_kernel_macros::shared_entry;

#[cfg(not(target_arch = "spirv"))]
pub use described::{Access, Bound, OnCpu, Pass, Work};
#[cfg(not(target_arch = "spirv"))]
pub(crate) use kinds::equal_by_name;
#[cfg(not(target_arch = "spirv"))]
pub use kinds::{Denoiser, Emission, FrameStage, History, Starts, Steps};
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

/// Declares the files of a kind of variant, a line each with its constants, and lists them as `ALL`, to be found by name ([`Named`](crate::interface::named::Named)).
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
