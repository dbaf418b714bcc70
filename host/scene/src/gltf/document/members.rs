//! Members that may be absent or null.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};
use serde_json::Value;

/// Elements of a section; empty without one.
pub fn list<T: DeserializeOwned>(section: Value) -> Result<Vec<T>, serde_json::Error> {
    Ok(serde_json::from_value::<Option<Vec<T>>>(section)?.unwrap_or_default())
}

/// Reads a member; null gives the default.
pub fn or_default<'de, D: Deserializer<'de>, T: Default + Deserialize<'de>>(
    member: D,
) -> Result<T, D::Error> {
    Ok(Option::deserialize(member)?.unwrap_or_default())
}
