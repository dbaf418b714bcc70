//! Colour spaces of FLIP with white D65 [Andersson 2020, section 4.1].

use std::sync::LazyLock;

use glam::{DMat3, DVec3};

/// Matrix from linear Rec. 709 to XYZ: rational coefficients of the primaries and the white of sRGB, by columns.
const TO_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0),
    DVec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0),
    DVec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
);

static FROM_XYZ: LazyLock<DMat3> = LazyLock::new(|| TO_XYZ.inverse());

/// Returns the XYZ of white.
fn white() -> DVec3 {
    TO_XYZ * DVec3::ONE
}

/// Converts linear colours to opponent colours: achromatic, red-green, blue-yellow (YCxCz).
pub fn to_opponent(linear: DVec3) -> DVec3 {
    let xyz = TO_XYZ * linear / white();
    DVec3::new(116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z))
}

/// Converts opponent colours to linear colours.
pub fn from_opponent(opponent: DVec3) -> DVec3 {
    let y = (opponent.x + 16.0) / 116.0;
    *FROM_XYZ * (DVec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0) * white())
}

/// Converts linear colours to CIE `L*a*b*`. The factor `L* / 100` on `a*` and `b*` models smaller colour differences in the
/// dark (Hunt).
pub fn to_hunt_lab(linear: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let bend = |t: f64| {
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let xyz = TO_XYZ * linear / white();
    let (x, y, z) = (bend(xyz.x), bend(xyz.y), bend(xyz.z));
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    DVec3::new(lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z))
}

/// Returns the distance of two colours: city block in lightness, Euclidean in chroma (HyAB).
pub fn distance(a: DVec3, b: DVec3) -> f64 {
    let difference = a - b;
    difference.x.abs() + difference.y.hypot(difference.z)
}

/// Returns the luminance of a linear colour, relative to white.
pub fn luminance(linear: DVec3) -> f64 {
    linear.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Converts display colours to linear colours: the inverse of sRGB's transfer function.
pub fn from_srgb(display: DVec3) -> DVec3 {
    let decode = |x: f64| if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    DVec3::from_array(display.to_array().map(decode))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spaces_and_their_inverses_agree() {
        for linear in [DVec3::ZERO, DVec3::ONE, DVec3::new(0.9, 0.2, 0.01), DVec3::new(-0.1, 3.0, 0.4)] {
            // Three matrix products have an error of a few ulp.
            assert!((from_opponent(to_opponent(linear)) - linear).abs().max_element() < 1e-14);
        }
        assert!((to_opponent(DVec3::ONE) - DVec3::new(100.0, 0.0, 0.0)).length() < 1e-12);
        assert!((to_hunt_lab(DVec3::ONE) - DVec3::new(100.0, 0.0, 0.0)).length() < 1e-12);
        assert!(to_hunt_lab(DVec3::ZERO).length() < 1e-12);
        // CIE: Y = 0.18 has L* = 49.496.
        assert!((to_hunt_lab(DVec3::splat(0.18)).x - 49.496).abs() < 1e-3);
        assert_eq!(from_srgb(DVec3::ONE), DVec3::ONE);
        // Both pieces of the transfer function meet at 0.04045, which the standard rounds to four digits.
        assert!((from_srgb(DVec3::splat(0.04045)) - from_srgb(DVec3::splat(0.0404501))).length() < 1e-6);
    }
}
