//! A gather variant as data: what its index consists of, and when it is built.

use crate::gather::{Gather, Index};

/// What a stage or a pass runs over, an invocation each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// Pixels of the image.
    Pixels,
    /// A share of the pixels, rounded up: one in so many.
    PixelsIn(u32),
    /// Slots of the deposit buffers.
    Deposits,
    /// Cells of the hash table.
    Cells,
    /// Words of level `k` of the counts of a sort of pixels by Morton codes; see `morton_sort`.
    PixelSort(u32),
    /// The same of deposits.
    DepositSort(u32),
    /// So many.
    Count(u32),
}

/// What an index is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Side {
    /// Over collection points: deposits look for points.
    Points,
    /// Over deposits: points look for deposits.
    Photons,
}

/// A stage of building an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Runs `build` of the index with this number; the name stands behind the pass's in profiles.
    Run(u32, &'static str, Over),
    /// Fills the words of this number with zeros.
    Clear(u32),
    /// Builds the acceleration structure over the boxes in the first words: of pixels, or of the deposits there are.
    Structure(Side),
}

/// Words of an index: so many for each of so many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words(pub u32, pub Over);

impl Words {
    /// No words.
    pub const NONE: Words = Words(0, Over::Count(0));
}

/// A way to bring deposits and collection points together.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// What is indexed.
    pub side: Side,
    /// Whether it needs ray queries.
    pub hardware: bool,
    /// Once a frame, after `collect`.
    pub frame: &'static [Stage],
    /// For each batch of light paths, after `shoot`.
    pub batch: &'static [Stage],
    /// The words of its index.
    pub words: [Words; 4],
    /// Whether building moves the deposits into `sorted_geometry` and `sorted_light`, and ids are of those.
    pub sorts: bool,
    /// Pass that builds.
    pub index_pass: &'static str,
    /// Pass that gathers.
    pub gather_pass: &'static str,
    /// The passes on a CPU.
    #[cfg(not(target_arch = "spirv"))]
    pub cpu: cpu::OnCpu,
}

impl Variant {
    /// An index of deposits that has no stages, words or name yet, with the functions of `G`.
    pub const fn of<G: Gather>() -> Variant {
        Variant {
            #[cfg(not(target_arch = "spirv"))]
            cpu: cpu::OnCpu { gather: Some(cpu::gather_one::<G>), ..cpu::OnCpu::of::<G>() },
            ..Variant::of_hardware::<G>()
        }
    }

    /// The same of an index that ray queries search.
    pub const fn of_hardware<I: Index>() -> Variant {
        Variant {
            name: "",
            about: "",
            side: Side::Photons,
            hardware: false,
            frame: &[],
            batch: &[],
            words: [Words::NONE; 4],
            sorts: false,
            index_pass: "index",
            gather_pass: "gather",
            #[cfg(not(target_arch = "spirv"))]
            cpu: cpu::OnCpu::of::<I>(),
        }
    }
}

#[cfg(not(target_arch = "spirv"))]
impl PartialEq for Variant {
    /// A name names one variant.
    fn eq(&self, other: &Variant) -> bool {
        self.name == other.name
    }
}

#[cfg(not(target_arch = "spirv"))]
pub use cpu::*;

/// The variants as a CPU runs them.
#[cfg(not(target_arch = "spirv"))]
mod cpu {
    use super::Variant;
    use crate::gather::tables::{Build, Tables};
    use crate::gather::{Gather, Index, for_each_gather};
    use crate::pass::gather::gather;
    use crate::seam::Atomics;

    /// One invocation of a stage of building.
    pub type BuildOne = fn(u32, u32, &mut Build<'_>);
    /// One invocation of a gather: tables, counters.
    pub type GatherOne = fn(u32, &mut Tables<'_>, &mut dyn Atomics);

    /// The passes of a variant as functions.
    #[derive(Clone, Copy, Debug)]
    pub struct OnCpu {
        /// Builds.
        pub build: BuildOne,
        /// Gathers; none by ray queries.
        pub gather: Option<GatherOne>,
    }

    impl OnCpu {
        pub(super) const fn of<I: Index>() -> OnCpu {
            OnCpu { build: I::build, gather: None }
        }
    }

    pub(super) fn gather_one<G: Gather>(index: u32, tables: &mut Tables<'_>, mut counters: &mut dyn Atomics) {
        gather::<G, _>(index, tables, &mut counters);
    }

    macro_rules! list {
        ($([$($file:ident $type:ident $constant:ident $index:tt $gather:tt;)*])*) => {
            $($(
                #[doc = concat!("See `", stringify!($file), "`.")]
                pub const $constant: Variant = Variant {
                    index_pass: $index,
                    gather_pass: $gather,
                    ..<crate::gather::$file::$type as Index>::VARIANT
                };
            )*)*

            /// Every gather variant.
            pub const ALL: &[Variant] = &[$($($constant,)*)*];
        };
    }
    for_each_gather!(list);

    /// The variant of this name.
    pub fn find(name: &str) -> Option<&'static Variant> {
        ALL.iter().find(|variant| variant.name == name)
    }
}
