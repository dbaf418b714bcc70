//! Control token: the open page that holds it decides what is rendered.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::watch;

/// Open pages, one of which holds the control token.
#[derive(Clone, Debug)]
pub struct ControlToken {
    state: Arc<Mutex<State>>,
    /// Number of the page that holds the token.
    holder: watch::Sender<Option<u64>>,
}

#[derive(Debug, Default)]
struct State {
    /// Numbers of the pages, in the order in which they were opened.
    pages: Vec<u64>,
    next: u64,
}

/// An open page; dropping it removes the page.
#[derive(Debug)]
pub struct RegisteredPage {
    number: u64,
    control_token: ControlToken,
}

impl ControlToken {
    /// Returns a token without pages.
    pub fn new() -> ControlToken {
        ControlToken { state: Arc::default(), holder: watch::Sender::new(None) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Registers a page, unless there are `max_pages` already; the first page gets the token.
    pub fn register(&self, max_pages: usize) -> Option<RegisteredPage> {
        let mut state = self.state();
        if state.pages.len() >= max_pages {
            return None;
        }
        let number = state.next;
        state.next += 1;
        state.pages.push(number);
        self.holder.send_if_modified(|holder| {
            let is_free = holder.is_none();
            *holder = holder.or(Some(number));
            is_free
        });
        Some(RegisteredPage { number, control_token: self.clone() })
    }
}

impl RegisteredPage {
    /// Whether this page holds the control token.
    pub fn has_control(&self) -> bool {
        *self.control_token.holder.borrow() == Some(self.number)
    }

    /// Takes the token from the page that holds it.
    pub fn take_control(&self) {
        self.control_token.holder.send_replace(Some(self.number));
    }

    /// Returns a receiver of every change of the holder.
    pub fn changes(&self) -> watch::Receiver<Option<u64>> {
        self.control_token.holder.subscribe()
    }

    /// Number of open pages.
    pub fn pages(&self) -> usize {
        self.control_token.state().pages.len()
    }
}

impl Drop for RegisteredPage {
    fn drop(&mut self) {
        let mut state = self.control_token.state();
        state.pages.retain(|page| *page != self.number);
        let next = state.pages.first().copied();
        self.control_token.holder.send_if_modified(|holder| {
            let had_it = *holder == Some(self.number);
            if had_it {
                *holder = next;
            }
            had_it
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_page_has_control_and_the_next_follows() {
        let control_token = ControlToken::new();
        let first = control_token.register(3).unwrap();
        let second = control_token.register(3).unwrap();
        let third = control_token.register(3).unwrap();
        assert!(control_token.register(3).is_none());
        assert!(first.has_control() && !second.has_control() && !third.has_control());
        third.take_control();
        assert!(!first.has_control() && third.has_control());
        drop(first);
        assert!(third.has_control());
        drop(third);
        assert!(second.has_control());
        assert_eq!(second.pages(), 1);
        drop(second);
        assert!(control_token.register(3).unwrap().has_control());
    }
}
