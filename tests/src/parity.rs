//! CPU/GPU parity: a CPU runner and a GPU runner over the same tables and buffers.

use bytemuck::{Pod, cast_slice};
use caustics::render_config::RenderConfig;
use caustics::runner::Runner;
use caustics::scene::{self, Scene};
use caustics::session::{self, RunnerChoice};
use caustics_kernels::declare::Pass;
use caustics_kernels::declare::{BufferSpec, Step, buffers};
use caustics_kernels::gather::variant;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::{Dispatch, FrameParams};
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::frame::look_back;
use caustics_kernels::method::{Parts, Stages};
use caustics_kernels::pass::collect::pixel_order;
use caustics_kernels::pass::step::{STEP_EMIT, STEP_HIT, STEP_SAMPLE, STEP_SCATTER};
use caustics_kernels::{denoiser, emission, history};

use crate::gpu::Gpu;

/// Largest number of elements that single steps run over.
pub const STEPS: usize = 200_000;

/// Loads a committed scene by its name.
pub fn load(name: &str) -> Scene {
    let file = scene::resolve(name).expect("the scene is committed");
    Scene::load(&file).expect("the scene is sound")
}

/// Features that any of these scenes needs, and the parts of light that parity tests compare.
pub fn needs<'a>(scenes: impl IntoIterator<Item = &'a Scene>, config: &RenderConfig) -> Features {
    let each = scenes.into_iter().map(|scene| scene.features(config.specular_roughness));
    each.fold(Features::PARTS, |all, needs| all | needs)
}

/// A CPU and a GPU runner with the same tables and buffers.
pub struct RunnerPair {
    /// The CPU.
    pub cpu: Box<dyn Runner>,
    /// The GPU.
    pub gpu: Box<dyn Runner>,
    /// Features of the scene.
    pub features: Features,
    /// Parameters of frame 0.
    pub params: FrameParams,
    frame_buffers: Vec<&'static str>,
}

impl RunnerPair {
    /// Opens both runners for a view of a scene, with the buffers of every variant and of the single steps.
    pub fn open(gpu: &Gpu, hardware: bool, scene: &Scene, config: &RenderConfig) -> RunnerPair {
        RunnerPair::with(gpu, hardware, scene, config, Features::default())
    }

    /// Opens both runners with kernels of more features than the scene needs. A software driver compiles kernels for
    /// ten seconds and keeps them, so that tests of similar scenes request the same ones.
    pub fn with(
        gpu: &Gpu,
        hardware: bool,
        scene: &Scene,
        config: &RenderConfig,
        others: Features,
    ) -> RunnerPair {
        let features = needs([scene], config) | others;
        let params = config.params(scene, &scene.cameras[0], 0);
        // Some emissions aim at casters.
        let params = FrameParams {
            casters: scene.casters(config.specular_roughness, config.passes_thin_walls()),
            ..params
        };
        let frame = frame_buffers(&params);
        let steps = STEP_PASSES.map(|pass| Step::new(pass, &FrameParams::default()));
        let of_steps = buffers(&steps, &FrameParams { light_path_batch: STEPS as u32, ..params });
        let all: Vec<_> = frame.iter().chain(&of_steps).copied().collect();
        let open = |choice: &RunnerChoice| {
            let mut runner = session::open(choice, scene, features, &all).expect("the runner opens");
            let order = pixel_order(params.width, params.height);
            runner.write("pixel_order", cast_slice(&order)).expect("the order fits");
            runner
        };
        RunnerPair {
            cpu: open(&RunnerChoice::Cpu { threads: 0 }),
            gpu: open(&gpu.choice(hardware)),
            features,
            params,
            frame_buffers: frame.iter().map(|spec| spec.name).collect(),
        }
    }

