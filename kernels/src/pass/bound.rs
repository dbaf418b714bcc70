//! `bound`: the box around each collection point's disc, for the acceleration structure over points.

use crate::gather::contribution::disc_half_extent;
use crate::interface::point::{PointBox, PointGeometry};

/// The box of one point. Without a point: a box of no size where the
/// camera path ended, never NaN and never far away (drivers answer both badly).
#[inline(always)]
pub fn bound(point: &PointGeometry) -> PointBox {
    if point.depth == 0 {
        return PointBox { min: point.position, max: point.position };
    }
    let half = disc_half_extent(point);
    PointBox { min: point.position - half, max: point.position + half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gather::contribution::takes;
    use crate::interface::point::DepositGeometry;
    use crate::math::rng::{Rng, Stream};
    use crate::math::warp::uniform_sphere;
    use spirv_std::glam::Vec3;

    #[test]
    fn every_deposit_taken_lies_in_the_box() {
        let mut taken = 0;
        for path in 0..400_000 {
            let mut rng = Rng::new(Stream::Camera, 1, path, 0);
            let (a, b, c) = (rng.next4(), rng.next4(), rng.next4());
            let normal = uniform_sphere(a.x, a.y);
            let point = PointGeometry { position: Vec3::new(3.0, -2.0, 1.0), radius: 0.1, normal, depth: 1 };
            // A deposit near the disc's rim whose normal leans by up to 26 degrees.
            let tilt = (normal + uniform_sphere(b.x, b.y) * 0.44).normalize();
            let away = (uniform_sphere(c.x, c.y) * 0.1) * (0.9 + 0.1 * c.z);
            let deposit = DepositGeometry {
                position: point.position + away,
                scatterings: 1,
                normal: tilt,
                instance: 0,
            };
            if takes(&point, &deposit, 5) {
                taken += 1;
                let b = bound(&point);
                assert!(deposit.position.cmpge(b.min).all() && deposit.position.cmple(b.max).all());
            }
        }
        assert!(taken > 10_000, "the test has lost its subject: {taken}");
    }

    #[test]
    fn no_point_makes_a_box_of_no_size() {
        let nowhere = PointGeometry { position: Vec3::ONE, ..Default::default() };
        assert_eq!(bound(&nowhere), PointBox { min: Vec3::ONE, max: Vec3::ONE });
    }
}
