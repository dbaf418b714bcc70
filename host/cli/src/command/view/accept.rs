//! Connections: their maximum number, and the time for which each keeps its slot.
//!
//! A connection is unauthenticated until it has shown the token. If there are too many of those, the oldest is closed. A
//! connection is also closed if it sends no complete request head in time, or if its request is refused.

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

/// Maximum number of connections that have not shown the token.
const MAX_UNAUTHENTICATED: usize = 64;
/// Maximum number of connections that have shown it, besides those of open pages: a browser opens six.
const MAX_AUTHENTICATED: usize = 64;
/// Maximum wait for the head of a request, on a new connection and between two requests.
const HEAD: Duration = Duration::from_secs(10);
/// Maximum wait for a client that reads nothing of an answer, an image or a message.
const STALL: Duration = Duration::from_secs(30);
/// Maximum length of a request's head (bytes).
const MAX_HEAD: usize = 64 << 10;
/// First and maximum pause after a failure to accept; each failure doubles it.
const PAUSES: [Duration; 2] = [Duration::from_millis(50), Duration::from_secs(2)];

/// Accepts connections until the future is dropped.
pub async fn accept(listener: TcpListener, router: Router) {
    let connections = Arc::new(OpenConnections::default());
    let mut pause = PAUSES[0];
    let mut has_failed = false;
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                pause = PAUSES[0];
                tokio::spawn(serve(stream, connections.add(), router.clone()));
            }
            // The client has closed the connection already.
            Err(error)
                if [ErrorKind::ConnectionAborted, ErrorKind::ConnectionReset].contains(&error.kind()) => {}
            // The usual cause is the limit of open files.
            Err(error) => {
                if !std::mem::replace(&mut has_failed, true) {
                    message!(
                        "warning: a connection cannot be accepted: {error}; connections that have not shown the token are closed; \
                         a higher limit (ulimit -n) helps"
                    );
                }
                connections.make_room();
                tokio::time::sleep(pause).await;
                pause = (2 * pause).min(PAUSES[1]);
            }
        }
    }
}

/// Answers the requests of a connection until it ends or must be closed.
async fn serve(stream: TcpStream, slot: ConnectionSlot, router: Router) {
    let mut stream = TimeoutStream::new(stream);
    stream.set_write_timeout(Some(STALL));
    let answers = TowerToHyperService::new(router.layer(Extension(slot.handle.clone())));
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD).max_buf_size(MAX_HEAD);
    let connection = pin!(http.serve_connection(TokioIo::new(Box::pin(stream)), answers).with_upgrades());
    tokio::select! {
        // A failed connection has ended too.
        _ = connection => {}
        () = slot.handle.leave.notified() => {}
    }
}

/// All connections, except those of open pages.
#[derive(Debug, Default)]
struct OpenConnections {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Numbers of unauthenticated connections and their signals to close; the oldest comes first.
    unauthenticated: VecDeque<(u64, Arc<Notify>)>,
    authenticated: BTreeSet<u64>,
    next: u64,
    has_warned: bool,
}

/// Handle to a connection for its requests.
#[derive(Clone, Debug)]
pub struct ConnectionHandle {
    connections: Arc<OpenConnections>,
    number: u64,
    leave: Arc<Notify>,
}

/// Slot of a connection; dropping it frees the slot.
#[derive(Debug)]
struct ConnectionSlot {
    handle: ConnectionHandle,
}

impl OpenConnections {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an unauthenticated connection; closes the oldest unauthenticated one if there are too many.
    fn add(self: &Arc<OpenConnections>) -> ConnectionSlot {
        let mut state = self.state();
        let handle =
            ConnectionHandle { connections: Arc::clone(self), number: state.next, leave: Arc::default() };
        state.next += 1;
        state.unauthenticated.push_back((handle.number, Arc::clone(&handle.leave)));
        if state.unauthenticated.len() > MAX_UNAUTHENTICATED {
            if let Some((_, leave)) = state.unauthenticated.pop_front() {
                leave.notify_one();
            }
            if !std::mem::replace(&mut state.has_warned, true) {
                message!(
                    "warning: more than {MAX_UNAUTHENTICATED} connections have not shown the token; the oldest are closed"
                );
            }
        }
        drop(state);
        ConnectionSlot { handle }
    }

    /// Closes the older half of the unauthenticated connections, at least one.
    fn make_room(&self) {
        let mut state = self.state();
        let half = state.unauthenticated.len().div_ceil(2);
        state.unauthenticated.drain(..half).for_each(|(_, leave)| leave.notify_one());
    }
}

impl ConnectionHandle {
    /// Marks the connection as authenticated. Returns whether it may stay.
    pub fn show_token(&self) -> bool {
        let mut state = self.connections.state();
        if state.authenticated.contains(&self.number) {
            return true;
        }
        let index = state.unauthenticated.iter().position(|(number, _)| *number == self.number);
        let Some(index) = index.filter(|_| state.authenticated.len() < MAX_AUTHENTICATED) else {
            return false;
        };
        state.unauthenticated.remove(index);
        state.authenticated.insert(self.number)
    }
}

impl Drop for ConnectionSlot {
    fn drop(&mut self) {
        let mut state = self.handle.connections.state();
        state.unauthenticated.retain(|(number, _)| *number != self.handle.number);
        state.authenticated.remove(&self.handle.number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn has_to_leave(slot: &ConnectionSlot) -> bool {
        let mut leaves = pin!(slot.handle.leave.notified());
        leaves.as_mut().enable()
    }

    #[test]
    fn the_oldest_unauthenticated_connection_is_closed_first() {
        let connections = Arc::new(OpenConnections::default());
        let mut slots: Vec<ConnectionSlot> = (0..MAX_UNAUTHENTICATED).map(|_| connections.add()).collect();
        assert!(slots[0].handle.show_token() && slots[0].handle.show_token());
        // The authenticated connection has freed its slot among the unauthenticated ones.
        slots.push(connections.add());
        assert!(!slots.iter().any(has_to_leave));
        slots.push(connections.add());
        let leaves: Vec<usize> = (0..slots.len()).filter(|&id| has_to_leave(&slots[id])).collect();
        assert_eq!(leaves, [1]);
        assert!(!slots[1].handle.show_token(), "it has to leave");
        connections.make_room();
        assert_eq!(slots.iter().filter(|slot| has_to_leave(slot)).count(), MAX_UNAUTHENTICATED / 2);
        drop(slots);
        let state = connections.state();
        assert!(state.unauthenticated.is_empty() && state.authenticated.is_empty());
    }

    #[test]
    fn authenticated_connections_are_limited() {
        let connections = Arc::new(OpenConnections::default());
        let mut authenticated: Vec<ConnectionSlot> =
            (0..MAX_AUTHENTICATED).map(|_| connections.add()).collect();
        assert!(authenticated.iter().all(|slot| slot.handle.show_token()));
        let late = connections.add();
        assert!(!late.handle.show_token());
        authenticated.pop();
        assert!(late.handle.show_token());
    }
}
