//! Light for a scene that has none: three lamps, as a photographer sets them for a thing on a table. A key from the front left and
//! above, which makes the caustics; a fill from the right, so that nothing that it leaves out is black; a rim from behind.

use glam::{DAffine3, DQuat, DVec3, Vec3};

use super::animation::{Local, Node};
use super::motion::OnNode;
use super::viewpoint::Orbit;
use super::{LightShape, PunctualLight, Scene, light};

/// The key's distance from the middle of the scene, in radii of its bounds.
const DISTANCE: f64 = 4.0;
/// Angles of the key's cone (rad): the bounds are in its bright part (asin(1 / 4) = 0.253), a floor around them fades out.
const CONE: [f64; 2] = [0.27, 0.55];
/// What each lamp's light brings to a plane across, in the middle of the scene (W m^-2): a white thing has a radiance of about one.
const IRRADIANCE: [f32; 3] = [3.0, 0.6, 0.3];
/// Directions to the lamps.
const TO_LAMP: [Orbit; 3] = [of(-35.0, 50.0), of(65.0, 15.0), of(195.0, 25.0)];
/// Radiance behind everything (W m^-2 sr^-1): mirrors and glass would show nothing else than black.
const BACKGROUND: f32 = 0.1;

const fn of(azimuth: f64, elevation: f64) -> Orbit {
    Orbit { azimuth, elevation, distance: None }
}

impl Scene {
    /// Whether there is no light at any time.
    pub fn is_dark(&self) -> bool {
        let can_be_lit = self.motion.as_ref().is_some_and(super::Motion::has_light);
        self.lights.is_empty() && !can_be_lit
    }

    /// Lights a scene at time 0 by three lamps beside those it has, in proportion to [`Scene::bounds`], before a dim background where
    /// it has none. What they are, in words.
    pub fn add_default_light(&mut self) -> String {
        let [lower, upper] = self.bounds.map(|corner| corner.as_dvec3());
        let (centre, size) = (self.origin + 0.5 * (lower + upper), lower.distance(upper));
        let distance = if size > 0.0 { DISTANCE * 0.5 * size } else { DISTANCE };
        let lamps = TO_LAMP.iter().zip(IRRADIANCE).enumerate().map(|(id, (orbit, irradiance))| {
            let to_lamp = orbit.to_eye();
            let turn = DQuat::from_rotation_arc(DVec3::NEG_Z, -to_lamp);
            let (shape, intensity) = match id {
                0 => {
                    let direction = Vec3::NEG_Z;
                    let square = (distance * distance) as f32;
                    (LightShape::Spot { direction, inner: CONE[0], outer: CONE[1] }, irradiance * square)
                }
                _ => (LightShape::Directional { direction: Vec3::NEG_Z }, irradiance),
            };
            let what = PunctualLight { position: Vec3::ZERO, intensity: Vec3::splat(intensity), shape };
            (what, turn, centre + to_lamp * distance)
        });
        let lamps: Vec<_> = lamps.collect();
        let (emitters, mut lights) = match &self.motion {
            None => (light::emitters(self.tables()), std::mem::take(&mut self.punctual_lights)),
            Some(motion) => (motion.emitters.clone(), motion.lights_at_first(self.origin)),
        };
        let placed = lamps.iter().filter_map(|(what, turn, place)| {
            what.placed(&DAffine3::from_rotation_translation(*turn, *place), self.origin)
        });
        lights.extend(placed);
        self.light(&emitters, &lights);
        if self.motion.is_none() {
            self.punctual_lights = lights;
        }
        if let Some(motion) = &mut self.motion {
            for (what, rotation, translation) in lamps {
                let joint = motion.rig.joints.len();
                let local =
                    Local { translation, rotation, scale: DVec3::ONE, matrix: None, channels: Vec::new() };
                let label = "the default light".into();
                motion.rig.joints.push(Node { label, parent: None, local, moves: false });
                motion.lights.push(OnNode { joint, moves: false, what });
            }
        }
        if self.background == Vec3::ZERO {
            self.background = Vec3::splat(BACKGROUND);
        }
        let [key, fill, rim] = IRRADIANCE;
        let words = format!(
            "a spot from the front left ({key} W m^-2 in the middle), weaker light from the right ({fill}) and from behind ({rim})"
        );
        self.additions.insert("light", format!("default: {words}"));
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    /// `ring` without its lamp.
    fn dark(name: &str) -> Scene {
        let mut scene = Scene::load(&scene::resolve(name).unwrap()).unwrap();
        for material in &mut scene.materials {
            material.emission = Vec3::ZERO;
        }
        scene.light(&[], &[]);
        if let Some(motion) = &mut scene.motion {
            motion.emitters.clear();
        }
        scene
    }

    #[test]
    fn the_key_holds_the_bounds_whatever_their_size() {
        let scene = dark("ring");
        assert!(scene.is_dark());
        for scale in [1e-3_f32, 1.0, 1e6] {
            let mut scene = scene.clone();
            scene.bounds = scene.bounds.map(|corner| corner * scale);
            scene.add_default_light();
            let key = scene.lights.iter().find(|light| light.cone > 0.0).unwrap();
            let centre = 0.5 * (scene.bounds[0] + scene.bounds[1]);
            let radius = 0.5 * scene.bounds[0].distance(scene.bounds[1]);
            let along = (centre - key.position).length();
            // The ball around the bounds is in the cone's bright part, with the irradiance that is promised.
            assert!(f64::from(radius / along).asin() < CONE[0], "{radius} {along}");
            assert!((key.emission.x / (along * along) / IRRADIANCE[0] - 1.0).abs() < 1e-4);
            assert!((centre - key.position).normalize().dot(key.direction) > 1.0 - 1e-5);
        }
    }

    #[test]
    fn every_side_is_lit() {
        let mut scene = dark("ring");
        scene.add_default_light();
        assert!(!scene.is_dark() && scene.lights.len() == 3);
        for side in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::Z, Vec3::NEG_Z] {
            let sees = |light: &caustics_kernels::interface::light::Light| side.dot(-light.direction) > 0.05;
            assert!(scene.lights.iter().any(sees), "{side}");
        }
    }

    #[test]
    fn light_that_is_there_stays() {
        for name in ["ring", "moving-caster", "still-life"] {
            let mut scene = Scene::load(&scene::resolve(name).unwrap()).unwrap();
            let before = scene.clone();
            scene.add_default_light();
            assert_eq!(scene.lights.len(), before.lights.len() + 3, "{name}");
            for (with, without) in scene.lights.iter().zip(&before.lights) {
                assert_eq!((with.emission, with.triangle), (without.emission, without.triangle), "{name}");
                assert!(with.pdf_light_choice < without.pdf_light_choice, "{name}");
            }
            assert!(scene.flux.cmpgt(before.flux).all());
            assert_eq!(scene.surfaces, before.surfaces);
            let first = scene.lights.clone();
            scene.pose(0.0).unwrap();
            assert_eq!(scene.lights, first, "{name}");
        }
    }

    #[test]
    fn it_stays_where_it_is_while_things_move() {
        let mut scene = dark("moving-caster");
        scene.add_default_light();
        let before = scene.lights.clone();
        scene.pose(0.5).unwrap();
        let places = |lights: &[caustics_kernels::interface::light::Light]| {
            lights.iter().map(|light| (light.direction, light.emission)).collect::<Vec<_>>()
        };
        assert_eq!(places(&before), places(&scene.lights));
        assert_eq!(before.len(), 3);
    }
}
