//! Media: which of them is there where solids overlap, and which surfaces bound no solid. Imports interface.

use caustics_kernels::interface::material::{FLAG_HANGING, FLAG_SHEET, Material};
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::Vec3;

use super::Scene;
use super::motion::Motion;
use super::solids::Solids;

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
    /// The media of these triangles and of what moves; their sizes are those at time 0.
    pub fn of(
        materials: &[Material],
        triangles: &[Triangle],
        surfaces: &[TriangleSurface],
        motion: Option<&Motion>,
    ) -> Media {
        let none = vec![false; materials.len()];
        let sizes = vec![0.0; materials.len()];
        let mut media = Media { sizes, open: none.clone(), inside_out: none, ..Media::default() };
        let of_surfaces = surfaces.iter().map(|surface| surface.material);
        let still = by_medium(materials, triangles.iter().copied().zip(of_surfaces));
        for (id, of_medium) in still {
            let solids = media.add(id, &of_medium, 1.0);
            media.boxes.extend(solids.boxes);
        }
        let places = motion.and_then(|motion| motion.rig.at(0.0).ok());
        for mesh in motion.iter().flat_map(|motion| &motion.meshes) {
            let scale = places.as_ref().map_or(1.0, |at| at[mesh.joint].matrix3.determinant().abs());
            // A mesh that hides at time 0 is as large as in its own space.
            let scale = if scale > 0.0 { scale } else { 1.0 };
            let own = mesh.own_triangles().into_iter().zip(mesh.materials.iter().copied());
            for (id, of_medium) in by_medium(materials, own) {
                media.moving += media.add(id, &of_medium, scale).boxes.len();
            }
        }
        media
    }

    fn add(&mut self, id: usize, triangles: &[Triangle], scale: f64) -> Solids {
        let solids = Solids::of(triangles);
        self.sizes[id] = self.sizes[id].max(scale * solids.size());
        self.open[id] |= !solids.is_closed;
        self.inside_out[id] |= solids.is_closed && solids.volume < 0.0;
        solids
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

/// Whether two of the boxes meet.
fn overlap(boxes: &[[Vec3; 2]]) -> bool {
    let meet =
        |[low, high]: &[Vec3; 2], other: &[Vec3; 2]| low.cmple(other[1]).all() && other[0].cmple(*high).all();
    boxes.iter().enumerate().any(|(id, one)| boxes[..id].iter().any(|other| meet(one, other)))
}
