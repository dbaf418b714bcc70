//! Pencils: rays beside a camera ray, to first order. They give the image of a point as the eye sees it.
//!
//! A ray that starts at y0 (m) beside the eye, turned by a0 (rad), reaches A y0 + B a0 beside the camera ray. A and B are two by
//! two matrices; their slopes are carried along. The rays from a point reach it with 0. At the eye they turn by a0 = -B^-1 A y0,
//! as from an image of vergence B^-1 A [1/m], which is symmetric.
//!
//! Its principal values are one over the distances of two images. A lens seen straight has one image, and so have plane mirrors
//! (at the path's length). A cylinder has two, and so has a curved mirror seen obliquely. By Coddington, its powers are 2 k / cos
//! in the plane of incidence and 2 k cos across. Without an image the vergence is zero, which is no special case.
//!
//! The steps are Igehy's [Tracing ray differentials, 1999], in axes that turn with the ray.

use crate::interface::packed;
use crate::math::{clamp, is_finite};
use caustics_kernel_macros::shared;
use spirv_std::glam::{Vec2, Vec3};

/// First derivative of a camera ray by its origin or its direction at the eye, in the ray's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayDerivative {
    /// Offset (m), per metre or radian at the eye.
    pub offset: Vec2,
    /// Slope (rad), per metre or radian at the eye.
    pub slope: Vec2,
}

/// Derivatives of a camera ray: four rays beside it, to first order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pencil {
    /// First unit axis across the ray.
    pub x: Vec3,
    /// Second unit axis across the ray.
    pub y: Vec3,
    /// Derivative by the origin at the eye, along x (1/m).
    pub by_origin_x: RayDerivative,
    /// Derivative by the origin at the eye, along y (1/m).
    pub by_origin_y: RayDerivative,
    /// Derivative by the direction at the eye, along x (1/rad).
    pub by_direction_x: RayDerivative,
    /// Derivative by the direction at the eye, along y (1/rad).
    pub by_direction_y: RayDerivative,
    /// Whether anything but plane mirrors has distorted the pencil.
    pub is_distorted: bool,
}

/// Minimum cosine of incidence at which surfaces reflect or refract.
const MIN_COS: f32 = 1.0e-3;
/// Maximum ratio of the distance of an image to the length of the path; the minimum is its inverse.
const MAX_VERGENCE_DISTANCE: f32 = 1.0e6;

/// Unit axes across a direction, the first along the rows of pixels.
#[shared]
pub fn axes(direction: Vec3, right: Vec3) -> (Vec3, Vec3) {
    let x = (right - direction * right.dot(direction)).normalize();
    (x, x.cross(direction))
}

/// Image of a point, as the eye sees it. The vergence is a symmetric matrix over |`distance`|. The trace of the matrix is 2 m,
/// the difference of its diagonal is 2 x, and y is off the diagonal. (x, y) is `astigmatism`, and m is 1 - |(x, y)| with the sign
/// of `distance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualImage {
    /// Distance of the nearer of the two images (m); negative, behind the eye, if their mean vergence is negative.
    pub distance: f32,
    /// Difference of the two images, in the unit disc.
    pub astigmatism: Vec2,
}

impl VirtualImage {
    /// Image of a pencil that nothing distorts: as far away as its path is long (m).
    #[inline(always)]
    pub fn straight(length: f32) -> VirtualImage {
        VirtualImage { distance: length, astigmatism: Vec2::ZERO }
    }
}

impl Pencil {
    /// Pencil at the eye, in the axes of `axes`.
    #[inline]
    pub fn at_eye(direction: Vec3, right: Vec3) -> Self {
        let (x, y) = axes(direction, right);
        let by_origin = |offset: Vec2| RayDerivative { offset, slope: Vec2::ZERO };
        let by_direction = |slope: Vec2| RayDerivative { offset: Vec2::ZERO, slope };
        Pencil {
            x,
            y,
            by_origin_x: by_origin(Vec2::X),
            by_origin_y: by_origin(Vec2::Y),
            by_direction_x: by_direction(Vec2::X),
            by_direction_y: by_direction(Vec2::Y),
            is_distorted: false,
        }
    }

    /// Pencil after `distance` (m).
    #[inline]
    pub fn advance(self, distance: f32) -> Self {
        self.each(|ray| RayDerivative { offset: ray.offset + ray.slope * distance, ..ray })
    }

