//! What the renderer and the connections of pages share. Nothing in it grows: a view request is one, whatever the number of messages that
//! made it, and of images and words only the latest is kept.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use caustics::scene::Edits;
use tokio::sync::{oneshot, watch};

use super::look::{DisplayedImage, Look};
use super::request::{Message, ViewRequest};

/// Maximum number of unanswered queries of pages.
const MAX_QUERIES: usize = 8;

/// An image for pages.
#[derive(Debug)]
pub struct PageFrame {
    /// The how manieth of all.
    pub serial: u64,
    /// Frames that it is the mean of.
    pub samples: u32,
    /// Whether something moves.
    pub moves: bool,
    /// When its camera was asked for, by the clock of the page that did.
    pub at: f64,
    /// The image.
    pub shown: DisplayedImage,
}

/// A query of a page, which the renderer answers between frames.
#[derive(Debug)]
pub enum Query {
    /// The image as an EXR file.
    Exr,
    /// The image as a PNG file.
    Png,
    /// The edits as a file.
    Edits,
    /// What was recorded as a file of edits.
    Recording,
    /// What is met first in a pixel, by shares of width and height; answered in JSON.
    Pick([f64; 2]),
    /// What light transport did in a pixel, by shares of width and height; answered in JSON.
    Inspect([f64; 2]),
    /// What is known of a node; answered in JSON.
    Node(usize),
}

/// What the renderer gives a page.
#[derive(Debug)]
pub enum Content {
    /// Bytes of a file, or JSON.
    Bytes(Vec<u8>),
    /// Edits that become a file while they are sent.
    Edits(Box<Edits>),
}

/// The answer of the renderer, or why there is none.
pub type Answer = Result<Content, String>;

struct State {
    request: ViewRequest,
    onlookers: usize,
    queries: VecDeque<(Query, oneshot::Sender<Answer>)>,
    /// Whether the renderer has not seen the view request as it is.
    is_new: bool,
}

/// What the renderer and the connections of pages share.
pub struct Shared {
    state: Mutex<State>,
    changed: Condvar,
    /// Ends the frame that is rendered, since another is wanted.
    pub stop: Arc<AtomicBool>,
    /// Ends the frame that is rendered, and all that follow.
    pub is_over: Arc<AtomicBool>,
    /// The latest image, and that which it is held against.
    pub frames: [watch::Sender<Option<Arc<PageFrame>>>; 2],
    /// How images are shown.
    pub look: watch::Sender<Look>,
    /// What the renderer says of itself, in JSON.
    pub status: watch::Sender<Arc<str>>,
}

/// What the renderer finds to do.
pub enum Next {
    /// To end.
    End,
    /// An answer to a page.
    Answer(Query, oneshot::Sender<Answer>),
    /// A frame.
    Frame(Box<ViewRequest>),
    /// Words alone: nothing is to be rendered.
    Words(Box<ViewRequest>),
}

impl Shared {
    /// With a view request to begin with, and nobody who looks on.
    pub fn new(request: ViewRequest) -> Arc<Shared> {
        let look = watch::Sender::new(request.look);
        Arc::new(Shared {
            state: Mutex::new(State { request, onlookers: 0, queries: VecDeque::new(), is_new: true }),
            changed: Condvar::new(),
            stop: Arc::default(),
            is_over: Arc::default(),
            frames: [watch::Sender::new(None), watch::Sender::new(None)],
            look,
            status: watch::Sender::new("{}".into()),
        })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Whoever panicked left a whole state: fields are assigned last.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The view request as it is.
    pub fn request(&self) -> ViewRequest {
        self.state().request.clone()
    }

    /// Does what a message says.
    ///
    /// # Errors
    ///
    /// What is wrong with it, for people.
    pub fn take(&self, message: &Message) -> Result<(), String> {
        let mut state = self.state();
        let outdates = state.request.take(message)?;
        state.is_new = true;
        if outdates {
            self.stop.store(true, Ordering::Relaxed);
        }
        self.look.send_if_modified(|look| std::mem::replace(look, state.request.look) != state.request.look);
        self.changed.notify_all();
        Ok(())
    }

    /// Asks the renderer for something.
    ///
    /// # Errors
    ///
    /// If it is asked for too much already.
    pub fn ask(&self, query: Query) -> Result<oneshot::Receiver<Answer>, String> {
        let mut state = self.state();
        state.queries.retain(|(_, answer)| !answer.is_closed());
        if state.queries.len() >= MAX_QUERIES {
            return Err("too much is asked for at once; try again".into());
        }
        let (answer, receiver) = oneshot::channel();
        state.queries.push_back((query, answer));
        self.changed.notify_all();
        Ok(receiver)
    }

    /// Counts someone who looks on, or one less.
    pub fn look_on(&self, comes: bool) {
        let mut state = self.state();
        let onlookers = state.onlookers;
        state.onlookers = if comes { onlookers + 1 } else { onlookers.saturating_sub(1) };
        self.changed.notify_all();
    }

    /// Ends the renderer after the frame at hand, which is stopped.
    pub fn end(&self) {
        // Under the lock, so that the renderer does not begin to wait in between.
        let _state = self.state();
        self.is_over.store(true, Ordering::Relaxed);
        self.stop.store(true, Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// Waits until there is something to do. Nothing is rendered while nobody looks on. From then on the flag `stop` means the
    /// frame that follows.
    pub fn next(&self) -> Next {
        let mut state = self.state();
        loop {
            if self.is_over.load(Ordering::Relaxed) {
                return Next::End;
            }
            // Nothing is made for a page that is gone.
            state.queries.retain(|(_, answer)| !answer.is_closed());
            if let Some((query, answer)) = state.queries.pop_front() {
                return Next::Answer(query, answer);
            }
            if state.onlookers > 0 && !state.request.paused {
                self.stop.store(false, Ordering::Relaxed);
                state.is_new = false;
                return Next::Frame(Box::new(state.request.clone()));
            }
            if std::mem::take(&mut state.is_new) {
                return Next::Words(Box::new(state.request.clone()));
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits until a view request is taken, or for a while: after a failure that another view request may mend.
    pub fn rest(&self, timeout: Duration) {
        let state = self.state();
        if !self.is_over.load(Ordering::Relaxed) && state.queries.is_empty() {
            drop(self.changed.wait_timeout(state, timeout));
        }
    }
}
