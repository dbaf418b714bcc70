//! Priorities of overlapping solids: among equal priorities of the file, the smaller solid wins. Imports interface.
//!
//! Kernels look priorities up by material. The solids of one material can lie on both sides of another's: a glass marble in water
//! on a glass plate. Such a material gets a record for each *level*. The level of a solid is one above that of every larger solid
//! of another material that it may meet. In most scenes the largest solids order the materials, and one record each suffices.

use caustics_kernels::interface::material::Material;
use glam::Vec3;

/// Maximum number of compared pairs of boxes. Above it, every solid counts as meeting every other.
const MAX_COMPARISONS: usize = 1 << 26;
/// Maximum number of pairs of solids that meet, with the same consequence.
const MAX_MEETINGS: usize = 1 << 22;

/// A solid in the world, as input of the order of priorities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldSolid {
    /// Index of the material.
    pub material: u32,
    /// Volume of the box (m^3).
    pub size: f64,
    /// Box (m); `None` for moving and open solids, which may meet any solid.
    pub bounds: Option<[Vec3; 2]>,
}

/// Volume of the largest solid of each material (m^3).
pub fn sizes(solids: &[WorldSolid], materials: usize) -> Vec<f64> {
    let mut sizes = vec![0.0f64; materials];
    solids.iter().for_each(|solid| {
        sizes[solid.material as usize] = sizes[solid.material as usize].max(solid.size);
    });
    sizes
}

/// Media by ascending priority: by the file's priority, then the smaller largest solid, then the later material.
pub fn by_largest(materials: &[Material], sizes: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..materials.len()).filter(|&id| materials[id].is_medium()).collect();
    order.sort_by(|&a, &b| {
        let by_number = materials[a].priority.cmp(&materials[b].priority);
        by_number.then(sizes[b].total_cmp(&sizes[a])).then(a.cmp(&b))
    });
    order
}

/// Level of each solid. It is 0 for all solids of one priority if their largest solids order the materials.
pub fn levels(solids: &[WorldSolid], materials: &[Material]) -> Vec<u32> {
    let order = by_largest(materials, &sizes(solids, materials.len()));
    let mut ranks = vec![0; materials.len()];
    order.iter().enumerate().for_each(|(rank, &id)| ranks[id] = rank);
    let number = |solid: &WorldSolid| materials[solid.material as usize].priority;

    // Sort by ascending priority, as if each solid had its own.
    let mut sorted: Vec<usize> = (0..solids.len()).collect();
    sorted.sort_by(|&a, &b| {
        let (one, other) = (&solids[a], &solids[b]);
        let by_number = number(one).cmp(&number(other));
        let by_size = other.size.total_cmp(&one.size);
        by_number.then(by_size).then(one.material.cmp(&other.material)).then(a.cmp(&b))
    });
    let mut levels = vec![0; solids.len()];
    for of_number in sorted.chunk_by(|&a, &b| number(&solids[a]) == number(&solids[b])) {
        let own: Vec<WorldSolid> = of_number.iter().map(|&id| solids[id]).collect();
        let (own, disagree) = levels_by_size(&own, &ranks);
        if disagree {
            of_number.iter().zip(own).for_each(|(&id, level)| levels[id] = level);
        }
    }
    levels
}

/// Levels of solids of one priority, the largest first. Also returns whether the order of materials (`ranks`) contradicts them.
fn levels_by_size(solids: &[WorldSolid], ranks: &[usize]) -> (Vec<u32>, bool) {
    let met = meetings(solids);
    let may_meet_all = |solid: &WorldSolid| solid.bounds.is_none() || met.is_none();
    let met = met.as_deref().unwrap_or_default();
    let (mut all, mut endless) = (Highest::default(), Highest::default());
    let (mut levels, mut disagree, mut next) = (Vec::with_capacity(solids.len()), false, 0);
    for (id, solid) in solids.iter().enumerate() {
        let mut larger = if may_meet_all(solid) { all } else { endless };
        while let Some(&[_, other]) = met.get(next).filter(|[smaller, _]| *smaller as usize == id) {
            let material = solids[other as usize].material;
            larger.add(material, levels[other as usize], ranks[material as usize]);
            next += 1;
        }
        let level = larger.beside(solid.material).map_or(0, |level| level + 1);
        let rank = ranks[solid.material as usize];
        disagree |= larger.rank > rank;
        levels.push(level);
        all.add(solid.material, level, rank);
        if may_meet_all(solid) {
            endless.add(solid.material, level, rank);
        }
    }
    (levels, disagree)
}

/// Highest level of a material, and of all other materials, among some solids; and the highest rank.
#[derive(Clone, Copy, Default)]
struct Highest {
    first: Option<(u32, u32)>,
    second: Option<(u32, u32)>,
    rank: usize,
}

impl Highest {
    fn add(&mut self, material: u32, level: u32, rank: usize) {
        self.rank = self.rank.max(rank);
        let new = Some((level, material));
        let is_first = self.first.is_some_and(|(_, first)| first == material);
        if self.first.is_none_or(|(highest, _)| level > highest) {
            if !is_first {
                self.second = self.first;
            }
            self.first = new;
        } else if !is_first && self.second.is_none_or(|(highest, _)| level > highest) {
            self.second = new;
        }
    }

