//! Who is at the wheel: of the pages that look on, one says what is rendered.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::watch;

/// The pages that look on.
#[derive(Clone, Debug)]
pub struct Wheel {
    state: Arc<Mutex<State>>,
    /// The page at the wheel, by its number.
    holder: watch::Sender<Option<u64>>,
}

#[derive(Debug, Default)]
struct State {
    /// Pages by their numbers, in the order in which they came.
    pages: Vec<u64>,
    next: u64,
}

/// A page's place among those that look on; it leaves when this is dropped.
#[derive(Debug)]
pub struct Seat {
    number: u64,
    wheel: Wheel,
}

impl Wheel {
    /// Nobody looks on.
    pub fn new() -> Wheel {
        Wheel { state: Arc::default(), holder: watch::Sender::new(None) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a seat, unless so many are taken; the first is at the wheel.
    pub fn sit(&self, max_pages: usize) -> Option<Seat> {
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
        Some(Seat { number, wheel: self.clone() })
    }
}

impl Seat {
    /// Whether this page is at the wheel.
    pub fn steers(&self) -> bool {
        *self.wheel.holder.borrow() == Some(self.number)
    }

    /// Takes the wheel from whoever has it.
    pub fn take(&self) {
        self.wheel.holder.send_replace(Some(self.number));
    }

    /// Says when another page takes the wheel.
    pub fn changes(&self) -> watch::Receiver<Option<u64>> {
        self.wheel.holder.subscribe()
    }

    /// Pages that look on.
    pub fn pages(&self) -> usize {
        self.wheel.state().pages.len()
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut state = self.wheel.state();
        state.pages.retain(|page| *page != self.number);
        let next = state.pages.first().copied();
        self.wheel.holder.send_if_modified(|holder| {
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
    fn one_is_at_the_wheel_and_the_next_follows() {
        let wheel = Wheel::new();
        let first = wheel.sit(3).unwrap();
        let second = wheel.sit(3).unwrap();
        let third = wheel.sit(3).unwrap();
        assert!(wheel.sit(3).is_none());
        assert!(first.steers() && !second.steers() && !third.steers());
        third.take();
        assert!(!first.steers() && third.steers());
        drop(first);
        assert!(third.steers());
        drop(third);
        assert!(second.steers());
        assert_eq!(second.pages(), 1);
        drop(second);
        assert!(wheel.sit(3).unwrap().steers());
    }
}
