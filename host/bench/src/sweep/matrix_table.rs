//! Table `[[matrix]]` of a sweep file: lists of values, all combinations of which are run configurations.

use std::fmt;

use serde::de::{DeserializeSeed, Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::value::{NonEmpty, Side};
use crate::matrix::Matrix;
use crate::parameter::{self, METHOD, PATHS_PER_PIXEL, Parameter, spelled};
use crate::renamed;
use caustics::exact::Exact;
use caustics::scene::{CameraChoice, Position};

/// A table of lists.
#[derive(Clone, Debug, Default)]
pub struct MatrixTable {
    /// Files or names of scenes.
    pub scene: Vec<String>,
    /// The camera.
    pub camera: CameraChoice,
    /// Widths and heights of the timed images; none: the size in `[time]`.
    pub size: Vec<(Side, Side)>,
    /// Values of the parameters.
    pub parameters: Matrix,
    /// Keys that gave the light paths.
    pub paths_keys: Vec<&'static str>,
}

impl MatrixTable {
    /// Adds a value under the key of a parameter.
    ///
    /// # Errors
    /// If the value is not allowed; the message says what it must be.
    pub fn add(&mut self, key: &'static str, text: &str) -> Result<(), String> {
        let (parameter, value) = spelled(key, text).ok_or_else(|| format!("there is no key {key}"))?;
        if *parameter == PATHS_PER_PIXEL && !self.paths_keys.contains(&key) {
            self.paths_keys.push(key);
        }
        self.parameters.add(parameter, &value)
    }

    /// Number of combinations of its lists.
    pub fn count(&self) -> u64 {
        let images = self.scene.len() as u64 * self.size.len().max(1) as u64;
        self.parameters.count().saturating_mul(images)
    }
}

/// All keys of the table.
fn known_keys() -> impl Iterator<Item = &'static str> {
    ["scene", "camera", "from", "look_at", "fov", "size"]
        .into_iter()
        .chain(parameter::keys().map(|(key, ..)| key))
}

impl<'de> Deserialize<'de> for MatrixTable {
    fn deserialize<D: Deserializer<'de>>(table: D) -> Result<Self, D::Error> {
        table.deserialize_map(TableVisitor)
    }
}

fn position(Exact(metres): Exact<f64, 3>) -> Position {
    Position(metres.into())
}

struct TableVisitor;

impl<'de> Visitor<'de> for TableVisitor {
    type Value = MatrixTable;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a table of lists")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<MatrixTable, A::Error> {
        let mut table = MatrixTable::default();
        let (mut camera, mut from, mut look_at, mut fov) = (None::<String>, None, None, None);
        while let Some(key) = map.next_key::<Key>()? {
            match key.0 {
                "scene" => table.scene = map.next_value::<NonEmpty<String>>()?.0,
                "camera" => camera = Some(map.next_value()?),
                "from" => from = Some(position(map.next_value()?)),
                "look_at" => look_at = Some(position(map.next_value()?)),
                "fov" => fov = Some(map.next_value()?),
                "size" => {
                    let sizes: Vec<Exact<Side, 2>> = map.next_value()?;
                    table.size = sizes.into_iter().map(|Exact([width, height])| (width, height)).collect();
                }
                key => map.next_value_seed(List { table: &mut table, key })?,
            }
        }
        table.camera =
            CameraChoice::from_options(camera.as_deref(), from, look_at, fov).map_err(A::Error::custom)?;
        if table.scene.is_empty() {
            return Err(A::Error::missing_field("scene"));
        }
        if !table.parameters.has(&METHOD) {
            return Err(A::Error::missing_field("method"));
        }
        Ok(table)
    }
}

/// A key that the table knows.
struct Key(&'static str);

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(key: D) -> Result<Self, D::Error> {
        let text = String::deserialize(key)?;
        known_keys().find(|known| *known == text).map(Key).ok_or_else(|| {
            let known: Vec<_> = known_keys().collect();
            let unknown = || format!("unknown key {text}; known are {}", known.join(", "));
            D::Error::custom(renamed::hint(renamed::KEYS, &text).unwrap_or_else(unknown))
        })
    }
}

/// Values of a key: a single one, or a list.
struct List<'a> {
    table: &'a mut MatrixTable,
    key: &'static str,
}

impl<'de> DeserializeSeed<'de> for List<'_> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, values: D) -> Result<(), D::Error> {
        values.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for List<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a name or a number, or a list of them")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<(), E> {
        self.table.add(self.key, text).map_err(E::custom)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<(), E> {
        self.visit_str(&number.to_string())
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<(), E> {
        self.visit_str(&number.to_string())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let mut is_empty = true;
        while list.next_element_seed(List { table: &mut *self.table, key: self.key })?.is_some() {
            is_empty = false;
        }
        // An empty list leaves a parameter without a default to the machine.
        let may_be_empty = Parameter::find(self.key).is_some_and(|parameter| parameter.default.is_empty());
        if is_empty && !may_be_empty { Err(A::Error::custom("the list is empty")) } else { Ok(()) }
    }
}
