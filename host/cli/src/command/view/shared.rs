//! State that the renderer and the connections of pages share. Its size is bounded: all messages change one view request,
//! and only the latest image and status are kept.

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
    /// Number of the image, counted over all images.
    pub serial: u64,
    /// Number of frames in the mean.
    pub samples: u32,
    /// Whether something moves.
    pub moves: bool,
    /// Time at which the page chose its camera, by that page's clock.
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
    /// The recording as a file of edits.
    Recording,
    /// First hit of a pixel, in shares of width and height; answered in JSON.
    Pick([f64; 2]),
    /// Light transport of a pixel, in shares of width and height; answered in JSON.
    Inspect([f64; 2]),
    /// Description of a node; answered in JSON.
    Node(usize),
}

/// Content of an answer.
#[derive(Debug)]
pub enum Content {
    /// Bytes of a file, or JSON.
    Bytes(Vec<u8>),
    /// Edits that become a file while they are sent.
    Edits(Box<Edits>),
}

/// Answer of the renderer, or the reason why there is none.
pub type Answer = Result<Content, String>;

struct State {
    request: ViewRequest,
    onlookers: usize,
    queries: VecDeque<(Query, oneshot::Sender<Answer>)>,
    /// Whether the view request has changed since the renderer read it.
    is_new: bool,
}

/// State that the renderer and the connections of pages share.
pub struct Shared {
    state: Mutex<State>,
    changed: Condvar,
    /// Flag that stops the current frame, since another view was requested.
    pub stop: Arc<AtomicBool>,
    /// Flag that stops the current frame and all later ones.
    pub is_over: Arc<AtomicBool>,
    /// Latest image, and the image to compare with.
    pub frames: [watch::Sender<Option<Arc<PageFrame>>>; 2],
    /// Display of the images.
    pub look: watch::Sender<Look>,
    /// Status of the renderer, in JSON.
    pub status: watch::Sender<Arc<str>>,
}

/// Next work of the renderer.
pub enum Next {
    /// End.
    End,
    /// Answer a query.
    Answer(Query, oneshot::Sender<Answer>),
    /// Render a frame.
    Frame(Box<ViewRequest>),
    /// Send the status only.
    Words(Box<ViewRequest>),
}

impl Shared {
    /// Starts with a view request and without pages.
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
        // A panicking thread leaves a valid state: fields are assigned last.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the current view request.
    pub fn request(&self) -> ViewRequest {
        self.state().request.clone()
    }

    /// Applies a message.
    ///
    /// # Errors
    ///
    /// If the message is invalid; the text is for the user.
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

    /// Queues a query for the renderer.
    ///
    /// # Errors
    ///
    /// If too many queries are waiting.
    pub fn ask(&self, query: Query) -> Result<oneshot::Receiver<Answer>, String> {
        let mut state = self.state();
        state.queries.retain(|(_, answer)| !answer.is_closed());
        if state.queries.len() >= MAX_QUERIES {
            return Err("too many queries at once; try again".into());
        }
        let (answer, receiver) = oneshot::channel();
        state.queries.push_back((query, answer));
        self.changed.notify_all();
        Ok(receiver)
    }

    /// Adds a page that watches, or removes one.
    pub fn look_on(&self, comes: bool) {
        let mut state = self.state();
        let onlookers = state.onlookers;
        state.onlookers = if comes { onlookers + 1 } else { onlookers.saturating_sub(1) };
        self.changed.notify_all();
    }

    /// Stops the current frame and ends the renderer.
    pub fn end(&self) {
        // Hold the lock, so that the renderer does not begin to wait in between.
        let _state = self.state();
        self.is_over.store(true, Ordering::Relaxed);
        self.stop.store(true, Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// Waits for work. Renders nothing while no page watches. From the return on, the flag `stop` refers to the returned
    /// frame.
    pub fn next(&self) -> Next {
        let mut state = self.state();
        loop {
            if self.is_over.load(Ordering::Relaxed) {
                return Next::End;
            }
            // Drop queries of pages that are gone.
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

    /// Waits for another view request, which may fix a failure, or for a timeout.
    pub fn rest(&self, timeout: Duration) {
        let state = self.state();
        if !self.is_over.load(Ordering::Relaxed) && state.queries.is_empty() {
            drop(self.changed.wait_timeout(state, timeout));
        }
    }
}
