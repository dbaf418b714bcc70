//! Silent recovery from panics of third-party decoders.

use std::cell::Cell;
use std::panic::{UnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Number of nested calls of [`caught`] on this thread.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
}

/// Returns the result of `decode`, or `None` if it panics. The panic prints nothing; the caller reports the damaged input.
/// Panics on other threads and after the call are reported by the previous hook.
pub fn caught<T>(decode: impl FnOnce() -> T + UnwindSafe) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let report = take_hook();
        set_hook(Box::new(move |panic| {
            // The count is gone while its thread ends.
            if DEPTH.try_with(Cell::get).unwrap_or(0) == 0 {
                report(panic);
            }
        }));
    });
    DEPTH.set(DEPTH.get() + 1);
    let decoded = catch_unwind(decode);
    DEPTH.set(DEPTH.get() - 1);
    decoded.ok()
}

/// Returns the result of a decoder, or the error `damaged` if the decoder panics.
pub fn decoded<T>(
    decode: impl FnOnce() -> Result<T, String> + UnwindSafe,
    damaged: &str,
) -> Result<T, String> {
    caught(decode).unwrap_or_else(|| Err(damaged.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_of_decoders_are_kept_and_panics_are_errors() {
        assert_eq!(decoded(|| Ok(7), "damaged"), Ok(7));
        assert_eq!(decoded(|| Err::<u32, _>("short".into()), "damaged"), Err("short".into()));
        assert_eq!(decoded(|| -> Result<u32, String> { panic!("hidden") }, "damaged"), Err("damaged".into()));
    }

    /// Child process of the next test, which reads this process's output.
    #[test]
    #[ignore = "started by the test below"]
    fn child() {
        assert_eq!(caught(|| 7), Some(7));
        let (ready, go) = (std::sync::Barrier::new(2), std::sync::Barrier::new(2));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                ready.wait();
                // Panic while the other thread is inside of `caught`.
                assert!(catch_unwind(|| panic!("shown of another thread")).is_err());
                go.wait();
            });
            let hidden = caught(std::panic::AssertUnwindSafe(|| {
                ready.wait();
                go.wait();
                assert_eq!(caught(|| -> u32 { panic!("hidden inside") }), None);
                panic!("hidden outside")
            }));
            assert_eq!(hidden, None::<()>);
        });
        assert!(catch_unwind(|| panic!("shown afterwards")).is_err());
    }

    #[test]
    fn panics_inside_of_a_call_are_silent_and_all_others_are_reported() {
        let this = std::env::current_exe().unwrap();
        let arguments = ["--exact", "caught::tests::child", "--ignored", "--nocapture"];
        let output = std::process::Command::new(this).args(arguments).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{text}");
        assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"));
        assert!(text.contains("shown of another thread") && text.contains("shown afterwards"), "{text}");
        assert!(!text.contains("hidden"), "{text}");
    }
}
