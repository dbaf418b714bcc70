//! Media: priorities of overlapping solids, and surfaces that bound no solid. Imports interface.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use caustics_kernels::interface::material::{FLAG_HANGING, FLAG_OPEN_SURFACE, Material};
use caustics_kernels::interface::texture::MaterialTextures;
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use caustics_kernels::surface::media::MAX_MATERIALS;
use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use super::animation::Nodes;
use super::instanced::Instanced;
use super::mesh::Mesh;
use super::priorities::{self, WorldSolid};
use super::solids::Solids;
use super::{Scene, geometry};

/// Maximum number of boxes that are compared; more boxes count as overlapping.
const MAX_BOXES: usize = 4096;
/// Maximum number of triangles in copies of meshes whose instances need several records, in a scene of fewer triangles.
const MAX_COPIED: usize = 1 << 18;

/// The media of a scene.
#[derive(Clone, Debug, Default)]
pub struct Media {
    /// Boxes around connected parts of resting meshes (m).
    boxes: Vec<[Vec3; 2]>,
    /// Number of boxes of moving meshes.
    moving: usize,
    /// Surfaces of the world, then those of each mesh.
    surfaces: Vec<Vec<Surface>>,
    /// The world, then the instances with media.
    holders: Vec<Holder>,
    /// Solids of all holders; all open surfaces of a material count as one.
    world_solids: Vec<WorldSolid>,
    /// Index in `world_solids` of each solid, by holder and surface.
    of_holders: Vec<u32>,
    /// Whether each record's surface is open.
    open: Vec<bool>,
    /// Whether each record's front faces inwards.
    inside_out: Vec<bool>,
    /// Whether some solids share a priority although they need different ones.
    is_coarse: bool,
}

/// Triangles of one medium in a mesh or in the world.
#[derive(Clone, Debug)]
struct Surface {
    material: u32,
    /// Indices of the triangles.
    triangles: Vec<u32>,
    solids: Solids,
}

/// The world or an instance.
#[derive(Clone, Copy, Debug)]
struct Holder {
    /// Index of the instance; `None` for the world.
    instance: Option<usize>,
    /// Index in `Media::surfaces`.
    surfaces: usize,
    /// Index of the first solid in `of_holders`.
    first: usize,
}

impl Media {
    /// Finds the media of these triangles and instances, relative to an origin (m), with the nodes at time 0.
    pub fn for_scene(
        materials: &[Material],
        triangles: &[Triangle],
        surfaces: &[TriangleSurface],
        instanced: &Instanced,
        nodes: &Nodes,
        origin: DVec3,
    ) -> Media {
        let of_triangles = surfaces.iter().map(|surface| surface.material);
        let world = by_medium(materials, triangles.iter().copied().zip(of_triangles), origin);
        let of_mesh = |mesh: &Mesh| by_medium(materials, mesh.own(), mesh.centre);
        let of_meshes = instanced.meshes.iter().map(of_mesh);
        let mut media =
            Media { surfaces: [world].into_iter().chain(of_meshes).collect(), ..Media::default() };
        let mut open = HashMap::new();
        media.hold(None, 0, 1.0, Some(DAffine3::IDENTITY), &mut open);
        for (id, instance) in instanced.instances.iter().enumerate() {
            let to_world = instance.world_transform(nodes);
            // A mesh that is hidden at time 0 gets the size in its own space.
            let scale = to_world.matrix3.determinant().abs();
            let scale = if scale > 0.0 { scale } else { 1.0 };
            let mesh = &instanced.meshes[instance.mesh];
            let moves = instance.node().is_some() || mesh.deformation.is_some();
            let to_world =
                DAffine3::from_translation(-origin) * to_world * DAffine3::from_translation(mesh.centre);
            media.hold(Some(id), instance.mesh + 1, scale, (!moves).then_some(to_world), &mut open);
        }
        media
    }

    /// Adds an instance; its volume is that of the mesh times `scale`. `to_world` is `None` if it moves. `open` maps each
    /// material to its open surface in `world_solids`.
    fn hold(
        &mut self,
        instance: Option<usize>,
        surfaces: usize,
        scale: f64,
        to_world: Option<DAffine3>,
        open: &mut HashMap<u32, u32>,
    ) {
        if self.surfaces[surfaces].is_empty() {
            return;
        }
        self.holders.push(Holder { instance, surfaces, first: self.of_holders.len() });
        for Surface { material, solids, .. } in &self.surfaces[surfaces] {
            match &to_world {
                None => self.moving += solids.boxes.len(),
                Some(to_world) => {
                    self.boxes.extend(solids.boxes.iter().map(|bounds| around(bounds, to_world)));
                }
            }
            for solid in &solids.solids {
                let size = scale * solid.size;
                let fresh = self.world_solids.len() as u32;
                let index = if solid.is_open { *open.entry(*material).or_insert(fresh) } else { fresh };
                self.of_holders.push(index);
                if let Some(there) = self.world_solids.get_mut(index as usize) {
                    there.size = there.size.max(size);
                    continue;
                }
                let bounds =
                    to_world.filter(|_| !solid.is_open).map(|to_world| around(&solid.bounds, &to_world));
                self.world_solids.push(WorldSolid { material: *material, size, bounds });
            }
        }
    }

