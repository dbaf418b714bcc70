//! Identity of a run, by which a checkpoint recognises its run and `merge` its view.

use std::collections::BTreeMap;
use std::path::Path;

use caustics::checkpoint::Identity;
use caustics::kernels;
use caustics::program::program;
use caustics::render_config::RenderConfig;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};

/// Returns everything that decides the bits of the run.
pub fn identity(
    scene: &Scene,
    camera: &str,
    config: &RenderConfig,
    gather: &str,
    choice: &RunnerChoice,
    session: &Session,
) -> Identity {
    let mut identity = pose_independent(scene, camera, config, gather, choice, session);
    let viewpoint = format!("{:?} from {}", session.params(0).camera, scene.origin);
    identity.insert("viewpoint".into(), viewpoint);
    identity
}

/// Returns the part of the identity that is the same at every pose.
pub fn pose_independent(
    scene: &Scene,
    camera: &str,
    config: &RenderConfig,
    gather: &str,
    choice: &RunnerChoice,
    session: &Session,
) -> Identity {
    let device = match choice {
        RunnerChoice::Cpu { .. } => "CPU".to_string(),
        RunnerChoice::Gpu { hardware, .. } => format!("{}, ray queries {hardware}", session.device()),
    };
    let entry = |name: &str, value: String| (name.to_string(), value);
    let additions = scene.additions.iter().map(|(name, what)| entry(name, what.clone()));
    let own = [
        entry("scene", format!("{} {}", scene.name, scene.fingerprint())),
        entry("camera", camera.to_string()),
        entry("background", session.params(0).background.to_string()),
        entry("gather", gather.to_string()),
        entry("runner", device),
        entry("kernels", kernels::SOURCES.to_string()),
    ];
    config.run_identity().into_iter().chain(own).chain(additions).collect()
}

/// Attributes of a run's EXR file, except those known only at its end.
pub fn attributes(identity: Identity, file: &Path, session: &Session) -> BTreeMap<String, String> {
    let mut attributes = identity;
    attributes.extend([
        ("scene_file".into(), file.display().to_string()),
        ("device".into(), session.device()),
        ("commit".into(), program().commit.clone()),
    ]);
    attributes
}

/// Adds the number of frames and the seconds that the run took.
pub fn end(attributes: &mut BTreeMap<String, String>, frames: u32, seconds: f64) {
    attributes.insert("frames".into(), frames.to_string());
    // Users set this variable to get equal files of equal runs (reproducible-builds.org).
    if std::env::var_os("SOURCE_DATE_EPOCH").is_none() {
        attributes.insert("seconds".into(), seconds.to_string());
    }
}