    /// Highest level of another material.
    fn beside(&self, material: u32) -> Option<u32> {
        [self.first, self.second]
            .into_iter()
            .flatten()
            .find(|&(_, other)| other != material)
            .map(|(level, _)| level)
    }
}

/// Pairs of solids of different materials whose boxes meet: the later index, then the earlier, ordered by the later. `None` above
/// the limits. Solids without a box are left out.
fn meetings(solids: &[WorldSolid]) -> Option<Vec<[u32; 2]>> {
    let boxed = solids.iter().enumerate().filter_map(|(id, solid)| Some((id as u32, solid.bounds?)));
    let mut boxed: Vec<(u32, [Vec3; 2])> = boxed.collect();
    boxed.sort_by(|(_, [a, _]), (_, [b, _])| a.x.total_cmp(&b.x));
    let (mut met, mut comparisons) = (Vec::new(), 0);
    for (at, (id, [low, high])) in boxed.iter().enumerate() {
        for (other, [lower, upper]) in &boxed[at + 1..] {
            if lower.x > high.x {
                break;
            }
            comparisons += 1;
            let meet = low.cmple(*upper).all() && lower.cmple(*high).all();
            if meet && solids[*id as usize].material != solids[*other as usize].material {
                met.push([*id.max(other), *id.min(other)]);
            }
            if comparisons > MAX_COMPARISONS || met.len() > MAX_MEETINGS {
                return None;
            }
        }
    }
    met.sort_unstable();
    Some(met)
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: Option<[Vec3; 2]> = Some([Vec3::ZERO, Vec3::ONE]);
    const FAR: Option<[Vec3; 2]> = Some([Vec3::splat(5.0), Vec3::splat(6.0)]);

    fn levels_for(solids: &[(u32, f64, Option<[Vec3; 2]>)], numbers: &[i32]) -> Vec<u32> {
        let solids = solids.iter().map(|&(material, size, bounds)| WorldSolid { material, size, bounds });
        let medium = |&priority: &i32| Material { transmission: 1.0, priority, ..Material::default() };
        levels(&solids.collect::<Vec<_>>(), &numbers.iter().map(medium).collect::<Vec<_>>())
    }

    #[test]
    fn materials_ordered_by_their_largest_solids_have_one_level() {
        assert_eq!(levels_for(&[(0, 8.0, AT), (1, 4.0, AT), (1, 2.0, AT)], &[0, 0]), [0, 0, 0]);
        // Solids that meet no other need no level.
        assert_eq!(levels_for(&[(0, 8.0, FAR), (1, 4.0, AT), (1, 2.0, AT)], &[0, 0]), [0, 0, 0]);
    }

    #[test]
    fn smaller_solid_is_above_the_larger_solids_that_it_meets() {
        assert_eq!(levels_for(&[(0, 8.0, FAR), (1, 4.0, AT), (0, 2.0, AT)], &[0, 0]), [0, 0, 1]);
        assert_eq!(
            levels_for(&[(0, 8.0, AT), (1, 4.0, AT), (0, 2.0, AT), (1, 1.0, AT)], &[0, 0]),
            [0, 1, 2, 3]
        );
        // Many solids of many sizes need no more levels than their nesting depth.
        let jars = (0..100).flat_map(|id| {
            let at = Some([Vec3::splat(2.0 * id as f32), Vec3::splat(2.0 * id as f32 + 1.0)]);
            let size = f64::from(id + 1);
            [(0, size, at), (1, 0.9 * size, at), (0, 0.8 * size, at)]
        });
        let found = levels_for(&jars.collect::<Vec<_>>(), &[0, 0]);
        assert!(found.chunks(3).all(|levels| levels == [0, 1, 2]), "{found:?}");
    }

    #[test]
    fn moving_and_open_solids_may_meet_any_solid() {
        assert_eq!(levels_for(&[(0, 8.0, AT), (1, 4.0, FAR), (0, 2.0, None)], &[0, 0]), [0, 0, 1]);
        assert_eq!(levels_for(&[(0, 8.0, AT), (1, 4.0, None), (0, 2.0, FAR)], &[0, 0]), [0, 1, 2]);
    }

    #[test]
    fn priorities_of_the_file_precede_sizes() {
        assert_eq!(levels_for(&[(0, 8.0, AT), (1, 4.0, AT), (0, 2.0, AT)], &[1, 0]), [0, 0, 0]);
        assert_eq!(levels_for(&[(0, 8.0, AT), (1, 4.0, AT), (0, 2.0, AT)], &[7, 7]), [0, 1, 2]);
        assert_eq!(
            levels_for(&[(0, 8.0, AT), (1, 4.0, AT), (0, 2.0, AT), (2, 1.0, AT)], &[0, 0, 3]),
            [0, 1, 2, 0]
        );
    }

    #[test]
    fn above_the_comparison_limit_every_solid_meets_every_other() {
        let near = (0..4500).map(|id| (1 + id % 2, 4500.0 - f64::from(id), AT));
        let solids: Vec<_> = [(0, 1e4, FAR)].into_iter().chain(near).chain([(0, 0.5, FAR)]).collect();
        assert_eq!(levels_for(&solids, &[0, 0, 0]), (0..4502).collect::<Vec<_>>());
    }
}
