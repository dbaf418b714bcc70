//! Keys of the radiance cache: in which cell a vertex lies.

use crate::interface::frame::FrameParams;
use crate::interface::material::Material;
use crate::interface::radiance_cache::{CacheCell, CacheKey};
use crate::math::grid::cell;
use spirv_std::glam::Vec3;

/// Edge of a cell, relative to the width of a pixel at its distance from the eye.
pub const CELL_PX: f32 = 48.0;
/// Smallest share of light that a surface in the cache scatters diffusely. A cell holds one radiance for all directions.
const MIN_DIFFUSE: f32 = 0.75;
/// Distance by which a position is moved along its normal (edges of a cell): walls often lie on the border of two cells.
const OFF_BORDERS: f32 = 0.37;

/// Cube of space of a cell: its key, and its edge.
#[derive(Clone, Copy, Debug)]
pub struct Cube {
    /// Key.
    pub key: CacheKey,
    /// Edge (m).
    pub edge: f32,
}

impl Cube {
    /// Number below 2^24, which other cells seldom have.
    #[inline(always)]
    pub fn number(&self) -> u32 {
        hash(&self.key) & 0xff_ffff
    }
}

/// Whether a surface is diffuse enough for the cache.
#[inline(always)]
pub fn is_diffuse(material: &Material) -> bool {
    (1.0 - material.metallic) * (1.0 - material.transmission) >= MIN_DIFFUSE
}

/// Albedo of a surface in the cache, about: a diffuse base below a coat with the mean of Schlick's reflectance over all directions.
#[inline(always)]
pub fn albedo(material: &Material) -> Vec3 {
    let root = (material.ior - 1.0) / (material.ior + 1.0);
    let f0 = (root * root * material.specular).min(1.0);
    let coat = if material.specular > 0.0 { f0 + (1.0 - f0) * (1.0 / 21.0) } else { 0.0 };
    material.base_color * (1.0 - coat) + Vec3::splat(coat)
}

/// Cell of a vertex on a face with this normal, at a depth of its camera path. Its edge is the power of two below [`CELL_PX`] pixels, as
/// wide as a pixel is at the distance of the vertex from the eye.
#[inline(always)]
pub fn cube_around(position: Vec3, normal: Vec3, material: u32, depth: u32, params: &FrameParams) -> Cube {
    let distance = (position - params.camera.position).length();
    let exponent = (CELL_PX * params.pixel_spread * distance).to_bits() >> 23;
    let exponent = exponent.max(1);
    let edge = f32::from_bits(exponent << 23);
    let cell = cell(position + normal * (OFF_BORDERS * edge), edge);
    let key = CacheKey {
        xy: cell.x as u32 & 0xffff | (cell.y as u32) << 16,
        z_edge_side_depth: cell.z as u32 & 0xffff | exponent << 16 | side(normal) << 24 | depth.min(31) << 27,
        material,
    };
    Cube { key, edge }
}

/// Side of a cube that a normal points to most.
#[inline(always)]
fn side(normal: Vec3) -> u32 {
    let size = normal.abs();
    let (mut axis, mut along) = (0, normal.x);
    if size.y > size.x && size.y >= size.z {
        (axis, along) = (1, normal.y);
    } else if size.z > size.x {
        (axis, along) = (2, normal.z);
    }
    2 * axis + u32::from(along < 0.0)
}

/// Index of the cell with a key, or of that which a sample with this key would take. A key has two slots; the second one serves where
/// the first belongs to another key.
#[inline(always)]
pub fn find(key: &CacheKey, cells: &[CacheCell], cell_mask: u32) -> u32 {
    let hash = hash(key);
    let first = hash & cell_mask;
    let cell = &cells[first as usize];
    if cell.count == 0.0 || cell.key == *key { first } else { (hash >> 16 ^ hash << 10) & cell_mask }
}

/// Hash of a key.
#[inline(always)]
fn hash(key: &CacheKey) -> u32 {
    let mut hash = key.xy.wrapping_mul(0x9e37_79b1);
    hash = (hash ^ hash >> 15 ^ key.z_edge_side_depth).wrapping_mul(0x85eb_ca77);
    hash = (hash ^ hash >> 13 ^ key.material).wrapping_mul(0xc2b2_ae3d);
    hash ^ hash >> 16
}

/// Number of cells of the cache minus one (a power of two minus one).
#[inline(always)]
pub fn cell_mask(params: &FrameParams) -> u32 {
    (u32::MAX >> (params.pixel_count() | 4).leading_zeros()) >> 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_tell_positions_sides_depths_and_materials_apart() {
        let params = FrameParams { pixel_spread: 0.16 / CELL_PX, ..FrameParams::default() };
        let at = |x, y, z| cube_around(Vec3::new(x, y, z), Vec3::Y, 0, 2, &params).key;
        let here = Vec3::new(3.0, 0.0, 0.0);
        let Cube { key, edge } = cube_around(here, Vec3::Y, 0, 2, &params);
        assert_eq!(edge, 0.25, "the power of two below 48 pixels of 0.01 m");
        assert_eq!([at(3.1, 1.0e-6, 0.1), at(3.1, -1.0e-6, 0.1)], [key; 2]);
        let others = [
            at(3.3, 0.0, 0.0),
            at(3.0, 0.3, 0.0),
            at(3.0, 0.0, -0.1),
            cube_around(here, Vec3::NEG_Y, 0, 2, &params).key,
            cube_around(here, Vec3::Y, 1, 2, &params).key,
            cube_around(here, Vec3::Y, 0, 3, &params).key,
        ];
        assert!(others.iter().all(|other| *other != key), "{others:?}");
    }

    #[test]
    fn a_key_takes_its_second_slot_where_the_first_is_another_keys() {
        let key = CacheKey { xy: 5, z_edge_side_depth: 6, material: 7 };
        let mut cells = [CacheCell::default(); 64];
        let first = find(&key, &cells, 63);
        cells[first as usize] = CacheCell { key, count: 1.0, ..CacheCell::default() };
        assert_eq!(find(&key, &cells, 63), first);
        cells[first as usize].key.xy = 8;
        let second = find(&key, &cells, 63);
        assert_ne!(second, first);
        cells[first as usize].count = 0.0;
        assert_eq!(find(&key, &cells, 63), first, "the slot of a free cell");
    }

    #[test]
    fn coats_reflect_a_twelfth_of_the_light_and_lambert_surfaces_have_none() {
        let material = Material { base_color: Vec3::new(0.0, 0.5, 1.0), ior: 1.5, ..Material::default() };
        assert_eq!(albedo(&Material { specular: 0.0, ..material }), material.base_color);
        let coated = albedo(&Material { specular: 1.0, ..material });
        assert!((coated - Vec3::new(0.0857, 0.5429, 1.0)).abs().max_element() < 1.0e-4, "{coated}");
    }

    #[test]
    fn sides_are_those_of_the_largest_axis() {
        let normals = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        for (expected, normal) in (0..).zip(normals) {
            assert_eq!(side((normal + Vec3::new(0.1, -0.2, 0.3)).normalize()), expected);
        }
    }
}
