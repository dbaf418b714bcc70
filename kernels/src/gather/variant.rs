//! A gather variant as data: what its index consists of, and when it is built.

#[cfg(not(target_arch = "spirv"))]
use crate::declare::Pass;
use crate::gather::morton_sort;
#[cfg(not(target_arch = "spirv"))]
use crate::gather::{Index, exchange, for_each_gather};
use crate::interface::frame::FrameParams;
pub use crate::interface::point::Side;

/// What a stage or a pass runs over, an invocation each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// Pixels of the image.
    Pixels,
    /// A share of the pixels, rounded up: one in so many.
    PixelsIn(u32),
    /// Slots of the photon buffers.
    Photons,
    /// Cells of the hash table.
    Cells,
    /// Words of level `k` of the counts of a sort of pixels by Morton codes; see `morton_sort`.
    PixelSort(u32),
    /// The same of photons.
    PhotonSort(u32),
    /// So many.
    Count(u32),
}

/// A stage of building an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Runs `build` of the index with this number; the name stands behind the pass's in profiles.
    Run(u32, &'static str, Over),
    /// Fills the words of this number with zeros.
    Clear(u32),
    /// Builds the acceleration structure over the boxes in the first words: of pixels, or of the photons there are.
    Structure(Side),
}

/// Words of an index: so many for each of so many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WordCount(pub u32, pub Over);

impl WordCount {
    /// No words.
    pub const NONE: WordCount = WordCount(0, Over::Count(0));

    /// So many.
    pub fn count(self, params: &FrameParams) -> u32 {
        self.0 * self.1.extent(params)
    }
}

impl Over {
    /// What a gather runs over, whose index is over this side: those that search.
    pub fn searchers(side: Side) -> Over {
        match side {
            Side::Points => Over::Photons,
            Side::Photons => Over::Pixels,
        }
    }

    /// Elements there are.
    pub fn extent(self, params: &FrameParams) -> u32 {
        match self {
            Over::Pixels => params.pixel_count(),
            Over::PixelsIn(share) => params.pixel_count().div_ceil(share),
            Over::Photons => params.photon_capacity,
            Over::Cells => params.cell_mask + 1,
            Over::PixelSort(level) => morton_sort::level_count(params.pixel_count(), level),
            Over::PhotonSort(level) => morton_sort::level_count(params.photon_capacity, level),
            Over::Count(count) => count,
        }
    }
}

/// A gather: brings photons and collection points together.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// Name on the command line.
    pub name: &'static str,
    /// Description, in one line.
    pub description: &'static str,
    /// Cost of a frame.
    pub cost: &'static str,
    /// Limitations: where it is slow or wrong.
    pub limitations: &'static str,
    /// What is indexed.
    pub side: Side,
    /// Whether it needs ray queries.
    pub hardware: bool,
    /// Once a frame, after `collect`.
    pub frame: &'static [Stage],
    /// For each batch of light paths, after `shoot`.
    pub batch: &'static [Stage],
    /// The words of its index.
    pub words: [WordCount; 4],
    /// Whether building moves the photons into `sorted_geometry` and `sorted_light`, and ids are of those.
    pub sorts: bool,
    /// The pass that builds.
    #[cfg(not(target_arch = "spirv"))]
    pub index: &'static Pass,
    /// The pass that gathers.
    #[cfg(not(target_arch = "spirv"))]
    pub gather: &'static Pass,
}

impl Variant {
    /// An index of photons that has no stages, words or name yet.
    pub const NEW: Variant = Variant {
        name: "",
        description: "",
        cost: "",
        limitations: "",
        side: Side::Photons,
        hardware: false,
        frame: &[],
        batch: &[],
        words: [WordCount::NONE; 4],
        sorts: false,
        #[cfg(not(target_arch = "spirv"))]
        index: &exchange::brute::INDEX,
        #[cfg(not(target_arch = "spirv"))]
        gather: &exchange::brute::GATHER,
    };

    /// Elements of the sorted photons.
    pub fn sorted(&self, params: &FrameParams) -> u32 {
        if self.sorts { params.photon_capacity } else { 0 }
    }
}

#[cfg(not(target_arch = "spirv"))]
impl PartialEq for Variant {
    /// A name names one variant.
    fn eq(&self, other: &Variant) -> bool {
        self.name == other.name
    }
}

/// Declares the variants with their passes.
#[cfg(not(target_arch = "spirv"))]
macro_rules! list {
    ($([$($file:ident $type:ident $constant:ident;)*])*) => {
        $($(
            #[doc = concat!("See `", stringify!($file), "`.")]
            pub const $constant: Variant = Variant {
                index: &exchange::$file::INDEX,
                gather: &exchange::$file::GATHER,
                ..<crate::gather::$file::$type as Index>::VARIANT
            };
        )*)*

        /// Every gather variant.
        pub const ALL: &[Variant] = &[$($($constant,)*)*];
    };
}
#[cfg(not(target_arch = "spirv"))]
for_each_gather!(list);

#[cfg(not(target_arch = "spirv"))]
crate::interface::named::listed!(Variant in ALL.iter().collect());
