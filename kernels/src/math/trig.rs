//! Sine and cosine from + - * only: Vulkan's own may be off by 2^-11, and decisions must agree on every device.

/// (sin, cos) of 2 pi `turns`, for turns in [0, 1]; absolute error below 3e-7.
#[inline]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    // Reduce to an eighth of a turn around the nearest quarter.
    let quarter = (turns * 4.0 + 0.5) as u32;
    let angle = (turns - quarter as f32 * 0.25) * core::f32::consts::TAU;
    let square = angle * angle;

    // Taylor series: the first term left out is below 1e-9 at pi/4.
    let s = angle
        * (1.0
            + square * (-1.0 / 6.0 + square * (1.0 / 120.0 + square * (-1.0 / 5040.0 + square / 362_880.0))));
    let c = 1.0
        + square
            * (-0.5
                + square
                    * (1.0 / 24.0
                        + square * (-1.0 / 720.0 + square * (1.0 / 40_320.0 - square / 3_628_800.0))));

    // Turn by the quarters taken off.
    let quadrant = quarter & 3;
    if quadrant == 0 {
        (s, c)
    } else if quadrant == 1 {
        (c, -s)
    } else if quadrant == 2 {
        (-s, -c)
    } else {
        (-c, s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_library_in_double_precision() {
        for i in 0..=1_000_000u32 {
            let turns = i as f32 / 1_000_000.0;
            let (s, c) = sin_cos_turns(turns);
            let (exact_s, exact_c) = (f64::from(turns) * std::f64::consts::TAU).sin_cos();
            assert!((f64::from(s) - exact_s).abs() < 3e-7, "sin at {turns}");
            assert!((f64::from(c) - exact_c).abs() < 3e-7, "cos at {turns}");
        }
    }
}
