//! Small scenes whose light fades, grows or shrinks, and the share of their light that a history shows.

use caustics::render_config::RenderConfig;
use caustics::scene::{CameraEdit, Edits, Keyframe, LoadOptions, NodeEdit, Scene, SceneCamera};
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::history::{History, NONE};
use caustics_kernels::interface::choice::PathHistory;
use serde_json::{Value, json};

use crate::frames::sums;
use crate::scenes::{copied, make_glass};
use crate::statistics::Mean;

/// Frames per second.
const FPS: f64 = 24.0;
/// Number of frames of a fade.
const FRAMES: u32 = 18;
/// Node of the light in `moving-caster`, and of the light that goes out in `light-off`.
const LIGHT_NODE: usize = 2;
const SECOND_LIGHT_NODE: usize = 3;

/// Object that casts the caustic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Caster {
    /// A ring of metal.
    Metal,
    /// A ring of glass.
    Glass,
}

/// A light whose power changes from frame to frame.
#[derive(Clone, Debug)]
pub enum Fade {
    /// Growth of the light's edges from one factor to another; its area grows by their square.
    Light(f64, f64),
    /// Growth of one of two lights.
    OneOfTwo(f64, f64),
    /// Motion of the light away to this multiple of its distance.
    Away(f64),
    /// Factor on the intensity of a punctual light in each frame.
    Power(Punctual, f64),
}

/// A punctual light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Punctual {
    /// A point light.
    Point,
    /// One of two point lights that are equal at first.
    OneOfTwoPoints,
    /// A spot light.
    Spot,
    /// A directional light.
    Sun,
}

impl Punctual {
    /// Lights of a scene; the first fades.
    fn lights(self) -> Vec<Value> {
        let point = json!({ "type": "point", "intensity": 60.0 });
        match self {
            Punctual::Point => vec![point],
            Punctual::OneOfTwoPoints => vec![point.clone(), point],
            Punctual::Spot => {
                let cone = json!({ "innerConeAngle": 0.1, "outerConeAngle": 0.3 });
                vec![json!({ "type": "spot", "intensity": 60.0, "spot": cone })]
            }
            Punctual::Sun => vec![json!({ "type": "directional", "intensity": 4.0 })],
        }
    }
}

/// A scene with a fade.
#[derive(Clone, Debug)]
pub struct Fading {
    /// Object that casts the caustic.
    pub caster: Caster,
    /// The fade.
    pub fade: Fade,
    /// Whether the camera moves too.
    pub moves: bool,
}

impl Fading {
    /// The scene at time 0, with the keys of its fade.
    pub fn scene(&self) -> Scene {
        let folder = if matches!(self.fade, Fade::OneOfTwo(..)) { "light-off" } else { "moving-caster" };
        let (copy, mut document) = copied(folder);
        document.as_object_mut().expect("a document").remove("animations");
        document["nodes"][1]["translation"] = json!([0.0, 0.0, 0.0]);
        if self.caster == Caster::Glass {
            make_glass(&mut document);
        }
        if let Fade::Power(punctual, _) = self.fade {
            replace_light(&mut document, punctual.lights());
        }
        let path = copy.path().join("scene.gltf");
        std::fs::write(&path, document.to_string()).expect("a file");
        let keys = self.keys();
        let options = LoadOptions { grabbed: keys.grabbed(), ..LoadOptions::default() };
        let mut scene = Scene::load_with(&path, &options).expect("the scene loads");
        scene.play(&keys).expect("the keys are of the scene");
        scene
    }

