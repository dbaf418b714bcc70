//! Numbers as text for readers.

/// Three significant digits; very large and very small ones with a power of ten.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return "∞".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-3..=5).contains(&exponent) {
        let text = format!("{value:.2e}");
        let (mantissa, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{mantissa}·10{}", superscript(power));
    }
    let digits = (2 - exponent).max(0) as usize;
    format!("{value:.digits$}")
}

/// Number without trailing zeros, for axes and settings.
pub fn short(value: f64) -> String {
    let text = number(value);
    if let Some((mantissa, power)) = text.split_once('·') {
        let mantissa = trimmed(mantissa);
        return if mantissa == "1" { power.into() } else { format!("{mantissa}·{power}") };
    }
    trimmed(&text).into()
}

fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

fn superscript(text: &str) -> String {
    let raised = |letter: char| match letter.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    text.chars().map(raised).collect()
}

/// Coordinate of a drawing, rounded to a tenth of a pixel.
pub fn at(value: f64) -> String {
    trimmed(&format!("{value:.1}")).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_and_axes_no_trailing_zeros() {
        let cases = [
            (0.0, "0", "0"),
            (1.0, "1.00", "1"),
            (0.05, "0.0500", "0.05"),
            (12.34, "12.3", "12.3"),
            (200.0, "200", "200"),
            (123_456.0, "123456", "123456"),
            (2e6, "2.00·10⁶", "2·10⁶"),
            (1e-4, "1.00·10⁻⁴", "10⁻⁴"),
            (1e12, "1.00·10¹²", "10¹²"),
            (-0.5, "-0.500", "-0.5"),
        ];
        for (value, long, brief) in cases {
            assert_eq!((number(value).as_str(), short(value).as_str()), (long, brief));
        }
    }
}