    /// Steps along a face (m) from a ray to the rays a metre beside it, along both axes. `normal` is the face's.
    #[inline]
    pub fn steps(&self, from: Vec3, normal: Vec3) -> (Vec3, Vec3) {
        let along = from / (-from.dot(normal)).max(MIN_COS);
        (self.x + along * self.x.dot(normal), self.y + along * self.y.dot(normal))
    }

    /// Pencil after a mirror, or a facet that refracts, between the unit directions `from` and `to`. `eta` = index before over
    /// index behind, 1 for mirrors. `change_x` and `change_y` are the changes of the unit normal over the `steps`.
    #[shared]
    pub fn reflect_or_refract(
        self,
        from: Vec3,
        to: Vec3,
        eta: f32,
        is_mirror: bool,
        change_x: Vec3,
        change_y: Vec3,
    ) -> Self {
        // Find the facet that reflects or refracts, also on a rough surface, on the side of arrival.
        let facet = from * eta - to;
        let facet = facet / facet.length().max(1.0e-12);
        let facet = if facet.dot(from) > 0.0 { -facet } else { facet };
        let cos = (-facet.dot(from)).max(MIN_COS);
        let cos_behind = -facet.dot(to);
        // Find the change of the normal as the ray sees it; in the plane of incidence it sees the face foreshortened.
        let (step_x, step_y) = self.steps(from, facet);
        let (xx, yy) = (step_x.dot(change_x), step_y.dot(change_y));
        let xy = 0.5 * (step_x.dot(change_y) + step_y.dot(change_x));
        let power = eta * cos - cos_behind;
        let across = Vec2::new(self.x.dot(facet), self.y.dot(facet));
        let across = across / across.length().max(1.0e-6);
        // Refraction widens the pencil in the plane of incidence, and narrows its slopes by as much.
        let widening = if is_mirror { 1.0 } else { cos_behind.max(MIN_COS) / cos };
        let mut pencil = self.each(|ray| {
            let tilt =
                Vec2::new(xx * ray.offset.x + xy * ray.offset.y, xy * ray.offset.x + yy * ray.offset.y);
            let slope = ray.slope * eta + tilt * power;
            RayDerivative {
                offset: ray.offset + across * (across.dot(ray.offset) * (widening - 1.0)),
                slope: slope + across * (across.dot(slope) * (1.0 / widening - 1.0)),
            }
        });
        let curved = xx != 0.0 || yy != 0.0 || xy != 0.0;
        pencil.is_distorted = self.is_distorted || curved || !is_mirror;
        if is_mirror {
            pencil.x = self.x - facet * (2.0 * self.x.dot(facet));
            pencil.y = self.y - facet * (2.0 * self.y.dot(facet));
            pencil
        } else {
            pencil.turn(from, to)
        }
    }

    /// Turns the axes with the ray, by the smallest angle; offsets and slopes turn with them.
    #[shared]
    pub fn turn(self, from: Vec3, to: Vec3) -> Self {
        let between = (from + to) / (1.0 + from.dot(to)).max(1.0e-6);
        Pencil { x: self.x - between * self.x.dot(to), y: self.y - between * self.y.dot(to), ..self }
    }

    /// Image of the point that the ray has reached after `length` (m), as the eye sees it.
    #[shared]
    pub fn virtual_image(self, length: f32) -> VirtualImage {
        if !self.is_distorted {
            return VirtualImage::straight(length);
        }
        // Compute B^-1 A by Cramer's rule, with the determinant apart: where rays meet again it is zero, and the image is at the
        // eye.
        let (a_x, a_y) = (self.by_origin_x.offset, self.by_origin_y.offset);
        let (b_x, b_y) = (self.by_direction_x.offset, self.by_direction_y.offset);
        let determinant = b_x.perp_dot(b_y);
        let (xx, yy) = (a_x.perp_dot(b_y), b_x.perp_dot(a_y));
        let xy = 0.5 * (a_y.perp_dot(b_y) + b_x.perp_dot(a_x));
        let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
        let mean = 0.5 * sign * (xx + yy);
        let astigmatism = Vec2::new(0.5 * (xx - yy), xy) * sign;
        let largest = mean.abs() + astigmatism.length();
        if !is_finite(determinant.abs() + largest) {
            return VirtualImage::straight(length * MAX_VERGENCE_DISTANCE);
        }
        let largest = largest.max(1.0e-30);
        let (nearest, farthest) = (length / MAX_VERGENCE_DISTANCE, length * MAX_VERGENCE_DISTANCE);
        let distance = clamp(determinant.abs() / largest, nearest, farthest);
        VirtualImage {
            distance: if mean < 0.0 { -distance } else { distance },
            astigmatism: astigmatism / largest,
        }
    }

