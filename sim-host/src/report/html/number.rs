//! Numbers as people read them, and quantiles.

/// Shown where there is no value.
pub const NONE: &str = "–";

/// `v` with `digits` significant digits; powers of ten outside 0.0001 .. 1,000,000.
pub fn sig(v: f64, digits: usize) -> String {
    if !v.is_finite() {
        return if v == f64::INFINITY { "∞".into() } else { NONE.into() };
    }
    if v == 0.0 {
        return "0".into();
    }
    let rounded: f64 = format!("{:.*e}", digits.saturating_sub(1), v).parse().unwrap_or(v);
    let exponent = rounded.abs().log10().floor() as i32;
    if !(-4..6).contains(&exponent) {
        let mantissa = rounded / 10f64.powi(exponent);
        let mantissa = trimmed(&format!("{:.*}", digits.saturating_sub(1), mantissa));
        let power = superscript(exponent);
        return if mantissa == "1" { format!("10{power}") } else { format!("{mantissa}·10{power}") };
    }
    let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
    trimmed(&format!("{rounded:.decimals$}"))
}

/// Without zeros at the end of a decimal fraction; a true minus sign.
fn trimmed(text: &str) -> String {
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text };
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

/// `v` with exactly `decimals` digits behind the point and a true minus sign.
pub fn fixed(v: f64, decimals: usize) -> String {
    let text = format!("{v:.decimals$}");
    let zero = text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
    if zero { text.trim_start_matches('-').into() } else { text.replace('-', "−") }
}

fn superscript(n: i32) -> String {
    n.to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32('⁰' as u32 + u32::from(digit) - u32::from('0')).unwrap_or(digit),
        })
        .collect()
}

/// Metres as a number of millimetres.
pub fn mm(metres: Option<f64>) -> String {
    metres.map_or(NONE.into(), |m| sig(m * 1e3, 3))
}

/// Radians as a number of degrees.
pub fn deg(radians: Option<f64>) -> String {
    radians.map_or(NONE.into(), |r| sig(r.to_degrees(), 3))
}

/// A share (0..1) as a number of per cent.
pub fn percent(share: f64) -> String {
    if !share.is_finite() {
        return NONE.into();
    }
    // 99.96 % is not 100 %: only a whole is written as one.
    let shown = share * 100.0;
    let bounded = if share < 1.0 { shown.min(99.9) } else { shown };
    trimmed(&format!("{bounded:.1}"))
}

/// `part` of `whole` as a share; NaN of nothing.
pub fn share(part: usize, whole: usize) -> f64 {
    part as f64 / whole as f64
}

/// Seconds with a unit that suits them.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if !s.is_finite() => NONE.into(),
        s if s < 1e-3 => format!("{} µs", sig(s * 1e6, 3)),
        s if s < 1.0 => format!("{} ms", sig(s * 1e3, 3)),
        s if s < 120.0 => format!("{} s", sig(s, 3)),
        s if s < 7200.0 => format!("{} min", sig(s / 60.0, 3)),
        s => format!("{} h", sig(s / 3600.0, 3)),
    }
}

/// The `p` quantile (0..1) by nearest rank; what has no value counts as infinitely large. `None` of nothing.
pub fn quantile(values: impl Iterator<Item = Option<f64>>, p: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.map(|v| v.filter(|v| !v.is_nan()).unwrap_or(f64::INFINITY)).collect();
    sorted.sort_by(f64::total_cmp);
    let rank = (p * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

/// About `count` round numbers from `low` to `high`, both included where they are round, and the decimals they need.
pub fn ticks(low: f64, high: f64, count: usize) -> (Vec<f64>, usize) {
    let span = high - low;
    if !span.is_finite() || span <= 0.0 {
        return (vec![low], 2);
    }
    let rough = span / count.max(1) as f64;
    let decade = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|s| *s >= rough * 0.999).unwrap_or(rough);
    let decimals = (-(step * 1.0001).log10().floor()).max(0.0) as usize;
    let first = (low / step - 1e-6).ceil() as i64;
    let last = (high / step + 1e-6).floor() as i64;
    // `low` and `high` come from files: the number of steps between them is bounded by the choice of `step`.
    ((first..=last).take(100).map(|i| i as f64 * step).collect(), decimals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_significant_digits() {
        let cases =
            [(0.0, "0"), (12.345, "12.3"), (0.001_234, "0.00123"), (99.96, "100"), (1234.0, "1230"), (-2.5, "−2.5")];
        for (v, text) in cases {
            assert_eq!(sig(v, 3), text);
        }
        assert_eq!(sig(1.0e-7, 3), "10⁻⁷");
        assert_eq!(sig(2.346e9, 3), "2.35·10⁹");
    }

    #[test]
    fn less_than_all_is_never_written_as_100_percent() {
        assert_eq!(percent(2999.0 / 3000.0), "99.9");
        assert_eq!(percent(1.0), "100");
    }

    #[test]
    fn a_missing_value_counts_as_infinitely_wrong() {
        let values = [Some(1.0), None, Some(2.0)];
        assert_eq!(quantile(values.into_iter(), 0.5), Some(2.0));
        assert_eq!(quantile(values.into_iter(), 0.9), Some(f64::INFINITY));
        assert_eq!(quantile([].into_iter(), 0.5), None);
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let (values, decimals) = ticks(0.095, 0.305, 5);
        assert_eq!(decimals, 2);
        let texts: Vec<String> = values.iter().map(|v| fixed(*v, decimals)).collect();
        assert_eq!(texts, ["0.10", "0.15", "0.20", "0.25", "0.30"]);
    }
}
