//! Histories: what the frame before lends to the collection points of this one. A history is data: the steps that it
//! adds to a frame.

use std::fmt;

use caustics_kernels::declare::Pass;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::history::HistorySettings;
use caustics_kernels::pass::resolve::RESOLVE;
use caustics_kernels::pass::resolve_history::RESOLVE_HISTORY;
use caustics_kernels::pass::reuse_paper::REUSE_PAPER;
use caustics_kernels::pass::reuse_validated::REUSE_VALIDATED;
use caustics_kernels::pass::validate::VALIDATE;

use super::Step;

/// A way to lend light from frame to frame.
#[derive(Clone, Copy)]
pub struct History {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Its settings; none: nothing is lent.
    pub settings: Option<HistorySettings>,
    /// Once a frame, after `collect`, before anything is built over the frame's points.
    pub before: fn(&FrameParams) -> Vec<Step>,
    /// The pass that turns a point's sum into radiance.
    pub resolve: &'static Pass,
    /// What is filled with zeros in a frame without light, so that nothing is lent; empty: such a frame is like any other.
    pub forget: &'static [&'static str],
    /// Buffers in which something outlives its frame.
    pub keeps: &'static [&'static str],
}

/// Every history.
pub const ALL: &[&History] = &[&NONE, &PAPER, &VALIDATED];

/// The history of this name.
pub fn find(name: &str) -> Option<&'static History> {
    ALL.iter().find(|history| history.name == name).copied()
}

impl fmt::Debug for History {
    /// Its name: addresses of functions differ from process to process.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for History {
    fn eq(&self, other: &History) -> bool {
        self.name == other.name
    }
}

/// OurBasic: no light outlives its frame.
pub const NONE: History = History {
    name: "none",
    about: "no light outlives its frame: OurBasic",
    settings: None,
    before: |_| Vec::new(),
    resolve: &RESOLVE,
    forget: &[],
    keeps: &[],
};

/// OurTemporal as published: eight tenths of the mean of the previous points that overlap, two tenths of this frame's
/// light, always [Moreau and Doggett 2022].
///
/// Cost: nine rows of 32 bytes a point to search, and 72 bytes a point of state. Where it is wrong: its variance stays at a
/// ninth; light that is gone is seen for 20 frames; repeated means blur; radiance is lent, so a texture and a glossy lobe
/// smear.
pub const PAPER: History = History {
    name: "paper",
    about: "OurTemporal as published: 0.8 of what overlaps, 0.2 of this frame",
    settings: Some(HistorySettings { reach: 1.0, lag: 0.0, most_samples: 0.0, demodulates: 0 }),
    before: |params| vec![Step::of(&REUSE_PAPER, params)],
    resolve: &RESOLVE_HISTORY,
    forget: &[],
    keeps: &["history_points", "history_mean"],
};

/// Light of the nearest previous point, counted by the frames that it holds, as far as light paths with the same random
/// numbers say that it still arrives.
///
/// Cost: as `paper`, and an eighth more light paths that give no light. Where it gives nothing: light that moves by more than
/// a disc or so a frame is as noisy as without a history, since light that is late is lost where its old place is hidden.
/// Where it is wrong: where few validation paths deposit, cells are large, and a change in a part of one is seen late; how
/// far light moved is judged by the radius of a direct view, behind curved mirrors too.
pub const VALIDATED: History = History {
    name: "validated",
    about: "all frames that still hold by the validation paths, from the nearest point",
    settings: Some(HistorySettings { reach: 1.3, lag: 0.25, most_samples: 1024.0, demodulates: 1 }),
    before: |params| {
        vec![
            Step::Clear { buffer: "validation_cells" },
            Step::of(&VALIDATE, params),
            Step::of(&REUSE_VALIDATED, params),
        ]
    },
    resolve: &RESOLVE_HISTORY,
    forget: &["history_points", "validation_deposits"],
    keeps: &["history_points", "history_mean", "validation_deposits"],
};
