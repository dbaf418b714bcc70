//! Serde modules that write choices and variants by their names.

pub use caustics_kernels::interface::named::Named;

/// Serde module of a value that is written by its name: `#[serde(with = "named::by_name")]`.
pub mod by_name {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::Named;

    /// Writes the name.
    ///
    /// # Errors
    /// The errors of the format.
    pub fn serialize<T: Named, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(value.name())
    }

    /// Reads a name.
    ///
    /// # Errors
    /// If no value has the name.
    pub fn deserialize<'de, T: Named, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
        T::find(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

/// Serde module of an optional value that is written by its name.
pub mod by_name_if_any {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::Named;

    /// Writes the name.
    ///
    /// # Errors
    /// The errors of the format.
    pub fn serialize<T: Named, S: Serializer>(value: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
        value.map(T::name).serialize(serializer)
    }

    /// Reads a name.
    ///
    /// # Errors
    /// If no value has the name.
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
