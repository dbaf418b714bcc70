//! Media: which of them is there where solids overlap, and which surfaces bound no solid. Imports interface.

use caustics_kernels::interface::material::{FLAG_HANGING, FLAG_SHEET, Material};
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use super::animation::Nodes;
use super::instanced::Instanced;
use super::mesh::Mesh;
use super::solids::Solids;
use super::{Scene, geometry};

/// Boxes that are compared with each other, at most; among more, some are taken to overlap.
const MAX_BOXES: usize = 4096;

/// The media of a scene.
#[derive(Clone, Debug, Default)]
pub struct Media {
    /// Boxes around solids (m), of what stands still.
    boxes: Vec<[Vec3; 2]>,
    /// Solids that move.
    moving: usize,
    /// Volume (m^3) of the largest box of each material.
    sizes: Vec<f64>,
    /// Materials whose surface is open.
    open: Vec<bool>,
    /// Materials whose fronts look inwards.
    inside_out: Vec<bool>,
}

impl Media {
    /// The media of these triangles and of instances, around an origin (m), where nodes are as at time 0.
    pub fn of(
        materials: &[Material],
        triangles: &[Triangle],
        surfaces: &[TriangleSurface],
        instanced: &Instanced,
        nodes: &Nodes,
        origin: DVec3,
    ) -> Media {
        let none = vec![false; materials.len()];
        let sizes = vec![0.0; materials.len()];
        let mut media = Media { sizes, open: none.clone(), inside_out: none, ..Media::default() };
        let of_surfaces = surfaces.iter().map(|surface| surface.material);
        let of_media: Vec<_> = by_medium(materials, triangles.iter().copied().zip(of_surfaces)).collect();
        let of_media: Vec<_> = of_media.into_par_iter().map(|(id, own)| (id, Solids::of(&own))).collect();
        for (id, solids) in of_media {
            media.add(id, &solids, 1.0);
            media.boxes.extend(solids.boxes);
        }
        let of_mesh = |mesh: &Mesh| -> Vec<(usize, Solids)> {
            by_medium(materials, mesh.own()).map(|(id, of_medium)| (id, Solids::of(&of_medium))).collect()
        };
        let of_meshes: Vec<_> = instanced.meshes.iter().map(of_mesh).collect();
        for instance in &instanced.instances {
            let Some(solids) = of_meshes.get(instance.mesh).filter(|solids| !solids.is_empty()) else {
                continue;
            };
            let place = instance.place(nodes);
            // A mesh that hides at time 0 is as large as in its own space.
            let scale = place.matrix3.determinant().abs();
            let scale = if scale > 0.0 { scale } else { 1.0 };
            for (id, solids) in solids {
                media.add(*id, solids, scale);
                if instance.node().is_some() || instanced.meshes[instance.mesh].deformation.is_some() {
                    media.moving += solids.boxes.len();
                    continue;
                }
                let centre = instanced.meshes[instance.mesh].centre;
                let place = DAffine3::from_translation(-origin) * place * DAffine3::from_translation(centre);
                media.boxes.extend(solids.boxes.iter().map(|bounds| around(bounds, &place)));
            }
        }
        media
    }

    /// A material's surface in a mesh, whose volume grows by `scale`.
    fn add(&mut self, id: usize, solids: &Solids, scale: f64) {
        self.sizes[id] = self.sizes[id].max(scale * solids.size());
        self.open[id] |= !solids.is_closed;
        self.inside_out[id] |= solids.is_closed && solids.volume < 0.0;
    }

    /// Makes priorities a strict order: by the file's number, then the smaller solid, then the later material. Marks sheets.
    pub fn rank(&self, materials: &mut [Material]) {
        let mut order: Vec<usize> = (0..materials.len()).filter(|&id| materials[id].is_medium()).collect();
        order.sort_by(|&a, &b| {
            let by_number = materials[a].priority.cmp(&materials[b].priority);
            by_number.then(self.sizes[b].total_cmp(&self.sizes[a])).then(a.cmp(&b))
        });
        for (id, material) in materials.iter_mut().enumerate() {
            material.flags &= !(FLAG_SHEET | FLAG_HANGING);
            material.flags |= match (self.inside_out[id], self.open[id]) {
                // What lies around it is no inside.
                (true, _) => FLAG_SHEET | FLAG_HANGING,
                (_, true) => FLAG_SHEET,
                _ => 0,
            };
            material.priority = 0;
        }
        for (rank, &id) in order.iter().enumerate() {
            materials[id].priority = rank as i32;
        }
    }

    /// Whether a path can be inside of two solids at once, or of a sheet.
    pub fn are_nested(&self) -> bool {
        let sheets = self.open.iter().chain(&self.inside_out).any(|&is_sheet| is_sheet);
        let may_meet = self.moving > 0 && self.moving + self.boxes.len() > 1;
        sheets || may_meet || self.boxes.len() > MAX_BOXES || overlap(&self.boxes)
    }

    /// What a person should repair.
    pub fn warnings(&self, scene: &Scene) -> Vec<String> {
        let named = |id: usize, what: &str| {
            format!("{}: material {:?} has a volume, but {what}", scene.name, scene.material_names[id])
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
        open.chain(turned).collect()
    }
}

/// Triangles of each medium that there is.
fn by_medium(
    materials: &[Material],
    triangles: impl Iterator<Item = (Triangle, u32)>,
) -> impl Iterator<Item = (usize, Vec<Triangle>)> {
    let mut all = vec![Vec::new(); materials.len()];
    for (triangle, material) in triangles {
        if materials[material as usize].is_medium() {
            all[material as usize].push(triangle);
        }
    }
    all.into_iter().enumerate().filter(|(_, triangles)| !triangles.is_empty())
}

/// The box around a box that is placed (m).
fn around(bounds: &[Vec3; 2], place: &DAffine3) -> [Vec3; 2] {
    let corners = geometry::corners_of_box(bounds.map(|p| p.as_dvec3()));
    geometry::box_around(corners.into_iter().map(|p| place.transform_point3(p))).map(|p| p.as_vec3())
}

/// Whether two of the boxes meet.
fn overlap(boxes: &[[Vec3; 2]]) -> bool {
    let meet =
        |[low, high]: &[Vec3; 2], other: &[Vec3; 2]| low.cmple(other[1]).all() && other[0].cmple(*high).all();
    boxes.iter().enumerate().any(|(id, one)| boxes[..id].iter().any(|other| meet(one, other)))
}
