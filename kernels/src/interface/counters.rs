//! Counters: kernels never fail, they count in slots of the counter buffer.

use crate::interface::ledger::{ENTRY_COUNT, LEDGER_BANKS, LEDGER_FIRST};

/// A slot of the counter buffer (one u32 each).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Counter {
    /// Photons created.
    Photons,
    /// Photons dropped for lack of room.
    PhotonsDropped,
    /// Pairs of photon and point that were gathered.
    Gathered,
    /// Addends clamped by the accumulator.
    Clamped,
    /// Non-finite addends, and non-finite radiance of pixels, set to zero.
    NonFinite,
    /// Closest-hit rays of `collect`.
    CameraRays,
    /// Shadow rays of `collect`.
    ShadowRays,
    /// Closest-hit rays of `shoot`.
    LightRays,
    /// Light paths started, without training paths.
    LightPaths,
    /// Light paths cut by the bounce limit while they still carried flux.
    Cut,
    /// Paths whose stack of nested media overflowed.
    MediaOverflow,
    /// Faces of media that contradict the media around the path that met them.
    UnexpectedFaces,
    /// Camera paths that ended in the radiance cache.
    CacheEnds,
}

/// Number of slots of the counter buffer, with those of the energy ledger.
pub const COUNTER_COUNT: usize = (LEDGER_FIRST + 2 * ENTRY_COUNT * LEDGER_BANKS) as usize;

/// Names of the counters that users see.
pub const COUNTER_NAMES: [(Counter, &str); 13] = [
    (Counter::Photons, "photons"),
    (Counter::PhotonsDropped, "photons_dropped"),
    (Counter::Gathered, "gathered"),
    (Counter::Clamped, "clamped"),
    (Counter::NonFinite, "non_finite"),
    (Counter::CameraRays, "camera_rays"),
    (Counter::ShadowRays, "shadow_rays"),
    (Counter::LightRays, "light_rays"),
    (Counter::LightPaths, "light_paths"),
    (Counter::Cut, "cut"),
    (Counter::MediaOverflow, "media_overflow"),
    (Counter::UnexpectedFaces, "unexpected_faces"),
    (Counter::CacheEnds, "cache_ends"),
];

/// A slot of the buffer `photon_state`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum PhotonState {
    /// Photons stored in this batch, those without room included.
    Stored,
}

/// Number of slots of the buffer `photon_state`.
pub const PHOTON_STATE_COUNT: usize = 4;
