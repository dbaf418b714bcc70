//! Values known by a name: choices and variants, in options, files of sweeps, and JSON.

/// A value of a list, in which each value has a name.
pub trait Named: Copy + Send + Sync + 'static {
    /// All values.
    fn all() -> Vec<Self>;

    /// Name on the command line.
    fn name(self) -> &'static str;

    /// Description, in one line.
    fn description(self) -> &'static str;

    /// Finds the value of a name.
    ///
    /// # Errors
    /// Fails with a list of the known names.
    fn find(name: &str) -> Result<Self, String> {
        let all = Self::all();
        all.iter().copied().find(|one| one.name() == name).ok_or_else(|| {
            let names: Vec<_> = all.into_iter().map(Self::name).collect();
            format!("there is no {name:?}; known are {}", names.join(", "))
        })
    }
}

/// Implements `Named` for references to the variants of a kind.
macro_rules! listed {
    ($kind:ident in $all:expr) => {
        impl $crate::interface::named::Named for &'static $kind {
            fn all() -> Vec<Self> {
                $all
            }

            fn name(self) -> &'static str {
                self.name
            }

            fn description(self) -> &'static str {
                self.description
            }
        }
    };
}
pub(crate) use listed;