    /// Names of the frame's buffers that these steps bind.
    pub fn bound(&self, steps: &[Step]) -> Vec<&'static str> {
        let bound = buffers(steps, &self.params).into_iter().map(|spec| spec.name);
        bound.filter(|name| self.frame_buffers.contains(name)).collect()
    }

    /// Runs steps of a frame with these parameters on both runners.
    pub fn run(&mut self, params: &FrameParams, steps: &[Step]) {
        self.cpu.run(params, steps).expect("the CPU runs the steps");
        self.gpu.run(params, steps).expect("the GPU runs the steps and the validation layer is silent");
    }

    /// Runs a single step over `count` elements on both runners.
    pub fn step(&mut self, pass: &'static Pass, count: usize) {
        let params = self.params;
        self.run(&params, &[single(pass, count)]);
    }

    /// Runs a single step over `count` elements on the CPU, to produce inputs.
    pub fn step_on_cpu(&mut self, pass: &'static Pass, count: usize) {
        self.cpu.run(&self.params, &[single(pass, count)]).expect("the CPU runs the step");
    }

    /// Writes the head of a buffer on both runners.
    pub fn write<T: Pod>(&mut self, buffer: &str, records: &[T]) {
        self.cpu.write(buffer, cast_slice(records)).expect("the CPU has the buffer");
        self.gpu.write(buffer, cast_slice(records)).expect("the GPU has the buffer");
    }

    /// Reads the first `count` records of a buffer: the CPU's and the GPU's.
    pub fn head<T: Pod>(&mut self, buffer: &str, count: usize) -> (Vec<T>, Vec<T>) {
        let (mut cpu, mut gpu) = self.records(buffer);
        cpu.truncate(count);
        gpu.truncate(count);
        (cpu, gpu)
    }

    /// Reads all records of a buffer: the CPU's and the GPU's.
    pub fn records<T: Pod>(&mut self, buffer: &str) -> (Vec<T>, Vec<T>) {
        (records(&mut *self.cpu, buffer), records(&mut *self.gpu, buffer))
    }

    /// Copies the CPU's contents of all buffers that these steps bind to the GPU.
    pub fn copy_to_gpu(&mut self, steps: &[Step]) {
        for buffer in self.bound(steps) {
            let bytes = self.cpu.read(buffer).expect("the CPU has the buffer");
            self.gpu.write(buffer, &bytes).expect("the GPU has the buffer");
        }
    }
}

/// Reads all records of a runner's buffer.
pub fn records<T: Pod>(runner: &mut dyn Runner, buffer: &str) -> Vec<T> {
    let bytes = runner.read(buffer).unwrap_or_else(|error| panic!("reading {buffer}: {error:#}"));
    bytemuck::pod_collect_to_vec(&bytes)
}

/// A single step over `count` elements.
fn single(pass: &'static Pass, count: usize) -> Step {
    assert!(count <= STEPS);
    Step::dispatch(pass, Dispatch { count: count as u32, ..Dispatch::default() })
}

/// The passes of single steps.
const STEP_PASSES: [&Pass; 4] = [&STEP_SAMPLE, &STEP_HIT, &STEP_SCATTER, &STEP_EMIT];

/// Buffers of every gather, history, denoiser and emission, each in the largest size that any of them requests.
pub fn frame_buffers(params: &FrameParams) -> Vec<BufferSpec> {
    let default = Parts::from(&variant::PHOTONS_GRID);
    let gathers = variant::ALL.iter().map(|gather| Parts { gather, ..default });
    let histories = history::ALL.iter().map(|&history| Parts { history, ..default });
    let denoisers = denoiser::ALL.iter().map(|&denoiser| Parts { denoiser, ..default });
    let emissions = emission::ALL.iter().map(|&emission| Parts { emission, ..default });
    let learning = [Parts { stages: Stages::ALL, ..default }];
    let all = gathers.chain(histories).chain(denoisers).chain(emissions).chain(learning);
    let steps_of = |parts| [look_back(parts, params), BASIC.frame_steps(parts, params)].concat();
    let steps: Vec<Step> = all.flat_map(steps_of).collect();
    buffers(&steps, params)
}
