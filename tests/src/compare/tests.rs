use super::*;
use caustics_kernels::interface::ray::Hit;

const LOOSE: Tolerance = Tolerance::relative(1.0e-4, 0.0, "ulps of a division");

fn hits() -> Vec<Hit> {
    (0..100).map(|i| Hit { distance: i as f32 + 1.0, triangle: i, u: 0.25, v: 0.5, instance: 0 }).collect()
}

fn compare_hits(right: &[Hit]) -> Vec<Difference> {
    records(&hits(), right, Tolerance::EXACT, |_| LOOSE)
}

#[test]
fn equal_records_pass() {
    let differences = compare_hits(&hits());
    assert_eq!(differences.len(), 5);
    assert!(differences.iter().all(|d| d.passes() && d.exceeding == 0 && d.count == 100 && d.max_abs == 0.0));
}

#[test]
fn differences_of_1e_5_pass_and_of_1e_3_fail() {
    let image: Vec<f32> = (1..=300).map(|i| i as f32).collect();
    let scaled = |factor: f32| image.iter().map(|value| value * factor).collect::<Vec<_>>();
    assert!(floats("image", 3, &image, &scaled(1.000_01), LOOSE).passes());
    let far = floats("image", 3, &image, &scaled(1.001), LOOSE);
    assert!(!far.passes());
    assert_eq!(far.exceeding, 100);
}

#[test]
fn detects_one_flipped_pixel() {
    let image = vec![0.5f32; 3 * 64];
    let mut flipped = image.clone();
    flipped[3 * 17 + 1] = 0.6;
    let difference = floats("image", 3, &image, &flipped, LOOSE);
    assert!(!difference.passes());
    assert_eq!((difference.exceeding, difference.first), (1, Some(17)));
    assert!((difference.max_abs - 0.1).abs() < 1.0e-6);
    assert_eq!(difference.indices, [17]);
}

#[test]
fn detects_a_swapped_id() {
    let mut swapped = hits();
    (swapped[3].triangle, swapped[4].triangle) = (4, 3);
    let differences = compare_hits(&swapped);
    let failed: Vec<_> = differences.iter().filter(|d| !d.passes()).collect();
    assert_eq!(failed.len(), 1);
    assert_eq!((failed[0].name.as_str(), failed[0].exceeding, failed[0].first), ("triangle", 2, Some(3)));
}

#[test]
fn detects_nan_in_either_or_both_slices() {
    let (number, nan) = ([1.0f32, 2.0], [1.0f32, f32::NAN]);
    let lenient = Tolerance { absolute: f32::MAX, ..LOOSE };
    for (left, right) in [(number, nan), (nan, number), (nan, nan)] {
        assert_eq!(floats("x", 1, &left, &right, lenient).first, Some(1));
    }
}

#[test]
fn detects_infinity() {
    let infinite = [f32::INFINITY];
    assert!(floats("x", 1, &infinite, &infinite, LOOSE).passes());
    assert!(!floats("x", 1, &infinite, &[1.0], LOOSE).passes());
    assert!(!floats("x", 1, &infinite, &[f32::NEG_INFINITY], LOOSE).passes());
}

#[test]
fn detects_a_missing_record() {
    let differences = compare_hits(&hits()[..99]);
    assert!(differences.iter().all(|d| !d.passes() && d.exceeding == 1 && d.first == Some(99)));
}

#[test]
fn detects_one_flipped_bit() {
    let words_left = [1u32, 2, 3, 4];
    assert!(words("w", 2, &words_left, &words_left, Tolerance::EXACT).passes());
    let difference = words("w", 2, &words_left, &[1, 2, 3, 5], Tolerance::EXACT);
    assert_eq!((difference.passes(), difference.first), (false, Some(1)));
}

#[test]
fn allowed_share_is_rounded_down_to_whole_elements() {
    let tolerance = LOOSE.except(0.01, "one in a hundred");
    let image = vec![1.0f32; 199];
    let mut other = image.clone();
    other[0] = 2.0;
    assert!(floats("x", 1, &image, &other, tolerance).passes());
    other[1] = 2.0;
    assert!(!floats("x", 1, &image, &other, tolerance).passes());
}
