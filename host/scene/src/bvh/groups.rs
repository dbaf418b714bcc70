//! Triangles that share a box. Clustering them one by one would take quadratic time. Imports obvhs.

use std::collections::BTreeMap;

use obvhs::aabb::Aabb;
use rayon::prelude::*;

/// Ids of triangles, grouped by equal boxes. Groups are in the order of their first triangles.
pub struct Groups {
    /// Ids, group after group, ascending within a group.
    ids: Vec<u32>,
    /// First index of each group in `ids`, then the end of the last group.
    starts: Vec<u32>,
}

impl Groups {
    /// Groups the triangles by box.
    pub fn from_boxes(boxes: &[Aabb]) -> Groups {
        // Equal boxes have equal hashes, so sorting puts them side by side.
        let hashed = boxes.par_iter().enumerate().map(|(id, bounds)| (hash(bounds), id as u32));
        let mut hashed: Vec<(u64, u32)> = hashed.collect();
        hashed.par_sort_unstable();
        let mut group: Vec<u32> = (0..boxes.len() as u32).collect();
        for run in hashed.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
            // Different boxes may share a hash: a scene can be crafted so.
            let mut firsts = BTreeMap::new();
            for &(_, id) in run {
                group[id as usize] = *firsts.entry(bits(&boxes[id as usize])).or_insert(id);
            }
        }
        drop(hashed);

        // Number the groups by their first triangles, then sort the ids by group.
        let mut starts = vec![0];
        for id in 0..group.len() {
            group[id] = if group[id] as usize == id {
                starts.push(0);
                starts.len() as u32 - 2
            } else {
                group[group[id] as usize]
            };
            starts[group[id] as usize + 1] += 1;
        }
        for at in 1..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut next = starts.clone();
        let mut ids = vec![0; group.len()];
        for (id, &group) in group.iter().enumerate() {
            ids[next[group as usize] as usize] = id as u32;
            next[group as usize] += 1;
        }
        Groups { ids, starts }
    }

    /// Number of groups.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Triangles of a group.
    pub fn get(&self, group: usize) -> &[u32] {
        &self.ids[self.starts[group] as usize..self.starts[group + 1] as usize]
    }
}

/// The golden ratio in 64 bits.
const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;

fn bits(bounds: &Aabb) -> [[u32; 3]; 2] {
    [bounds.min, bounds.max].map(|corner| corner.to_array().map(f32::to_bits))
}

fn hash(bounds: &Aabb) -> u64 {
    let words = bits(bounds).into_iter().flatten();
    words.fold(0, |hash: u64, word| (hash ^ u64::from(word)).wrapping_mul(FACTOR).rotate_left(29))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    #[test]
    fn triangles_of_equal_boxes_form_groups_in_order_of_the_first() {
        let cube = |size: f32| Aabb { min: Vec3A::ZERO, max: Vec3A::splat(size) };
        let boxes = [3.0, 1.0, 3.0, 2.0, 1.0, 3.0].map(cube);
        let groups = Groups::from_boxes(&boxes);
        let all: Vec<&[u32]> = (0..groups.count()).map(|group| groups.get(group)).collect();
        assert_eq!(all, [&[0, 2, 5][..], &[1, 4], &[3]]);
        assert_eq!(Groups::from_boxes(&[]).count(), 0);
    }

    /// Every step of the hash is invertible: a compensating first word gives the same hash.
    #[test]
    fn boxes_of_one_hash_are_grouped_by_their_bits() {
        let step = |hash: u64, word: u32| (hash ^ u64::from(word)).wrapping_mul(FACTOR).rotate_left(29);
        let mut upper: BTreeMap<u32, (u64, u32)> = BTreeMap::new();
        let mut pairs = (1..1 << 20).filter_map(|index: u32| {
            // Scattered, since multiples of the factor are as far from each other as possible.
            let low = (index ^ index << 13).wrapping_mul(0x2c1b_3c6d);
            let low = low ^ low >> 15;
            let found = (step(step(0, low), 0), low);
            Some((found, upper.insert((found.0 >> 32) as u32, found)?))
        });
        let (one, other) = pairs.next().unwrap();
        let word = 0x3f80_0000;
        // After the third word both boxes have the same state.
        let to_box = |(state, low): (u64, u32)| Aabb {
            min: Vec3A::new(f32::from_bits(low), 0.0, f32::from_bits(word ^ (state ^ one.0) as u32)),
            max: Vec3A::splat(2.0),
        };
        let [a, b] = [to_box(one), to_box(other)];
        assert!(hash(&a) == hash(&b) && bits(&a) != bits(&b));
        let groups = Groups::from_boxes(&[a, b, b, a, b]);
        let all: Vec<&[u32]> = (0..groups.count()).map(|group| groups.get(group)).collect();
        assert_eq!(all, [&[0, 3][..], &[1, 2, 4]]);
    }
}
