//! Triangles that share a box: clustering them one by one would take quadratic time. Imports obvhs.

use obvhs::aabb::Aabb;
use rayon::prelude::*;

/// Ids of triangles by their boxes. Groups are in the order of their first triangles.
pub struct Groups {
    /// Those of a group beside each other, in rising order.
    ids: Vec<u32>,
    /// Where each group starts among them, and the last one ends.
    starts: Vec<u32>,
}

impl Groups {
    /// Gathers the triangles of each box.
    pub fn of(boxes: &[Aabb]) -> Groups {
        // Equal boxes have equal hashes: sorted, they stand beside each other.
        let hashed = boxes.par_iter().enumerate().map(|(id, bounds)| (hash(bounds), id as u32));
        let mut hashed: Vec<(u64, u32)> = hashed.collect();
        hashed.par_sort_unstable();
        let mut group: Vec<u32> = (0..boxes.len() as u32).collect();
        for run in hashed.chunk_by(|a, b| a.0 == b.0) {
            let (_, first) = run[0];
            for &(_, id) in &run[1..] {
                // A different box of the same hash stays by itself.
                if bits(&boxes[id as usize]) == bits(&boxes[first as usize]) {
                    group[id as usize] = first;
                }
            }
        }
        drop(hashed);

        // From the first triangle of each group to its number, and to places.
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

fn bits(bounds: &Aabb) -> [[u32; 3]; 2] {
    [bounds.min, bounds.max].map(|corner| corner.to_array().map(f32::to_bits))
}

fn hash(bounds: &Aabb) -> u64 {
    let words = bits(bounds).into_iter().flatten();
    words.fold(0, |hash: u64, word| {
        (hash ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    #[test]
    fn triangles_of_a_box_are_together_in_the_order_of_the_first() {
        let of = |size: f32| Aabb { min: Vec3A::ZERO, max: Vec3A::splat(size) };
        let boxes = [3.0, 1.0, 3.0, 2.0, 1.0, 3.0].map(of);
        let groups = Groups::of(&boxes);
        let all: Vec<&[u32]> = (0..groups.count()).map(|group| groups.get(group)).collect();
        assert_eq!(all, [&[0, 2, 5][..], &[1, 4], &[3]]);
        assert_eq!(Groups::of(&[]).count(), 0);
    }
}