    /// Makes priorities a strict order: by the file's priority, then the smaller solid, then the later material. If solids of a
    /// material need several priorities, records are appended. Marks open surfaces.
    pub fn rank(
        &mut self,
        materials: &mut Vec<Material>,
        textures: &mut Vec<MaterialTextures>,
        surfaces: &mut [TriangleSurface],
        instanced: &mut Instanced,
    ) {
        materials.iter_mut().zip(0..).for_each(|(material, id)| material.medium = id);
        let (records, levels) = self.records(materials, textures);
        if self.world_solids.iter().zip(&records).any(|(solid, &record)| solid.material != record) {
            self.assign(&records, surfaces, instanced);
        }
        self.mark(&records, materials);

        let world_solids = self.world_solids.iter().zip(&records);
        let world_solids: Vec<_> =
            world_solids.map(|(solid, &material)| WorldSolid { material, ..*solid }).collect();
        let sizes = priorities::sizes(&world_solids, materials.len());
        let mut order = priorities::by_largest(materials, &sizes);
        order.sort_by_key(|&id| (materials[id].priority, levels[id]));
        materials.iter_mut().for_each(|material| material.priority = 0);
        for (rank, &id) in order.iter().enumerate() {
            materials[id].priority = rank as i32;
        }
    }

    /// Returns the record of each solid in the world and the level of each record; appends missing records.
    fn records(
        &mut self,
        materials: &mut Vec<Material>,
        textures: &mut Vec<MaterialTextures>,
    ) -> (Vec<u32>, Vec<u32>) {
        let mut of_solids = priorities::levels(&self.world_solids, materials);
        let with_levels = |of_solids: &[u32]| -> BTreeSet<(u32, u32)> {
            self.world_solids.iter().zip(of_solids).map(|(solid, &level)| (solid.material, level)).collect()
        };
        let mut needed = with_levels(&of_solids);
        if materials.len() + needed.len() > MAX_MATERIALS && of_solids.iter().any(|&level| level > 0) {
            self.is_coarse = true;
            of_solids.fill(0);
            needed = with_levels(&of_solids);
        }
        let mut levels = vec![0; materials.len()];
        let mut of_levels = BTreeMap::new();
        let mut last = None;
        for (material, level) in needed {
            let mut record = material;
            if last == Some(material) {
                record = materials.len() as u32;
                materials.push(materials[material as usize]);
                levels.push(0);
                if let Some(&material_textures) = textures.get(material as usize) {
                    textures.push(material_textures);
                }
            }
            last = Some(material);
            levels[record as usize] = level;
            of_levels.insert((material, level), record);
        }
        let solids = self.world_solids.iter().zip(of_solids);
        (solids.map(|(solid, level)| of_levels[&(solid.material, level)]).collect(), levels)
    }

    /// Assigns triangles the records of their solids. A mesh whose instances need different records is copied.
    fn assign(&mut self, records: &[u32], surfaces: &mut [TriangleSurface], instanced: &mut Instanced) {
        let max_copied = MAX_COPIED.max(surfaces.len() + instanced.triangle_count());
        let mut copied = 0;
        let mut meshes: HashMap<(usize, Vec<u32>), usize> = HashMap::new();
        let mut taken = BTreeSet::new();
        for holder in &self.holders {
            let own = &self.surfaces[holder.surfaces];
            let of_solids: Vec<u32> = self.solids_of(holder).map(|id| records[id]).collect();
            let Some(instance) = holder.instance else {
                set(own, &of_solids, |triangle, record| surfaces[triangle].material = record);
                continue;
            };
            let mesh = holder.surfaces - 1;
            let index = match meshes.get(&(mesh, of_solids.clone())) {
                Some(&index) => index,
                None if taken.insert(mesh) => mesh,
                None if copied + instanced.meshes[mesh].count as usize > max_copied => {
                    self.is_coarse = true;
                    continue;
                }
                None => {
                    copied += instanced.meshes[mesh].count as usize;
                    instanced.meshes.push(instanced.meshes[mesh].clone());
                    instanced.meshes.len() - 1
                }
            };
            instanced.instances[instance].mesh = index;
            let materials = &mut instanced.meshes[index].materials;
            set(own, &of_solids, |triangle, record| materials[triangle] = record);
            meshes.insert((mesh, of_solids), index);
        }
    }

