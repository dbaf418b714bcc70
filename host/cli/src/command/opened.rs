//! A session as a command opens it, and what is said of it.

use caustics::scene::{Scene, SceneCamera};
use caustics::session::{RunnerChoice, Session};
use caustics::settings::Settings;
use caustics_bench::cell::Cell;
use caustics_kernels::interface::features::Features;

use super::pick::pick;
use crate::cli::Machine;

/// A session, and what is said of it.
pub struct Opened {
    /// The session.
    pub session: Session,
    /// What runs it.
    pub choice: RunnerChoice,
    /// Its gather, or `none`.
    pub gather: &'static str,
    /// Why it runs there.
    pub reason: String,
}

/// Opens a session that renders by this cell, where its runner says.
pub fn opened(
    cell: &Cell,
    machine: &Machine,
    scene: &Scene,
    camera: &SceneCamera,
    settings: &Settings,
    features: Features,
) -> anyhow::Result<Opened> {
    let method = cell.method;
    let (choice, variant, reason) =
        pick(cell.asked_runner, machine, cell.gather.filter(|_| method.chooses_gather))?;
    let session = Session::new(&choice, scene, camera, settings, method, variant, features)?;
    let gather = if method.chooses_gather { variant.name } else { "none" };
    Ok(Opened { session, choice, gather, reason })
}