    fn keys(&self) -> Edits {
        let scaled = |node, factor| NodeEdit { node, scale: Some([factor; 3]), ..NodeEdit::default() };
        let at = |factor: f64| [2.6 * factor, 2.6 * factor, 0.0];
        let placed =
            |factor| NodeEdit { node: LIGHT_NODE, translation: Some(at(factor)), ..NodeEdit::default() };
        let nodes = match self.fade {
            Fade::Light(from, to) => [scaled(LIGHT_NODE, from), scaled(LIGHT_NODE, to)],
            Fade::OneOfTwo(from, to) => [scaled(SECOND_LIGHT_NODE, from), scaled(SECOND_LIGHT_NODE, to)],
            Fade::Away(factor) => [placed(1.0), placed(factor)],
            // A key without effect: the host updates lights only where something is animated.
            Fade::Power(..) => [placed(1.0), placed(1.0)],
        };
        let eyes = [[0.0, 2.3, 1.3], [0.4, 2.2, 1.4]];
        let camera = |from| CameraEdit { from, look_at: [0.0; 3], fov: 40.0 };
        let end = f64::from(FRAMES) / FPS;
        let keys = nodes.into_iter().zip(eyes).zip([0.0, end]).map(|((node, eye), time)| Keyframe {
            time,
            camera: self.moves.then(|| camera(eye)),
            nodes: vec![node],
        });
        Edits { keys: keys.collect(), ..Edits::default() }
    }

    /// Poses the scene at a frame.
    fn pose(&self, scene: &mut Scene, frame: u32) {
        let before = f64::from(frame.saturating_sub(1));
        let power = |factor: f64| factor.powf(f64::from(frame) - before) as f32;
        if let (Fade::Power(_, factor), Some(motion)) = (&self.fade, &mut scene.motion) {
            motion.lights[0].what.intensity *= power(*factor);
        }
        scene.pose(f64::from(frame) / FPS).expect("a pose");
    }

    /// Caustics and path-traced light summed over the frames of the fade: with histories over without, over several
    /// seeds. All runs trace the same paths.
    pub fn kept(&self, history: &'static History, config: &RenderConfig, seeds: u32) -> [Mean; 2] {
        let start = self.scene();
        let mut ratios = [Vec::new(), Vec::new()];
        for seed in 0..seeds {
            let none = RenderConfig { history: &NONE, seed, ..config.clone() };
            let kept = RenderConfig { history, path_history: PathHistory::Validated, ..none.clone() };
            let [none, kept] = [none, kept].map(|config| self.energies(&start, &config));
            for (ratios, (kept, none)) in ratios.iter_mut().zip(kept.into_iter().zip(none)) {
                ratios.push(kept / none);
            }
        }
        ratios.map(|ratios| Mean::from_samples(&ratios))
    }

    fn energies(&self, start: &Scene, config: &RenderConfig) -> [f64; 2] {
        let mut scene = start.clone();
        let features = scene.features(config.specular_roughness);
        let (choice, camera) = (RunnerChoice::Cpu { threads: 0 }, last_camera(&scene));
        let mut session = Session::new(&choice, &scene, &camera, config, features).expect("a session opens");
        let mut energies = [0.0; 2];
        for frame in 0..FRAMES {
            self.pose(&mut scene, frame);
            session.pose(&scene, &last_camera(&scene)).expect("a pose");
            session.frame(frame).expect("a frame runs");
            for (energy, layer) in energies.iter_mut().zip(["caustic_radiance", "path_radiance"]) {
                *energy += sums(&session.read(layer).expect("a layer")).iter().sum::<f64>();
            }
        }
        energies
    }
}

/// The camera that keys move, if there is one: the last.
fn last_camera(scene: &Scene) -> SceneCamera {
    scene.cameras.last().expect("a camera").clone()
}

/// Replaces the area light by punctual lights at its position, turned to the ring; the second stands across the scene.
fn replace_light(document: &mut Value, lights: Vec<Value>) {
    let node = |x: f64, light: usize| {
        let half_root = std::f64::consts::FRAC_1_SQRT_2;
        json!({
            "translation": [x, 2.6, 0.0],
            "rotation": [-0.5, 0.5f64.copysign(x), 0.0, half_root],
            "extensions": { "KHR_lights_punctual": { "light": light } },
        })
    };
    document["nodes"][LIGHT_NODE] = node(2.6, 0);
    if lights.len() > 1 {
        let nodes = document["nodes"].as_array_mut().expect("nodes");
        nodes.push(node(-2.6, 1));
        let added = json!(nodes.len() - 1);
        document["scenes"][0]["nodes"].as_array_mut().expect("roots").push(added);
    }
    document["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    let used = document["extensionsUsed"].as_array_mut().expect("extensions");
    used.push(json!("KHR_lights_punctual"));
}