    #[inline(always)]
    fn each(self, step: impl Fn(RayDerivative) -> RayDerivative) -> Self {
        Pencil {
            by_origin_x: step(self.by_origin_x),
            by_origin_y: step(self.by_origin_y),
            by_direction_x: step(self.by_direction_x),
            by_direction_y: step(self.by_direction_y),
            ..self
        }
    }
}

impl VirtualImage {
    /// Image of a point of this frame, from the two words of its record.
    #[inline]
    pub fn from_packed(distance: f32, astigmatism: u32) -> Self {
        VirtualImage { distance, astigmatism: packed::from_signed_shares(astigmatism) }
    }

    /// Direction to the image from another eye, of any length. `back` (m) leads from there to this frame's eye, whose ray has the
    /// unit `direction`.
    #[inline]
    pub fn from_eye(&self, back: Vec3, direction: Vec3, right: Vec3) -> Vec3 {
        let (x, y) = axes(direction, right);
        let mean = (1.0 - self.astigmatism.length()) / self.distance;
        let scale = 1.0 / self.distance.abs();
        let (p, q) = (self.astigmatism.x * scale, self.astigmatism.y * scale);
        let (along_x, along_y) = (back.dot(x), back.dot(y));
        // Seen from the other eye, a single image lies at direction / mean + back: use that times mean.
        direction + back * mean + x * (p * along_x + q * along_y) + y * (q * along_x - p * along_y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spirv_std::glam::DVec3;

    /// Reflects or refracts at a sphere of signed curvature [1/m], positive where the side met is convex.
    fn met(pencil: Pencil, from: Vec3, normal: Vec3, curvature: f32, eta: Option<f32>) -> (Pencil, Vec3) {
        let cos = -from.dot(normal);
        let to = match eta {
            None => from + normal * (2.0 * cos),
            Some(eta) => from * eta + normal * (eta * cos - (1.0 - eta * eta * (1.0 - cos * cos)).sqrt()),
        };
        let (x, y) = pencil.steps(from, normal);
        let scattered = pencil.reflect_or_refract(
            from,
            to,
            eta.unwrap_or(1.0),
            eta.is_none(),
            x * curvature,
            y * curvature,
        );
        (scattered, to)
    }

    /// Image on the axis of a point `behind` (m) the last of the surfaces: distance to each (m), curvature [1/m], eta.
    fn on_axis(surfaces: &[(f32, f32, Option<f32>)], behind: f32) -> VirtualImage {
        let (mut pencil, mut from) = (Pencil::at_eye(Vec3::NEG_Z, Vec3::X), Vec3::NEG_Z);
        let mut length = behind;
        for &(way, curvature, eta) in surfaces {
            (pencil, from) = met(pencil.advance(way), from, -from, curvature, eta);
            length += way;
        }
        pencil.advance(behind).virtual_image(length)
    }

    fn assert_single(virtual_image: VirtualImage, distance: f32) {
        let off = (virtual_image.distance / distance - 1.0).abs();
        assert!(
            off < 1.0e-5 && virtual_image.astigmatism.length() < 1.0e-5,
            "{virtual_image:?} should be at {distance}"
        );
    }

    #[test]
    fn a_plane_mirror_images_at_the_length_of_the_path() {
        for normal in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.1, -0.9, 0.4).normalize()] {
            let pencil = Pencil::at_eye(Vec3::NEG_Z, Vec3::X).advance(2.0);
            let pencil = met(pencil, Vec3::NEG_Z, normal, 0.0, None).0.advance(1.7);
            // To the bit, and by the rays themselves to a few ulp.
            let length = 2.0 + 1.7;
            assert_eq!(
                pencil.virtual_image(length),
                VirtualImage { distance: length, astigmatism: Vec2::ZERO }
            );
            assert_single(Pencil { is_distorted: true, ..pencil }.virtual_image(length), length);
        }
    }

