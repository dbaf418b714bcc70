//! Session: one scene, one view and one method on one runner. The caller renders frames by index and reads images back.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bytemuck::cast_slice;
use caustics_kernels::emission::GUIDED;
use caustics_kernels::gather::accumulator;
use caustics_kernels::gather::variant::{self, Variant};
use caustics_kernels::history::auxiliary::AUXILIARY_LAYERS;
use caustics_kernels::history::path::PATH_HISTORY;
use caustics_kernels::interface::auxiliary::Auxiliary as AuxiliaryRecord;
use caustics_kernels::interface::balance::Balance;
use caustics_kernels::interface::choice::LightSampler;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::{Camera, FIRST_FRAME, FrameParams};
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::light_bvh::LightBvhNode;
use caustics_kernels::interface::point::PointGeometry;
use caustics_kernels::pass::balance::BALANCE;
use caustics_kernels::pass::collect::pixel_order;
use caustics_kernels::pass::display::DISPLAY;
use glam::{DVec3, Vec3};

use crate::counters::Counters;
use crate::energy::EnergyLedger;
use crate::frame_memory::{FrameTooLarge, Need};
use crate::kernels::{self, KernelsError};
use crate::render_config::{RenderConfig, with_light_paths};
use crate::runner::cpu::CpuRunner;
use crate::runner::gpu::GpuRunner;
use crate::runner::{RunError, Runner, StepTime};
use crate::upload::Upload;
use crate::vulkan::VulkanError;
use crate::vulkan::passes::{DeviceOptions, Kernels};
use caustics_files::rendered_image::{Auxiliary, RenderedImage};
use caustics_kernels::declare::{Bound, BufferSpec, Step};
use caustics_kernels::method::Method;
use caustics_kernels::method::Parts;
use caustics_kernels::method::frame::{frame_buffers, look_back};
use caustics_scene::{Scene, SceneCamera, SceneError};

use self::last::{Last, Starts, overwritten};
use self::tiles::{Rendered, TileState, Tiles};

mod kept;
pub(crate) mod last;
mod tiles;

/// Runner to open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RunnerChoice {
    /// CPU runner.
    Cpu {
        /// Number of worker threads; 0 uses every core.
        threads: usize,
    },
    /// GPU runner on a Vulkan device.
    Gpu {
        /// Index of the device, or part of its name. `None` selects the best device.
        device: Option<String>,
        /// Whether ray queries trace rays; the device must support them.
        hardware: bool,
        /// Whether the Vulkan validation layer is on; its messages are errors.
        validation: bool,
        /// Source of the compiled kernels, which are read when a session is opened.
        kernels: kernels::Source,
    },
}

impl RunnerChoice {
    /// Whether the runner has ray queries.
    pub fn has_ray_queries(&self) -> bool {
        matches!(self, RunnerChoice::Gpu { hardware: true, .. })
    }

    /// Returns the gather that is used unless the user chooses one. On a GPU, photons search the points: if one disc took
    /// most photons, the GPU would wait for that disc's invocation.
    pub fn default_gather(&self) -> &'static Variant {
        match self {
            RunnerChoice::Cpu { .. } => &variant::PHOTONS_GRID,
            RunnerChoice::Gpu { hardware: false, .. } => &variant::POINTS_BVH,
            RunnerChoice::Gpu { hardware: true, .. } => &variant::POINTS_RT,
        }
    }

    /// Checks that the runner can be opened. An opened device is kept for the sessions that follow.
    ///
    /// # Errors
    ///
    /// If there is no such device, or it cannot run the kernels.
    pub fn check(&self) -> Result<(), SessionError> {
        if let RunnerChoice::Gpu { device, hardware, validation, kernels } = self {
            let options = device_options(device.as_deref(), *hardware, *validation, kernels)?;
            Kernels::open(&options).map_err(RunError::from)?;
        }
        Ok(())
    }
}

fn device_options(
    device: Option<&str>,
    hardware: bool,
    validation: bool,
    kernels: &kernels::Source,
) -> Result<DeviceOptions, SessionError> {
    let modules = kernels.modules()?;
    Ok(DeviceOptions {
        device: device.map(String::from),
        hardware,
        validation,
        base: modules.base,
        rayquery: hardware.then_some(modules.rayquery),
    })
}

