//! Shared indirect light of a collection point. The CPU repeats the frame's search, and lists the samples that it averaged.

use std::collections::HashMap;

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::packed::{MIN_EXPONENT, from_rgbe, rgbe_quantum};
use caustics_kernels::interface::point::{IndirectSample, PointGeometry};
use caustics_kernels::pass::share::{LARGEST, Samples, Taker, cell_mask, diffuse_response, share_radius};
use glam::Vec3;

use super::{SharedLight, SharingPoint, photons};
use crate::session::{Session, SessionError};

impl Session {
    /// Finds the points that gave indirect light to a point of the last frame. `None` if it took none.
    pub(super) fn shared_light(
        &mut self,
        pixel: u32,
        point: &photons::Taker<'_>,
    ) -> Result<Option<SharedLight>, SessionError> {
        let photons::Taker { view, geometry, shading } = point;
        let params = view.params;
        if !params.shares_indirect() {
            return Ok(None);
        }
        let levels = self.read::<u32>("share_levels")?;
        let own = self.read::<IndirectSample>("point_indirect")?[pixel as usize];
        // Frames in which sharing pauses have no levels.
        let largest = levels[LARGEST as usize];
        if !geometry.exists() || own.light[0] == NONE || largest < MIN_EXPONENT {
            return Ok(None);
        }
        let ranges = self.read("share_ranges")?;
        let (points, light) = (self.read("sharing_points")?, self.read("shared_light")?);
        let samples = Samples { levels: &levels, ranges: &ranges, points: &points, light: &light };
        let taker = Taker::new(*geometry, shading, largest);
        let mut entries = Vec::new();
        let search =
            samples.search(&taker, share_radius(&own, params), cell_mask(params), &mut |entry, radius| {
                entries.push((entry as usize, radius));
            });
        if !search.has_mean() {
            return Ok(None);
        }
        let all = self.read::<PointGeometry>("point_geometry")?;
        let bits = |position: Vec3| position.to_array().map(f32::to_bits);
        let pixels: HashMap<[u32; 3], u32> =
            (0..).zip(&all).map(|(pixel, point)| (bits(point.position), pixel)).collect();
        let given = entries.iter().filter(|(_, radius)| *radius == search.radius).map(|&(entry, _)| {
            let (giver, sample) = (&points[entry], &light[entry].sample);
            let pixel = pixels.get(&bits(giver.position)).copied().unwrap_or(NONE);
            SharingPoint {
                pixel: [pixel % params.width, pixel / params.width],
                position: view.file_position(giver.position),
                depth: giver.key & 0xff,
                light: from_rgbe(sample.light[taker.deeper(giver) as usize]).to_array(),
            }
        });
        let mut points: Vec<SharingPoint> = given.collect();
        points.sort_by_key(|point| (point.pixel[1], point.pixel[0]));
        let mean = search.taken.mean(rgbe_quantum(largest));
        let own = from_rgbe(own.light[0]);
        let factor = diffuse_response(shading, view.scene.tables().materials, params, view.features);
        Ok(Some(SharedLight {
            radius: search.radius,
            own: own.to_array(),
            mean: mean.to_array(),
            change: (factor * (mean - own)).to_array(),
            points,
        }))
    }
}
