//! A CPU runner and a GPU runner over the same tables and buffers.

use std::collections::BTreeMap;

use bytemuck::{Pod, cast_slice};
use caustics::method::settings::Settings;
use caustics::method::{BufferSpec, Step, basic, filter};
use caustics::runner::Runner;
use caustics::scene::{self, Scene};
use caustics::session::{self, RunnerChoice};
use caustics_kernels::gather::variant;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::needs::Needs;
use caustics_kernels::interface::step::{EmitStep, SampleStep, ScatterIn, ScatterOut};
use caustics_kernels::math::ray::{Hit, Ray};

use crate::gpu::Gpu;

/// Elements that single steps run over, at most.
pub const STEPS: usize = 200_000;

/// A committed scene by its name.
pub fn load(name: &str) -> Scene {
    let file = scene::resolve(name).expect("the scene is committed");
    Scene::load(&file).expect("the scene is sound")
}

/// Two runners that hold the same.
pub struct Twin {
    /// The CPU.
    pub cpu: Box<dyn Runner>,
    /// The GPU.
    pub gpu: Box<dyn Runner>,
    /// What the scene needs.
    pub needs: Needs,
    /// Push constants of frame 0.
    pub params: FrameParams,
    frame_buffers: Vec<&'static str>,
}

impl Twin {
    /// Opens both for a view of a scene, with the buffers of every gather, of the settings' history and of the single
    /// steps.
    pub fn open(gpu: &Gpu, hardware: bool, scene: &Scene, settings: &Settings) -> Twin {
        let needs = scene.needs(settings.specular_roughness);
        let params = settings.params(scene, &scene.cameras[0], 0);
        let mut frame = frame_buffers(&params);
        frame.extend((settings.history.buffers)(&params));
        let all: Vec<_> = frame.iter().chain(&step_buffers()).copied().collect();
        let open = |choice: &RunnerChoice| {
            let mut runner = session::open(choice, scene, needs, &all).expect("the runner opens");
            let order = basic::pixel_order(params.width, params.height);
            runner.write("pixel_order", cast_slice(&order)).expect("the order fits");
            runner
        };
        Twin {
            cpu: open(&RunnerChoice::Cpu { threads: 0 }),
            gpu: open(&gpu.choice(hardware)),
            needs,
            params,
            frame_buffers: frame.iter().map(|spec| spec.name).collect(),
        }
    }

    /// Names of the buffers of a frame.
    pub fn frame_buffers(&self) -> &[&'static str] {
        &self.frame_buffers
    }

    /// Runs steps on both.
    pub fn run(&mut self, steps: &[Step]) {
        self.cpu.run(steps).expect("the CPU runs the steps");
        self.gpu.run(steps).expect("the GPU runs the steps and the validation layer is silent");
    }

    /// Runs a single step over `count` elements on both.
    pub fn step(&mut self, pass: &'static str, count: usize) {
        assert!(count <= STEPS);
        let count = count as u32;
        let params = FrameParams { light_path_batch: count, ..self.params };
        self.run(&[Step::Dispatch { pass, count, params }]);
    }

    /// Runs a single step over `count` elements on the CPU, to make inputs of.
    pub fn step_on_cpu(&mut self, pass: &'static str, count: usize) {
        let count = count as u32;
        let params = FrameParams { light_path_batch: count, ..self.params };
        self.cpu.run(&[Step::Dispatch { pass, count, params }]).expect("the CPU runs the step");
    }

    /// Writes the head of a buffer of both.
    pub fn write<T: Pod>(&mut self, buffer: &str, rows: &[T]) {
        self.cpu.write(buffer, cast_slice(rows)).expect("the CPU has the buffer");
        self.gpu.write(buffer, cast_slice(rows)).expect("the GPU has the buffer");
    }

    /// The first `count` rows of a buffer, the CPU's and the GPU's.
    pub fn head<T: Pod>(&mut self, buffer: &str, count: usize) -> (Vec<T>, Vec<T>) {
        let (mut cpu, mut gpu) = self.rows(buffer);
        cpu.truncate(count);
        gpu.truncate(count);
        (cpu, gpu)
    }

    /// All rows of a buffer, the CPU's and the GPU's.
    pub fn rows<T: Pod>(&mut self, buffer: &str) -> (Vec<T>, Vec<T>) {
        (rows(&mut *self.cpu, buffer), rows(&mut *self.gpu, buffer))
    }

    /// Gives the GPU the CPU's contents of every buffer of the frame.
    pub fn copy_to_gpu(&mut self) {
        for buffer in self.frame_buffers.clone() {
            let bytes = self.cpu.read(buffer).expect("the CPU has the buffer");
            self.gpu.write(buffer, &bytes).expect("the GPU has the buffer");
        }
    }
}

/// All rows of a runner's buffer.
pub fn rows<T: Pod>(runner: &mut dyn Runner, buffer: &str) -> Vec<T> {
    let bytes = runner.read(buffer).unwrap_or_else(|error| panic!("reading {buffer}: {error:#}"));
    bytemuck::pod_collect_to_vec(&bytes)
}

/// The buffers of every gather and filter, each once and as large as any asks for.
pub fn frame_buffers(params: &FrameParams) -> Vec<BufferSpec> {
    let all = variant::ALL.iter().flat_map(|variant| basic::buffers(variant, params));
    let filters = filter::ALL.iter().flat_map(|filter| (filter.buffers)(params));
    let mut largest = BTreeMap::new();
    for spec in all.chain(filters) {
        let bytes = largest.entry(spec.name).or_insert(0);
        *bytes = spec.bytes.max(*bytes);
    }
    largest.into_iter().map(|(name, bytes)| BufferSpec { name, bytes }).collect()
}

/// The buffers of the single steps.
fn step_buffers() -> [BufferSpec; 6] {
    [
        ("samples", size_of::<SampleStep>()),
        ("rays", size_of::<Ray>()),
        ("hits", size_of::<Hit>()),
        ("scatter_in", size_of::<ScatterIn>()),
        ("scatter_out", size_of::<ScatterOut>()),
        ("emit_steps", size_of::<EmitStep>()),
    ]
    .map(|(name, row)| BufferSpec { name, bytes: row * STEPS })
}
