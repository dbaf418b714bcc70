//! C interface of Open Image Denoise 2 (`OpenImageDenoise/oidn.h`): all unsafe code of `oidn`.

use std::ffi::{CStr, OsStr, c_char, c_int, c_void};
use std::ptr::null;

use glam::Vec3;
use libloading::Library;

use super::error::OidnError;

/// Handle of a device or of a filter.
type Handle = *mut c_void;

/// `OIDN_DEVICE_TYPE_CPU`, whose images lie in the memory of the process.
const CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`, the format of a `Vec3`.
const FLOAT3: c_int = 3;
const _: () = assert!(size_of::<Vec3>() == 12);

/// Declares the functions of the library, each with its name and type.
macro_rules! functions {
    ($($field:ident: $name:literal ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Functions of the library.
        struct Functions {
            $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            /// Finds all functions.
            fn find(library: &Library) -> Result<Functions, libloading::Error> {
                // SAFETY: the header of version 2 declares the functions with these types.
                unsafe { Ok(Functions { $($field: *library.get($name.to_bytes_with_nul())?,)* }) }
            }
        }
    };
}

functions! {
    new_device: c"oidnNewDevice" (c_int) -> Handle;
    set_device_int: c"oidnSetDeviceInt" (Handle, *const c_char, c_int);
    get_device_int: c"oidnGetDeviceInt" (Handle, *const c_char) -> c_int;
    get_device_error: c"oidnGetDeviceError" (Handle, *mut *const c_char) -> c_int;
    commit_device: c"oidnCommitDevice" (Handle);
    release_device: c"oidnReleaseDevice" (Handle);
    new_filter: c"oidnNewFilter" (Handle, *const c_char) -> Handle;
    set_filter_image: c"oidnSetSharedFilterImage"
        (Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
    set_filter_bool: c"oidnSetFilterBool" (Handle, *const c_char, bool);
    commit_filter: c"oidnCommitFilter" (Handle);
    execute_filter: c"oidnExecuteFilter" (Handle);
    release_filter: c"oidnReleaseFilter" (Handle);
}

/// Device of the library on the CPU.
pub struct OidnDevice {
    functions: Functions,
    /// The device, never null.
    device: Handle,
}

impl OidnDevice {
    /// Loads the library of a file and opens a device of at most `threads` threads; 0: one for each core.
    pub fn open(file: &OsStr, threads: usize) -> Result<OidnDevice, OidnError> {
        let missing = |error: libloading::Error| OidnError::Missing { reason: error.to_string() };
        // SAFETY: the user names the library, or installed it; its initialisation needs nothing of this process.
        let library = unsafe { Library::new(file) }.map_err(missing)?;
        let functions = Functions::find(&library).map_err(missing)?;
        // Keep the library loaded: its threads may outlive the device.
        std::mem::forget(library);
        // SAFETY: the function takes any type of device.
        let device = unsafe { (functions.new_device)(CPU) };
        if device.is_null() {
            return Err(
                first_error(&functions, device).unwrap_or_else(|| OidnError::Failed("no device".into()))
            );
        }
        let opened = OidnDevice { functions, device };
        let threads = c_int::try_from(threads).unwrap_or(0);
        // SAFETY: the device is live.
        unsafe {
            (opened.functions.set_device_int)(device, c"numThreads".as_ptr(), threads);
            (opened.functions.commit_device)(device);
        }
        first_error(&opened.functions, device).map_or(Ok(opened), Err)
    }

    /// Version of the library.
    pub fn version(&self) -> String {
        let number = |name: &CStr| {
            // SAFETY: the device is live.
            unsafe { (self.functions.get_device_int)(self.device, name.as_ptr()) }
        };
        [c"versionMajor", c"versionMinor", c"versionPatch"].map(|name| number(name).to_string()).join(".")
    }

    /// Returns the denoised colours of an image of this width and height (px).
    pub fn denoise(
        &self,
        [width, height]: [usize; 2],
        color: &[Vec3],
        albedo: &[Vec3],
        normal: &[Vec3],
    ) -> Result<Vec<Vec3>, OidnError> {
        if [color, albedo, normal].iter().any(|layer| layer.len() != width * height) {
            return Err(OidnError::Failed("the image lacks the path layer, albedo or normal".into()));
        }
        let mut output = vec![Vec3::ZERO; color.len()];
        let images = [
            (c"color", color.as_ptr().cast_mut()),
            (c"albedo", albedo.as_ptr().cast_mut()),
            (c"normal", normal.as_ptr().cast_mut()),
            (c"output", output.as_mut_ptr()),
        ];
        let functions = &self.functions;
        // SAFETY: each image has width * height records of three floats without gaps, and outlives the filter. The filter writes
        // to the output alone. A null filter makes each function set an error.
        unsafe {
            let filter = (functions.new_filter)(self.device, c"RT".as_ptr());
            for (name, pixels) in images {
                let pixels = pixels.cast();
                (functions.set_filter_image)(filter, name.as_ptr(), pixels, FLOAT3, width, height, 0, 0, 0);
            }
            (functions.set_filter_bool)(filter, c"hdr".as_ptr(), true);
            (functions.commit_filter)(filter);
            (functions.execute_filter)(filter);
            (functions.release_filter)(filter);
        }
        first_error(functions, self.device).map_or(Ok(output), Err)
    }
}

impl Drop for OidnDevice {
    fn drop(&mut self) {
        // SAFETY: the device is live, and nothing uses it afterwards.
        unsafe { (self.functions.release_device)(self.device) }
    }
}

/// Returns the first error of a device since the last call; of a null device, that of this thread.
fn first_error(functions: &Functions, device: Handle) -> Option<OidnError> {
    let mut message = null();
    // SAFETY: the device is live or null.
    let code = unsafe { (functions.get_device_error)(device, &raw mut message) };
    if code == 0 {
        return None;
    }
    if message.is_null() {
        return Some(OidnError::Failed(format!("error {code}")));
    }
    // SAFETY: the library returns a string that is valid until the next call for an error.
    let message = unsafe { CStr::from_ptr(message) };
    Some(OidnError::Failed(message.to_string_lossy().into_owned()))
}
