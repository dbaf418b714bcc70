//! A gather variant as data: the parts of its index, and the stages that build it.

#[cfg(not(target_arch = "spirv"))]
use crate::declare::Pass;
use crate::gather::morton_sort;
#[cfg(not(target_arch = "spirv"))]
use crate::gather::{Index, exchange, for_each_gather};
use crate::interface::frame::FrameParams;
pub use crate::interface::point::Side;

/// Range of a stage or a pass, one invocation for each element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// Pixels of the image.
    Pixels,
    /// One in this number of pixels, rounded up.
    PixelsIn(u32),
    /// Slots of the photon buffers.
    Photons,
    /// Cells of the hash table.
    Cells,
    /// Words of level `k` of the counts of a sort of pixels by Morton codes; see `morton_sort`.
    PixelSort(u32),
    /// Words of level `k` of the counts of a sort of photons by Morton codes.
    PhotonSort(u32),
    /// A fixed number of invocations.
    Count(u32),
}

/// A stage of building an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Runs `build` of the index with this stage number. Profiles show the name behind the pass's name.
    Run(u32, &'static str, Over),
    /// Fills the words of this number (of `index_0` to `index_3`) with zeros.
    Clear(u32),
    /// Builds the acceleration structure over the boxes in `index_0`: those of all pixels, or of the stored photons.
    Structure(Side),
}

/// Number of words of an index: this number for each element of a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WordCount(pub u32, pub Over);

impl WordCount {
    /// No words.
    pub const NONE: WordCount = WordCount(0, Over::Count(0));

    /// Number of words.
    pub fn count(self, params: &FrameParams) -> u32 {
        self.0 * self.1.extent(params)
    }
}

impl Over {
    /// Range of a gather whose index is over this side: the elements of the other side search.
    pub fn searchers(side: Side) -> Over {
        match side {
            Side::Points => Over::Photons,
            Side::Photons => Over::Pixels,
        }
    }

    /// Number of elements.
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
    /// Side that is indexed.
    pub side: Side,
    /// Whether it needs ray queries.
    pub hardware: bool,
    /// Stages that run once a frame, after `collect`.
    pub frame: &'static [Stage],
    /// Stages that run for each batch of light paths, after `shoot`.
    pub batch: &'static [Stage],
    /// Number of words of each part of its index.
    pub words: [WordCount; 4],
    /// Whether building copies the photons to `sorted_geometry` and `sorted_light`, so that ids refer to these.
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

    /// Number of elements of the sorted photons.
    pub fn sorted(&self, params: &FrameParams) -> u32 {
        if self.sorts { params.photon_capacity } else { 0 }
    }
}

#[cfg(not(target_arch = "spirv"))]
impl PartialEq for Variant {
    /// Compares names: a name identifies one variant.
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
