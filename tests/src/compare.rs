//! Comparison of the results of two runners: slices of floats, of words, or records field by field.

use crate::fields::{Field, Fields, Kind};
use caustics_kernels::interface::packed::from_signed_shares;

/// Largest difference that two computations of one quantity may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Absolute difference that is allowed (unit of the field).
    pub absolute: f32,
    /// Relative difference that is allowed as well, over the larger magnitude (of the whole vector, for vectors).
    pub relative: f32,
    /// Share of the elements that may exceed both.
    pub share: f64,
    /// Reason of the tolerance.
    pub reason: &'static str,
}

impl Tolerance {
    /// Equal bits everywhere.
    pub const EXACT: Tolerance = Tolerance {
        absolute: 0.0,
        relative: 0.0,
        share: 0.0,
        reason: "integers and copies have no rounding",
    };

    /// Allows this relative difference, and as much absolute difference for values up to `scale`.
    pub const fn relative(relative: f32, scale: f32, reason: &'static str) -> Tolerance {
        Tolerance { absolute: relative * scale, relative, share: 0.0, reason }
    }

    /// Allows a share of the elements to exceed the tolerance.
    pub const fn except(self, share: f64, reason: &'static str) -> Tolerance {
        Tolerance { share, reason, ..self }
    }

    /// Number of elements out of `count` that may exceed the tolerance.
    pub fn allowed(&self, count: usize) -> usize {
        (count as f64 * self.share).floor() as usize
    }
}

/// Difference of two slices in one field.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Name of the field.
    pub name: String,
    /// Number of elements of the longer slice.
    pub count: usize,
    /// Largest absolute difference of a component; infinite if either value is NaN.
    pub max_abs: f32,
    /// Largest difference relative to the larger magnitude.
    pub max_rel: f32,
    /// Number of elements that exceed the tolerance; elements that only one slice has count too.
    pub exceeding: usize,
    /// Index of the first of them.
    pub first: Option<usize>,
    /// Indices of all of them, for explanations.
    pub indices: Vec<usize>,
    /// The tolerance.
    pub tolerance: Tolerance,
}

impl Difference {
    /// Whether no more elements exceed the tolerance than it allows.
    pub fn passes(&self) -> bool {
        self.exceeding <= self.tolerance.allowed(self.count)
    }

    fn new(name: &str, count: usize, tolerance: Tolerance) -> Difference {
        let (max_abs, max_rel, exceeding) = (0.0, 0.0, 0);
        Difference {
            name: name.into(),
            count,
            max_abs,
            max_rel,
            exceeding,
            first: None,
            indices: vec![],
            tolerance,
        }
    }

    fn add(&mut self, index: usize, absolute: f32, relative: f32, exceeds: bool) {
        self.max_abs = self.max_abs.max(absolute);
        self.max_rel = self.max_rel.max(relative);
        if exceeds {
            self.exceeding += 1;
            self.first = self.first.or(Some(index));
            self.indices.push(index);
        }
    }
}

/// Compares vectors of `components` floats each.
pub fn floats(
    name: &str,
    components: usize,
    left: &[f32],
    right: &[f32],
    tolerance: Tolerance,
) -> Difference {
    let count = left.len().max(right.len()) / components;
    let mut difference = Difference::new(name, count, tolerance);
    for index in 0..count {
        let range = index * components..(index + 1) * components;
        let (absolute, relative, exceeds) = match (left.get(range.clone()), right.get(range)) {
            (Some(left), Some(right)) => float_element(left, right, &tolerance),
            _ => (f32::INFINITY, f32::INFINITY, true),
        };
        difference.add(index, absolute, relative, exceeds);
    }
    difference
}

fn float_element(left: &[f32], right: &[f32], tolerance: &Tolerance) -> (f32, f32, bool) {
    let pairs = || left.iter().zip(right);
    if left.iter().chain(right).any(|value| value.is_nan()) {
        return (f32::INFINITY, f32::INFINITY, true);
    }
    // Equal infinities are equal; their difference would be NaN.
    let absolute = pairs().map(|(a, b)| if a == b { 0.0 } else { (a - b).abs() }).fold(0.0, f32::max);
    let largest = left.iter().chain(right).fold(0.0f32, |largest, value| largest.max(value.abs()));
    let relative = if absolute == 0.0 { 0.0 } else { absolute / largest };
    let allowed = tolerance.absolute + tolerance.relative * largest;
    // Reject infinite differences explicitly: an infinite magnitude makes `allowed` infinite.
    (absolute, relative, absolute > allowed || absolute.is_infinite())
}

/// Compares groups of `components` words each: an element with any differing bit exceeds.
pub fn words(name: &str, components: usize, left: &[u32], right: &[u32], tolerance: Tolerance) -> Difference {
    let count = left.len().max(right.len()) / components;
    let mut difference = Difference::new(name, count, tolerance);
    for index in 0..count {
        let range = index * components..(index + 1) * components;
        let (absolute, exceeds) = match (left.get(range.clone()), right.get(range)) {
            (Some(left), Some(right)) => {
                (left.iter().zip(right).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0), left != right)
            }
            _ => (u32::MAX, true),
        };
        difference.add(index, absolute as f32, 0.0, exceeds);
    }
    difference
}

/// Compares records field by field; `tolerance` returns the tolerance of a float field. Words must agree.
pub fn records<T: Fields>(
    left: &[T],
    right: &[T],
    words_tolerance: Tolerance,
    tolerance: impl Fn(&Field) -> Tolerance,
) -> Vec<Difference> {
    let compare = |field: &Field| {
        let (left, right) = (column(left, field), column(right, field));
        match field.kind {
            Kind::Floats => {
                let (left, right) = (bytemuck::cast_slice(&left), bytemuck::cast_slice(&right));
                floats(field.name, field.words, left, right, tolerance(field))
            }
            Kind::Shares => {
                let shares = |words: Vec<u32>| -> Vec<f32> {
                    words.into_iter().flat_map(|word| from_signed_shares(word).to_array()).collect()
                };
                floats(field.name, 2 * field.words, &shares(left), &shares(right), tolerance(field))
            }
            Kind::Words => words(field.name, field.words, &left, &right, words_tolerance),
        }
    };
    T::FIELDS.iter().map(compare).collect()
}

/// Words of one field of all records.
fn column<T: Fields>(records: &[T], field: &Field) -> Vec<u32> {
    let range = field.first..field.first + field.words;
    let words = records
        .iter()
        .flat_map(|record| &bytemuck::cast_slice::<T, u32>(std::slice::from_ref(record))[range.clone()]);
    words.copied().collect()
}

#[cfg(test)]
#[path = "compare/tests.rs"]
mod tests;