/// Error of opening or using a session.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The runner fails.
    #[error("{0}")]
    Run(#[from] RunError),
    /// The compiled kernels cannot be run.
    #[error("{0}")]
    Kernels(#[from] KernelsError),
    /// A frame takes more memory than is available.
    #[error("{0}")]
    TooLarge(#[from] FrameTooLarge),
    /// The runner does not support the gather.
    #[error("--gather {gather} needs ray queries (--runner gpu --tracer hardware)")]
    RayQueries {
        /// Name of the gather.
        gather: &'static str,
    },
    /// The method does not use the emission.
    #[error("--method {method} starts its light paths in its own way, not by {emission}")]
    Emission {
        /// Name of the method.
        method: &'static str,
        /// Name of the emission.
        emission: &'static str,
    },
    /// The scene has no such camera.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// The state belongs to another session.
    #[error("a state has no whole buffer {buffer}")]
    State {
        /// Name of the missing buffer.
        buffer: &'static str,
    },
    /// The state has values that are not finite.
    #[error("the numbers of buffer {buffer} in a state are not finite")]
    NotFinite {
        /// Name of the buffer.
        buffer: &'static str,
    },
    /// No frame can be inspected.
    #[error("there is no frame of the scene as it stands to look into; render one first")]
    NoFrame,
    /// The frame has several tiles.
    #[error("a frame of several tiles cannot be looked into; render it in one (--tiles 1)")]
    Tiles,
    /// The pixel is outside of the image.
    #[error("there is no pixel {x},{y} in an image of {width} by {height}")]
    NoPixel {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// Width (px).
        width: u32,
        /// Height (px).
        height: u32,
    },
    /// A buffer cannot be read.
    #[error("reading buffer {buffer}")]
    Read {
        /// Name of the buffer.
        buffer: String,
        /// Cause.
        source: RunError,
    },
}

/// Opens a runner and returns it with its number of tiles. The number is the user's, or else the smallest for which the
/// device can bind all buffers.
fn open_in_tiles(
    config: &RenderConfig,
    open: impl Fn(u32) -> Result<Box<dyn Runner>, SessionError>,
    buffers_of: impl Fn(u32) -> Vec<BufferSpec>,
) -> Result<(Box<dyn Runner>, u32), SessionError> {
    let count = config.tiles.unwrap_or(1);
    let opened = open(count);
    if let Err(SessionError::Run(RunError::Vulkan(VulkanError::BufferTooLarge { limit, .. }))) = &opened
        && config.tiles.is_none()
        && let Some(more) = tiles::within(*limit, config.height, buffers_of)
    {
        return Ok((open(more)?, more));
    }
    Ok((opened?, count))
}

/// Opens a runner with a scene's tables and the given buffers, for running single passes.
///
/// # Errors
///
/// If there is no suitable Vulkan device, the compiled kernels do not fit this program, or memory does not suffice.
pub fn open(
    choice: &RunnerChoice,
    scene: &Scene,
    features: Features,
    buffers: &[BufferSpec],
) -> Result<Box<dyn Runner>, SessionError> {
    let mut tables = scene.buffers();
    // Reserve room for all lights, since an animation turns lights off and on.
    let mut lights = scene.lights.clone();
    lights.resize(scene.max_light_count(), Light::default());
    let mut light_bvh = scene.light_bvh.clone();
    light_bvh.resize(scene.max_light_bvh_nodes(), LightBvhNode::default());
    for (name, bytes) in &mut tables {
        match *name {
            "lights" => *bytes = cast_slice(&lights),
            "light_bvh" => *bytes = cast_slice(&light_bvh),
            _ => (),
        }
    }
    match choice {
        RunnerChoice::Cpu { threads } => Ok(Box::new(CpuRunner::new(*threads, features, buffers, &tables)?)),
        RunnerChoice::Gpu { device, hardware, validation, kernels } => {
            let options = device_options(device.as_deref(), *hardware, *validation, kernels)?;
            let opened = GpuRunner::new(&options, features, buffers, &tables, &scene.instanced);
            Ok(Box::new(opened.map_err(RunError::from)?))
        }
    }
}

/// Renderer of frames of one view; see [`Session::builder`].
///
/// The frame's index and the settings' seed determine all random numbers, so that any frame can be rendered again. If
/// frames learn from earlier ones, this also takes the [`Session::state`] after the frame before.
pub struct Session {
    runner: Box<dyn Runner>,
    parts: Parts,
    config: RenderConfig,
    params: FrameParams,
    /// Flux of the lights (W).
    flux: Vec3,
    /// Offset of the file's coordinates from the kernels' (m).
    origin: DVec3,
    /// Number of light paths of the next frame, if it shoots any.
    light_paths: u32,
    /// Camera of the frame before.
    previous_camera: Camera,
    /// Index of the frame before; `None` before the first frame.
    previous_frame: Option<u32>,
    upload: Upload,
    /// Whether something moved since the last frame, or there was none.
    moved: bool,
    /// Buffers that outlive a frame.
    kept: Vec<BufferSpec>,
    /// Features that are compiled into the kernels.
    features: Features,
    /// Last frame, unless the scene changed since.
    last: Option<Last>,
    keeps_starts: bool,
    /// Tiles of the image, with the one that is in the buffers.
    tiles: Tiles,
}

impl Session {
    /// Opens the runner and allocates all buffers of the method's frames. [`Session::builder`] fills in defaults.
    ///
    /// # Errors
    ///
    /// - If the gather needs ray queries and the runner has none.
    /// - If there is no suitable Vulkan device.
    /// - If a frame does not fit into memory.
    pub fn new(
        choice: &RunnerChoice,
        scene: &Scene,
        camera: &SceneCamera,
        config: &RenderConfig,
        features: Features,
    ) -> Result<Session, SessionError> {
        let gather = config.gather.unwrap_or_else(|| choice.default_gather());
        let config = RenderConfig { gather: Some(gather), ..config.clone() }.with_defaults_of_method();
        let method = config.method;
        if method.chooses_gather && gather.hardware && !choice.has_ray_queries() {
            return Err(SessionError::RayQueries { gather: gather.name });
        }
        if !method.takes_emission(config.emission) {
            return Err(SessionError::Emission { method: method.name, emission: config.emission.name });
        }
        let parts = config.parts();
        let largest = config.largest(scene, camera);
        let tiled = |count: u32| Tiles::new(largest.window, count);
        let buffers_of = |count: u32| frame_buffers(method, parts, &tiled(count).params(0, largest));
        let scene_bytes = scene.buffers().iter().map(|(_, bytes)| bytes.len() as u64).sum();
        let on_gpu = matches!(choice, RunnerChoice::Gpu { .. });
        let check = |count: u32| {
            let tile = tiled(count).params(0, largest);
            Need::for_frame(method, parts, tile, scene_bytes, on_gpu).check_available(&config)
        };
        let has_history = parts.history.settings.is_some() || parts.stages.has(&PATH_HISTORY);
        let of_history = if has_history { Features::HISTORY } else { Features(0) };
        let share_maps = parts.emission == &GUIDED && largest.light_groups.share_maps();
        let of_lights = if share_maps { Features::LIGHT_PYRAMIDS } else { Features(0) };
        let samples_by_bvh = config.light_sampler == LightSampler::Bvh && scene.max_light_bvh_nodes() > 0;
        let of_sampler = if samples_by_bvh { Features::LIGHT_BVH } else { Features(0) };
        let features = features | parts.features() | of_history | of_lights | of_sampler;
        check(config.tiles.unwrap_or(1))?;
        let open = |count: u32| open(choice, scene, features, &buffers_of(count));
        let (runner, count) = open_in_tiles(&config, open, buffers_of)?;
        let (tiles, buffers) = (tiled(count), buffers_of(count));
        let is_kept = |name| method.kept(parts).any(|kept| kept == name);
        let kept = buffers.iter().filter(|spec| is_kept(spec.name)).copied().collect();
        let params = config.params(scene, camera, 0);
        let previous_camera = params.camera;
        let upload = Upload::new(scene);
        let mut session = Session {
            runner,
            parts,
            config,
            params,
            flux: scene.flux,
            origin: scene.origin,
            light_paths: 0,
            previous_camera,
            previous_frame: None,
            upload,
            moved: true,
            kept,
            features,
            last: None,
            keeps_starts: false,
            tiles,
        };
        session.turn_to(0)?;
        Ok(session)
    }

    /// Returns the number of tiles, which are rendered one after another.
    pub fn tiles(&self) -> u32 {
        self.tiles.count()
    }

    /// Loads a tile's state after the frame before into the buffers.
    fn turn_to(&mut self, tile: u32) -> Result<(), SessionError> {
        let before = self.tiles.current.map(|tile| self.tiles.rows(tile).len());
        let is_new = self.tiles.current != Some(tile);
        self.tiles.current = Some(tile);
        self.params = self.tiles.params(tile, self.params);
        if before != Some(self.tiles.rows(tile).len()) {
            let order = pixel_order(self.params.width, self.params.height);
            self.runner.write("pixel_order", cast_slice(&order))?;
        }
        if is_new && !self.tiles.is_one() {
            match self.tiles.states.get(tile as usize) {
                Some(state) => {
                    for (buffer, bytes) in state {
                        self.runner.write(buffer, bytes)?;
                    }
                }
                None => self.clear_kept()?,
            }
        }
        self.take_light_paths()
    }

    /// Zeroes the buffers that outlive a frame, as at the start.
    fn clear_kept(&mut self) -> Result<(), SessionError> {
        for spec in &self.kept {
            self.runner.write(spec.name, &vec![0; spec.bytes])?;
        }
        Ok(())
    }

    /// Moves the session to another time. The caller passes a scene that [`Scene::pose`] has moved and a camera of it; only
    /// changes are uploaded. Call it before each frame of an animation, since a history needs the motion.
    pub fn pose(&mut self, scene: &Scene, camera: &SceneCamera) -> Result<(), SessionError> {
        self.flux = scene.flux;
        let params = self.config.params(scene, camera, 0);
        self.params = self.tiles.params(self.tiles.current.unwrap_or(0), params);
        self.moved |= self.params.camera != self.previous_camera;
        if self.upload.run(&mut *self.runner, scene)? {
            self.moved = true;
            self.last = None;
        }
        Ok(())
    }

    /// Sets the pose of the image before to the current one, as if a frame had been rendered of it. Motion then starts from
    /// there.
    pub fn stand(&mut self) {
        self.previous_camera = self.params.camera;
    }

    /// Returns the buffers that outlive a frame, by name, for [`Session::restore`]. Empty if frames do not depend on each
    /// other.
    pub fn state(&mut self) -> Result<Vec<(&'static str, Vec<u8>)>, SessionError> {
        if self.tiles.is_one() {
            return self.tile_state();
        }
        let of_tiles = |spec: &BufferSpec| {
            let states = self.tiles.states.iter().flatten().filter(|(name, _)| *name == spec.name);
            (spec.name, states.flat_map(|(_, bytes)| bytes.iter().copied()).collect())
        };
        Ok(self.kept.iter().map(of_tiles).collect())
    }

    fn tile_state(&mut self) -> Result<TileState, SessionError> {
        let mut state = Vec::with_capacity(self.kept.len());
        for spec in self.kept.clone() {
            let mut bytes = self.read(spec.name)?;
            bytes.truncate(spec.bytes);
            state.push((spec.name, bytes));
        }
        Ok(state)
    }

    /// Continues from the state of a session with the same scene and settings after a frame. The session must be at the
    /// pose of that frame.
    ///
    /// # Errors
    ///
    /// If a buffer is missing, has another size, or holds values that are not finite. The session is then unchanged.
    pub fn restore(&mut self, frame: u32, state: &[(String, Vec<u8>)]) -> Result<(), SessionError> {
        let count = self.tiles.count() as usize;
        let mut states = vec![TileState::new(); count];
        for spec in &self.kept {
            let whole =
                |(name, bytes): &&(String, Vec<u8>)| name == spec.name && bytes.len() == count * spec.bytes;
            let (_, bytes) = state.iter().find(whole).ok_or(SessionError::State { buffer: spec.name })?;
            if !kept::is_finite(spec.name, bytes) {
                return Err(SessionError::NotFinite { buffer: spec.name });
            }
            for (state, bytes) in states.iter_mut().zip(bytes.chunks_exact(spec.bytes.max(1))) {
                state.push((spec.name, bytes.to_vec()));
            }
        }
        for (buffer, bytes) in &states[0] {
            self.runner.write(buffer, bytes)?;
        }
        if !self.tiles.is_one() {
            (self.tiles.states, self.tiles.current) = (states, None);
        }
        self.previous_camera = self.params.camera;
        self.previous_frame = Some(frame);
        self.moved = false;
        self.last = None;
        self.take_light_paths()
    }

    /// Forgets all frames. The next one equals the first frame of a new session at the current pose.
    pub fn restart(&mut self) -> Result<(), SessionError> {
        self.clear_kept()?;
        self.tiles.states.clear();
        (self.last, self.tiles.rendered) = (None, Rendered::default());
        self.previous_camera = self.params.camera;
        self.previous_frame = None;
        self.moved = true;
        self.light_paths = self.config.first_light_paths(self.params.pixel_count());
        Ok(())
    }

    /// Sets a flag that stops frames with [`RunError::Stopped`]; the caller must then call [`Session::restart`]. On a GPU,
    /// frames run to their end.
    pub fn stop_by(&mut self, flag: &Arc<AtomicBool>) {
        self.runner.stop_by(flag);
    }

    /// Declares that something moved since the last frame, as at a cut. Frames then give less weight to what they learnt
    /// before.
    /// A history still judges its own content. The first frame still uses the disc radii that the last one chose.
    pub fn jump(&mut self) {
        self.moved = true;
    }

    /// Returns the names of the device and its driver.
    pub fn device(&self) -> String {
        self.runner.device()
    }

    /// Returns the parameters of frame `frame` for the kernels.
    pub fn params(&self, frame: u32) -> FrameParams {
        let params = FrameParams {
            previous_camera: self.previous_camera,
            moved: if self.previous_frame.is_some() { u32::from(self.moved) } else { FIRST_FRAME },
            sequence: self.config.sequence(frame),
            ..self.params
        };
        (self.config.method.frame)(params, frame)
    }

    /// Renders frame `index` and returns the time of each of its steps. [`Session::image`] reads the image.
    pub fn frame(&mut self, index: u32) -> Result<Vec<StepTime>, SessionError> {
        let times = if self.tiles.is_one() { self.tile(index)? } else { self.tile_by_tile(index)? };
        self.previous_camera = self.params.camera;
        self.previous_frame = Some(index);
        self.moved = false;
        self.take_light_paths()?;
        Ok(times)
    }

    fn tile_by_tile(&mut self, index: u32) -> Result<Vec<StepTime>, SessionError> {
        let (mut times, mut rendered) = (Vec::new(), Rendered::default());
        let mut states = Vec::with_capacity(self.tiles.count() as usize);
        for tile in 0..self.tiles.count() {
            self.turn_to(tile)?;
            times.extend(self.tile(index)?);
            rendered.image.append(self.tile_image()?);
            let words: Vec<u32> = self.read("counters")?;
            rendered.counters.add(&Counters::from_words(&words));
            rendered.energy = rendered.energy.plus(EnergyLedger::from_words(&words, self.params.quantum));
            states.push(self.tile_state()?);
        }
        (self.tiles.states, self.tiles.rendered) = (states, rendered);
        // An inspection needs the whole frame.
        self.last = None;
        Ok(times)
    }

    /// Renders the tile in the buffers.
    fn tile(&mut self, index: u32) -> Result<Vec<StepTime>, SessionError> {
        if self.params.light_path_count > 0 {
            self.params = with_light_paths(self.params, self.light_paths, self.flux);
        }
        let mut times = self.look_back()?;
        let params = self.params(index);
        times.extend(self.run(params)?);
        Ok(times)
    }

    /// Sets whether frames keep the starts of light paths that they overwrite later. Guided emission overwrites starts in a
    /// frame after a motion.
    /// With kept starts, [`Session::inspect`] can trace the first light paths of such a frame again. Each such frame reads
    /// back a few MiB more.
    pub fn keep_starts(&mut self, keeps: bool) {
        self.keeps_starts = keeps;
    }

    /// Runs the steps of a frame, and keeps the starts of its light paths.
    fn run(&mut self, params: FrameParams) -> Result<Vec<StepTime>, SessionError> {
        let steps = self.config.method.frame_steps(self.parts, &params);
        let shoot = self.parts.emission.shoot;
        self.last = None;
        let mut last = Last { params, ..Last::default() };
        let mut times = Vec::with_capacity(steps.len());
        let mut rest = &steps[..];
        if let Some((index, started)) = overwritten(&steps, shoot, params.light_path_count) {
            last.started_before = started;
            if self.keeps_starts {
                times.extend(self.runner.run(&params, &steps[..index])?);
                last.starts_before = Some(self.starts()?);
                rest = &steps[index..];
            }
        }
        times.extend(self.runner.run(&params, rest)?);
        self.last = Some(last);
        Ok(times)
    }

    /// Reads the buffers that light paths start from, without scene tables.
    pub(crate) fn starts(&mut self) -> Result<Starts, SessionError> {
        let bounds = last::reads(self.parts.emission.shoot);
        let read = |bound: &'static Bound| {
            let mut bytes: Vec<u8> = self.read(bound.name)?;
            // A device may allocate more than was requested.
            bytes.truncate(bytes.len() / bound.stride * bound.stride);
            Ok((bound.name, bytes))
        };
        bounds.map(read).collect()
    }

    /// Returns the last frame, unless the scene changed since.
    pub(crate) fn last(&self) -> Option<&Last> {
        self.last.as_ref()
    }

    /// Returns the method, the parts and the features of the frames.
    pub(crate) fn made_of(&self) -> (&'static Method, Parts, Features) {
        (self.config.method, self.parts, self.features)
    }

    /// After a motion, traces the current scene from the camera of the frame before.
    fn look_back(&mut self) -> Result<Vec<StepTime>, SessionError> {
        let Some(frame) = self.previous_frame.filter(|_| self.moved) else { return Ok(Vec::new()) };
        let params = FrameParams {
            camera: self.previous_camera,
            sequence: self.config.sequence(frame),
            ..self.params
        };
        let params = (self.config.method.frame)(params, frame);
        let steps = look_back(self.parts, &params);
        if steps.is_empty() {
            return Ok(Vec::new());
        }
        Ok(self.runner.run(&params, &steps)?)
    }

    /// Reads the number of light paths for the next frame from the balance of earlier frames.
    fn take_light_paths(&mut self) -> Result<(), SessionError> {
        self.light_paths = self.config.first_light_paths(self.params.pixel_count());
        // Without light paths there is no buffer `balance`.
        let is_kept = self.kept.iter().any(|spec| spec.name == "balance");
        if self.parts.stages.has(&BALANCE) && is_kept {
            let balance: Vec<Balance> = self.read("balance")?;
            if let Some(&Balance { light_paths: found @ 1.., .. }) = balance.first() {
                self.light_paths = found.min(self.config.max_light_paths());
            }
        }
        Ok(())
    }

    /// Reads back the layers of the last frame.
    pub fn image(&mut self) -> Result<RenderedImage, SessionError> {
        if self.tiles.is_one() { self.tile_image() } else { Ok(self.tiles.rendered.image.clone()) }
    }

    fn tile_image(&mut self) -> Result<RenderedImage, SessionError> {
        let (width, height) = (self.params.width as usize, self.params.height as usize);
        let pixels = width * height;
        let path = self.read_first("path_radiance", pixels)?;
        let mut auxiliary = Auxiliary::default();
        if self.parts.stages.has(&AUXILIARY_LAYERS) {
            let records: Vec<AuxiliaryRecord> = self.read_first("auxiliary", pixels)?;
            auxiliary = Auxiliary::new(&records, self.origin);
        }
        if !self.config.method.gathers {
            return Ok(RenderedImage { width, height, path, auxiliary, ..RenderedImage::default() });
        }
        let caustics = self.read_first("caustic_radiance", pixels)?;
        let [mut radius, mut depth, mut photons] = [0; 3].map(|_| Vec::with_capacity(pixels));
        self.show("point_geometry", |point: PointGeometry| {
            radius.push(point.radius);
            depth.push(point.depth as f32);
        })?;
        type Sums = [u32; accumulator::WORDS as usize];
        self.show("accumulator", |point: Sums| photons.push(point[accumulator::WORDS as usize - 1] as f32))?;
        for layer in [&mut radius, &mut depth, &mut photons] {
            layer.truncate(pixels);
        }
        Ok(RenderedImage { width, height, path, caustics, radius, depth, photons, auxiliary })
    }

    /// Reads back a buffer by its name in the passes. With several tiles, this is the buffer of the last tile.
    ///
    /// # Errors
    ///
    /// If no pass of the session's frames binds a buffer of this name.
    pub fn read<T: bytemuck::Pod>(&mut self, buffer: &str) -> Result<Vec<T>, SessionError> {
        let mut elements = Vec::new();
        let read = self.runner.show(buffer, &mut |bytes| elements = bytemuck::pod_collect_to_vec(bytes));
        read.map_err(|source| SessionError::Read { buffer: buffer.into(), source })?;
        Ok(elements)
    }

    /// Reads the first `count` elements of a buffer, which has room for the largest tile.
    fn read_first<T: bytemuck::Pod>(&mut self, buffer: &str, count: usize) -> Result<Vec<T>, SessionError> {
        let mut elements = self.read(buffer)?;
        elements.truncate(count);
        Ok(elements)
    }

    /// Passes the elements of a buffer to a function one after another.
    fn show<T: bytemuck::Pod>(&mut self, buffer: &str, mut to: impl FnMut(T)) -> Result<(), SessionError> {
        let each = &mut |bytes: &[u8]| {
            bytes.chunks_exact(size_of::<T>()).for_each(|element| to(bytemuck::pod_read_unaligned(element)));
        };
        let shown = self.runner.show(buffer, each);
        shown.map_err(|source| SessionError::Read { buffer: buffer.into(), source })
    }

    /// Returns the counters of the last frame: rays, photons, and faults such as clamped sums.
    pub fn counters(&mut self) -> Result<Counters, SessionError> {
        if !self.tiles.is_one() {
            return Ok(self.tiles.rendered.counters.clone());
        }
        let words: Vec<u32> = self.read("counters")?;
        Ok(Counters::from_words(&words))
    }

    /// Returns the energy ledger of the last frame's light paths. All zero unless the session's features have
    /// `Features::LEDGER`.
    pub fn energy(&mut self) -> Result<EnergyLedger, SessionError> {
        if !self.tiles.is_one() {
            // Average over the tiles: the light paths of each tile carry all flux of the lights.
            return Ok(self.tiles.rendered.energy.times(1.0 / f64::from(self.tiles.count())));
        }
        let words: Vec<u32> = self.read("counters")?;
        Ok(EnergyLedger::from_words(&words, self.params.quantum))
    }

    /// Sets the exposure of [`Session::display`] (stops).
    pub fn expose(&mut self, stops: f32) {
        self.config.exposure = stops;
        self.params.exposure = stops.exp2();
    }

    /// Tone-maps an image, such as a mean of frames, with the exposure of the settings. Returns display colours in [0, 1],
    /// row by row.
    pub fn display(&mut self, image: &RenderedImage) -> Result<Vec<Vec3>, SessionError> {
        let black = vec![Vec3::ZERO; if image.caustics.is_empty() { image.path.len() } else { 0 }];
        let caustics = if image.caustics.is_empty() { &black } else { &image.caustics };
        let mut colors = Vec::with_capacity(image.path.len());
        for tile in 0..self.tiles.count() {
            let (params, pixels) = (self.tiles.params(tile, self.params), self.tiles.pixels(tile));
            self.runner.write("path_radiance", cast_slice(&image.path[pixels.clone()]))?;
            self.runner.write("caustic_radiance", cast_slice(&caustics[pixels.clone()]))?;
            self.runner.run(&params, &[Step::new(&DISPLAY, &params)])?;
            colors.append(&mut self.read_first("display_color", pixels.len())?);
        }
        Ok(colors)
    }
}
