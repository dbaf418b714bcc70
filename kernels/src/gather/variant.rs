//! The gather variants as data: what each runs, over what. A new gather is one file and one line of `ALL`.

/// What a pass runs over, an invocation each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// Pixels of the image.
    Pixels,
    /// Light paths of the batch.
    LightPaths,
    /// Slots of the deposit buffers.
    Deposits,
    /// Cells of the hash table.
    Cells,
    /// One invocation.
    One,
}

/// One piece of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// Runs a pass.
    Pass(&'static str, Over),
    /// Fills a buffer with zeros.
    Clear(&'static str),
    /// Builds the acceleration structure over the points' boxes.
    BuildPoints,
}

/// A way to bring deposits and collection points together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Whether it needs ray queries.
    pub hardware: bool,
    /// Once a frame, after `collect`.
    pub prepare: &'static [Work],
    /// For each batch of light paths.
    pub batch: &'static [Work],
    /// Its buffers beside those of every gather: name, element size [bytes], elements.
    pub buffers: &'static [(&'static str, usize, Over)],
}

/// Every gather variant.
pub const ALL: &[Variant] = &[BRUTE, POINTS_RT, PHOTONS_GRID];

/// The variant of this name.
pub fn find(name: &str) -> Option<&'static Variant> {
    ALL.iter().find(|variant| variant.name == name)
}

/// See `brute`.
pub const BRUTE: Variant = Variant {
    name: "brute",
    about: "every point looks at every deposit: the oracle, O(points x deposits)",
    hardware: false,
    prepare: &[],
    batch: &[
        Work::Clear("deposit_state"),
        Work::Pass("shoot.store", Over::LightPaths),
        Work::Pass("gather.brute", Over::Pixels),
    ],
    buffers: &[("deposit_geometry", 32, Over::Deposits), ("deposit_light", 32, Over::Deposits)],
};

/// See `points_rt`.
pub const POINTS_RT: Variant = Variant {
    name: "points-rt",
    about: "the paper's: boxes around points, searched by ray queries from each deposit",
    hardware: true,
    prepare: &[Work::Pass("bound", Over::Pixels), Work::BuildPoints],
    batch: &[Work::Pass("shoot.points_rt", Over::LightPaths)],
    buffers: &[("point_boxes", 24, Over::Pixels)],
};

/// See `photons_grid`.
pub const PHOTONS_GRID: Variant = Variant {
    name: "photons-grid",
    about: "deposits in a hash grid, gathered from each point",
    hardware: false,
    prepare: &[Work::Clear("radius_histogram"), Work::Pass("grid.survey", Over::Pixels)],
    batch: &[
        Work::Clear("deposit_state"),
        Work::Clear("cell_counts"),
        Work::Pass("shoot.store", Over::LightPaths),
        Work::Pass("grid.size", Over::One),
        Work::Pass("grid.count", Over::Deposits),
        Work::Pass("grid.reserve", Over::Cells),
        Work::Pass("grid.fill", Over::Deposits),
        Work::Pass("gather.photons_grid", Over::Pixels),
    ],
    buffers: &[
        ("radius_histogram", 1024, Over::One),
        ("cell_counts", 4, Over::Cells),
        ("cell_starts", 4, Over::Cells),
        ("cell_ends", 4, Over::Cells),
        ("deposit_geometry", 32, Over::Deposits),
        ("deposit_light", 32, Over::Deposits),
        ("sorted_geometry", 32, Over::Deposits),
        ("sorted_light", 32, Over::Deposits),
    ],
};
