//! The energy ledger: the flux of light paths by its fate, in the words of the counter buffer behind the counters.

/// An entry of the ledger: flux summed over paths and channels, in quanta of `FrameParams::quantum` (W).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Entry {
    /// Emitted by the lights.
    Emitted,
    /// Absorbed by surfaces and media, computed independently of the sampled paths.
    Absorbed,
    /// Left the scene.
    Escaped,
    /// Carried by paths that were cut at the maximum length.
    Cut,
    /// Lost (or gained, if negative) where the shading normal differs from the face's.
    ShadingNormals,
    /// Scattered at the first surface by a lobe whose light is no caustic, so that no light path follows it.
    LeftToCamera,
}

/// Number of entries.
pub const ENTRY_COUNT: u32 = 6;
/// Number of copies of every entry, so that paths side by side add to different words.
pub const LEDGER_BANKS: u32 = 64;
/// First word of the ledger in the counter buffer.
pub const LEDGER_FIRST: u32 = 16;

/// First of the two words (low, high; signed) of an entry in the bank of a path.
#[inline]
pub fn slot(entry: Entry, path: u32) -> u32 {
    LEDGER_FIRST + 2 * (path % LEDGER_BANKS * ENTRY_COUNT + entry as u32)
}
