//! Threads of a process that may not have one for each core: its number of processes is limited (`ulimit -u`, the pids of a
//! container), or its address space.
//!
//! Threads are started before their pool is built: a pool that fails halfway does not tell how many there could be, and that of the
//! process is built once.

use std::num::NonZero;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread::{self, Builder, JoinHandle};
use std::time::Duration;

use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};

/// Time after which the system no longer counts a thread that has ended.
const REAPED: Duration = Duration::from_millis(20);
/// Whether this process may have fewer threads than it wants, so that each counts.
static IS_SHORT: AtomicBool = AtomicBool::new(false);

/// Fewer threads than were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the system lets this process start {started} of {wanted} threads; raise its limit of processes (ulimit -u, the pids of a \
     container) or of address space (ulimit -v)"
)]
pub struct TooFew {
    /// Threads that can be started.
    pub started: usize,
    /// Threads that were asked for.
    pub wanted: usize,
}

/// Makes the pool that this process computes in, of a thread for each core or of as many as there can be, one of which is left to
/// wait for Ctrl-C; without any, the calling thread computes alone. A process calls it once, before it computes anything.
///
/// # Errors
///
/// If there are fewer threads than cores; the pool is made nevertheless.
pub fn prepare() -> Result<(), TooFew> {
    // One more, which makes room for that of Ctrl-C.
    let wanted = cores() + 1;
    let mut waiting = Waiting::start(wanted);
    let started = waiting.0.len();
    IS_SHORT.store(started < wanted, Ordering::Relaxed);
    end(waiting.0.split_off(started.saturating_sub(1)));
    // Of a pool that is there already all is as it was.
    let _ = match waiting.0.len() {
        0 => ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global(),
        count => {
            ThreadPoolBuilder::new().num_threads(count).spawn_handler(waiting.into_handler()).build_global()
        }
    };
    if started < wanted { Err(TooFew { started, wanted }) } else { Ok(()) }
}

/// A pool of so many threads, 0 being one for each core, or of as many as there can be; `None` without any.
pub fn pool(threads: usize) -> Option<ThreadPool> {
    let waiting = Waiting::start(if threads == 0 { cores() } else { threads });
    let count = waiting.0.len();
    let builder = ThreadPoolBuilder::new().num_threads(count).spawn_handler(waiting.into_handler());
    if count == 0 { None } else { builder.build().ok() }
}

/// Checks that so many threads can be started beside those that run.
///
/// # Errors
///
/// If there are fewer.
pub fn check(wanted: usize) -> Result<(), TooFew> {
    let waiting = Waiting::start(wanted);
    let started = waiting.0.len();
    end(waiting.0);
    if started < wanted { Err(TooFew { started, wanted }) } else { Ok(()) }
}

/// Threads that a pool has where nobody says.
fn cores() -> usize {
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|number| number.parse().ok());
    asked.filter(|number| *number > 0).unwrap_or(thread::available_parallelism().map_or(1, NonZero::get))
}

/// A thread that waits to become one of a pool.
type Thread = (Sender<ThreadBuilder>, JoinHandle<()>);

/// Ends threads, so that others can be started in their place.
fn end(threads: Vec<Thread>) {
    let (senders, handles): (Vec<_>, Vec<_>) = threads.into_iter().unzip();
    drop(senders);
    for handle in handles {
        // It has nothing to panic for.
        let _ = handle.join();
    }
    if IS_SHORT.load(Ordering::Relaxed) {
        thread::sleep(REAPED);
    }
}

/// Threads that wait to become those of a pool.
struct Waiting(Vec<Thread>);

impl Waiting {
    /// Starts so many, or as many as there can be.
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

    /// Gives a thread to each that a pool wants to start.
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
    fn a_pool_has_the_threads_that_were_asked_for() {
        for threads in [1, 3] {
            let pool = pool(threads).unwrap();
            assert_eq!(pool.current_num_threads(), threads);
            assert_eq!(pool.broadcast(|thread| thread.index()), (0..threads).collect::<Vec<_>>());
        }
        assert_eq!(check(3), Ok(()));
    }
}
