//! What every metric is given, and a metric as data.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use super::flip::PIXELS_PER_DEGREE;
use super::pixels::{Estimate, Pixels};
use caustics_files::image_file::Encoding;

/// How to look at the images.
#[derive(Clone, Copy, Debug)]
pub struct Viewing {
    /// What the images were read from.
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

/// A metric's value, or why there is none.
pub type MetricValue = Result<f64, NoValue>;

/// Why a metric has no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoValue {
    /// No metric of this name.
    #[error("no metric is called {0}")]
    Unknown(String),
    /// Some pixels are NaN or infinite: so many.
    #[error("{0} pixels are not finite")]
    NonFinite(usize),
    /// The value is NaN or infinite.
    #[error("its value is {0}")]
    Undefined(f64),
    /// No run.
    #[error("there is no image")]
    NoImage,
    /// PNG holds what a display shows.
    #[error("display colours have no high dynamic range; compare EXR files")]
    DisplayColours,
    /// Nothing to relate an error to.
    #[error("the reference is black")]
    BlackReference,
    /// The pixels where caustics are seen are not known, or there are none.
    #[error(
        "the reference has no layer caustics beside all its light, or no pixel of which they are a fifth"
    )]
    NoCausticRegion,
    /// The image's noise is not known.
    #[error("it takes several runs of the image, or a variance layer of it")]
    NoImageNoise,
    /// The reference's noise is not known, and is part of the bias.
    #[error("the reference has no variance layer; bias2 holds its variance too")]
    NoSplitReference,
    /// The reference's noise is not known.
    #[error("the reference has no variance layer")]
    NoReferenceNoise,
    /// The noise of one of the two is not known.
    #[error("it takes a variance layer of the reference, and several runs or a variance layer of the image")]
    NoNoise,
    /// A variance is negative, NaN or infinite.
    #[error("a variance layer has values that are no variances")]
    BadVariance,
}

/// Which values of a metric are good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// The lower the better; of a part that may be negative too.
    Lower,
    /// The nearer to 0 the better: the sign says which of the two images is brighter.
    NearZero,
    /// The nearer to 1 the better.
    NearOne,
}

/// A distance between images, as data.
#[derive(Debug)]
pub struct Metric {
    /// Name in reports and on the command line.
    pub name: &'static str,
    /// Description, in one line.
    pub description: &'static str,
    /// Its unit; "1" for a plain number, "unit" stands for that of the layer.
    pub unit: &'static str,
    /// Which values are good.
    pub better: Better,
    /// Limitations: where its value misleads, in one line.
    pub limitations: &'static str,
    /// Its value.
    pub compute: fn(&Comparison<'_>) -> MetricValue,
}

impl Metric {
    /// What a limit on the value is compared with.
    pub fn limited(&self, value: f64) -> f64 {
        if self.better == Better::NearZero { value.abs() } else { value }
    }
}

/// Runs of an image beside a reference of their size; all pixels are finite.
pub struct Comparison<'a> {
    /// The image, or several runs of it; at least one.
    pub runs: &'a [Estimate],
    /// What they should be.
    pub reference: &'a Estimate,
    /// How to look at them.
    pub viewing: Viewing,
    shared: RefCell<HashMap<TypeId, Rc<dyn Any>>>,
}

impl<'a> Comparison<'a> {
    /// A comparison of at least one run with a reference.
    ///
    /// # Errors
    ///
    /// If there is no run, or a pixel is NaN or infinite: then no metric has a value.
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

    /// What several metrics are made of, computed for the first of them; its type is its name.
    pub fn shared<T: 'static>(&self, compute: impl FnOnce(&Self) -> T) -> Rc<T> {
        let known = self.shared.borrow().get(&TypeId::of::<T>()).cloned();
        if let Some(known) = known.and_then(|known| known.downcast().ok()) {
            return known;
        }
        let value = Rc::new(compute(self));
        self.shared.borrow_mut().insert(TypeId::of::<T>(), Rc::clone(&value) as Rc<dyn Any>);
        value
    }

    /// Mean over the runs of a distance between one of them and the reference.
    pub fn mean(&self, distance: impl Fn(&Pixels, &Pixels) -> f64) -> f64 {
        let values = self.runs.iter().map(|run| distance(&run.mean, &self.reference.mean));
        values.sum::<f64>() / self.runs.len() as f64
    }
}
