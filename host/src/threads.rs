//! Thread pools of a process that cannot have a thread for each core. Its number of processes may be limited (`ulimit -u`,
//! the pids of a container), or its address space.
//!
//! Threads are started before their pool is built, for two reasons. A pool that fails halfway does not report the possible
//! number of threads. The process's pool can be built only once.

use std::num::NonZero;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread::{self, Builder, JoinHandle};
use std::time::Duration;

use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};

/// Time after which the system no longer counts an ended thread.
const REAPED: Duration = Duration::from_millis(20);
/// Whether this process may have fewer threads than it requested, so that each counts.
static IS_SHORT: AtomicBool = AtomicBool::new(false);

/// Error: fewer threads than requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the system lets this process start {started} of {wanted} threads; raise its limit of processes (ulimit -u, the pids of a \
     container) or of address space (ulimit -v)"
)]
pub struct TooFew {
    /// Number of threads that can be started.
    pub started: usize,
    /// Number of threads that were requested.
    pub wanted: usize,
}

/// Builds the process's pool with a thread for each core, or with as many as possible. It leaves one thread to wait for
/// Ctrl-C. Without any thread, the calling thread computes alone.
/// A process calls it once, before any computation.
///
/// # Errors
///
/// If there are fewer threads than cores. The pool is built nevertheless.
pub fn prepare() -> Result<(), TooFew> {
    // Start one more thread, to make room for the one of Ctrl-C.
    let wanted = cores() + 1;
    let mut waiting = Waiting::start(wanted);
    let started = waiting.0.len();
    IS_SHORT.store(started < wanted, Ordering::Relaxed);
    end(waiting.0.split_off(started.saturating_sub(1)));
    // An existing pool stays unchanged.
    let _ = match waiting.0.len() {
        0 => ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global(),
        count => {
            ThreadPoolBuilder::new().num_threads(count).spawn_handler(waiting.into_handler()).build_global()
        }
    };
    if started < wanted { Err(TooFew { started, wanted }) } else { Ok(()) }
}

/// Builds a pool of this number of threads (0: one for each core), or of as many as possible. `None` without any.
pub fn pool(threads: usize) -> Option<ThreadPool> {
    let waiting = Waiting::start(if threads == 0 { cores() } else { threads });
    let count = waiting.0.len();
    let builder = ThreadPoolBuilder::new().num_threads(count).spawn_handler(waiting.into_handler());
    if count == 0 { None } else { builder.build().ok() }
}

/// Checks that this number of threads can be started beside the running ones.
///
/// # Errors
///
/// If fewer can be started.
pub fn check(wanted: usize) -> Result<(), TooFew> {
    let waiting = Waiting::start(wanted);
    let started = waiting.0.len();
    end(waiting.0);
    if started < wanted { Err(TooFew { started, wanted }) } else { Ok(()) }
}

/// Returns the default number of threads of a pool.
fn cores() -> usize {
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|number| number.parse().ok());
    asked.filter(|number| *number > 0).unwrap_or(thread::available_parallelism().map_or(1, NonZero::get))
}

/// Thread that waits to join a pool.
type Thread = (Sender<ThreadBuilder>, JoinHandle<()>);

/// Ends threads, so that others can be started instead.
fn end(threads: Vec<Thread>) {
    let (senders, handles): (Vec<_>, Vec<_>) = threads.into_iter().unzip();
    drop(senders);
    for handle in handles {
        // The thread cannot panic.
        let _ = handle.join();
    }
    if IS_SHORT.load(Ordering::Relaxed) {
        thread::sleep(REAPED);
    }
}

/// Threads that wait to join a pool.
struct Waiting(Vec<Thread>);

impl Waiting {
    /// Starts this number of threads, or as many as possible.
    fn start(wanted: usize) -> Waiting {
        let mut threads = Vec::new();
        for id in 0..wanted {
            let (sender, receiver) = channel::<ThreadBuilder>();
            let run = move || {
                if let Ok(thread) = receiver.recv() {
                    thread.run();
                }
            };
            match Builder::new().name(format!("worker {id}")).spawn(run) {
                Ok(handle) => threads.push((sender, handle)),
                Err(_) => break,
            }
        }
        Waiting(threads)
    }

    /// Returns a spawn handler that passes the waiting threads to a pool.
    fn into_handler(self) -> impl FnMut(ThreadBuilder) -> std::io::Result<()> {
        let mut threads = self.0.into_iter();
        move |thread| {
            let (sender, _) = threads.next().ok_or_else(|| std::io::Error::other("no thread is left"))?;
            sender.send(thread).map_err(|_| std::io::Error::other("a thread has ended"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pool_has_the_requested_number_of_threads() {
        for threads in [1, 3] {
            let pool = pool(threads).unwrap();
            assert_eq!(pool.current_num_threads(), threads);
            assert_eq!(pool.broadcast(|thread| thread.index()), (0..threads).collect::<Vec<_>>());
        }
        assert_eq!(check(3), Ok(()));
    }
}