    /// Indices in `world_solids` of a holder's solids.
    fn solids_of(&self, holder: &Holder) -> impl Iterator<Item = usize> + '_ {
        let count: usize = self.surfaces[holder.surfaces].iter().map(|own| own.solids.solids.len()).sum();
        self.of_holders[holder.first..][..count].iter().map(|&index| index as usize)
    }

    /// Marks the records of open surfaces.
    fn mark(&mut self, records: &[u32], materials: &mut [Material]) {
        (self.open, self.inside_out) = (vec![false; materials.len()], vec![false; materials.len()]);
        for holder in &self.holders {
            let mut world_solids = self.solids_of(holder).collect::<Vec<_>>().into_iter();
            for own in &self.surfaces[holder.surfaces] {
                // Volume, and whether it is open, by record.
                let mut of_records: BTreeMap<u32, (f64, bool)> = BTreeMap::new();
                for (solid, id) in own.solids.solids.iter().zip(world_solids.by_ref()) {
                    let (volume, is_open) = of_records.entry(records[id]).or_default();
                    *volume += solid.volume;
                    *is_open |= solid.is_open;
                }
                for (record, (volume, is_open)) in of_records {
                    self.open[record as usize] |= is_open;
                    self.inside_out[record as usize] |= !is_open && volume < 0.0;
                }
            }
        }
        for (id, material) in materials.iter_mut().enumerate() {
            material.flags &= !(FLAG_OPEN_SURFACE | FLAG_HANGING);
            material.flags |= match (self.inside_out[id], self.open[id]) {
                // The space around an inside-out solid is not an inside.
                (true, _) => FLAG_OPEN_SURFACE | FLAG_HANGING,
                (_, true) => FLAG_OPEN_SURFACE,
                _ => 0,
            };
        }
    }

    /// Whether a path can be inside of two solids at once, or of an open surface.
    pub fn are_nested(&self) -> bool {
        let open_surfaces = self.open.iter().chain(&self.inside_out).any(|&is_open_surface| is_open_surface);
        let may_meet = self.moving > 0 && self.moving + self.boxes.len() > 1;
        open_surfaces || may_meet || self.boxes.len() > MAX_BOXES || overlap(&self.boxes)
    }

    /// Warnings about meshes that the user should repair.
    pub fn warnings(&self, scene: &Scene) -> Vec<String> {
        let named = |id: usize, what: &str| {
            let name = scene.material_name(id as u32);
            format!("{}: material {name:?} has a volume, but {what}", scene.name)
        };
        let open = (0..self.open.len()).filter(|&id| self.open[id]).map(|id| {
            let hangs = scene.materials[id].flags & FLAG_HANGING != 0;
            let ends = if hangs {
                "light comes round its border: it is taken to end at the next face"
            } else {
                "what lies behind it is taken to be inside"
            };
            named(id, &format!("its surface is open; {ends}; close the mesh, or set thicknessFactor to 0"))
        });
        let inside_out = (0..self.inside_out.len()).filter(|&id| self.inside_out[id]);
        let turned = inside_out.map(|id| named(id, "its fronts look inwards; turn its faces over"));
        let coarse = self.is_coarse.then(|| {
            let what = "so many solids of different sizes overlap that some share the priority of their material's largest";
            format!("{}: {what}; give such solids materials with an extras.priority", scene.name)
        });
        let mut warnings: Vec<String> = open.chain(turned).chain(coarse).collect();
        // Several records of one material give the same warning.
        warnings.dedup();
        warnings
    }
}

/// Triangles of each medium; `origin` (m) was subtracted from their corners.
fn by_medium(
    materials: &[Material],
    triangles: impl Iterator<Item = (Triangle, u32)>,
    origin: DVec3,
) -> Vec<Surface> {
    let mut all: BTreeMap<u32, (Vec<u32>, Vec<Triangle>)> = BTreeMap::new();
    for (id, (triangle, material)) in triangles.enumerate() {
        if materials[material as usize].is_medium() {
            let (ids, triangles) = all.entry(material).or_default();
            ids.push(id as u32);
            triangles.push(triangle);
        }
    }
    let all: Vec<_> = all.into_iter().collect();
    let surface = |(material, (triangles, own)): (u32, (Vec<u32>, Vec<Triangle>))| {
        let solids = Solids::from_triangles(&own, origin);
        Surface { material, triangles, solids }
    };
    all.into_par_iter().map(surface).collect()
}

/// Calls a function for each triangle of these surfaces, with the record of its solid.
fn set(surfaces: &[Surface], of_solids: &[u32], mut then: impl FnMut(usize, u32)) {
    let mut first = 0;
    for Surface { triangles, solids, .. } in surfaces {
        for (&triangle, &solid) in triangles.iter().zip(&solids.of_triangle) {
            then(triangle as usize, of_solids[first + solid as usize]);
        }
        first += solids.solids.len();
    }
}

/// Box around a transformed box (m).
fn around(bounds: &[Vec3; 2], to_world: &DAffine3) -> [Vec3; 2] {
    let corners = geometry::corners_of_box(bounds.map(|p| p.as_dvec3()));
    geometry::box_around(corners.into_iter().map(|p| to_world.transform_point3(p))).map(|p| p.as_vec3())
}

/// Whether any two boxes overlap.
fn overlap(boxes: &[[Vec3; 2]]) -> bool {
    let meet =
        |[low, high]: &[Vec3; 2], other: &[Vec3; 2]| low.cmple(other[1]).all() && other[0].cmple(*high).all();
    boxes.iter().enumerate().any(|(id, one)| boxes[..id].iter().any(|other| meet(one, other)))
}