    #[test]
    fn mirrors_and_lenses_image_by_their_formulas() {
        // 1 / s' = 1 / s + 2 / r: a ball of 0.3 m, 2 m from the eye and from what it shows.
        assert_single(on_axis(&[(2.0, 1.0 / 0.3, None)], 2.0), 2.0 + 1.0 / (0.5 + 2.0 / 0.3));
        // Inside of a sphere of 1 m: a real image between it and the eye, and one behind the eye.
        assert_single(on_axis(&[(2.0, -1.0, None)], 2.0), 2.0 - 1.0 / 1.5);
        assert_single(on_axis(&[(0.2, -1.0, None)], 1.0), 0.2 - 1.0);
        // A slab of 0.3 m of glass looks two thirds as thick.
        let slab = [(1.0, 0.0, Some(1.0 / 1.5)), (0.3, 0.0, Some(1.5))];
        assert_single(on_axis(&slab, 0.5), 1.0 + 0.2 + 0.5);
        // A ball of glass of 0.3 m has the focal length n r / (2 (n - 1)) = 0.45 m, from its centre.
        for (eye, distance) in [(2.0, 0.4), (2.0, 1.0), (0.7, 3.0)] {
            let ball = [(eye - 0.3, 1.0 / 0.3, Some(1.0 / 1.5)), (0.6, -1.0 / 0.3, Some(1.5))];
            assert_single(on_axis(&ball, distance - 0.3), eye + 1.0 / (1.0 / distance - 1.0 / 0.45));
        }
    }

    #[test]
    fn an_image_at_infinity_keeps_the_direction() {
        // A point in the focus of a concave mirror is seen by parallel rays.
        let virtual_image = on_axis(&[(2.0, -1.0, None)], 0.5);
        let turn = virtual_image.from_eye(Vec3::X, Vec3::NEG_Z, Vec3::X) - Vec3::NEG_Z;
        assert!(virtual_image.distance.abs() > 1.0e5 && turn.length() < 1.0e-5, "{virtual_image:?}");
        // An eye whose rays meet again on a point sees the point all over the mirror.
        let virtual_image = on_axis(&[(2.0, -1.0, None)], 2.0 / 3.0);
        assert!(
            virtual_image.distance.abs() < 1.0e-5 && is_finite(virtual_image.astigmatism.element_sum()),
            "{virtual_image:?}"
        );
        // Derivatives that are NaN give no image either.
        let lost = Pencil {
            by_origin_x: RayDerivative { offset: Vec2::splat(f32::NAN), slope: Vec2::ZERO },
            is_distorted: true,
            ..Pencil::at_eye(Vec3::NEG_Z, Vec3::X)
        };
        assert_eq!(
            lost.virtual_image(2.0),
            VirtualImage { distance: 2.0 * MAX_VERGENCE_DISTANCE, astigmatism: Vec2::ZERO }
        );
    }

    /// Coddington: 1 / s' = 1 / s + 2 / (r cos) in the plane of incidence, 1 / s + 2 cos / r across.
    #[test]
    fn a_curved_mirror_seen_obliquely_has_two_images() {
        let (eye, distance, radius, cos) = (1.5f32, 0.8f32, 0.7f32, 0.6f32);
        for turn in [0.0f32, 0.4, 1.3, 2.0] {
            let (sin_turn, cos_turn) = turn.sin_cos();
            let normal = Vec3::new(0.8 * cos_turn, 0.8 * sin_turn, cos);
            let (pencil, _) = met(
                Pencil::at_eye(Vec3::NEG_Z, Vec3::X).advance(eye),
                Vec3::NEG_Z,
                normal,
                1.0 / radius,
                None,
            );
            let virtual_image = pencil.advance(distance).virtual_image(eye + distance);
            let vergence = |power: f32| 1.0 / (eye + 1.0 / (1.0 / distance + power));
            let expected = [vergence(2.0 / (radius * cos)), vergence(2.0 * cos / radius)];
            let incidence = Vec3::new(cos_turn, sin_turn, 0.0);
            for (axis, expected) in [incidence, Vec3::Z.cross(incidence)].into_iter().zip(expected) {
                let turned = virtual_image.from_eye(axis, Vec3::NEG_Z, Vec3::X) - Vec3::NEG_Z;
                assert!((turned - axis * expected).length() < 1.0e-5, "{turned} along {axis}, {expected}");
            }
            // Packed words keep the astigmatism.
            let kept = VirtualImage::from_packed(
                virtual_image.distance,
                packed::to_signed_shares(virtual_image.astigmatism),
            );
            assert!((kept.astigmatism - virtual_image.astigmatism).length() < 1.0e-4);
        }
    }

