//! Connections: how many there are, and for how long one keeps its slot.
//!
//! A connection that has not shown the token is a stranger. Strangers keep no page out: beyond their number the oldest is closed. One
//! that sends no whole head of a request in time is closed, and so is one whose request is refused.

use std::collections::{BTreeSet, VecDeque};
use std::io::ErrorKind;
use std::pin::pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;
use tokio_io_timeout::TimeoutStream;

/// Connections that have not shown the token, at most.
const MAX_STRANGERS: usize = 64;
/// Connections that have shown it, at most, those of open pages aside: a browser opens six.
const MAX_GUESTS: usize = 64;
/// Longest wait for the head of a request, on a new connection and between two requests.
const HEAD: Duration = Duration::from_secs(10);
/// Longest wait for a reader that takes nothing of an answer, an image or a message.
const STALL: Duration = Duration::from_secs(30);
/// Longest head of a request (bytes).
const MAX_HEAD: usize = 64 << 10;
/// Wait after a connection could not be accepted, and the longest to which it is doubled.
const PAUSES: [Duration; 2] = [Duration::from_millis(50), Duration::from_secs(2)];

/// Accepts connections until the future is dropped.
pub async fn accept(listener: TcpListener, router: Router) {
    let door = Arc::new(Door::default());
    let mut pause = PAUSES[0];
    let mut has_failed = false;
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                pause = PAUSES[0];
                tokio::spawn(attend(stream, door.enter(), router.clone()));
            }
            // The other side is gone already.
            Err(error)
                if [ErrorKind::ConnectionAborted, ErrorKind::ConnectionReset].contains(&error.kind()) => {}
            // As a rule the process has as many open files as it may.
            Err(error) => {
                if !std::mem::replace(&mut has_failed, true) {
                    tell!(
                        "warning: a connection cannot be accepted: {error}; connections that have not shown the token are closed; \
                         a higher limit (ulimit -n) helps"
                    );
                }
                door.make_room();
                tokio::time::sleep(pause).await;
                pause = (2 * pause).min(PAUSES[1]);
            }
        }
    }
}

/// Answers the requests of a connection until it ends or has to leave.
async fn attend(stream: TcpStream, visit: Visit, router: Router) {
    let mut stream = TimeoutStream::new(stream);
    stream.set_write_timeout(Some(STALL));
    let answers = TowerToHyperService::new(router.layer(Extension(visit.badge.clone())));
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD).max_buf_size(MAX_HEAD);
    let connection = pin!(http.serve_connection(TokioIo::new(Box::pin(stream)), answers).with_upgrades());
    tokio::select! {
        // A connection that failed has ended, too.
        _ = connection => {}
        () = visit.badge.leave.notified() => {}
    }
}

/// All connections, those of open pages aside.
#[derive(Debug, Default)]
struct Door {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Numbers of those that have not shown the token, and what tells them to leave; the oldest first.
    strangers: VecDeque<(u64, Arc<Notify>)>,
    guests: BTreeSet<u64>,
    next: u64,
    has_warned: bool,
}

/// A connection, as its requests know it.
#[derive(Clone, Debug)]
pub struct Badge {
    door: Arc<Door>,
    number: u64,
    leave: Arc<Notify>,
}

/// A connection's slot, free again when this is dropped.
#[derive(Debug)]
struct Visit {
    badge: Badge,
}

impl Door {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes in a stranger; the oldest leaves if there are too many.
    fn enter(self: &Arc<Door>) -> Visit {
        let mut state = self.state();
        let badge = Badge { door: Arc::clone(self), number: state.next, leave: Arc::default() };
        state.next += 1;
        state.strangers.push_back((badge.number, Arc::clone(&badge.leave)));
        if state.strangers.len() > MAX_STRANGERS {
            if let Some((_, leave)) = state.strangers.pop_front() {
                leave.notify_one();
            }
            if !std::mem::replace(&mut state.has_warned, true) {
                tell!(
                    "warning: more than {MAX_STRANGERS} connections have not shown the token; the oldest are closed"
                );
            }
        }
        drop(state);
        Visit { badge }
    }

    /// The older half of the strangers leaves, one at least.
    fn make_room(&self) {
        let mut state = self.state();
        let half = state.strangers.len().div_ceil(2);
        state.strangers.drain(..half).for_each(|(_, leave)| leave.notify_one());
    }
}

impl Badge {
    /// Notes that the connection has shown the token; whether it may stay.
    pub fn show_token(&self) -> bool {
        let mut state = self.door.state();
        if state.guests.contains(&self.number) {
            return true;
        }
        let index = state.strangers.iter().position(|(number, _)| *number == self.number);
        let Some(index) = index.filter(|_| state.guests.len() < MAX_GUESTS) else { return false };
        state.strangers.remove(index);
        state.guests.insert(self.number)
    }
}

impl Drop for Visit {
    fn drop(&mut self) {
        let mut state = self.badge.door.state();
        state.strangers.retain(|(number, _)| *number != self.badge.number);
        state.guests.remove(&self.badge.number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn has_to_leave(visit: &Visit) -> bool {
        let mut leaves = pin!(visit.badge.leave.notified());
        leaves.as_mut().enable()
    }

    #[test]
    fn the_oldest_stranger_leaves_and_no_guest_does() {
        let door = Arc::new(Door::default());
        let mut visits: Vec<Visit> = (0..MAX_STRANGERS).map(|_| door.enter()).collect();
        assert!(visits[0].badge.show_token() && visits[0].badge.show_token());
        // The guest's slot among the strangers is free.
        visits.push(door.enter());
        assert!(!visits.iter().any(has_to_leave));
        visits.push(door.enter());
        let leaves: Vec<usize> = (0..visits.len()).filter(|&id| has_to_leave(&visits[id])).collect();
        assert_eq!(leaves, [1]);
        assert!(!visits[1].badge.show_token(), "it has to leave");
        door.make_room();
        assert_eq!(visits.iter().filter(|visit| has_to_leave(visit)).count(), MAX_STRANGERS / 2);
        drop(visits);
        let state = door.state();
        assert!(state.strangers.is_empty() && state.guests.is_empty());
    }

    #[test]
    fn guests_are_limited_and_one_that_leaves_makes_room() {
        let door = Arc::new(Door::default());
        let mut guests: Vec<Visit> = (0..MAX_GUESTS).map(|_| door.enter()).collect();
        assert!(guests.iter().all(|visit| visit.badge.show_token()));
        let late = door.enter();
        assert!(!late.badge.show_token());
        guests.pop();
        assert!(late.badge.show_token());
    }
}
