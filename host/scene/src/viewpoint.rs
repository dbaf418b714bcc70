//! Placed cameras: the user's viewpoint, completed from the bounds of the scene.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use super::{Scene, SceneCamera, SceneError, geometry};

/// Default orbit: to the right of the front, which is +z in glTF, and above (degrees).
const THREE_QUARTER: Orbit = Orbit { azimuth: 30.0, elevation: 20.0, distance: None };
/// Default vertical field of view (degrees).
const FIELD: f64 = 40.0;
/// Maximum share of the image's width and height that the bounds fill.
const FILLED: f64 = 0.9;
/// Maximum elevation of an orbit (degrees): from straight above left and right are undefined.
const STEEPEST: f64 = 89.9;
/// Maximum distance of a position from the scene's origin (m): a multiple of the largest coordinate of a triangle.
const FARTHEST: f64 = 1e10;
/// Range of vertical fields of view for users (degrees).
pub const FIELDS: std::ops::RangeInclusive<f64> = 0.1..=170.0;

/// A position in the file's coordinates (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Position(pub DVec3);

/// A position on an orbit around the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Angle round the y axis, from +z towards +x (degrees).
    pub azimuth: f64,
    /// Angle above the plane of x and z (degrees), -90 to 90.
    pub elevation: f64,
    /// Distance from the target (m); `None`: the minimum that shows the whole scene.
    pub distance: Option<f64>,
}

/// Position of the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// At a position.
    At(Position),
    /// On an orbit around the target.
    On(Orbit),
}

/// Viewpoint of the user; missing parts follow from the scene's bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Viewpoint {
    /// Eye; `None`: a three-quarter view from the front that shows the whole scene.
    pub eye: Option<Eye>,
    /// Target; `None`: the centre of the bounds.
    pub look_at: Option<Position>,
    /// Vertical field of view (degrees), in (0, 180).
    pub field: Option<f64>,
}

/// Choice of the camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CameraChoice {
    /// The file's first camera; a three-quarter view if the file has none.
    #[default]
    First,
    /// Camera of this name.
    Named(String),
    /// A placed camera.
    Placed(Viewpoint),
}

impl CameraChoice {
    /// Reads the options: the name of a camera or `orbit:AZIMUTH,ELEVATION[,DISTANCE]`, positions, and a field of view.
    ///
    /// # Errors
    ///
    /// If options contradict each other, or an orbit or a field of view is invalid. The message names options without dashes.
    pub fn from_options(
        camera: Option<&str>,
        from: Option<Position>,
        look_at: Option<Position>,
        field: Option<f64>,
    ) -> Result<CameraChoice, String> {
        if let Some(field) = field.filter(|field| !FIELDS.contains(field)) {
            return Err(format!("fov {field}: give 0.1 to 170 degrees"));
        }
        let orbit = camera.and_then(|camera| camera.strip_prefix("orbit:"));
        let eye = match (orbit, from) {
            (Some(_), Some(_)) => {
                return Err("an orbit and from both say where the camera is; give one".into());
            }
            (Some(orbit), None) => Some(Eye::On(orbit.parse()?)),
            (None, from) => from.map(Eye::At),
        };
        let is_placed = eye.is_some() || look_at.is_some() || field.is_some();
        match camera.filter(|_| orbit.is_none()) {
            Some(name) if is_placed => Err(format!(
                "camera {name:?} is one of the file, and from, look-at and fov place another; leave one out"
            )),
            Some(name) => Ok(CameraChoice::Named(name.into())),
            None if is_placed => Ok(CameraChoice::Placed(Viewpoint { eye, look_at, field })),
            None => Ok(CameraChoice::First),
        }
    }
}

impl Orbit {
    /// Unit direction from the target to the eye.
    pub fn to_eye(&self) -> DVec3 {
        let (azimuth, elevation) =
            (self.azimuth.to_radians(), self.elevation.clamp(-STEEPEST, STEEPEST).to_radians());
        let level = elevation.cos();
        DVec3::new(level * azimuth.sin(), elevation.sin(), level * azimuth.cos())
    }
}

impl Viewpoint {
    /// Completes the viewpoint for a scene of these bounds (m) and images of this aspect ratio (width over height). Computed
    /// parts are rounded to five digits of the distance.
    pub fn whole(&self, [lower, upper]: [DVec3; 2], aspect: f64) -> Whole {
        let centre = 0.5 * (lower + upper);
        // A scene without extent counts as a metre wide.
        let radius = match 0.5 * lower.distance(upper) {
            radius if radius > 0.0 => radius,
            _ => 0.5,
        };
        let field = self.field.unwrap_or(FIELD);
        let target = self.look_at.map_or(centre, |position| position.0);
        let (eye, distance) = match self.eye.unwrap_or(Eye::On(THREE_QUARTER)) {
            Eye::At(Position(eye)) => (eye, eye.distance(target)),
            Eye::On(orbit) => {
                let to_eye = orbit.to_eye();
                let fitted = || fitted(to_eye, target, [lower, upper], field, aspect).max(0.5 * radius);
                let distance = orbit.distance.unwrap_or_else(fitted);
                (target + to_eye * distance, distance)
            }
        };
        // From the centre of the bounds the view goes along -z.
        let is_inside = self.look_at.is_none() && distance <= 1e-6 * radius;
        let (target, distance) =
            if is_inside { (eye - DVec3::Z * radius, radius) } else { (target, distance) };
        let look_at = self.look_at.unwrap_or_else(|| rounded(target, distance));
        let from = match self.eye {
            Some(Eye::At(position)) => position,
            _ => rounded(eye, distance),
        };
        Whole { from, look_at, field }
    }
}