    /// A sphere that a ray meets at its first or second crossing: a mirror, or glass that refracts by eta.
    struct Ball {
        centre: DVec3,
        radius: f64,
        second: bool,
        eta: Option<f64>,
    }

    impl Ball {
        /// Distance to the sphere (m), unit normal on the side met, direction behind.
        fn meet(&self, origin: DVec3, from: DVec3) -> (f64, DVec3, DVec3) {
            let to_centre = self.centre - origin;
            let nearest = to_centre.dot(from);
            let half = (self.radius * self.radius - (to_centre - from * nearest).length_squared()).sqrt();
            let way = nearest + if self.second { half } else { -half };
            let normal = (from * way - to_centre) / self.radius * if self.second { -1.0 } else { 1.0 };
            let cos = -from.dot(normal);
            let to = match self.eta {
                None => from + normal * (2.0 * cos),
                Some(eta) => from * eta + normal * (eta * cos - (1.0 - eta * eta * (1.0 - cos * cos)).sqrt()),
            };
            (way, normal, to)
        }
    }

    /// Mirror of 0.5 m, 3 m away, with which three of the chains begin.
    fn mirror() -> Ball {
        Ball { centre: DVec3::new(0.1, 0.1, -3.0), radius: 0.5, second: false, eta: None }
    }

    fn glass(centre: DVec3) -> [Ball; 2] {
        [(false, 1.0 / 1.5), (true, 1.5)].map(|(second, eta)| Ball {
            centre,
            radius: 0.6,
            second,
            eta: Some(eta),
        })
    }

    /// Last vertex of a path from `origin`, its direction there, and the length up to it.
    fn trace(chain: &[Ball], mut origin: DVec3, mut from: DVec3) -> (DVec3, DVec3, f64) {
        let mut length = 0.0;
        for ball in chain {
            let (way, _, to) = ball.meet(origin, from);
            (origin, from, length) = (origin + from * way, to, length + way);
        }
        (origin, from, length)
    }

    /// Rays are traced from an eye that moved, through curved mirrors and glass with planes of incidence of their own. In the
    /// direction that the image gives they meet the point again.
    #[test]
    fn an_eye_that_moves_finds_the_point_by_its_virtual_image() {
        let direction = (mirror().centre + DVec3::new(0.17, 0.23, 0.0)).normalize();
        let (at, along, _) = trace(&[mirror()], DVec3::ZERO, direction);
        let [enter, leave] = glass(at + along * 1.5 + DVec3::new(0.2, -0.1, 0.15));
        let [ahead, behind] = glass(direction * 1.5 + DVec3::new(0.1, 0.3, 0.0));
        let centre = at + along * 0.5 + DVec3::new(0.3, 0.2, -0.6);
        let hollow = Ball { centre, radius: 2.5, second: true, eta: None };
        let chains =
            [vec![mirror()], vec![ahead, behind], vec![mirror(), enter, leave], vec![mirror(), hollow]];
        for (index, chain) in chains.iter().enumerate() {
            let (last, end, length) = trace(chain, DVec3::ZERO, direction);
            let point = last + end * 0.9;
            let (mut pencil, mut origin, mut from) =
                (Pencil::at_eye(direction.as_vec3(), Vec3::X), DVec3::ZERO, direction);
            for ball in chain {
                let (way, normal, to) = ball.meet(origin, from);
                let curvature = (if ball.second { -1.0 } else { 1.0 } / ball.radius) as f32;
                let eta = ball.eta.map(|eta| eta as f32);
                pencil = met(pencil.advance(way as f32), from.as_vec3(), normal.as_vec3(), curvature, eta).0;
                (origin, from) = (origin + from * way, to);
            }
            let virtual_image = pencil.advance(0.9).virtual_image(length as f32 + 0.9);

            let (x, y) = axes(direction.as_vec3(), Vec3::X);
            for way in [x, y, (x - y) * 0.7].map(|way| way * 1.0e-4) {
                let miss = |towards: DVec3| {
                    let (last, end, _) = trace(chain, way.as_dvec3(), towards.normalize());
                    (point - last).reject_from(end).length()
                };
                let found = miss(virtual_image.from_eye(-way, direction.as_vec3(), Vec3::X).as_dvec3());
                let by_length = miss(direction * (length + 0.9) - way.as_dvec3());
                // The rest is the square of the eye's motion, and ulps.
                assert!(found < 0.01 * by_length, "chain {index}: {found:.1e} m off, not {by_length:.1e}");
            }
        }
    }
}
