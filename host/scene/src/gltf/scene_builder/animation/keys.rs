//! Keys of a channel: times and values.

use glam::{DVec4, Vec3};
use gltf::json::Index;
use gltf::json::accessor::Accessor;

use crate::SceneError;
use crate::animation::{Channel, Interpolation, Path};
use crate::gltf::accessor::AccessorReader;
use crate::gltf::context::ImportContext;
use crate::gltf::document::Document;
use crate::gltf::document::sections::JsonKeys;

/// Largest time (s).
const MAX_TIME: f32 = 1e9;
/// Largest component of a value.
const MAX_VALUE: f64 = 1e30;
/// Maximum length of a quaternion that is not a rotation.
const MIN_LENGTH: f64 = 1e-6;
/// Memory of a time, while it is read and in the scene (bytes).
const TIME_BYTES: u64 = 12;
/// Memory of a value, while it is read and in the scene (bytes).
const VALUE_BYTES: u64 = 48;

/// Reader of the keys of a channel.
pub struct KeyReader<'a> {
    pub document: &'a Document,
    /// Accessors of the keys.
    pub sampler: &'a JsonKeys,
    /// Member that the keys set.
    pub path: Path,
    /// Number of morph targets of the node's mesh.
    pub targets: usize,
    /// Name of the channel in messages.
    pub owner: &'a str,
}

impl KeyReader<'_> {
    /// Reads the keys; weights give a channel for every four targets.
    pub fn read(&self, context: &mut ImportContext<'_>) -> Result<Vec<Channel>, SceneError> {
        let wrong = |context: &ImportContext<'_>, what: String| context.animation_error(self.owner, what);
        let interpolation = self.interpolation().map_err(|what| wrong(context, what))?;
        let index = |index: Option<u32>, name: &str| {
            index.map(Index::new).ok_or_else(|| wrong(context, format!("has no {name}")))
        };
        let input = index(self.sampler.input, "input")?;
        let output = index(self.sampler.output, "output")?;

        // Reserve memory for the keys, while they are read and in the scene
        let accessors = AccessorReader::new(self.document, context, self.owner);
        let (keys, values) = (accessors.count(input)?, accessors.count(output)?);
        let bytes = keys.saturating_mul(TIME_BYTES).saturating_add(values.saturating_mul(VALUE_BYTES));
        context.take(bytes, format_args!("{}", self.owner))?;

        // Read and check
        let times: Vec<f32> = accessors.numbers(input)?.into_iter().map(|[time]| time).collect();
        let values = match self.path {
            Path::Weights => {
                let weights = accessors.numbers(output)?.into_iter().map(|[weight]: [f32; 1]| weight.into());
                self.weights(&weights.collect::<Vec<f64>>()).map_err(|what| wrong(context, what))?
            }
            _ => vec![self.vectors(&accessors, output)?],
        };
        check_times(&times).map_err(|what| wrong(context, what))?;
        for values in &values {
            self.check_values(values, times.len(), interpolation).map_err(|what| wrong(context, what))?;
        }
        let times: Vec<f64> = times.into_iter().map(f64::from).collect();
        let channel = |values| Channel { path: self.path, interpolation, times: times.clone(), values };
        Ok(values.into_iter().map(channel).collect())
    }

    fn interpolation(&self) -> Result<Interpolation, String> {
        match self.sampler.interpolation.as_deref() {
            Some("STEP") => Ok(Interpolation::Step),
            None | Some("LINEAR") => Ok(Interpolation::Linear),
            Some("CUBICSPLINE") => Ok(Interpolation::Cubic),
            Some(name) => Err(format!("has the interpolation {name:?}, which glTF does not know")),
        }
    }

    /// Reads rotations or vectors.
    fn vectors(
        &self,
        accessors: &AccessorReader<'_>,
        output: Index<Accessor>,
    ) -> Result<Vec<DVec4>, SceneError> {
        if self.path == Path::Rotation {
            let values = accessors.numbers::<4>(output)?;
            return Ok(values.into_iter().map(|value| DVec4::from(value.map(f64::from))).collect());
        }
        let values = accessors.numbers::<3>(output)?;
        Ok(values.into_iter().map(|value| Vec3::from(value).as_dvec3().extend(0.0)).collect())
    }

    /// Weights in groups of four targets.
    fn weights(&self, values: &[f64]) -> Result<Vec<Vec<DVec4>>, String> {
        let (count, targets) = (values.len(), self.targets);
        if !count.is_multiple_of(targets) {
            return Err(format!("has {count} weights, no multiple of its {targets} targets"));
        }
        let four = |first: usize| {
            let weights = |key: &[f64]| {
                DVec4::from(std::array::from_fn(|at| key.get(first + at).copied().unwrap_or(0.0)))
            };
            values.chunks(targets).map(weights).collect()
        };
        Ok((0..targets).step_by(4).map(four).collect())
    }

    /// Refuses values that are not usable, or whose number does not fit the keys.
    fn check_values(
        &self,
        values: &[DVec4],
        keys: usize,
        interpolation: Interpolation,
    ) -> Result<(), String> {
        let is_spline = interpolation == Interpolation::Cubic;
        let (count, needed) = (values.len(), keys * if is_spline { 3 } else { 1 });
        if count != needed {
            return Err(format!("has {count} values for {keys} keys, but {needed} are needed"));
        }
        let usable = |value: &DVec4| value.is_finite() && value.abs().max_element() <= MAX_VALUE;
        if let Some(id) = values.iter().position(|value| !usable(value)) {
            return Err(format!("has a value that is not finite or beyond 1e30 (value {id})"));
        }
        let mut at_keys = values.iter().skip(usize::from(is_spline)).step_by(if is_spline { 3 } else { 1 });
        if self.path == Path::Rotation
            && let Some(key) = at_keys.position(|value| value.length() <= MIN_LENGTH)
        {
            return Err(format!("has a rotation of no length (key {key})"));
        }
        Ok(())
    }
}

/// Refuses times that are not usable.
fn check_times(times: &[f32]) -> Result<(), String> {
    if times.is_empty() {
        return Err("has no keys".into());
    }
    if !times.iter().all(|time| (0.0..=MAX_TIME).contains(time)) {
        return Err("has a time that is negative, beyond 1e9 s or not a number".into());
    }
    if let Some(key) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
        return Err(format!("has times that do not ascend (key {})", key + 1));
    }
    Ok(())
}
