//! The photons that a collection point took, found by the rule of the gathers alone: whatever variant found them in the frame.

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

/// A photon that the point took.
#[derive(Clone, Copy)]
pub struct GatheredPhoton {
    /// Its light path.
    pub path: u32,
    /// Where it is.
    pub geometry: PhotonGeometry,
    /// Its light.
    pub light: PhotonLight,
    /// f times flux (W/sr).
    value: Vec3,
}

/// A collection point that takes photons.
pub struct Taker<'a> {
    pub view: InspectedFrame<'a>,
    pub geometry: PointGeometry,
    pub shading: PointShading,
}

/// Keeps the photons of a light path that a point takes.
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
    /// The point, if there is one.
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

    /// The photons of these light paths that the point takes, in the order of the paths.
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

    /// Flux that photons bring to the disc (W), and what they give the pixel (W m^-2 sr^-1).
    pub fn sum(&self, found: &[GatheredPhoton]) -> ([f32; 3], [f32; 3]) {
        let params = self.view.params;
        let flux: Vec3 = found.iter().map(GatheredPhoton::flux).sum();
        let add = |sum: GatheredSum, found: &GatheredPhoton| {
            sum.plus(GatheredSum::new(found.value, params.inverse_quantum()))
        };
        let GatheredSum { red, green, blue, .. } = found.iter().fold(GatheredSum::default(), add);
        let value = Vec3::from_array([red, green, blue].map(|sum| sum.to_f32(params.quantum)));
        (flux.to_array(), self.radiance(value).to_array())
    }

    /// A photon, told.
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

    /// What a sum of f times flux (W/sr) gives the pixel (W m^-2 sr^-1).
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

/// At most `max_count` photons, in their order: half of them spread evenly, half by what they give.
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
    // Systematic sampling: the photons whose shares hold one of `max_count` equidistant numbers.
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
    fn deposits_are_chosen_all_over_and_the_brightest_for_sure() {
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
        // Black ones are spread evenly, too.
        let black: Vec<GatheredPhoton> = (0..1001).map(|path| found(path, 0.0)).collect();
        assert_eq!(paths(&black, 4), [125, 375, 625, 875]);
        // One that gives as much as all others holds a quarter of the numbers and more.
        let mut bright = even.clone();
        bright[700] = found(700, 1000.0);
        let chosen = paths(&bright, 8);
        assert!(chosen.contains(&700) && chosen.len() >= 5, "{chosen:?}");
    }
}