/// Minimum distance at which all corners of the bounds are in view.
fn fitted(to_eye: DVec3, target: DVec3, bounds: [DVec3; 2], field: f64, aspect: f64) -> f64 {
    let (right, up) = axes(-to_eye);
    let tangent = (0.5 * field).to_radians().tan() * FILLED;
    let reach = |corner: DVec3| {
        let p = corner - target;
        let across = (p.dot(right).abs() / (tangent * aspect)).max(p.dot(up).abs() / tangent);
        p.dot(to_eye) + across
    };
    geometry::corners_of_box(bounds).into_iter().map(reach).fold(0.0, f64::max)
}

/// Right and up of a viewing direction, with y upwards.
fn axes(forward: DVec3) -> (DVec3, DVec3) {
    let right = forward.cross(DVec3::Y);
    let right = if right.length() > 1e-6 { right.normalize() } else { DVec3::X };
    (right, right.cross(forward).normalize())
}

/// Rounds a position to five digits of a distance.
fn rounded(position: DVec3, distance: f64) -> Position {
    let digits = (5.0 - distance.log10().ceil()).clamp(0.0, 300.0) as usize;
    // Adding zero turns -0 into 0.
    let value = |x: f64| format!("{x:.digits$}").parse().unwrap_or(x) + 0.0;
    Position(DVec3::from(position.to_array().map(value)))
}

/// A complete viewpoint. Its text is the options that place the same camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whole {
    /// Eye.
    pub from: Position,
    /// Target.
    pub look_at: Position,
    /// Vertical field of view (degrees).
    pub field: f64,
}

impl Scene {
    /// Returns a camera for images of this aspect ratio. [`Scene::bounds`] complete the viewpoint. The camera's name is the
    /// options that place it again.
    ///
    /// # Errors
    ///
    /// If eye and target coincide, or the eye is too far away.
    pub fn view_from(&self, viewpoint: &Viewpoint, aspect: f64) -> Result<SceneCamera, SceneError> {
        let bounds = self.bounds.map(|corner| self.origin + corner.as_dvec3());
        let whole = viewpoint.whole(bounds, aspect);
        self.camera_at(&whole, &whole.to_string())
    }

    /// Adds the camera of [`Scene::view_from`].
    ///
    /// # Errors
    ///
    /// Errors of [`Scene::view_from`].
    pub fn place_camera(&mut self, viewpoint: &Viewpoint, aspect: f64) -> Result<&SceneCamera, SceneError> {
        let camera = self.view_from(viewpoint, aspect)?;
        // The name is in the file's coordinates, the tables are relative to the origin.
        self.additions.insert("origin", self.origin.to_string());
        self.cameras.push(camera);
        Ok(&self.cameras[self.cameras.len() - 1])
    }

    /// The camera of a complete viewpoint.
    pub(super) fn camera_at(&self, whole: &Whole, name: &str) -> Result<SceneCamera, SceneError> {
        let wrong = |what| SceneError::Viewpoint { viewpoint: whole.to_string(), what };
        let Whole { from: Position(from), look_at: Position(look_at), field } = *whole;
        let Some(forward) = (look_at - from).try_normalize() else {
            return Err(wrong("looks at where it is"));
        };
        let position = from - self.origin;
        if !position.is_finite() || position.abs().max_element() > FARTHEST {
            return Err(wrong("is too far from the scene"));
        }
        let (right, up) = axes(forward);
        Ok(SceneCamera {
            name: name.into(),
            position: position.as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            forward: forward.as_vec3(),
            fov_y: field.to_radians() as f32,
            aspect: None,
        })
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let DVec3 { x, y, z } = self.0;
        write!(f, "{x},{y},{z}")
    }
}

impl fmt::Display for Whole {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Whole { from, look_at, field } = self;
        write!(f, "--from {from} --look-at {look_at} --fov {field}")
    }
}

impl FromStr for Position {
    type Err = String;

    fn from_str(text: &str) -> Result<Position, String> {
        match numbers(text).as_deref() {
            Some(&[x, y, z]) => Ok(Position(DVec3::new(x, y, z))),
            _ => Err("give three numbers of metres, such as 1.5,1,-3".into()),
        }
    }
}

impl FromStr for Orbit {
    type Err = String;

    fn from_str(text: &str) -> Result<Orbit, String> {
        let parts = numbers(text);
        let (azimuth, elevation, distance) = match parts.as_deref() {
            Some(&[azimuth, elevation]) => (azimuth, elevation, None),
            Some(&[azimuth, elevation, distance]) => (azimuth, elevation, Some(distance)),
            _ => {
                return Err(format!(
                    "orbit:{text}: give an azimuth and an elevation in degrees, and perhaps a distance in metres, such as \
                     orbit:30,20 or orbit:-90,10,2.5"
                ));
            }
        };
        if !(-90.0..=90.0).contains(&elevation) {
            return Err(format!("orbit:{text}: give an elevation of -90 to 90 degrees"));
        }
        if distance.is_some_and(|distance| distance <= 0.0) {
            return Err(format!("orbit:{text}: give a distance above zero"));
        }
        Ok(Orbit { azimuth, elevation, distance })
    }
}

/// Finite numbers, separated by commas.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let number = |part: &str| part.trim().parse().ok().filter(|value: &f64| value.is_finite());
    text.split(',').map(number).collect()
}

#[cfg(test)]
mod tests;
