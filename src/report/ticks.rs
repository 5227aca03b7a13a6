//! Ticks of axes and colour bars: round steps, short labels.

/// Evenly spaced ticks with labels, the values divided by 10^exponent.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ticks {
    /// Power of ten taken out of the labels.
    pub exponent: i32,
    /// Position and label of each tick.
    pub marks: Vec<(f64, String)>,
}

/// The largest of 1, 2, 5 times a power of ten that is at most `length` (0 where that is 0).
pub(super) fn round_length(length: f64) -> f64 {
    if !(length > 0.0 && length.is_finite()) {
        return 0.0;
    }
    let power = 10f64.powf(length.log10().floor());
    let mantissa = length / power;
    // A hair of slack keeps 5.0 from becoming 2 by rounding.
    let digit = [5.0, 2.0, 1.0].into_iter().find(|d| mantissa >= d * (1.0 - 1e-9)).unwrap_or(1.0);
    digit * power
}

/// About `count` ticks on round numbers between `low` and `high`.
pub(super) fn linear(low: f64, high: f64, count: usize) -> Ticks {
    let span = high - low;
    // The step is rounded up to 1, 2 or 5 so that there are never more than `count` steps.
    let raw = span / count.max(1) as f64;
    let step = [1.0, 2.0, 2.5].into_iter().map(|f| f * round_length(raw)).find(|s| *s >= raw * (1.0 - 1e-9));
    let step = step.unwrap_or(raw);
    if !(step > 0.0 && step.is_finite()) {
        return Ticks { exponent: 0, marks: vec![(low, number(low, 0))] };
    }
    let exponent = exponent_of(low.abs().max(high.abs()));
    let scale = 10f64.powi(exponent);
    let decimals = (-(step / scale).log10().floor()).max(0.0) as usize;
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    let mark = |i: i64| (i as f64 * step, number(i as f64 * step / scale, decimals));
    Ticks { exponent, marks: (first..=last).map(mark).collect() }
}

/// Powers of ten between `low` and `high` (both above 0), with 2 and 5 times them where they are few; round numbers
/// where the axis is shorter than that.
pub(super) fn logarithmic(low: f64, high: f64) -> Vec<(f64, String)> {
    if high < 5.0 * low {
        let Ticks { exponent, marks } = linear(low, high, 5);
        let label = |value: f64, label: String| if exponent == 0 { label } else { short(value) };
        return marks.into_iter().map(|(value, text)| (value, label(value, text))).collect();
    }
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let digits: &[i32] = if high < 200.0 * low { &[1, 2, 5] } else { &[1] };
    let mark = |exponent: i32, digit: i32| {
        let value = f64::from(digit) * 10f64.powi(exponent);
        let label = match digits.len() {
            1 => power_of_ten(exponent),
            _ if first >= -3 && last <= 5 => number(value, exponent.min(0).unsigned_abs() as usize),
            _ => format!("{digit} × {}", power_of_ten(exponent)),
        };
        (value, label)
    };
    let marks = (first..=last).flat_map(|e| digits.iter().map(move |&d| mark(e, d)));
    marks.filter(|(v, _)| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9)).collect()
}

/// "10⁻³".
pub(super) fn power_of_ten(exponent: i32) -> String {
    let digits = exponent.to_string();
    let raised = digits.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        // The other superscript digits are consecutive code points from U+2070.
        _ => c.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(c),
    });
    std::iter::once('1').chain(std::iter::once('0')).chain(raised).collect()
}

/// The power of ten to take out: none for magnitudes that read well, else a multiple of 3.
fn exponent_of(magnitude: f64) -> i32 {
    if magnitude == 0.0 || (0.1..1e5).contains(&magnitude) {
        return 0;
    }
    3 * (magnitude.log10() / 3.0).floor() as i32
}

/// A number with a true minus sign.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", value.abs());
    let is_zero = text.chars().all(|c| c == '0' || c == '.');
    if value < 0.0 && !is_zero { format!("−{text}") } else { text }
}

/// Three significant digits, with a power of ten below a thousandth and from 10⁵ on.
pub(super) fn short(value: f64) -> String {
    let exponent = if (1e-3..1.0).contains(&value.abs()) { 0 } else { exponent_of(value.abs()) };
    let scaled = value / 10f64.powi(exponent);
    let whole_digits = if scaled == 0.0 { 1 } else { scaled.abs().log10().floor() as i32 + 1 };
    let text = number(scaled, (3 - whole_digits).clamp(0, 6) as usize);
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
    if exponent == 0 { text } else { format!("{text} × {}", power_of_ten(exponent)) }
}

