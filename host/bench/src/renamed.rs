//! Renamed options, keys and environment variables. An old spelling on the command line, in a sweep or in the environment
//! is an error that names the new one. Results on disk are read under both. Imports nothing.

/// Options of the command line.
pub const OPTIONS: &[(&str, &str)] = &[
    ("--connections", "--light-sampler"),
    ("--deposits", "--photons"),
    ("--error", "--measure error"),
    ("--filter", "--denoiser"),
    ("--needs", "--features"),
    ("--pictures", "--images"),
    ("--time", "--measure time"),
    ("--time-s", "--moment"),
    ("--tree-quality", "--bvh-quality"),
];

/// Keys of sweeps, and of the configurations in results.
pub const KEYS: &[(&str, &str)] = &[
    ("connections", "light_sampler"),
    ("filter", "denoiser"),
    ("needs", "features"),
    ("tree_quality", "bvh_quality"),
];

/// Environment variables.
pub const VARIABLES: &[(&str, &str)] = &[("CAUSTICS_TREES_MIB", "CAUSTICS_BVH_CACHE_MIB")];

/// Returns the new name of an old one, as a sentence.
pub fn hint(renamed: &[(&str, &str)], name: &str) -> Option<String> {
    let (old, new) = renamed.iter().find(|(old, _)| *old == name)?;
    Some(format!("{old} is called {new} now"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hints_name_the_new_spelling_of_old_names_alone() {
        assert_eq!(
            hint(OPTIONS, "--connections"),
            Some("--connections is called --light-sampler now".into())
        );
        assert_eq!(hint(KEYS, "tree_quality"), Some("tree_quality is called bvh_quality now".into()));
        assert_eq!(hint(KEYS, "bvh_quality"), None);
    }

    #[test]
    fn no_new_name_is_an_old_one() {
        for (_, new) in OPTIONS.iter().chain(KEYS).chain(VARIABLES) {
            assert_eq!(hint(OPTIONS, new).or(hint(KEYS, new)).or(hint(VARIABLES, new)), None);
        }
    }
}
