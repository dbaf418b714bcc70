//! Renders the view request: small frames while something moves, then frames of the full size, which are averaged without
//! end, as `render` does.

mod answers;

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use caustics::kernels::{Source, Watch};
use caustics::scene::{CameraChoice, SceneCamera};
use caustics_bench::parameter::{MAX_BOUNCES, RUNNER};
use caustics_bench::run_config::RunConfig;
use caustics_kernels::method::path::PATH;

use super::distance::Distance;
use super::edited::{Changed, Edited, camera_edit};
use super::look::{DisplayedImage, Layer, suiting};
use super::pace::Pace;
use super::recording::Recording;
use super::render_job::{JobConfiguration, RenderJob};
use super::request::{Against, ViewRequest, still};
use super::save;
use super::share::Share;
use super::shared::{Next, PageFrame, Shared};
use super::status::{self, Status};
use crate::cli::Viewer;
use crate::command::console::error_chain;

/// Minimum time between images of a still view, and the reciprocal of the maximum share of time for making them.
const SHOW_EVERY: Duration = Duration::from_millis(60);
const SHOWS: u32 = 8;
/// Minimum time between checks for new kernels.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// Minimum time between two statuses.
const STATUS_EVERY: Duration = Duration::from_millis(100);
/// Minimum time between warnings of failures on stderr.
const WARN_EVERY: Duration = Duration::from_secs(1);
/// Pause after a failure, unless another view request arrives.
const AFTER_FAILURE: Duration = Duration::from_secs(2);

/// Renders the view request.
pub struct Engine<'a> {
    shared: Arc<Shared>,
    options: &'a Viewer,
    edited: Edited,
    /// Render job while something moves.
    moving: Option<RenderJob>,
    pace: Pace,
    /// Render jobs that converge: the image, and the one compared with it.
    still: [Option<RenderJob>; 2],
    /// Camera and time of the render jobs that converge, as text; none since something moved.
    stands: Option<String>,
    /// Camera and time of the last frame.
    camera: Option<SceneCamera>,
    time: f64,
    serial: u64,
    shows: Share,
    status_sent: Option<Instant>,
    /// Exposure that fits the image (stops).
    suits: Option<f64>,
    distance: Distance,
    /// Folder of kernels that are watched while this program runs.
    kernels: Option<Watch>,
    looked: Instant,
    /// Failure of the last frame, if any.
    failed: Option<String>,
    warns: Share,
    /// Start of the recording, and its keys so far.
    records: Option<Instant>,
    recording: Recording,
    /// Arguments of the command line that `render` takes too.
    kept: Vec<String>,
}

impl<'a> Engine<'a> {
    /// Makes the engine of an opened scene.
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
            status_sent: None,
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

    /// Renders until the program ends.
    pub fn run(mut self) {
        loop {
            match self.shared.next() {
                Next::End => return,
                Next::Answer(query, answer) => {
                    // The page that asked may be gone.
                    let _ = answer.send(self.answer(&query));
                }
                Next::Words(request) => {
                    // The variance layer needs more data of the mean than others.
                    if self.stands.is_some() && request.look.layer == Layer::Variance {
                        (0..2).for_each(|side| self.show_mean(side, &request));
                    }
                    self.status_sent = None;
                    self.send_status(&request, None);
                }
                Next::Frame(request) => {
                    if let Err(error) = self.frame(&request) {
                        // Open failed sessions anew.
                        (self.moving, self.still, self.stands) = (None, [None, None], None);
                        let message = error_chain(&error);
                        // The frame fails again until another view request arrives; warn once of each failure, and not too
                        // often.
                        let now = Instant::now();
                        if self.failed.as_ref() != Some(&message) && self.warns.is_due(now) {
                            self.warns.spent(now, now);
                            message!("warning: {message}");
                        }
                        self.send_status(&request, Some(&message));
                        self.failed = Some(message);
                        self.shared.rest(AFTER_FAILURE);
                    } else {
                        self.failed = None;
                    }
                }
            }
        }
    }

