//! The energy ledger: where the flux of light paths goes, in the words of the counter buffer behind the counters.

/// An entry of the ledger: flux summed over paths and channels, in quanta of `FrameParams::quantum` (W).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Entry {
    /// Left the lights.
    Emitted,
    /// Absorbed by surfaces and media, computed apart from what paths do there.
    Absorbed,
    /// Left the scene.
    Escaped,
    /// Under way where the path's length was cut.
    Cut,
    /// Lost (or gained, if negative) where the shading normal is not the face's.
    ShadingNormals,
    /// Scattered by a lobe at the first surface whose light is no caustic, so that no light path follows it.
    LeftToCamera,
}

/// Entries there are.
pub const ENTRY_COUNT: u32 = 6;
/// Copies of every entry, so that paths side by side add to different words.
pub const LEDGER_BANKS: u32 = 64;
/// First word of the ledger in the counter buffer.
pub const LEDGER_FIRST: u32 = 16;

/// First of the two words (low, high; signed) of an entry in the bank of a path.
#[inline]
pub fn slot(entry: Entry, path: u32) -> u32 {
    LEDGER_FIRST + 2 * (path % LEDGER_BANKS * ENTRY_COUNT + entry as u32)
}
