//! Sine and cosine from + - * only: Vulkan's own may be off by 2^-11, and decisions must agree on every device.

use caustics_kernel_macros::shared;

/// (sin, cos) of 2 pi `turns`, for turns in [0, 1]; absolute error below 3e-7.
#[shared]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    // Reduce to an eighth of a turn around the nearest quarter.
    let quarter = (turns * 4.0 + 0.5) as u32;
    let angle = (turns - quarter as f32 * 0.25) * core::f32::consts::TAU;
    let square = angle * angle;

    // Taylor series: the first term left out is below 1e-9 at pi/4.
    let s = angle
        * (1.0
            + square
                * (-1.0 / 6.0
                    + square * (1.0 / 120.0 + square * (-1.0 / 5040.0 + square * (1.0 / 362_880.0)))));
    let c = 1.0
        + square
            * (-0.5
                + square
                    * (1.0 / 24.0
                        + square
                            * (-1.0 / 720.0 + square * (1.0 / 40_320.0 - square * (1.0 / 3_628_800.0)))));

    // Turn by the quarters taken off: (s, c), (c, -s), (-s, -c), (-c, s). Use bits, since no branch would be predictable.
    let (s, c) = (s.to_bits(), c.to_bits());
    let exchanged = (s ^ c) & (quarter & 1).wrapping_neg();
    let sin_sign = (quarter >> 1 & 1) << 31;
    let cos_sign = ((quarter + 1) >> 1 & 1) << 31;
    (f32::from_bits(s ^ exchanged ^ sin_sign), f32::from_bits(c ^ exchanged ^ cos_sign))
}

/// Share of a turn, in [0, 1), from the first axis to (x, y); 0 at the origin. Absolute error below 1e-7 [Abramowitz and Stegun
/// 1964, 4.4.49].
#[shared]
pub fn turns(y: f32, x: f32) -> f32 {
    let (low, high) = (x.abs().min(y.abs()), x.abs().max(y.abs()));
    if high == 0.0 {
        return 0.0;
    }
    let slope = low / high;
    let square = slope * slope;
    let series = -0.075_289_64 + square * (0.042_909_61 + square * (-0.016_165_74 + square * 0.002_866_226));
    let series = -0.142_089 + square * (0.106_562_64 + square * series);
    let series = 1.0 + square * (-0.333_331_45 + square * (0.199_935_5 + square * series));
    let mut turn = slope * series * (0.5 * core::f32::consts::FRAC_1_PI);
    if y.abs() > x.abs() {
        turn = 0.25 - turn;
    }
    if x < 0.0 {
        turn = 0.5 - turn;
    }
    if y < 0.0 {
        turn = 1.0 - turn;
    }
    if turn < 1.0 { turn } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_inverts_sine_and_cosine() {
        for i in 0..1_000_000u32 {
            let exact = f64::from(i) / 1_000_000.0;
            let (y, x) = (exact * std::f64::consts::TAU).sin_cos();
            let found = f64::from(turns((3.0 * y) as f32, (3.0 * x) as f32));
            let off = (found - exact).abs();
            assert!((0.0..1.0).contains(&found) && off.min(1.0 - off) < 1e-7, "{exact} {found}");
        }
        assert_eq!((turns(0.0, 0.0), turns(-1e-30, 1.0), turns(0.0, -1.0)), (0.0, 0.0, 0.5));
    }

    #[test]
    fn sin_cos_turns_matches_double_precision() {
        for i in 0..=1_000_000u32 {
            let turns = i as f32 / 1_000_000.0;
            let (s, c) = sin_cos_turns(turns);
            let (exact_s, exact_c) = (f64::from(turns) * std::f64::consts::TAU).sin_cos();
            assert!((f64::from(s) - exact_s).abs() < 3e-7, "sin at {turns}");
            assert!((f64::from(c) - exact_c).abs() < 3e-7, "cos at {turns}");
        }
    }
}