/// A value and its interval with the digits that the interval supports: "1239", "1097 to 1342".
pub(super) fn interval(value: f64, low: f64, high: f64) -> (String, String) {
    let exponent = match value.abs().max(low.abs()).max(high.abs()) {
        most if (1e-3..1.0).contains(&most) => 0,
        most => exponent_of(most),
    };
    let scale = 10f64.powi(exponent);
    // Two digits of the half width; three of the value where there is no width.
    let resolved = if high > low { 0.5 * (high - low) / scale } else { 0.1 * value.abs() / scale };
    let decimals = if resolved > 0.0 { (1 - resolved.log10().floor() as i32).clamp(0, 9) } else { 0 } as usize;
    let power = if exponent == 0 { String::new() } else { format!(" × {}", power_of_ten(exponent)) };
    let text = |v: f64| number(v / scale, decimals);
    (format!("{}{power}", text(value)), format!("{} to {}{power}", text(low), text(high)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &Ticks) -> Vec<&str> {
        ticks.marks.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn linear_ticks_are_round_and_no_more_than_asked() {
        assert_eq!(labels(&linear(0.0, 255.0, 6)), ["0", "50", "100", "150", "200", "250"]);
        assert_eq!(labels(&linear(-15.0, 15.0, 6)), ["−15", "−10", "−5", "0", "5", "10", "15"]);
        assert_eq!(labels(&linear(0.0, 1.0, 5)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        let small = linear(0.0, 0.0042, 5);
        assert_eq!((small.exponent, labels(&small)), (-3, vec!["0", "1", "2", "3", "4"]));
        for high in [0.13, 0.7, 3.3, 9.99, 123.0, 4.7e7] {
            let n = linear(0.0, high, 5).marks.len();
            assert!((3..=6).contains(&n), "{high}: {n}");
        }
    }

    #[test]
    fn empty_range_has_one_tick() {
        assert_eq!(labels(&linear(0.0, 0.0, 5)), ["0"]);
    }

    #[test]
    fn logarithmic_ticks_are_powers_of_ten_with_more_between_where_they_are_few() {
        let texts = |low, high| logarithmic(low, high).into_iter().map(|(_, t)| t).collect::<Vec<_>>();
        assert_eq!(texts(2e-4, 1.0), ["10⁻³", "10⁻²", "10⁻¹", "10⁰"]);
        assert_eq!(texts(0.03, 0.31), ["0.05", "0.1", "0.2"]);
        assert_eq!(texts(0.9, 120.0), ["1", "2", "5", "10", "20", "50", "100"]);
        assert_eq!(texts(3e-6, 5e-5), ["5 × 10⁻⁶", "1 × 10⁻⁵", "2 × 10⁻⁵", "5 × 10⁻⁵"]);
        // 15.1 to 18.2 holds none of 1, 2 and 5 times a power of ten.
        assert_eq!(texts(15.1, 18.2), ["16", "17", "18"]);
        assert_eq!(power_of_ten(-14), "10⁻¹⁴");
    }

    #[test]
    fn intervals_show_the_digits_they_support() {
        let both = |v, l, h| {
            let (value, range) = interval(v, l, h);
            format!("{value} ({range})")
        };
        assert_eq!(both(1238.7, 1097.2, 1341.8), "1239 (1097 to 1342)");
        assert_eq!(both(701.7617, 701.753, 701.7704), "701.7617 (701.7530 to 701.7704)");
        assert_eq!(both(7.93, 7.5, 8.4), "7.93 (7.50 to 8.40)");
        assert_eq!(both(32_312_820.0, 32_312_124.0, 32_313_516.0), "32.31282 × 10⁶ (32.31212 to 32.31352 × 10⁶)");
        assert_eq!(both(0.0, 0.0, 0.0), "0 (0 to 0)");
    }

    #[test]
    fn round_lengths_are_one_two_or_five() {
        for (length, rounded) in [(7.3, 5.0), (5.0, 5.0), (4.9, 2.0), (1.0, 1.0), (0.03, 0.02), (0.0, 0.0)] {
            assert!((round_length(length) - rounded).abs() < 1e-12, "{length}");
        }
    }

    #[test]
    fn short_numbers_keep_three_digits() {
        assert_eq!(short(0.0), "0");
        assert_eq!(short(255.0), "255");
        assert_eq!(short(0.4237), "0.424");
        assert_eq!(short(-1.5), "−1.5");
        assert_eq!(short(0.021_507), "0.0215");
        assert_eq!(short(0.000_123_4), "123 × 10⁻⁶");
    }
}
