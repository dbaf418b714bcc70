//! Renders what is wanted: small frames that follow what moves, and, once all stands still, frames of the whole size that are
//! averaged without end, as `render` does it.

mod answers;

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use caustics::experiment::axis::{MAX_BOUNCES, RUNNER};
use caustics::experiment::cell::Cell;
use caustics::kernels::{Source, Watch};
use caustics::scene::{CameraChoice, SceneCamera};
use caustics_kernels::method::path::PATH;

use super::distance::Distance;
use super::edited::{Edited, camera_edit};
use super::lane::{JobConfiguration, Lane};
use super::look::{Layer, Shown, suiting};
use super::pace::Pace;
use super::recording::Recording;
use super::save;
use super::share::Share;
use super::shared::{Frame, Next, Shared};
use super::status::{self, Said};
use super::wish::{Against, Wish, still};
use crate::cli::Viewer;
use crate::command::say::told;

/// Least time between images of what stands still; making them takes at most one part in so many of the time.
const SHOW_EVERY: Duration = Duration::from_millis(60);
const SHOWS: u32 = 8;
/// Least time between looks for new kernels.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// Least time between words.
const SAY_EVERY: Duration = Duration::from_millis(100);
/// Least time between failures that are told outside of the pages.
const WARN_EVERY: Duration = Duration::from_secs(1);
/// Time that is waited after a failure, unless another wish comes.
const AFTER_FAILURE: Duration = Duration::from_secs(2);

/// Renders what is wanted.
pub struct Engine<'a> {
    shared: Arc<Shared>,
    options: &'a Viewer,
    edited: Edited,
    /// What renders while something moves, and its size.
    moving: Option<Lane>,
    pace: Pace,
    /// What converges: the image, and what it is held against.
    still: [Option<Lane>; 2],
    /// What the lanes that converge stand at: text of the camera and the time; none since something moved.
    stands: Option<String>,
    /// The camera and the time of the last frame.
    camera: Option<SceneCamera>,
    time: f64,
    serial: u64,
    shows: Share,
    said: Option<Instant>,
    /// The exposure that suits the image (stops).
    suits: Option<f64>,
    distance: Distance,
    /// Kernels from a folder, which change while this program runs.
    kernels: Option<Watch>,
    looked: Instant,
    /// Why the last frame failed, if it did.
    failed: Option<String>,
    warns: Share,
    /// Since when it is recorded what moves, and what was.
    records: Option<Instant>,
    recording: Recording,
    /// What of the command line `render` is told too.
    kept: Vec<String>,
}

