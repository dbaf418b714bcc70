//! What is known by a name: choices and variants, in options, files of sweeps, JSON.

/// One of several that are listed, each with a name.
pub trait Named: Copy + Send + Sync + 'static {
    /// Every one.
    fn all() -> Vec<Self>;

    /// Its name on the command line.
    fn name(self) -> &'static str;

    /// What it is, in one line.
    fn description(self) -> &'static str;

    /// The one of this name.
    ///
    /// # Errors
    /// The names there are, if it is none of them.
    fn find(name: &str) -> Result<Self, String> {
        let all = Self::all();
        all.iter().copied().find(|one| one.name() == name).ok_or_else(|| {
            let names: Vec<_> = all.into_iter().map(Self::name).collect();
            format!("there is no {name:?}; known are {}", names.join(", "))
        })
    }
}

/// A kind of variant whose list `ALL` has references to its variants.
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
