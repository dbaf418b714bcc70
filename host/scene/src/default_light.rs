//! Default light of a scene without lights. A small bright light from the front left and above makes the caustics. A soft sky
//! leaves nothing black, and gives mirrors and glass something to show.

use caustics_kernels::interface::NONE;
use glam::{DAffine3, DQuat, DVec3, Vec3};

use super::animation::{Local, Node};
use super::motion::OnNode;
use super::viewpoint::Orbit;
use super::{EnvironmentMap, LightShape, PunctualLight, Scene, SceneError};

/// Distance of the light from the centre of the scene, in radii of its bounds.
const DISTANCE: f64 = 4.0;
/// Angles of the light's cone (rad): bright up to the first (asin(1 / 4) = 0.253 covers the bounds), zero from the second on.
const CONE: [f64; 2] = [0.27, 0.55];
/// Irradiance at the centre of the scene, on a plane across the light (W m^-2): a white surface has a radiance of about one.
const IRRADIANCE: f32 = 3.0;
/// Direction from the centre of the scene to the light.
const TO_LIGHT: Orbit = Orbit { azimuth: -35.0, elevation: 50.0, distance: None };
/// Radiance of the sky from top to bottom, in equal steps of angle (W m^-2 sr^-1).
const SKY: [f32; 4] = [0.5, 0.4, 0.25, 0.15];

impl Scene {
    /// Whether the scene has no light at any time.
    pub fn is_dark(&self) -> bool {
        self.lights.is_empty() && !self.lights_up()
    }

    /// Whether all lights are emissive materials, at any time.
    pub fn only_glows(&self) -> bool {
        let has_lights = self.motion.as_ref().is_some_and(|motion| !motion.lights.is_empty());
        !has_lights && self.lights.iter().all(|light| light.triangle != NONE)
    }

    /// Adds a light in proportion to [`Scene::bounds`], and a soft sky if the scene has none. Returns their description in words.
    ///
    /// # Errors
    ///
    /// If a moving scene cannot be posed at time 0, which it is set to.
    pub fn add_default_light(&mut self) -> Result<String, SceneError> {
        let [lower, upper] = self.bounds.map(|corner| corner.as_dvec3());
        let (centre, size) = (self.origin + 0.5 * (lower + upper), lower.distance(upper));
        let distance = if size > 0.0 { DISTANCE * 0.5 * size } else { DISTANCE };
        let to_light = TO_LIGHT.to_eye();
        let rotation = DQuat::from_rotation_arc(DVec3::NEG_Z, -to_light);
        let translation = centre + to_light * distance;
        let shape = LightShape::Spot { direction: Vec3::NEG_Z, inner: CONE[0], outer: CONE[1] };
        let intensity = Vec3::splat(IRRADIANCE * (distance * distance) as f32);
        let what = PunctualLight { position: Vec3::ZERO, intensity, shape };
        let to_world = DAffine3::from_rotation_translation(rotation, translation);
        match &mut self.motion {
            None => self.punctual_lights.extend(what.placed(&to_world, self.origin)),
            Some(motion) => {
                let joint = self.rig.joints.len();
                let local = Local { translation, rotation, ..Local::default() };
                let label = "the default light".into();
                self.rig.joints.push(Node { label, local, ..Node::default() });
                motion.lights.push(OnNode { joint, moves: false, what });
            }
        }
        let mut words = format!("a spot from the front left ({IRRADIANCE} W m^-2 in the middle)");
        if self.environment.records.is_empty() {
            let sky = SKY.map(Vec3::splat).to_vec();
            self.set_environment(EnvironmentMap::new(1, SKY.len() as u32, sky))?;
            let (above, below) = (SKY[0], SKY[SKY.len() - 1]);
            words += &format!(" and a soft sky ({above} to {below} W m^-2 sr^-1)");
        } else {
            self.light_again()?;
        }
        self.additions.insert("light", format!("default: {words}"));
        Ok(words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolve;
    use caustics_kernels::interface::features::Features;

    /// Loads the scene without its lights.
    fn dark(name: &str) -> Scene {
        let mut scene = Scene::load(&resolve(name).unwrap()).unwrap();
        for material in &mut scene.materials {
            material.emission = Vec3::ZERO;
        }
        scene.emitters.clear();
        scene.light_again().unwrap();
        scene
    }

    #[test]
    fn default_light_covers_bounds_of_any_size() {
        let scene = dark("ring");
        assert!(scene.is_dark());
        for scale in [1e-3_f32, 1.0, 1e6] {
            let mut scene = scene.clone();
            scene.bounds = scene.bounds.map(|corner| corner * scale);
            scene.add_default_light().unwrap();
            let key = scene.lights.iter().find(|light| light.cone > 0.0).unwrap();
            let centre = 0.5 * (scene.bounds[0] + scene.bounds[1]);
            let radius = 0.5 * scene.bounds[0].distance(scene.bounds[1]);
            let along = (centre - key.position).length();
            // The sphere around the bounds lies in the cone's bright part, and the centre gets the stated irradiance.
            assert!(f64::from(radius / along).asin() < CONE[0], "{radius} {along}");
            assert!((key.emission.x / (along * along) / IRRADIANCE - 1.0).abs() < 1e-4);
            assert!((centre - key.position).normalize().dot(key.direction) > 1.0 - 1e-5);
        }
    }

    #[test]
    fn default_light_and_sky_light_every_side() {
        let mut scene = dark("ring");
        scene.add_default_light().unwrap();
        assert!(!scene.is_dark() && scene.lights.len() == 2);
        assert_eq!(scene.lights[1].kind, Features::ENVIRONMENT.0);
        assert!(scene.environment.texels.iter().all(|radiance| radiance.min_element() > 0.0));
    }

    #[test]
    fn default_light_keeps_the_lights_of_the_scene() {
        for name in ["ring", "moving-caster", "still-life"] {
            let mut scene = Scene::load(&resolve(name).unwrap()).unwrap();
            let before = scene.clone();
            scene.add_default_light().unwrap();
            assert_eq!(scene.lights.len(), before.lights.len() + 2, "{name}");
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
    fn default_light_stays_in_place_while_nodes_move() {
        let mut scene = dark("moving-caster");
        scene.add_default_light().unwrap();
        let before = scene.lights.clone();
        scene.pose(0.5).unwrap();
        let directions = |lights: &[caustics_kernels::interface::light::Light]| {
            lights.iter().map(|light| (light.direction, light.emission)).collect::<Vec<_>>()
        };
        assert_eq!(directions(&before), directions(&scene.lights));
        assert_eq!(before.len(), 2);
    }
}
