//! Axes: positions of values, and ticks.

/// Mapping of values to positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences have equal lengths.
    Linear,
    /// Equal ratios have equal lengths; values are positive.
    Log,
}

/// An axis from `low` to `high`, drawn from `start` to `end` (px).
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    start: f64,
    end: f64,
}

/// A line across the chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Value at which the line is drawn.
    pub value: f64,
    /// Whether its number is written.
    pub labelled: bool,
}

impl Axis {
    /// Returns an axis that holds all values with room around them; a logarithmic one holds those above 0. None where there
    /// are none.
    pub fn around(scale: Scale, values: impl Iterator<Item = f64>, start: f64, end: f64) -> Option<Axis> {
        let fits = |value: &f64| value.is_finite() && (scale == Scale::Linear || *value > 0.0);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(fits) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            return None;
        }
        match scale {
            Scale::Log => {
                // Add a tenth on both sides; centre a single value in a factor of two.
                let room = (0.08 * (high / low).log10()).max(0.15 - 0.5 * (high / low).log10()).max(0.02);
                (low, high) = (low / 10f64.powf(room), high * 10f64.powf(room));
                // Keep the room within the finite positive numbers.
                (low, high) = (low.max(f64::MIN_POSITIVE), high.min(f64::MAX));
            }
            Scale::Linear => {
                low = low.min(0.0);
                high = if high > low { (high + 0.05 * (high - low)).min(f64::MAX) } else { low + 1.0 };
            }
        }
        Some(Axis { scale, low, high, start, end })
    }

    /// An axis of whole numbers, from the first to the last.
    pub fn between(low: f64, high: f64, start: f64, end: f64) -> Axis {
        Axis { scale: Scale::Linear, low, high: high.max(low + 1.0), start, end }
    }

    /// Position of a value (px).
    pub fn position(&self, value: f64) -> f64 {
        let part = match self.scale {
            // Subtract logarithms: the ratio itself may overflow.
            Scale::Log => (value.ln() - self.low.ln()) / (self.high.ln() - self.low.ln()),
            Scale::Linear => (value - self.low) / (self.high - self.low),
        };
        self.start + part * (self.end - self.start)
    }

    /// Its ticks, in ascending order.
    pub fn ticks(&self) -> Vec<Tick> {
        match self.scale {
            Scale::Log => log_ticks(self.low, self.high),
            Scale::Linear => linear_ticks(self.low, self.high, 6),
        }
    }
}

/// Maximum number of powers of ten that have a tick each.
const MAX_POWERS: f64 = 12.0;

/// Ticks at 1 to 9 times the powers of ten; over many decades, at every n-th power only. As many ticks have numbers as
/// there is room for.
fn log_ticks(low: f64, high: f64) -> Vec<Tick> {
    let decades = (high / low).log10();
    if decades < 0.45 {
        return linear_ticks(low, high, 5);
    }
    let labelled: &[i32] = match decades {
        d if d > 3.2 => &[1],
        d if d > 1.0 => &[1, 2, 5],
        _ => &[1, 2, 3, 5, 7],
    };
    let mut ticks = Vec::new();
    // A ratio that overflows gives the largest step.
    let step = (decades / MAX_POWERS).ceil().clamp(1.0, 100.0) as usize;
    let digits = if step == 1 { 1..10 } else { 1..2 };
    for power in (low.log10().floor() as i32..=high.log10().ceil() as i32).step_by(step) {
        for digit in digits.clone() {
            let value = f64::from(digit) * 10f64.powi(power);
            if (low..=high).contains(&value) {
                ticks.push(Tick { value, labelled: labelled.contains(&digit) });
            }
        }
    }
    ticks
}

/// About `count` ticks at multiples of 1, 2 or 5 times a power of ten.
fn linear_ticks(low: f64, high: f64, count: u32) -> Vec<Tick> {
    let rough = (high - low) / f64::from(count);
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().find(|step| step * power >= rough).unwrap_or(10.0) * power;
    if !step.is_normal() {
        return Vec::new();
    }
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last)
        .take(2 * count as usize)
        .map(|index| Tick { value: index as f64 * step, labelled: true })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &[Tick]) -> Vec<f64> {
        let labelled = ticks.iter().filter(|tick| tick.labelled);
        labelled.map(|tick| (tick.value * 1e9).round() / 1e9).collect()
    }

    #[test]
    fn log_ticks_of_known_ranges_are_known() {
        assert_eq!(labels(&log_ticks(3.0, 60.0)), [5.0, 10.0, 20.0, 50.0]);
        assert_eq!(labels(&log_ticks(0.012, 0.09)), [0.02, 0.03, 0.05, 0.07]);
        assert_eq!(labels(&log_ticks(0.5, 5e4)), [1.0, 10.0, 100.0, 1e3, 1e4]);
        assert_eq!(labels(&log_ticks(9.0, 11.0)), [9.0, 9.5, 10.0, 10.5, 11.0]);
        let all: Vec<f64> = log_ticks(3.0, 60.0).iter().map(|tick| tick.value).collect();
        assert_eq!(all, [3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0]);
    }

    #[test]
    fn every_range_has_a_few_labels_in_it() {
        for power in -6..6 {
            for span in [1.05, 1.4, 2.0, 3.0, 8.0, 20.0, 300.0, 5e3, 1e6] {
                let low = 1.7 * 10f64.powi(power);
                let labels = labels_of(low, low * span);
                assert!((2..=10).contains(&labels.len()), "{low} times {span}: {labels:?}");
                assert!(labels.iter().all(|value| (low * 0.999..=low * span * 1.001).contains(value)));
            }
        }
    }

    #[test]
    fn a_range_of_all_numbers_has_a_few_ticks() {
        let (smallest, largest) = (f64::MIN_POSITIVE, f64::MAX);
        for (low, high) in
            [(1e-300, 0.5), (5e-324, 1.0), (smallest, largest), (1e307, largest), (smallest, 2.0 * smallest)]
        {
            for scale in [Scale::Log, Scale::Linear] {
                let axis = Axis::around(scale, [low, high].into_iter(), 0.0, 100.0).unwrap();
                let ticks = axis.ticks();
                assert!(ticks.len() < 120, "{low} to {high}: {} ticks", ticks.len());
                assert!(ticks.iter().all(|tick| axis.position(tick.value).is_finite()), "{low} to {high}");
            }
        }
        assert!((3..=13).contains(&labels_of(1e-300, 0.5).len()));
        assert!(linear_ticks(0.0, 5e-324, 6).is_empty());
    }

    fn labels_of(low: f64, high: f64) -> Vec<f64> {
        log_ticks(low, high).iter().filter(|tick| tick.labelled).map(|tick| tick.value).collect()
    }

    #[test]
    fn equal_ratios_are_equally_long_and_all_values_are_inside() {
        let axis = Axis::around(Scale::Log, [10.0, 1000.0, 0.0, f64::NAN].into_iter(), 0.0, 100.0).unwrap();
        let [a, b, c] = [10.0, 100.0, 1000.0].map(|value| axis.position(value));
        assert!((2.0 * b - a - c).abs() < 1e-9 && a > 0.0 && c < 100.0);
        let one = Axis::around(Scale::Log, [7.0].into_iter(), 0.0, 100.0).unwrap();
        assert!((one.position(7.0) - 50.0).abs() < 1e-9);
        assert!(Axis::around(Scale::Log, [0.0, -1.0].into_iter(), 0.0, 1.0).is_none());
        let linear = Axis::around(Scale::Linear, [2.0, 4.0].into_iter(), 0.0, 100.0).unwrap();
        assert_eq!(linear.position(0.0), 0.0);
    }
}
