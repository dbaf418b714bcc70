//! The Pareto front: points to which no other is better in one coordinate and no worse in the other.

/// Indices of the front's points, ordered by their first coordinate; small is good. Equal points are on it together.
pub fn pareto(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.retain(|&index| points[index].0.is_finite() && points[index].1.is_finite());
    order.sort_by(|&a, &b| {
        let ((ax, ay), (bx, by)) = (points[a], points[b]);
        ax.total_cmp(&bx).then(ay.total_cmp(&by)).then(a.cmp(&b))
    });
    let mut front: Vec<usize> = Vec::new();
    for index in order {
        // A later point has no smaller first coordinate: it must be better than all before in the second, or equal to the
        // last.
        let is_in = front
            .last()
            .is_none_or(|&last| points[index].1 < points[last].1 || points[index] == points[last]);
        if is_in {
            front.push(index);
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_of_known_points_is_known() {
        let points = [(3.0, 3.0), (1.0, 9.0), (2.0, 5.0), (2.0, 6.0), (4.0, 3.0), (5.0, 1.0), (2.0, 5.0)];
        assert_eq!(pareto(&points), [1, 2, 6, 0, 5]);
        assert_eq!(pareto(&[]), [0; 0]);
        assert_eq!(pareto(&[(f64::NAN, 1.0), (1.0, f64::INFINITY), (2.0, 2.0)]), [2]);
    }

    /// Definition of dominance, tested over all pairs.
    fn is_dominated(points: &[(f64, f64)], index: usize) -> bool {
        let (x, y) = points[index];
        points.iter().any(|&(a, b)| a <= x && b <= y && (a < x || b < y))
    }

    #[test]
    fn the_front_holds_exactly_the_undominated_points() {
        // Spread the points over a small grid by a hash, so that ties occur.
        let spread = |seed: u32| f64::from(seed.wrapping_mul(2_654_435_761) >> 16 & 31);
        for case in 0..50 {
            let points: Vec<_> =
                (0..40).map(|i| (spread(case * 97 + i), spread(case * 131 + 7 * i + 3))).collect();
            let mut front = pareto(&points);
            front.sort_unstable();
            let expected: Vec<usize> = (0..40).filter(|&index| !is_dominated(&points, index)).collect();
            assert_eq!(front, expected, "case {case}");
            assert!(front.len() < 40, "nothing is dominated in case {case}: it tests nothing");
        }
    }
}
