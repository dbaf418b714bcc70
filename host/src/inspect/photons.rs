//! Photons of a collection point. They are found by the common rule of all gathers, not by the frame's gather variant.

use std::ops::Range;

use caustics_kernels::gather::accumulator::GatheredSum;
use caustics_kernels::gather::contribution::{contribution, takes};
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight, PointGeometry, PointShading};
use caustics_kernels::light::emit::Emit;
use caustics_kernels::pass::resolve::estimate_radiance;
use caustics_kernels::pass::shoot::shoot;
use caustics_kernels::path::photon_sink::PhotonSink;
use caustics_kernels::platform::Uncounted;
use caustics_kernels::surface::textured::material_of;
use glam::Vec3;
use rayon::prelude::*;

use super::view::InspectedFrame;
use super::{Photon, Point};

/// Photon on the disc of the point.
#[derive(Clone, Copy)]
pub struct GatheredPhoton {
    /// Index of its light path.
    pub path: u32,
    /// Its geometry.
    pub geometry: PhotonGeometry,
    /// Its flux and direction.
    pub light: PhotonLight,
    /// f times flux (W/sr).
    value: Vec3,
}

/// Collection point that gathers photons.
pub struct Taker<'a> {
    pub view: InspectedFrame<'a>,
    pub geometry: PointGeometry,
    pub shading: PointShading,
}

/// Photon sink that keeps the photons of a light path on a point's disc.
struct Keep<'a> {
    point: &'a PointGeometry,
    max_bounces: u32,
    kept: Vec<(PhotonGeometry, PhotonLight)>,
}

impl PhotonSink for Keep<'_> {
    type PathState = ();

    fn store_photon(&mut self, (): &mut (), geometry: PhotonGeometry, light: PhotonLight) {
        if takes(self.point, &geometry, self.max_bounces) {
            self.kept.push((geometry, light));
        }
    }
}

impl Taker<'_> {
    /// Describes the collection point; `None` if the pixel has none.
    pub fn point(&self) -> Option<Point> {
        let Taker { view, geometry, shading } = self;
        geometry.exists().then(|| Point {
            position: view.file_position(geometry.position),
            normal: geometry.normal.to_array(),
            shading_normal: shading.shading_normal.to_array(),
            to_viewer: shading.to_viewer.to_array(),
            radius: geometry.radius,
            depth: geometry.depth,
            throughput: shading.throughput.to_array(),
        })
    }

    /// Returns the point's photons of these light paths, in the order of the paths.
    pub fn find(&self, paths: Range<u32>, emit: &(dyn Emit + Sync)) -> Vec<GatheredPhoton> {
        let InspectedFrame { scene, params, features } = self.view;
        let (tables, tracer) = (scene.tables(), scene.tracer(features));
        let material = material_of(&self.shading, tables.materials, features);
        let found = |path, (geometry, light)| {
            let value = contribution(&self.shading, material, &light, params.specular_roughness, features);
            GatheredPhoton { path, geometry, light, value }
        };
        let of_path = |path| {
            let mut keep = Keep { point: &self.geometry, max_bounces: params.max_bounces, kept: Vec::new() };
            shoot(path, params, features, tables, &emit, &mut tracer.clone(), &mut keep, &mut Uncounted);
            keep.kept.into_iter().map(move |photon| found(path, photon))
        };
        paths.into_par_iter().flat_map_iter(of_path).collect()
    }

    /// Returns the flux on the disc (W) and the radiance of the pixel (W m^-2 sr^-1).
    pub fn sum(&self, found: &[GatheredPhoton]) -> ([f32; 3], [f32; 3]) {
        let params = self.view.params;
        let flux: Vec3 = found.iter().map(GatheredPhoton::flux).sum();
        let add = |sum: GatheredSum, found: &GatheredPhoton| {
            let (photon, point) = (found.geometry.position, self.geometry.position);
            sum.plus(GatheredSum::new(found.value, params.inverse_quantum(), photon, point))
        };
        let GatheredSum { red, green, blue, .. } = found.iter().fold(GatheredSum::default(), add);
        let value = Vec3::from_array([red, green, blue].map(|sum| sum.to_f32(params.quantum)));
        (flux.to_array(), self.radiance(value).to_array())
    }

    /// Describes a photon.
    pub fn describe(&self, found: &GatheredPhoton) -> Photon {
        Photon {
            path: found.path,
            position: self.view.file_position(found.geometry.position),
            to_light: found.light.to_light.to_array(),
            scatterings: found.geometry.scatterings,
            flux: found.flux().to_array(),
            radiance: self.radiance(found.value).to_array(),
        }
    }

    /// Converts a sum of f times flux (W/sr) to the radiance of the pixel (W m^-2 sr^-1).
    fn radiance(&self, value: Vec3) -> Vec3 {
        if self.geometry.exists() {
            estimate_radiance(&self.geometry, &self.shading, value)
        } else {
            Vec3::ZERO
        }
    }
}

impl GatheredPhoton {
    /// Flux that arrives (W).
    fn flux(&self) -> Vec3 {
        self.light.flux * self.light.to_light.dot(self.geometry.normal)
    }
}

/// Selects at most `max_count` photons in their order. Half of the probability is uniform, half is proportional to their
/// contribution.
pub fn choose(found: &[GatheredPhoton], max_count: usize) -> Vec<GatheredPhoton> {
    if found.len() <= max_count {
        return found.to_vec();
    }
    let gives = |found: &GatheredPhoton| f64::from(found.value.element_sum());
    let total: f64 = found.iter().map(gives).filter(|gives| gives.is_finite()).sum();
    let share = |photon: &GatheredPhoton| {
        let (share, even) = (gives(photon) / total, 1.0 / found.len() as f64);
        0.5 * (even + if share.is_finite() { share } else { even })
    };
    // Systematic sampling: select the photons whose shares contain one of `max_count` equidistant numbers.
    let mut below = 0.0;
    let number = |below: f64| (below * max_count as f64 + 0.5).floor();
    let is_chosen = |photon: &&GatheredPhoton| {
        let before = below;
        below += share(photon);
        number(below) > number(before)
    };
    found.iter().filter(is_chosen).take(max_count).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selected_photons_are_spread_evenly_and_include_the_brightest() {
        let found = |path: u32, value: f32| GatheredPhoton {
            path,
            geometry: PhotonGeometry::default(),
            light: PhotonLight::default(),
            value: Vec3::splat(value),
        };
        let even: Vec<GatheredPhoton> = (0..1001).map(|path| found(path, 1.0)).collect();
        let paths = |found: &[GatheredPhoton], max_count| {
            choose(found, max_count).iter().map(|found| found.path).collect::<Vec<_>>()
        };
        assert_eq!(paths(&even, 4), [125, 375, 625, 875]);
        assert_eq!(paths(&even[..3], 4), [0, 1, 2]);
        assert_eq!(paths(&even, 0), [0; 0]);
        // Black photons are spread evenly.
        let black: Vec<GatheredPhoton> = (0..1001).map(|path| found(path, 0.0)).collect();
        assert_eq!(paths(&black, 4), [125, 375, 625, 875]);
        // A photon that gives as much as all others has a quarter of the shares or more.
        let mut bright = even.clone();
        bright[700] = found(700, 1000.0);
        let chosen = paths(&bright, 8);
        assert!(chosen.contains(&700) && chosen.len() >= 5, "{chosen:?}");
    }
}
