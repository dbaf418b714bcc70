//! A camera for a scene that has none, or for who wants another: what a person says of it, and what follows from the bounds.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use super::{Scene, SceneCamera, SceneError, geometry};

/// Where it stands if nobody says so: to the right of the front, which is +z in glTF, and above (degrees).
const THREE_QUARTER: Orbit = Orbit { azimuth: 30.0, elevation: 20.0, distance: None };
/// Vertical field of view if nobody says so (degrees).
const FIELD: f64 = 40.0;
/// Share of the image that the bounds fill at most, along its width and its height.
const FILLED: f64 = 0.9;
/// Steepest orbit (degrees): from straight above there is no right and left.
const STEEPEST: f64 = 89.9;
/// Farthest position from the scene's origin (m): some times the largest coordinate of a triangle.
const FARTHEST: f64 = 1e10;
/// Vertical fields of view that a person may ask for (degrees).
pub const FIELDS: std::ops::RangeInclusive<f64> = 0.1..=170.0;

/// A position in the file's coordinates (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Position(pub DVec3);

/// A way round what is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Angle round the y axis, from +z towards +x (degrees).
    pub azimuth: f64,
    /// Angle above the plane of x and z (degrees), -90 to 90.
    pub elevation: f64,
    /// Distance from what is looked at (m); none: so that all is in view.
    pub distance: Option<f64>,
}

/// Where the eye is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// At a position.
    At(Position),
    /// On a way round what is looked at.
    On(Orbit),
}

/// What a person says of a camera; the rest follows from the scene's bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Viewpoint {
    /// Where the eye is; none: a three-quarter view from the front, all in view.
    pub eye: Option<Eye>,
    /// What it looks at; none: the centre of the bounds.
    pub look_at: Option<Position>,
    /// Vertical field of view (degrees), in (0, 180).
    pub field: Option<f64>,
}

/// Which camera is looked through.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CameraChoice {
    /// The file's first; a three-quarter view where it has none.
    #[default]
    First,
    /// That of a name.
    Named(String),
    /// One that is placed, whatever the file has.
    Placed(Viewpoint),
}

impl CameraChoice {
    /// What options say: the name of a camera, or `orbit:AZIMUTH,ELEVATION[,DISTANCE]`; positions and a field of view.
    ///
    /// # Errors
    ///
    /// If they contradict each other, or an orbit or a field of view is none; the message names no option's dashes.
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
    /// Unit direction from what is looked at to the eye.
    pub fn to_eye(&self) -> DVec3 {
        let (azimuth, elevation) =
            (self.azimuth.to_radians(), self.elevation.clamp(-STEEPEST, STEEPEST).to_radians());
        let level = elevation.cos();
        DVec3::new(level * azimuth.sin(), elevation.sin(), level * azimuth.cos())
    }
}

impl Viewpoint {
    /// With nothing left open, for a scene of these bounds (m) and images of this width over height; what was left open is
    /// rounded to five digits of the distance.
    pub fn whole(&self, [lower, upper]: [DVec3; 2], aspect: f64) -> Whole {
        let centre = 0.5 * (lower + upper);
        // A scene of no extent is looked at as if it were a metre wide.
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
        // From the centre of the bounds itself, along -z.
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

/// The least distance at which all corners of the bounds are in view.
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

/// To the right and upwards of who looks this way, y upwards.
fn axes(forward: DVec3) -> (DVec3, DVec3) {
    let right = forward.cross(DVec3::Y);
    let right = if right.length() > 1e-6 { right.normalize() } else { DVec3::X };
    (right, right.cross(forward).normalize())
}

/// A position, rounded to five digits of a distance.
fn rounded(position: DVec3, distance: f64) -> Position {
    let digits = (5.0 - distance.log10().ceil()).clamp(0.0, 300.0) as usize;
    // Adding zero makes -0 a plain one.
    let value = |x: f64| format!("{x:.digits$}").parse().unwrap_or(x) + 0.0;
    Position(DVec3::from(position.to_array().map(value)))
}

/// A viewpoint with nothing left open. It is spelled as the options that give it again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whole {
    /// Where the eye is.
    pub from: Position,
    /// What it looks at.
    pub look_at: Position,
    /// Vertical field of view (degrees).
    pub field: f64,
}

impl Scene {
    /// A camera for images of this width over height. What is left open follows from [`Scene::bounds`]; the camera's name is the
    /// options that give it again.
    ///
    /// # Errors
    ///
    /// If it would look at where it is, or is too far away.
    pub fn view_from(&self, viewpoint: &Viewpoint, aspect: f64) -> Result<SceneCamera, SceneError> {
        let bounds = self.bounds.map(|corner| self.origin + corner.as_dvec3());
        let whole = viewpoint.whole(bounds, aspect);
        self.camera_at(&whole, &whole.to_string())
    }

    /// Adds [`Scene::view_from`].
    ///
    /// # Errors
    ///
    /// The same.
    pub fn place_camera(&mut self, viewpoint: &Viewpoint, aspect: f64) -> Result<&SceneCamera, SceneError> {
        let camera = self.view_from(viewpoint, aspect)?;
        // Its name speaks of the file's coordinates, the tables of those around the origin.
        self.additions.insert("origin", self.origin.to_string());
        self.cameras.push(camera);
        Ok(&self.cameras[self.cameras.len() - 1])
    }

    /// The camera at a viewpoint.
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

/// Finite numbers with commas between.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let number = |part: &str| part.trim().parse().ok().filter(|value: &f64| value.is_finite());
    text.split(',').map(number).collect()
}

#[cfg(test)]
mod tests;