    fn frame(&mut self, request: &ViewRequest) -> anyhow::Result<()> {
        let now = Instant::now();
        self.take_new_kernels(now);
        match self.edited.bring(self.options, &request.nodes)? {
            Changed::Nothing => {}
            Changed::Pose => self.stands = None,
            Changed::Scene => (self.moving, self.still, self.stands) = (None, [None, None], None),
        }
        let time = request.time_at(now, self.edited.scene.duration());
        self.time = time;
        if request.moves(now) {
            self.stands = None;
            self.distance.forget();
            self.edited.scene.pose(time)?;
            let camera = self.camera(request)?;
            self.follow(request, &camera)
        } else {
            let stands = format!("{:?} {time}", request.camera);
            let begins = self.stands.as_ref() != Some(&stands);
            if begins {
                self.edited.scene.pose(time)?;
            }
            let camera = self.camera(request)?;
            // While render jobs are being prepared, their camera and time are unknown.
            self.stands = None;
            let mut side = 0;
            for (other, run_config) in self.sides(request).into_iter().enumerate() {
                self.bring(other, run_config, request, &camera, begins)?;
                // Give both sides the same time in turn.
                let wall = |job: &Option<RenderJob>| job.as_ref().map(|job| job.report.wall);
                if wall(&self.still[other]).is_some_and(|wall_of| Some(wall_of) < wall(&self.still[side])) {
                    side = other;
                }
            }
            self.stands = Some(stands);
            self.converge(side, request)
        }
    }

    /// Drops the sessions when kernels were compiled again; new sessions take the new kernels.
    fn take_new_kernels(&mut self, now: Instant) {
        if now - self.looked < LOOK_EVERY {
            return;
        }
        self.looked = now;
        if self.kernels.as_mut().is_some_and(Watch::has_new) {
            (self.moving, self.still, self.stands) = (None, [None, None], None);
            message!("new kernels");
        }
    }

    /// Returns the configurations of the image and of the one compared with it.
    fn sides(&self, request: &ViewRequest) -> [Option<RunConfig>; 2] {
        let [own, other] = &request.run_configs;
        let against = match request.against {
            Against::Nothing => None,
            Against::Other => Some(still(other)),
            Against::Reference => {
                let mut reference = RunConfig::new(&PATH);
                for parameter in [&RUNNER, &MAX_BOUNCES] {
                    // A parameter accepts every value that it returns.
                    let _ = parameter.set(&mut reference, &parameter.get(own));
                }
                Some(RunConfig { asked_runner: own.asked_runner, ..reference }.effective())
            }
        };
        [Some(still(own)), against]
    }

