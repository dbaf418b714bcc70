//! Choices and variants in files: with serde a value is its name.

pub use caustics_kernels::interface::named::Named;

/// With serde a value is its name: `#[serde(with = "named::by_name")]`.
pub mod by_name {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::Named;

    /// Writes the name.
    ///
    /// # Errors
    /// Those of the format.
    pub fn serialize<T: Named, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(value.name())
    }

    /// Reads a name.
    ///
    /// # Errors
    /// A name that no value has.
    pub fn deserialize<'de, T: Named, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
        T::find(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

/// The same of a value that may be missing.
pub mod by_name_if_any {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::Named;

    /// Writes the name.
    ///
    /// # Errors
    /// Those of the format.
    pub fn serialize<T: Named, S: Serializer>(value: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
        value.map(T::name).serialize(serializer)
    }

    /// Reads a name.
    ///
    /// # Errors
    /// A name that no value has.
    pub fn deserialize<'de, T: Named, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
        let name = Option::<String>::deserialize(deserializer)?;
        name.map(|name| T::find(&name)).transpose().map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::Named;
    use caustics_kernels::gather::variant::Variant;
    use caustics_kernels::interface::choice::Sampler;
    use caustics_kernels::method::Method;

    fn finds_each_by_its_name_alone<T: Named>() {
        for one in T::all() {
            assert_eq!(T::find(one.name()).map(T::name), Ok(one.name()));
        }
        let refused = T::find("sieve").map(T::name).expect_err("no sieve");
        assert!(T::all().into_iter().all(|one| refused.contains(one.name())), "{refused}");
    }

    #[test]
    fn names_find_choices_and_variants() {
        finds_each_by_its_name_alone::<Sampler>();
        finds_each_by_its_name_alone::<&Method>();
        finds_each_by_its_name_alone::<&Variant>();
    }
}
