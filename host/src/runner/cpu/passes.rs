//! The passes by name: what each reads and writes, and the kernel it maps over indices.

use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::needs::Needs;
use rayon::prelude::*;

use super::memory::Memory;

mod density;
mod filter;
pub mod gather;
mod history;
mod photons;
mod points;
mod steps;

/// One dispatch.
pub struct Call<'a> {
    /// Buffers.
    pub memory: &'a Memory,
    /// Invocations.
    pub count: u32,
    /// Push constants.
    pub params: &'a FrameParams,
    /// What the scene needs.
    pub needs: Needs,
}

type Pass = fn(&Call<'_>) -> anyhow::Result<()>;

/// The pass of this name.
pub fn find(name: &str) -> Option<Pass> {
    PASSES.iter().find(|(known, _)| *known == name).map(|(_, pass)| *pass)
}

const PASSES: &[(&str, Pass)] = &[
    ("collect", points::collect),
    ("reference", points::reference),
    ("filter.guide", filter::guide),
    ("filter.atrous", filter::atrous),
    ("shoot.store", photons::shoot_store),
    ("splat.kim2019", gather::splat_kim2019),
    ("density.update", density::update),
    ("density.sum", density::sum),
    ("shoot.yang2021", density::shoot_yang2021),
    ("resolve", points::resolve),
    ("display", points::display),
    ("validate", history::validate),
    ("reuse.paper", history::reuse_paper),
    ("reuse.validated", history::reuse_validated),
    ("resolve.history", history::resolve_history),
    ("step.sample", steps::step_sample),
    ("step.hit", steps::step_hit),
    ("step.scatter", steps::step_scatter),
    ("step.emit", steps::step_emit),
];

/// Light paths or elements that a worker takes at a time.
const CHUNK: usize = 512;

/// Borrows the scene's tables under the names that `SceneTables` has.
macro_rules! scene {
    ($call:expr, $scene:ident) => {
        let triangles = $call.memory.read("triangles")?;
        let surfaces = $call.memory.read("surfaces")?;
        let materials = $call.memory.read("materials")?;
        let lights = $call.memory.read("lights")?;
        textures!($call, textures);
        let $scene = caustics_kernels::interface::scene::SceneTables {
            triangles: &triangles,
            surfaces: &surfaces,
            materials: &materials,
            lights: &lights,
            textures,
        };
    };
}

/// Borrows the tables of textures.
macro_rules! textures {
    ($call:expr, $textures:ident) => {
        let rows = $call.memory.read("textures")?;
        let material_textures = $call.memory.read("material_textures")?;
        let texture_coordinates = $call.memory.read("texture_coordinates")?;
        let texels_0 = $call.memory.read("texels_0")?;
        let texels_1 = $call.memory.read("texels_1")?;
        let texels_2 = $call.memory.read("texels_2")?;
        let texels_3 = $call.memory.read("texels_3")?;
        let $textures = caustics_kernels::interface::scene::TextureTables {
            textures: &rows,
            material_textures: &material_textures,
            texture_coordinates: &texture_coordinates,
            texels_0: &texels_0,
            texels_1: &texels_1,
            texels_2: &texels_2,
            texels_3: &texels_3,
        };
    };
}

/// Borrows the software tree and the holes in its triangles.
macro_rules! tracer {
    ($call:expr, $tracer:ident) => {
        let nodes = $call.memory.read("nodes")?;
        let blocks = $call.memory.read("blocks")?;
        let instances = $call.memory.read("instances")?;
        let surfaces = $call.memory.read("surfaces")?;
        let materials = $call.memory.read("materials")?;
        textures!($call, textures);
        let cut_outs = caustics_kernels::texture::cut_out::CutOuts {
            surfaces: &surfaces,
            materials: &materials,
            textures,
            needs: $call.needs,
        };
        let $tracer = caustics_kernels::trace::bvh::BvhTracer {
            nodes: &nodes,
            blocks: &blocks,
            instances: &instances,
            cut_outs,
        };
    };
}

use scene;
use textures;
use tracer;

/// Writes `kernel(index)` into each element of `buffer` below the dispatch's count.
fn map<T: bytemuck::Pod + Send>(
    call: &Call<'_>,
    buffer: &str,
    kernel: impl Fn(u32) -> T + Sync,
) -> anyhow::Result<()> {
    let mut out = call.memory.edit::<T>(buffer)?;
    let out = &mut out[..call.count as usize];
    out.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
        for (offset, out) in out.iter_mut().enumerate() {
            *out = kernel((chunk * CHUNK + offset) as u32);
        }
    });
    Ok(())
}

/// Calls `work` with consecutive ranges of the indices below `count`, in parallel.
fn for_chunks(count: u32, work: impl Fn(std::ops::Range<u32>) + Sync) {
    let chunk = CHUNK as u32;
    (0..count.div_ceil(chunk)).into_par_iter().for_each(|i| work(i * chunk..(i * chunk + chunk).min(count)));
}
