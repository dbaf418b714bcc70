//! Errors of Open Image Denoise, and the name of its file.

/// Environment variable that names the file of the library.
pub const VARIABLE: &str = "CAUSTICS_OIDN";
/// File of the library that the system's loader looks for without [`VARIABLE`].
pub(super) const FILE: &str = if cfg!(windows) {
    "OpenImageDenoise.dll"
} else if cfg!(target_os = "macos") {
    "libOpenImageDenoise.2.dylib"
} else {
    "libOpenImageDenoise.so.2"
};

/// Error: Open Image Denoise is missing, or fails.
#[derive(Debug, thiserror::Error)]
pub enum OidnError {
    /// The library cannot be loaded.
    #[error(
        "--denoiser oidn: Open Image Denoise 2 cannot be loaded ({reason}); install it by `pip install pyoidn`, and let {VARIABLE} name \
         its file LOCATION/pyoidn/oidn/lib/{FILE}, with the Location that `pip show pyoidn` prints"
    )]
    Missing {
        /// Reason that the system gives.
        reason: String,
    },
    /// The library reports an error.
    #[error("--denoiser oidn: Open Image Denoise: {0}")]
    Failed(String),
}
