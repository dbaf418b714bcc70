//! Values of a sweep's file, each of which knows what it may be.

use caustics_kernels::gather::variant::{self, Variant};
use serde::de::Error;
use serde::{Deserialize, Deserializer};

use crate::experiment::cell::Code;
use crate::experiment::matrix::RUNNERS;
use caustics_kernels::declare::TextureFilter;
use caustics_kernels::denoiser::{self, Denoiser};
use caustics_kernels::history::{self, History};
use caustics_kernels::method::{self, Method};

/// A list that is not empty.
#[derive(Clone, Debug)]
pub struct NonEmpty<T>(pub Vec<T>);

/// A thing by its name.
#[derive(Clone, Copy, Debug)]
pub struct ByName<T>(pub T);

/// What has a name.
pub trait Known: Sized {
    /// What such a thing is called.
    const WHAT: &'static str;
    /// All names.
    fn names() -> Vec<&'static str>;
    /// The thing of a name.
    fn find(name: &str) -> Option<Self>;
}

/// A name of [`RUNNERS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Runner(pub &'static str);

/// A positive number.
#[derive(Clone, Copy, Debug)]
pub struct Positive(pub f64);

/// Light paths a pixel.
#[derive(Clone, Copy, Debug)]
pub struct PathsPerPixel(pub f64);

/// A number of things, at least one.
#[derive(Clone, Copy, Debug)]
pub struct Count(pub u32);

/// Side of a picture (px).
#[derive(Clone, Copy, Debug)]
pub struct Side(pub u32);

/// Largest number of scattering vertices.
#[derive(Clone, Copy, Debug)]
pub struct Bounces(pub u32);

impl<T> NonEmpty<T> {
    /// One thing.
    pub fn of(thing: Option<T>) -> NonEmpty<T> {
        NonEmpty(thing.into_iter().collect())
    }
}

impl<T: Known> ByName<T> {
    /// The thing of a name.
    pub fn new(name: &str) -> Option<ByName<T>> {
        T::find(name).map(ByName)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for NonEmpty<T> {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        let list = Vec::deserialize(text)?;
        if list.is_empty() { Err(D::Error::custom("the list is empty")) } else { Ok(NonEmpty(list)) }
    }
}

impl<'de, T: Known> Deserialize<'de> for ByName<T> {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        let name = String::deserialize(text)?;
        let unknown = || format!("no {} is called {name}; known are {}", T::WHAT, T::names().join(", "));
        ByName::new(&name).ok_or_else(|| D::Error::custom(unknown()))
    }
}

impl Known for &'static Method {
    const WHAT: &'static str = "method";
    fn names() -> Vec<&'static str> {
        method::ALL.iter().map(|method| method.name).collect()
    }
    fn find(name: &str) -> Option<Self> {
        method::find(name)
    }
}

impl Known for &'static Variant {
    const WHAT: &'static str = "gather";
    fn names() -> Vec<&'static str> {
        variant::ALL.iter().map(|variant| variant.name).collect()
    }
    fn find(name: &str) -> Option<Self> {
        variant::find(name)
    }
}

impl Known for &'static History {
    const WHAT: &'static str = "history";
    fn names() -> Vec<&'static str> {
        history::ALL.iter().map(|history| history.name).collect()
    }
    fn find(name: &str) -> Option<Self> {
        history::find(name)
    }
}

impl Known for &'static Denoiser {
    const WHAT: &'static str = "denoiser";
    fn names() -> Vec<&'static str> {
        denoiser::ALL.iter().map(|denoiser| denoiser.name).collect()
    }
    fn find(name: &str) -> Option<Self> {
        denoiser::find(name)
    }
}

impl Known for TextureFilter {
    const WHAT: &'static str = "texture filter";
    fn names() -> Vec<&'static str> {
        TextureFilter::ALL.map(TextureFilter::name).to_vec()
    }
    fn find(name: &str) -> Option<Self> {
        TextureFilter::ALL.into_iter().find(|known| known.name() == name)
    }
}

impl Known for Runner {
    const WHAT: &'static str = "runner";
    fn names() -> Vec<&'static str> {
        RUNNERS.to_vec()
    }
    fn find(name: &str) -> Option<Self> {
        RUNNERS.into_iter().find(|known| *known == name).map(Runner)
    }
}

impl Known for Code {
    const WHAT: &'static str = "set of features";
    fn names() -> Vec<&'static str> {
        vec!["scene", "all"]
    }
    fn find(name: &str) -> Option<Self> {
        match name {
            "scene" => Some(Code::Scene),
            "all" => Some(Code::All),
            _ => None,
        }
    }
}

/// Reads a number and checks it.
fn checked<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    text: D,
    is_fine: impl Fn(&T) -> bool,
    what: &str,
) -> Result<T, D::Error> {
    let value = T::deserialize(text)?;
    if is_fine(&value) { Ok(value) } else { Err(D::Error::custom(what)) }
}

impl<'de> Deserialize<'de> for Positive {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        let is_fine = |value: &f64| value.is_finite() && *value > 0.0;
        checked(text, is_fine, "it must be a positive number").map(Positive)
    }
}

impl<'de> Deserialize<'de> for PathsPerPixel {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        let is_fine = |value: &f64| *value > 0.0 && *value <= 4096.0;
        checked(text, is_fine, "it must be more than 0, at most 4096").map(PathsPerPixel)
    }
}

impl<'de> Deserialize<'de> for Count {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        checked(text, |value| *value > 0, "it must be at least 1").map(Count)
    }
}

impl<'de> Deserialize<'de> for Side {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        checked(text, |value| (1..=8192).contains(value), "it must be 1 to 8192 px").map(Side)
    }
}

impl<'de> Deserialize<'de> for Bounces {
    fn deserialize<D: Deserializer<'de>>(text: D) -> Result<Self, D::Error> {
        checked(text, |value| (1..=64).contains(value), "it must be 1 to 64").map(Bounces)
    }
}