impl<'a> Engine<'a> {
    /// For a scene that is opened.
    pub fn new(shared: Arc<Shared>, options: &'a Viewer, edited: Edited) -> Engine<'a> {
        Engine {
            shared,
            options,
            edited,
            moving: None,
            pace: Pace::new(),
            still: [None, None],
            stands: None,
            camera: None,
            time: 0.0,
            serial: 0,
            shows: Share::new(SHOWS, SHOW_EVERY),
            said: None,
            suits: None,
            distance: Distance::new(),
            kernels: match options.machine.source() {
                Source::Folder(folder) => Some(Watch::new(folder)),
                Source::Embedded => None,
            },
            looked: Instant::now(),
            failed: None,
            warns: Share::new(0, WARN_EVERY),
            records: None,
            recording: Recording::default(),
            kept: save::kept(),
        }
    }

    /// Renders until the end.
    pub fn run(mut self) {
        loop {
            match self.shared.next() {
                Next::End => return,
                Next::Answer(asked, answer) => {
                    // Whoever asked may be gone.
                    let _ = answer.send(self.answer(&asked));
                }
                Next::Words(wish) => {
                    // The layer needs more of the mean than others.
                    if self.stands.is_some() && wish.look.layer == Layer::Variance {
                        (0..2).for_each(|side| self.show_mean(side, &wish));
                    }
                    self.said = None;
                    self.say(&wish, None);
                }
                Next::Frame(wish) => {
                    if let Err(error) = self.frame(&wish) {
                        // A session that failed is opened anew.
                        (self.moving, self.still, self.stands) = (None, [None, None], None);
                        let message = told(&error);
                        // Until another wish comes it fails again; a page may have very many that fail.
                        let now = Instant::now();
                        if self.failed.as_ref() != Some(&message) && self.warns.is_due(now) {
                            self.warns.spent(now, now);
                            tell!("warning: {message}");
                        }
                        self.say(&wish, Some(&message));
                        self.failed = Some(message);
                        self.shared.rest(AFTER_FAILURE);
                    } else {
                        self.failed = None;
                    }
                }
            }
        }
    }

    fn frame(&mut self, wish: &Wish) -> anyhow::Result<()> {
        let now = Instant::now();
        self.take_new_kernels(now);
        if self.edited.bring(self.options, &wish.nodes)? {
            (self.moving, self.still, self.stands) = (None, [None, None], None);
        }
        let time = wish.time_at(now, self.edited.scene.duration());
        self.time = time;
        if wish.moves(now) {
            self.stands = None;
            self.distance.forget();
            self.edited.scene.pose(time)?;
            let camera = self.camera(wish)?;
            self.follow(wish, &camera)
        } else {
            let stands = format!("{:?} {time}", wish.camera);
            let begins = self.stands.as_ref() != Some(&stands);
            if begins {
                self.edited.scene.pose(time)?;
            }
            let camera = self.camera(wish)?;
            // While lanes are brought there, they are not known to stand anywhere.
            self.stands = None;
            let mut side = 0;
            for (other, cell) in self.sides(wish).into_iter().enumerate() {
                self.bring(other, cell, wish, &camera, begins)?;
                // In turns of the same time.
                let wall = |lane: &Option<Lane>| lane.as_ref().map(|lane| lane.report.wall);
                if wall(&self.still[other]).is_some_and(|wall_of| Some(wall_of) < wall(&self.still[side])) {
                    side = other;
                }
            }
            self.stands = Some(stands);
            self.converge(side, wish)
        }
    }

    /// Drops sessions whose kernels were compiled again: those that are opened then take the new ones.
    fn take_new_kernels(&mut self, now: Instant) {
        if now - self.looked < LOOK_EVERY {
            return;
        }
        self.looked = now;
        if self.kernels.as_mut().is_some_and(Watch::has_new) {
            (self.moving, self.still, self.stands) = (None, [None, None], None);
            tell!("new kernels");
        }
    }

    /// How to render the image, and what it is held against.
    fn sides(&self, wish: &Wish) -> [Option<Cell>; 2] {
        let [own, other] = &wish.cells;
        let against = match wish.against {
            Against::Nothing => None,
            Against::Other => Some(still(other)),
            Against::Reference => {
                let mut reference = Cell::new(&PATH);
                for axis in [&RUNNER, &MAX_BOUNCES] {
                    // A value that an axis has itself is one that it takes.
                    let _ = axis.set(&mut reference, &axis.get(own));
                }
                Some(Cell { asked_runner: own.asked_runner, ..reference }.effective())
            }
        };
        [Some(still(own)), against]
    }

    /// The camera that is wanted.
    fn camera(&mut self, wish: &Wish) -> anyhow::Result<SceneCamera> {
        let [width, height] = wish.size.map(f64::from);
        let camera = match &wish.camera {
            CameraChoice::Placed(viewpoint) => {
                // A placed camera's name speaks of the file's coordinates, the tables of those around the origin.
                self.edited.scene.additions.insert("origin", self.edited.scene.origin.to_string());
                self.edited.scene.view_from(viewpoint, width / height)?
            }
            CameraChoice::Named(name) => {
                self.edited.scene.additions.remove("origin");
                self.edited.scene.camera(Some(name))?.clone()
            }
            CameraChoice::First => self.edited.scene.camera(None)?.clone(),
        };
        self.camera = Some(camera.clone());
        Ok(camera)
    }

    /// Renders a frame of what moves.
    fn follow(&mut self, wish: &Wish, camera: &SceneCamera) -> anyhow::Result<()> {
        let cell = wish.cells[0].clone().effective();
        let size = self.pace.size(wish.size, wish.target_fps);
        let configuration = self.configuration(cell, size, false);
        if self.moving.as_ref().is_none_or(|lane| lane.key != configuration.key()) {
            let was = self.moving.take().map(|lane| lane.configuration.cell.key());
            if was.is_some_and(|was| was != configuration.cell.key()) {
                self.pace.forget();
            }
            let mut lane = self.open(configuration, camera)?;
            lane.stop_by(&self.shared.is_over);
            self.moving = Some(lane);
        }
        let lane = self.moving.as_mut().context("a session was opened")?;
        lane.opened.session.pose(&self.edited.scene, camera)?;
        // One that is stopped is the last.
        let Some(took) = lane.frame()? else { return Ok(()) };
        self.pace.learn(size, took);
        self.record(wish);
        let lane = self.moving.as_mut().context("a session was opened")?;
        let shown = Shown { image: lane.opened.session.image()?, ..Shown::default() };
        self.show(0, 1, true, wish.at, shown);
        self.say(wish, None);
        Ok(())
    }

    /// Records where all is, if that is wanted.
    fn record(&mut self, wish: &Wish) {
        if !wish.records {
            self.records = None;
            return;
        }
        if self.records.is_none() {
            self.recording = Recording::default();
        }
        let since = *self.records.get_or_insert_with(Instant::now);
        let was_full = self.recording.is_full();
        self.recording.add(since.elapsed().as_secs_f64(), self.edited.nodes(), camera_edit(&wish.camera));
        if self.recording.is_full() && !was_full {
            tell!("warning: the recording is full: what moves from now on is not recorded");
        }
    }

    /// Opens what converges on a side, or begins it anew.
    fn bring(
        &mut self,
        side: usize,
        cell: Option<Cell>,
        wish: &Wish,
        camera: &SceneCamera,
        begins: bool,
    ) -> anyhow::Result<()> {
        let Some(cell) = cell else {
            if self.still[side].take().is_some() {
                self.shared.frames[side].send_replace(None);
                self.distance.forget();
            }
            return Ok(());
        };
        let configuration = self.configuration(cell, wish.size, true);
        match &mut self.still[side] {
            Some(lane) if lane.key == configuration.key() => {
                if begins {
                    lane.restart(&self.edited.scene, camera)?;
                }
            }
            lane => {
                *lane = None;
                let mut lane = self.open(configuration, camera)?;
                lane.stop_by(&self.shared.stop);
                self.still[side] = Some(lane);
            }
        }
        Ok(())
    }

    fn configuration(&self, cell: Cell, size: [u32; 2], averages: bool) -> JobConfiguration {
        let features = cell.features(&self.edited.scene, self.options.view.specular_roughness);
        JobConfiguration { cell, size, averages, features }
    }

    fn open(&self, configuration: JobConfiguration, camera: &SceneCamera) -> anyhow::Result<Lane> {
        Lane::open(configuration, &self.options.machine, &self.options.view, &self.edited.scene, camera)
    }

    /// Renders a frame of what converges.
    fn converge(&mut self, side: usize, wish: &Wish) -> anyhow::Result<()> {
        let lane = self.still[side].as_mut().context("a session was opened")?;
        if lane.frame()?.is_none() {
            // Another wish came meanwhile.
            self.stands = None;
            return Ok(());
        }
        lane.add()?;
        let start = Instant::now();
        if lane.sums.frames().is_power_of_two() || self.shows.is_due(start) {
            self.show_mean(side, wish);
            self.shows.spent(start, Instant::now());
            self.measure(wish);
        }
        self.say(wish, None);
        Ok(())
    }

    /// Shows the mean of a side, if there is one.
    fn show_mean(&mut self, side: usize, wish: &Wish) {
        let lane = self.still[side].as_ref().filter(|lane| lane.sums.frames() > 0);
        if let Some((samples, mean)) = lane.map(|lane| (lane.sums.frames(), lane.mean(wish.look.layer))) {
            self.show(side, samples, false, wish.at, mean);
        }
    }

    /// Measures how far the sides are apart.
    fn measure(&mut self, wish: &Wish) {
        let [Some(own), Some(other)] = &self.still else { return };
        if own.sums.frames() > 0 && other.sums.frames() > 0 {
            let stops = wish.look.stops(self.suits.unwrap_or_default());
            self.distance.measure(|| [own.sums.mean(), other.sums.mean()], stops);
        }
    }

    /// Hands an image to the pages.
    fn show(&mut self, side: usize, samples: u32, moves: bool, at: f64, mut shown: Shown) {
        if side == 0 {
            self.suits = Some(suiting(&shown.image, self.suits));
        }
        shown.suits = self.suits.unwrap_or_default();
        self.serial += 1;
        let frame = Frame { serial: self.serial, samples, moves, at, shown };
        self.shared.frames[side].send_replace(Some(Arc::new(frame)));
    }

    /// Tells the pages how things are.
    fn say(&mut self, wish: &Wish, failure: Option<&str>) {
        if failure.is_none() && self.said.is_some_and(|said| said.elapsed() < SAY_EVERY) {
            return;
        }
        self.said = Some(Instant::now());
        let lane = if self.stands.is_some() { self.still[0].as_ref() } else { self.moving.as_ref() };
        let said = Said {
            kept: &self.kept,
            scene: &self.edited.scene,
            wish,
            is_edited: self.edited.is_edited(),
            recorded: self.recording.len(),
            is_full: self.recording.is_full(),
            camera: self.camera.as_ref(),
            time: self.time,
            moves: self.stands.is_none(),
            lane,
            against: self.still[1].as_ref(),
            distance: self.distance.value.as_ref(),
            stops: wish.look.stops(self.suits.unwrap_or_default()),
            failure,
        };
        self.shared.status.send_replace(status::text(&said).into());
    }
}