    /// Returns the camera of the view request.
    fn camera(&mut self, request: &ViewRequest) -> anyhow::Result<SceneCamera> {
        let [width, height] = request.size.map(f64::from);
        let camera = match &request.camera {
            CameraChoice::Placed(viewpoint) => {
                // The name of a placed camera has the file's coordinates, the scene's tables have others; record the origin
                // between them.
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

    /// Renders a frame while something moves.
    fn follow(&mut self, request: &ViewRequest, camera: &SceneCamera) -> anyhow::Result<()> {
        let run_config = request.run_configs[0].clone().effective();
        let size = self.pace.size(request.size, request.target_fps);
        let configuration = self.configuration(run_config, size, false);
        if self.moving.as_ref().is_none_or(|job| job.key != configuration.key()) {
            let was = self.moving.take().map(|job| job.configuration.run_config.key());
            if was.is_some_and(|was| was != configuration.run_config.key()) {
                self.pace.forget();
            }
            let mut job = self.open(configuration, camera)?;
            job.stop_by(&self.shared.is_over);
            self.moving = Some(job);
        }
        let job = self.moving.as_mut().context("a session was opened")?;
        job.opened.session.pose(&self.edited.scene, camera)?;
        // Only the end of the program stops such a frame.
        let Some(took) = job.frame()? else { return Ok(()) };
        self.pace.learn(size, took);
        self.record(request);
        let job = self.moving.as_mut().context("a session was opened")?;
        let shown = DisplayedImage { image: job.opened.session.image()?, ..DisplayedImage::default() };
        self.show(0, 1, true, request.at, shown);
        self.send_status(request, None);
        Ok(())
    }

    /// Records the positions of nodes and the camera, if the view request asks for it.
    fn record(&mut self, request: &ViewRequest) {
        if !request.records {
            self.records = None;
            return;
        }
        if self.records.is_none() {
            self.recording = Recording::default();
        }
        let since = *self.records.get_or_insert_with(Instant::now);
        let was_full = self.recording.is_full();
        self.recording.add(since.elapsed().as_secs_f64(), self.edited.nodes(), camera_edit(&request.camera));
        if self.recording.is_full() && !was_full {
            message!("warning: the recording is full: what moves from now on is not recorded");
        }
    }

    /// Opens the render job of a side that converges, or restarts it.
    fn bring(
        &mut self,
        side: usize,
        run_config: Option<RunConfig>,
        request: &ViewRequest,
        camera: &SceneCamera,
        begins: bool,
    ) -> anyhow::Result<()> {
        let Some(run_config) = run_config else {
            if self.still[side].take().is_some() {
                self.shared.frames[side].send_replace(None);
                self.distance.forget();
            }
            return Ok(());
        };
        let configuration = self.configuration(run_config, request.size, true);
        match &mut self.still[side] {
            Some(job) if job.key == configuration.key() => {
                if begins {
                    job.restart(&self.edited.scene, camera)?;
                }
            }
            job => {
                *job = None;
                let mut job = self.open(configuration, camera)?;
                job.stop_by(&self.shared.stop);
                self.still[side] = Some(job);
            }
        }
        Ok(())
    }

    fn configuration(&self, run_config: RunConfig, size: [u32; 2], averages: bool) -> JobConfiguration {
        let features =
            run_config.config.features.features(&self.edited.scene, self.options.view.specular_roughness);
        JobConfiguration { run_config, size, averages, features }
    }

    fn open(&self, configuration: JobConfiguration, camera: &SceneCamera) -> anyhow::Result<RenderJob> {
        RenderJob::open(configuration, &self.options.machine, &self.options.view, &self.edited.scene, camera)
    }

    /// Renders a frame of a side that converges.
    fn converge(&mut self, side: usize, request: &ViewRequest) -> anyhow::Result<()> {
        let job = self.still[side].as_mut().context("a session was opened")?;
        if job.frame()?.is_none() {
            // Another view request has arrived.
            self.stands = None;
            return Ok(());
        }
        job.add()?;
        let start = Instant::now();
        if job.sums.frames().is_power_of_two() || self.shows.is_due(start) {
            self.show_mean(side, request);
            self.shows.spent(start, Instant::now());
            self.measure(request);
        }
        self.send_status(request, None);
        Ok(())
    }

    /// Shows the mean of a side, if it has frames.
    fn show_mean(&mut self, side: usize, request: &ViewRequest) {
        let job = self.still[side].as_ref().filter(|job| job.sums.frames() > 0);
        if let Some((samples, mean)) = job.map(|job| (job.sums.frames(), job.mean(request.look.layer))) {
            self.show(side, samples, false, request.at, mean);
        }
    }

    /// Measures the distance between the sides.
    fn measure(&mut self, request: &ViewRequest) {
        let [Some(own), Some(other)] = &self.still else { return };
        if own.sums.frames() > 0 && other.sums.frames() > 0 {
            let stops = request.look.stops(self.suits.unwrap_or_default());
            self.distance.measure(|| [own.sums.mean(), other.sums.mean()], stops);
        }
    }

    /// Passes an image to the pages.
    fn show(&mut self, side: usize, samples: u32, moves: bool, at: f64, mut shown: DisplayedImage) {
        if side == 0 {
            self.suits = Some(suiting(&shown.image, self.suits));
        }
        shown.suits = self.suits.unwrap_or_default();
        self.serial += 1;
        let frame = PageFrame { serial: self.serial, samples, moves, at, shown };
        self.shared.frames[side].send_replace(Some(Arc::new(frame)));
    }

    /// Sends the status to the pages.
    fn send_status(&mut self, request: &ViewRequest, failure: Option<&str>) {
        if failure.is_none()
            && self.status_sent.is_some_and(|status_sent| status_sent.elapsed() < STATUS_EVERY)
        {
            return;
        }
        self.status_sent = Some(Instant::now());
        let job = if self.stands.is_some() { self.still[0].as_ref() } else { self.moving.as_ref() };
        let status = Status {
            kept: &self.kept,
            scene: &self.edited.scene,
            request,
            is_edited: self.edited.is_edited(),
            recorded: self.recording.len(),
            is_full: self.recording.is_full(),
            camera: self.camera.as_ref(),
            time: self.time,
            moves: self.stands.is_none(),
            job,
            against: self.still[1].as_ref(),
            distance: self.distance.value.as_ref(),
            stops: request.look.stops(self.suits.unwrap_or_default()),
            failure,
        };
        self.shared.status.send_replace(status::text(&status).into());
    }
}
