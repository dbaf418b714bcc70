//! The footprint of a photon [Yang and Ouyang 2021]: the ellipse on its tangent plane over which its flux is spread. It holds the
//! pixels that may see the ellipse.
//!
//! The photon's own part is `SCALE` times its differential, with its anisotropy and its size in the image clamped. The footprint
//! of a pixel is added to it in quadrature, so that no ellipse falls between pixels.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::frame::FrameParams;
use crate::math::PI;
use crate::math::differential::Differential;
use crate::math::frame::ShadingFrame;
use crate::math::is_finite;
use spirv_std::glam::Vec3;

/// Half axes over those of the differential. An ellipse overlaps with about SCALE^2 / 0.61 others, as its kernel weighs them.
const SCALE: f32 = 1.5;
/// Half axes of a pixel's footprint (px).
const PIXEL_HALF_AXIS: f32 = 0.9;
/// Longest half axis over the shortest, of the photon's own part.
const MAX_ANISOTROPY: f32 = 16.0;
/// Largest half size of the photon's own part in the image (px).
const MAX_HALF_SIZE: f32 = 15.0;

/// Symmetric 2 by 2 matrix over the tangents of a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Symmetric {
    xx: f32,
    xy: f32,
    yy: f32,
}

impl Symmetric {
    /// Outer product of a vector with itself.
    #[inline]
    fn square(x: f32, y: f32) -> Self {
        Symmetric { xx: x * x, xy: x * y, yy: y * y }
    }

    #[inline]
    fn plus(self, other: Symmetric) -> Self {
        Symmetric { xx: self.xx + other.xx, xy: self.xy + other.xy, yy: self.yy + other.yy }
    }

    #[inline]
    fn times(self, factor: f32) -> Self {
        Symmetric { xx: self.xx * factor, xy: self.xy * factor, yy: self.yy * factor }
    }

    #[inline]
    fn determinant(self) -> f32 {
        self.xx * self.yy - self.xy * self.xy
    }

    /// Value of the quadratic form.
    #[inline]
    fn form(self, x: f32, y: f32) -> f32 {
        x * x * self.xx + 2.0 * x * y * self.xy + y * y * self.yy
    }

    /// Widens the matrix so that no axis is longer than `max_ratio` times the other.
    #[inline]
    fn rounded(self, max_ratio: f32) -> Self {
        let mean = 0.5 * (self.xx + self.yy);
        let off = (mean * mean - self.determinant()).max(0.0).sqrt();
        let lift = ((mean + off) / (max_ratio * max_ratio) - (mean - off)).max(0.0);
        Symmetric { xx: self.xx + lift, xy: self.xy, yy: self.yy + lift }
    }
}

/// Ellipse of a photon; `area_px` is 0 where no pixel sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// First column of pixels that may see it.
    pub first_column: u32,
    /// Last column.
    pub last_column: u32,
    /// First row.
    pub first_row: u32,
    /// Last row.
    pub last_row: u32,
    /// Area in the image (px), without the part of rough scattering: denser light paths reduce it.
    pub area_px: f32,
    /// Upper bound of the longest half axis (m).
    pub reach: f32,
    /// Tangents of the plane.
    tangent_x: Vec3,
    tangent_y: Vec3,
    /// Squares of the half axes (m^2).
    axes: Symmetric,
    /// 1 / (product of the half axes)^2 (m^-4).
    inverse: f32,
}

