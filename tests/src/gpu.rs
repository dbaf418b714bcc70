//! The Vulkan device that the tests run on, or the reason why there is none.

use std::sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError};

use caustics::kernels::Source;
use caustics::session::RunnerChoice;
use caustics::vulkan::context::Context;
use caustics::vulkan::{DeviceInfo, VulkanError, best};

/// A device to test on. While it lives, few other tests of this process have one.
pub struct Gpu {
    /// Description of the device.
    pub info: DeviceInfo,
    /// Whether the validation layer is active.
    pub validation: bool,
    _turn: Turn,
}

impl Gpu {
    /// Returns the runner on this device, by ray queries or by the software tracer, with validation where available.
    pub fn choice(&self, hardware: bool) -> RunnerChoice {
        let kernels = Source::from_environment();
        RunnerChoice::Gpu { device: None, hardware, validation: self.validation, kernels }
    }

    /// Tracers of the device: `false` is software, `true` is ray queries.
    pub fn tracers(&self) -> &'static [bool] {
        if self.info.ray_queries { &[false, true] } else { &[false] }
    }
}

/// Opens the device with the validation layer. Without a device it prints why the test is skipped; with
/// `CAUSTICS_REQUIRE_GPU=1` it panics.
pub fn watched_gpu() -> Option<Gpu> {
    device(true)
}

/// Opens the device without the validation layer, which takes longer over our large modules than lavapipe does. For
/// tests whose passes another test runs with validation.
pub fn gpu() -> Option<Gpu> {
    device(false)
}

/// Permission to have a device, held by [`at_once`] tests.
struct Turn;

/// Number of permissions in use.
static TURNS: Mutex<usize> = Mutex::new(0);
static GIVEN_BACK: Condvar = Condvar::new();

/// Number of tests of a process that may have a device at once: two where the driver compiles kernels on a CPU, else
/// one. NVIDIA's driver crashes in half of all runs in which two threads have devices
/// (<https://github.com/kvark/blade/issues/336>).
fn at_once() -> usize {
    static AT_ONCE: OnceLock<usize> = OnceLock::new();
    *AT_ONCE.get_or_init(|| if best(None).is_ok_and(|device| device.is_cpu()) { 2 } else { 1 })
}

impl Turn {
    fn wait() -> Turn {
        let at_once = at_once();
        let taken = GIVEN_BACK.wait_while(Turn::taken(), |taken| *taken == at_once);
        *taken.unwrap_or_else(PoisonError::into_inner) += 1;
        Turn
    }

    /// Locks the number of turns; a failed test leaves no poison that the next one could meet.
    fn taken() -> MutexGuard<'static, usize> {
        TURNS.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        *Turn::taken() -= 1;
        GIVEN_BACK.notify_one();
    }
}

fn device(watched: bool) -> Option<Gpu> {
    let turn = Turn::wait();
    match find(watched) {
        Ok((info, validation)) => {
            eprintln!("on {} ({}), validation {validation}", info.name, info.driver);
            Some(Gpu { info, validation, _turn: turn })
        }
        Err(reason) => {
            skip(&reason);
            None
        }
    }
}

fn find(watched: bool) -> Result<(DeviceInfo, bool), String> {
    Source::from_environment().modules().map_err(|error| error.to_string())?;
    let open = |validation| {
        let context = Context::new(None, true, validation).or_else(|error| match error {
            VulkanError::Unsuitable { .. } => Context::new(None, false, validation),
            error => Err(error),
        });
        context.map(|context| context.info().clone())
    };
    match open(watched) {
        Ok(info) => Ok((info, watched)),
        Err(error @ VulkanError::NoValidationLayer) => {
            assert!(!is_required(), "CAUSTICS_REQUIRE_GPU=1, but {error}");
            eprintln!("without validation: {error}");
            open(false).map(|info| (info, false)).map_err(|error| error.to_string())
        }
        Err(error) if error.is_no_device() => Err(error.to_string()),
        Err(error) => panic!("{error}"),
    }
}

fn is_required() -> bool {
    std::env::var("CAUSTICS_REQUIRE_GPU").is_ok_and(|value| value == "1")
}

fn skip(reason: &str) {
    assert!(!is_required(), "CAUSTICS_REQUIRE_GPU=1, but {reason}");
    eprintln!("skipped: {reason}");
}
