//! Photons in boxes of one size, in an acceleration structure; each point searches it by ray queries.
//!
//! Source: [Evangelou, Papaioannou, Vardis and Vasilakis 2021, Rasterisation-free photon mapping, JCGT 10(1)], where one radius
//! serves all points. Here each point has its own radius, and the boxes fit nine points in ten. Such a point needs one query of
//! almost no length. A larger disc is swept by parallel rays, one box width apart. Each photon belongs to the one ray whose
//! column holds its centre, so the result is exact for every radius.
//!
//! Cost: in every batch, a sort of the photons by Morton codes and a structure over them, whose size the host must wait for. (The
//! sort serves drivers that build BVHs in the order of their input.) A query a point.
//!
//! Limitations: slow for discs far above the common radius, since they take many rays. Where these would be more than there are
//! photons, the point visits all photons. Slow where there are more photons than points.

use crate::gather::Index;
use crate::gather::hash::{RADIUS_BINS, common_cell_size, radius_bin};
use crate::gather::morton_sort;
use crate::gather::points_rt::write_box;
use crate::gather::tables::Build;
use crate::gather::variant::{Over, Side, Stage, Variant, WordCount};
use crate::math::max_abs;
use crate::platform::{Atomics, Words as _};
use spirv_std::glam::Vec3;

/// Gather with an acceleration structure over the photons.
pub struct PhotonsRt;

/// Index of the word of `index_2`, behind the histogram of radii, that holds the bits of a box's width (m).
const WIDTH: u32 = RADIUS_BINS;

impl Index for PhotonsRt {
    const VARIANT: Variant = Variant {
        name: "photons-rt",
        description: "boxes around photons, searched by ray queries from each point",
        cost: "a sort of the photons and a structure over them in every batch; a query a point",
        limitations: "slow where radii are far above the common one, and where photons outnumber points",
        hardware: true,
        frame: &[
            Stage::Clear(2),
            Stage::Run(0, "survey", Over::Pixels),
            Stage::Run(1, "size", Over::Count(1)),
        ],
        batch: &[
            Stage::Clear(1),
            Stage::Run(morton_sort::BOUNDS, "bounds", Over::Photons),
            Stage::Run(morton_sort::COUNT, "count", Over::Photons),
            Stage::Run(morton_sort::SUM, "sum", Over::PhotonSort(1)),
            Stage::Run(morton_sort::SUM_OF_SUMS, "sum", Over::PhotonSort(2)),
            Stage::Run(morton_sort::SCAN, "sum", Over::Count(1)),
            Stage::Run(morton_sort::SPREAD, "sum", Over::PhotonSort(2)),
            Stage::Run(morton_sort::SPREAD_AGAIN, "sum", Over::PhotonSort(1)),
            Stage::Run(morton_sort::FILL, "bound", Over::Photons),
            Stage::Structure(Side::Photons),
        ],
        words: [
            WordCount(6, Over::Photons),
            WordCount(1, Over::PhotonSort(3)),
            WordCount(1, Over::Count(RADIUS_BINS + 1)),
            WordCount::NONE,
        ],
        sorts: true,
        ..Variant::NEW
    };

    #[inline(always)]
    fn build(stage: u32, index: u32, build: &mut Build<'_>) {
        let capacity = build.params.photon_capacity;
        if stage == 0 {
            let point = build.point(index);
            if point.exists() {
                build.index_2.add(radius_bin(point.radius), 1);
            }
        } else if stage == 1 {
            let width = common_cell_size(&build.index_2);
            build.index_2.set(WIDTH, width);
        } else if stage == morton_sort::BOUNDS || stage == morton_sort::COUNT || stage == morton_sort::FILL {
            let photon = build.photon_geometry[index as usize];
            let slot = morton_sort::element(stage, photon.position, capacity, &mut build.index_1);
            if stage == morton_sort::FILL {
                let half = 0.5 * f32::from_bits(build.index_2.get(WIDTH));
                // Inflate the box by the rounding of the box and of the column.
                let slack = (max_abs(photon.position) + half) * (16.0 * f32::EPSILON);
                let half = Vec3::splat(half + slack);
                write_box(&mut build.index_0, slot, photon.position - half, photon.position + half);
                build.sorted_geometry.write(slot, photon);
                build.sorted_light.write(slot, build.photon_light[index as usize]);
            }
        } else {
            morton_sort::counts(stage, index, capacity, &mut build.index_1);
        }
    }
}

#[cfg(feature = "ray-query")]
pub use query::for_each_near;

#[cfg(feature = "ray-query")]
mod query {
    use super::WIDTH;
    use crate::gather::tables::Tables;
    use crate::gather::{Near, Visit};
    use spirv_std::glam::Vec3;
    use spirv_std::ray_query;
    use spirv_std::ray_tracing::{AccelerationStructure, RayFlags, RayQuery};

    /// Visits the photons in the box `near`.
    #[inline(always)]
    pub fn for_each_near<V: Visit>(
        structure: &AccelerationStructure,
        tables: &mut Tables<'_>,
        near: Near,
        visit: &mut V,
    ) {
        let width = f32::from_bits(tables.index_2[WIDTH as usize]);
        let half = near.half_extent;
        if half.max_element() <= 0.5 * width {
            // Query the disc's centre: the box of every photon of the disc holds it.
            column(
                structure,
                tables,
                near.position,
                0.0,
                visit,
                Vec3::splat(-f32::MAX),
                Vec3::splat(f32::MAX),
            );
            return;
        }
        let low = near.position - half;
        let columns_x = (2.0 * half.x / width) as u32 + 1;
        let columns_y = (2.0 * half.y / width) as u32 + 1;
        // Visit all photons where the sweep takes more rays than there are photons
        if columns_x as f32 * columns_y as f32 > tables.photon_count as f32 {
            let mut id = 0;
            while id < tables.photon_count {
                visit.visit(tables, id);
                id += 1;
            }
            return;
        }
        // Sweep the box by parallel rays
        let mut y = 0;
        while y < columns_y {
            let mut x = 0;
            while x < columns_x {
                // Neighbouring columns share their bounds to the bit.
                let corner = low + Vec3::new(x as f32, y as f32, 0.0) * width;
                let next = low + Vec3::new((x + 1) as f32, (y + 1) as f32, 0.0) * width;
                let axis = corner + Vec3::new(0.5 * width, 0.5 * width, 0.0);
                column(structure, tables, axis, 2.0 * half.z, visit, corner, next);
                x += 1;
            }
            y += 1;
        }
    }

    /// Visits the photons whose boxes a ray along z meets and whose centres are in a column.
    #[inline(always)]
    fn column<V: Visit>(
        structure: &AccelerationStructure,
        tables: &mut Tables<'_>,
        origin: Vec3,
        length: f32,
        visit: &mut V,
        corner: Vec3,
        next: Vec3,
    ) {
        ray_query!(let mut query);
        // SAFETY: the query is initialised before it proceeds.
        unsafe {
            query.initialize(structure, RayFlags::NONE, 0xff, origin, 0.0, Vec3::Z, length.max(1.0e-30));
            while query.proceed() {
                let id = query.get_candidate_intersection_primitive_index();
                let position = tables.photon_geometry[id as usize].position;
                let in_x = position.x >= corner.x && position.x < next.x;
                let in_y = position.y >= corner.y && position.y < next.y;
                if in_x && in_y {
                    visit.visit(tables, id);
                }
            }
        }
    }
}