impl Footprint {
    /// Footprint of a photon at `position`, on the side of a surface that the unit `normal` points to.
    #[inline(always)]
    pub fn new(position: Vec3, normal: Vec3, differential: &Differential, params: &FrameParams) -> Self {
        let camera = &params.camera;
        let along = position - camera.position;
        let (is_before_eye, on_plane) = camera.on_plane(along);
        if !is_before_eye || along.dot(normal) >= 0.0 {
            return Footprint::default();
        }

        // Linearise the projection: columns and rows of pixels over the tangents
        let (by_column, by_row) = camera.gradients(along, on_plane, params);
        let frame = ShadingFrame::new(normal);
        let (column_x, column_y) = (by_column.dot(frame.x), by_column.dot(frame.y));
        let (row_x, row_y) = (by_row.dot(frame.x), by_row.dot(frame.y));
        let pixels = column_x * row_y - column_y * row_x;
        if pixels == 0.0 {
            return Footprint::default();
        }

        // Compute the photon's own part from its differential.
        let own = |v: Vec3| Symmetric::square(v.dot(frame.x), v.dot(frame.y));
        let mut own = own(differential.position_u).plus(own(differential.position_v)).times(SCALE * SCALE);
        if !is_finite((own.xx + own.yy) * (own.xx + own.yy)) {
            // Replace an overflow of grazing light by a size that is clamped below.
            own = Symmetric { xx: 1.0e15, xy: 0.0, yy: 1.0e15 };
        }
        let own = own.rounded(MAX_ANISOTROPY);
        let rough = differential.rough_width * differential.rough_width;
        let whole = own.plus(Symmetric { xx: rough, xy: 0.0, yy: rough });
        let size = |part: Symmetric| part.form(column_x, column_y).max(part.form(row_x, row_y));
        let clamped =
            |part: Symmetric| part.times((MAX_HALF_SIZE * MAX_HALF_SIZE / size(part).max(1.0e-30)).min(1.0));

        // Add a pixel's part: the inverse of the pixels per metre.
        let half = PIXEL_HALF_AXIS / pixels;
        let pixel = Symmetric::square(row_y * half, -row_x * half)
            .plus(Symmetric::square(-column_y * half, column_x * half));
        let axes = clamped(whole).plus(pixel);
        let alone = clamped(own).plus(pixel).determinant().max(0.0).sqrt();

        // Bound the pixels that may see the ellipse, a tenth wider than to first order, for perspective.
        let (width, height) = (params.width as f32, params.height as f32);
        let position_px = params.raster_position(on_plane);
        let across = axes.form(column_x, column_y).sqrt() * 1.1 + 0.5;
        let down = axes.form(row_x, row_y).sqrt() * 1.1 + 0.5;
        let determinant = axes.determinant();
        let seen = position_px.x + across > 0.0
            && position_px.x - across < width
            && position_px.y + down > 0.0
            && position_px.y - down < height;
        if !seen || determinant <= 0.0 {
            return Footprint::default();
        }
        Footprint {
            first_column: (position_px.x - across).max(0.0) as u32,
            last_column: ((position_px.x + across) as u32).min(params.width - 1),
            first_row: (position_px.y - down).max(0.0) as u32,
            last_row: ((position_px.y + down) as u32).min(params.height - 1),
            area_px: PI * alone * pixels.abs(),
            reach: (axes.xx + axes.yy).sqrt(),
            tangent_x: frame.x,
            tangent_y: frame.y,
            axes,
            inverse: 1.0 / determinant,
        }
    }

