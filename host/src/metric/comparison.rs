//! Inputs of every metric, and a metric as data.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use super::flip::PIXELS_PER_DEGREE;
use super::pixels::{Estimate, Pixels};
use caustics_files::image_file::Encoding;

/// Viewing conditions.
#[derive(Clone, Copy, Debug)]
pub struct Viewing {
    /// Encoding of the images' files.
    pub encoding: Encoding,
    /// Exposure of scene-linear images for `flip_ldr` (stops).
    pub exposure: f64,
    /// Pixels per degree of visual angle.
    pub pixels_per_degree: f64,
}

impl Default for Viewing {
    fn default() -> Viewing {
        Viewing { encoding: Encoding::Linear, exposure: 0.0, pixels_per_degree: PIXELS_PER_DEGREE }
    }
}

/// Value of a metric, or the reason why it has none.
pub type MetricValue = Result<f64, NoValue>;

/// Reason why a metric has no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoValue {
    /// There is no metric of this name.
    #[error("no metric is called {0}")]
    Unknown(String),
    /// This number of pixels are NaN or infinite.
    #[error("{0} pixels are not finite")]
    NonFinite(usize),
    /// The value is NaN or infinite.
    #[error("its value is {0}")]
    Undefined(f64),
    /// There is no run.
    #[error("there is no image")]
    NoImage,
    /// The images are PNG files, which hold display colours.
    #[error("display colours have no high dynamic range; compare EXR files")]
    DisplayColours,
    /// The reference is black, so that relative errors are undefined.
    #[error("the reference is black")]
    BlackReference,
    /// The caustic region is unknown or empty.
    #[error(
        "the reference has no layer caustics beside all its light, or no pixel of which they are a fifth"
    )]
    NoCausticRegion,
    /// The image's noise is unknown.
    #[error("it takes several runs of the image, or a variance layer of it")]
    NoImageNoise,
    /// The reference's noise is unknown and remains in the bias.
    #[error("the reference has no variance layer; bias2 holds its variance too")]
    NoSplitReference,
    /// The reference's noise is unknown.
    #[error("the reference has no variance layer")]
    NoReferenceNoise,
    /// The noise of the image or of the reference is unknown.
    #[error("it takes a variance layer of the reference, and several runs or a variance layer of the image")]
    NoNoise,
    /// A variance is negative, NaN or infinite.
    #[error("a variance layer has values that are no variances")]
    BadVariance,
}

/// Direction in which a metric's values are better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// Lower is better, also for a part that may be negative.
    Lower,
    /// Nearer to 0 is better; the sign tells which image is brighter.
    NearZero,
    /// Nearer to 1 is better.
    NearOne,
}

/// Metric as data: a distance between images.
#[derive(Debug)]
pub struct Metric {
    /// Name in reports and on the command line.
    pub name: &'static str,
    /// Description in one line.
    pub description: &'static str,
    /// Unit: "1" for a plain number, "unit" for the unit of the layer.
    pub unit: &'static str,
    /// Direction in which values are better.
    pub better: Better,
    /// Limitations in one line: cases in which the value misleads.
    pub limitations: &'static str,
    /// Function that computes the value.
    pub compute: fn(&Comparison<'_>) -> MetricValue,
}

impl Metric {
    /// Returns the value that a limit is compared with.
    pub fn limited(&self, value: f64) -> f64 {
        if self.better == Better::NearZero { value.abs() } else { value }
    }
}

/// Runs of an image and a reference of the same size. All pixels are finite.
pub struct Comparison<'a> {
    /// The image, or several runs of it; at least one.
    pub runs: &'a [Estimate],
    /// The reference.
    pub reference: &'a Estimate,
    /// Viewing conditions.
    pub viewing: Viewing,
    shared: RefCell<HashMap<TypeId, Rc<dyn Any>>>,
}

impl<'a> Comparison<'a> {
    /// Compares at least one run with a reference.
    ///
    /// # Errors
    ///
    /// If there is no run, or a pixel is NaN or infinite. Then no metric has a value.
    pub fn new(
        runs: &'a [Estimate],
        reference: &'a Estimate,
        viewing: Viewing,
    ) -> Result<Comparison<'a>, NoValue> {
        let bad = runs.iter().chain([reference]).map(|image| image.mean.non_finite_count()).sum();
        match (runs, bad) {
            ([], _) => Err(NoValue::NoImage),
            (_, 0) => Ok(Comparison { runs, reference, viewing, shared: RefCell::default() }),
            _ => Err(NoValue::NonFinite(bad)),
        }
    }

    /// Returns a value that several metrics need. The first call computes it; its type is its key.
    pub fn shared<T: 'static>(&self, compute: impl FnOnce(&Self) -> T) -> Rc<T> {
        let known = self.shared.borrow().get(&TypeId::of::<T>()).cloned();
        if let Some(known) = known.and_then(|known| known.downcast().ok()) {
            return known;
        }
        let value = Rc::new(compute(self));
        self.shared.borrow_mut().insert(TypeId::of::<T>(), Rc::clone(&value) as Rc<dyn Any>);
        value
    }

    /// Returns the mean over runs of a distance between run and reference.
    pub fn mean(&self, distance: impl Fn(&Pixels, &Pixels) -> f64) -> f64 {
        let values = self.runs.iter().map(|run| distance(&run.mean, &self.reference.mean));
        values.sum::<f64>() / self.runs.len() as f64
    }
}
