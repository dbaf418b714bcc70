//! Matching of the photons of two runs as multisets, because their order is free.

use std::collections::HashMap;

use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight};
use glam::{IVec3, Vec3};

/// Geometry and light of a photon.
pub type Photon = (PhotonGeometry, PhotonLight);

/// Pairs of equal photons of two runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Matching {
    /// Pairs of indices, left and right.
    pub pairs: Vec<(usize, usize)>,
    /// Indices of left photons without a partner.
    pub left: Vec<usize>,
    /// Indices of right photons without a partner.
    pub right: Vec<usize>,
}

/// Largest difference of unit directions, and of fluxes relative to the larger, between partners.
const ALIKE: f32 = 1.0e-2;

/// Pairs photons within `reach` (m) of each other that have equal numbers of scatterings and similar light, nearest
/// first.
pub fn pair(left: &[Photon], right: &[Photon], reach: f32) -> Matching {
    let cell = |position: Vec3| (position / reach).floor().as_ivec3();
    let mut cells: HashMap<IVec3, Vec<usize>> = HashMap::new();
    for (index, (geometry, _)) in left.iter().enumerate() {
        cells.entry(cell(geometry.position)).or_default().push(index);
    }

    // List every possible pair, the closest first.
    let mut possible = vec![];
    for (index, photon) in right.iter().enumerate() {
        let centre = cell(photon.0.position);
        for offset in 0..27 {
            let near = centre + IVec3::new(offset % 3 - 1, offset / 3 % 3 - 1, offset / 9 - 1);
            let candidates = cells.get(&near).into_iter().flatten().copied();
            let alike = candidates.filter(|&candidate| is_alike(&left[candidate], photon, reach));
            possible.extend(alike.map(|candidate| (distance(&left[candidate], photon), candidate, index)));
        }
    }
    possible.sort_by(|a, b| a.partial_cmp(b).expect("distances of like photons are numbers"));

    let (mut free_left, mut free_right) = (vec![true; left.len()], vec![true; right.len()]);
    let mut pairs = vec![];
    for (_, l, r) in possible {
        if free_left[l] && free_right[r] {
            (free_left[l], free_right[r]) = (false, false);
            pairs.push((l, r));
        }
    }
    let rest = |free: &[bool]| (0..free.len()).filter(|&index| free[index]).collect();
    Matching { pairs, left: rest(&free_left), right: rest(&free_right) }
}

fn is_alike(a: &Photon, b: &Photon, reach: f32) -> bool {
    // Compare component by component: the largest element of a vector ignores NaN.
    let flux = a.1.flux.max(b.1.flux).max_element();
    a.0.scatterings == b.0.scatterings
        && a.0.position.distance(b.0.position) <= reach
        && a.0.normal.distance(b.0.normal) <= ALIKE
        && a.1.to_light.distance(b.1.to_light) <= ALIKE
        && (a.1.flux - b.1.flux).abs().cmple(Vec3::splat(ALIKE * flux)).all()
}

/// Distance of two photons in position and light: partners at one position may still differ in light.
fn distance(a: &Photon, b: &Photon) -> f32 {
    a.0.position.distance(b.0.position) + a.1.to_light.distance(b.1.to_light)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn photons() -> Vec<Photon> {
        let photon = |i: i32| {
            let position = Vec3::new((i * 37 % 101) as f32, (i * 53 % 97) as f32, 1.0) * 1.0e-2;
            let geometry =
                PhotonGeometry { position, scatterings: i as u32 % 4, normal: Vec3::Z, instance: 0 };
            let light = PhotonLight { to_light: Vec3::Z, flux: Vec3::ONE, ..Default::default() };
            (geometry, light)
        };
        (0..200).map(photon).collect()
    }

    #[test]
    fn photons_in_another_order_and_off_by_ulps_are_paired() {
        let left = photons();
        let mut right: Vec<_> = left.iter().rev().copied().collect();
        right.iter_mut().for_each(|photon| photon.0.position *= 1.000_001);
        let matching = pair(&left, &right, 1.0e-3);
        assert_eq!((matching.pairs.len(), matching.left.len(), matching.right.len()), (200, 0, 0));
        assert!(matching.pairs.iter().all(|&(l, r)| l + r == 199));
    }

    #[test]
    fn detects_a_moved_a_dimmed_and_a_lost_photon() {
        let left = photons();
        let mut right = left.clone();
        right[5].0.position.x += 0.1;
        right[9].1.flux *= 0.9;
        right[11].0.scatterings += 1;
        right.pop();
        let matching = pair(&left, &right, 1.0e-3);
        assert_eq!(matching.left, [5, 9, 11, 199]);
        assert_eq!(matching.right, [5, 9, 11]);
    }

    #[test]
    fn detects_photons_with_nan() {
        let left = photons();
        let mut right = left.clone();
        right[7].1.flux.y = f32::NAN;
        right[8].0.position.z = f32::NAN;
        let matching = pair(&left, &right, 1.0e-3);
        assert_eq!((matching.left, matching.right), (vec![7, 8], vec![7, 8]));
    }
}