    /// Kernel of the footprint: share of the photon's flux at a point `along` from it (m^-2). It is 10 / (3 pi a b) (1 - 3 x^2 +
    /// 2 x^3), with x the distance over the ellipse's own in that direction. Its integral over the plane is 1.
    #[inline]
    pub fn weight(&self, along: Vec3) -> f32 {
        let (x, y) = (along.dot(self.tangent_x), along.dot(self.tangent_y));
        let inverse = Symmetric { xx: self.axes.yy, xy: -self.axes.xy, yy: self.axes.xx };
        let square = inverse.form(x, y) * self.inverse;
        if square >= 1.0 {
            return 0.0;
        }
        let distance = square.max(0.0).sqrt();
        let height = 10.0 / (3.0 * PI) * self.inverse.sqrt();
        height * (1.0 - 3.0 * square + 2.0 * square * distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::frame::{Camera, Window};

    fn params() -> FrameParams {
        let camera = Camera {
            position: Vec3::new(0.0, 2.0, 2.0),
            right: Vec3::X * 0.8,
            up: Vec3::new(0.0, 1.0, -1.0).normalize() * 0.5,
            forward: Vec3::new(0.0, -1.0, -1.0).normalize(),
        };
        FrameParams {
            camera,
            width: 320,
            height: 200,
            window: Window::all(320, 200),
            ..FrameParams::default()
        }
    }

    /// The kernel sums to one over the plane, whatever the ellipse, and lies in the pixels that are visited.
    #[test]
    fn weights_integrate_to_one_within_the_pixels() {
        let params = params();
        for (u, v, rough) in [
            (Vec3::new(0.03, 0.0, 0.01), Vec3::new(-0.01, 0.0, 0.02), 0.0),
            (Vec3::new(0.1, 0.0, 0.0), Vec3::new(0.0, 0.0, 1.0e-4), 0.0),
            (Vec3::ZERO, Vec3::ZERO, 0.0),
            (Vec3::ZERO, Vec3::ZERO, 0.05),
            (Vec3::new(9.0, 0.0, 0.0), Vec3::new(0.0, 0.0, 9.0), 0.0),
        ] {
            let differential =
                Differential { position_u: u, position_v: v, rough_width: rough, ..Differential::default() };
            let position = Vec3::new(0.1, 0.0, -0.2);
            let footprint = Footprint::new(position, Vec3::Y, &differential, &params);
            let (steps, reach) = (600, f64::from(footprint.reach));
            let cell = 2.0 * reach / f64::from(steps);
            let mut sum = 0.0;
            for i in 0..steps * steps {
                let at = |k: i32| ((f64::from(k) + 0.5) * cell - reach) as f32;
                let along = Vec3::new(at(i % steps), 0.0, at(i / steps));
                let weight = footprint.weight(along);
                sum += f64::from(weight) * cell * cell;
                if weight > 0.0 {
                    let d = position + along - params.camera.position;
                    let depth = d.dot(params.camera.forward);
                    let column = (d.dot(params.camera.right) / (0.64 * depth) + 1.0) * 160.0;
                    let row = (1.0 - d.dot(params.camera.up) / (0.25 * depth)) * 100.0;
                    let within = column as u32 >= footprint.first_column
                        && column as u32 <= footprint.last_column
                        && row as u32 >= footprint.first_row
                        && row as u32 <= footprint.last_row;
                    assert!(within, "{column} {row} {footprint:?}");
                }
            }
            // The sum's own error at an ellipse of a sixteenth of the square is 1e-4.
            assert!((sum - 1.0).abs() < 1e-3, "{sum} {footprint:?}");
            assert!(footprint.last_column - footprint.first_column <= 36, "{footprint:?}");
        }
    }

    #[test]
    fn huge_and_nan_differentials_have_the_largest_footprint() {
        let params = params();
        for (u, v) in [(f32::INFINITY, 0.0), (f32::NAN, 1.0), (1.0e15, 1.0e-3), (1.0e6, 1.0e6)] {
            let position_u = Vec3::new(u, 0.0, 0.0);
            let position_v = Vec3::new(0.0, 0.0, v);
            let differential = Differential { position_u, position_v, ..Differential::default() };
            let footprint = Footprint::new(Vec3::ZERO, Vec3::Y, &differential, &params);
            assert!(footprint.weight(Vec3::ZERO) > 0.0 && footprint.area_px < 1000.0, "{u} {footprint:?}");
            assert!(footprint.last_column - footprint.first_column >= 30, "{u} {footprint:?}");
        }
    }

    #[test]
    fn no_footprint_is_smaller_than_a_pixel() {
        let params = params();
        let footprint = Footprint::new(Vec3::ZERO, Vec3::Y, &Differential::default(), &params);
        let pixel = PI * PIXEL_HALF_AXIS * PIXEL_HALF_AXIS;
        assert!((footprint.area_px / pixel - 1.0).abs() < 1e-4, "{}", footprint.area_px);
    }

    #[test]
    fn photons_out_of_view_have_no_footprint() {
        let params = params();
        let at = |position, normal| {
            Footprint::new(position, normal, &Differential::default(), &params).area_px > 0.0
        };
        assert!(at(Vec3::ZERO, Vec3::Y));
        assert!(!at(Vec3::ZERO, Vec3::NEG_Y), "faces away");
        assert!(!at(Vec3::new(0.0, 3.0, 4.0), Vec3::NEG_Y), "behind the eye");
        assert!(!at(Vec3::new(20.0, 0.0, 0.0), Vec3::Y), "beside the image");
    }
}
