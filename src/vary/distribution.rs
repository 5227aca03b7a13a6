//! Values along a variable: listed ones, and distributions by their quantiles.

use super::{Scalar, Vary};
use statrs::function::erf::{erfc, erfc_inv};
use std::f64::consts::SQRT_2;

/// Most values of a list.
const MOST_VALUES: u32 = 100_000;

/// Where a variable's values come from.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Source {
    /// The same everywhere.
    Fixed(Scalar),
    /// A list: an axis of a grid; elsewhere each is drawn as often.
    Listed(Vec<Scalar>),
    /// Drawn.
    Drawn(Distribution),
    /// Computed from the others.
    Derived(super::Expression),
    /// A column of the design's table.
    Column,
}

/// A distribution of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Distribution {
    Uniform {
        low: f64,
        high: f64,
    },
    LogUniform {
        low: f64,
        high: f64,
    },
    /// Between the quantiles `from` and `to` of a normal distribution.
    Normal {
        mean: f64,
        sd: f64,
        from: f64,
        to: f64,
    },
    /// The same of the logarithm.
    LogNormal {
        mean: f64,
        sd: f64,
        from: f64,
        to: f64,
    },
}

/// Share of a standard normal distribution below `z`.
fn normal_share(z: f64) -> f64 {
    0.5 * erfc(-z / SQRT_2)
}

/// The standard normal quantile.
fn normal_quantile(share: f64) -> f64 {
    -SQRT_2 * erfc_inv(2.0 * share)
}

/// A value without what rounding left behind the 15th digit of a scale: 1.405 is no 1.4049999999999998, and
/// counts in powers of ten are whole.
pub(super) fn written_out(value: f64, scale: f64) -> f64 {
    let decimals = (14.0 - scale.abs().log10().floor()).clamp(0.0, 340.0) as usize;
    // A sum with 0 has no sign where it is none.
    format!("{value:.decimals$}").parse().map_or(value, |value: f64| value + 0.0)
}

impl Distribution {
    /// The value below which the share `u` lies, 0 < u < 1.
    pub fn quantile(&self, u: f64) -> f64 {
        match *self {
            Self::Uniform { low, high } => low + (high - low) * u,
            Self::LogUniform { low, high } => (low.ln() + (high / low).ln() * u).exp().clamp(low, high),
            Self::Normal { mean, sd, from, to } => mean + sd * normal_quantile(from + (to - from) * u),
            Self::LogNormal { mean, sd, from, to } => (mean + sd * normal_quantile(from + (to - from) * u)).exp(),
        }
    }
}

impl Source {
    /// The values that are listed; none of what is drawn or computed.
    pub fn listed(&self) -> &[Scalar] {
        match self {
            Self::Fixed(value) => std::slice::from_ref(value),
            Self::Listed(values) => values,
            Self::Drawn(_) | Self::Derived(_) | Self::Column => &[],
        }
    }

    /// What an entry asks for.
    pub fn of(vary: &Vary) -> Result<Self, String> {
        let given = [
            ("fixed", vary.fixed.is_some()),
            ("values", vary.values.is_some()),
            ("linear", vary.linear.is_some()),
            ("log", vary.log.is_some()),
            ("uniform", vary.uniform.is_some()),
            ("log_uniform", vary.log_uniform.is_some()),
            ("normal", vary.normal.is_some()),
            ("log_normal", vary.log_normal.is_some()),
            ("choice", vary.choice.is_some()),
            ("expression", vary.expression.is_some()),
        ];
        let named: Vec<&str> = given.iter().filter(|(_, is_given)| *is_given).map(|(name, _)| *name).collect();
        if named.len() > 1 {
            return Err(format!("has {}, which cannot all hold; keep one", named.join(" and ")));
        }
        let list = |values: &[Scalar], name: &str| match values.is_empty() {
            true => Err(format!("{name} must have at least one value")),
            false => Ok(Self::Listed(values.to_vec())),
        };
        let normal = |normal: &super::Normal, name: &str, mean: f64, sd: f64, at: &dyn Fn(f64) -> Option<f64>| {
            if !(sd.is_finite() && sd > 0.0 && mean.is_finite()) {
                return Err(format!("{name} must have a width: an sd above 0"));
            }
            let share = |bound: Option<f64>, open: f64| match bound {
                None => Ok(open),
                Some(bound) => at(bound)
                    .map(|bound| normal_share((bound - mean) / sd))
                    .ok_or_else(|| format!("{name} must have bounds above 0")),
            };
            let (from, to) = (share(normal.low, 0.0)?, share(normal.high, 1.0)?);
            match to - from > 1e-9 {
                true => Ok([mean, sd, from, to]),
                false => Err(format!("{name} leaves nothing between its bounds")),
            }
        };
        let bounds = |[low, high]: [f64; 2], name: &str, positive: bool| {
            if low >= high {
                return Err(format!("{name} must have a width, from low to high; for example [{low}, {}]", low + 1.0));
            }
            if positive && low <= 0.0 {
                return Err(format!("{name} must lie above 0, starts at {low}"));
            }
            if !(high - low).is_finite() {
                return Err(format!("{name} is wider than numbers go: [{low:e}, {high:e}]"));
            }
            Ok((low, high))
        };
        Ok(match vary {
            Vary { fixed: Some(value), .. } => Self::Fixed(value.clone()),
            Vary { values: Some(values), .. } => list(values, "values")?,
            Vary { choice: Some(values), .. } => list(values, "choice")?,
            Vary { linear: Some(range), .. } => {
                let scale = range.from.abs().max(range.to.abs());
                let at = |k, last| range.from + (range.to - range.from) * k / last;
                range.list("linear", |k, last| written_out(at(k, last), scale))?
            }
            Vary { log: Some(range), .. } => {
                if range.from <= 0.0 || range.to <= 0.0 {
                    return Err("log must lie above 0".into());
                }
                let at = |k, last| range.from * (range.to / range.from).powf(k / last);
                range.list("log", |k, last| written_out(at(k, last), at(k, last)))?
            }
            Vary { uniform: Some(range), .. } => {
                let (low, high) = bounds(*range, "uniform", false)?;
                Self::Drawn(Distribution::Uniform { low, high })
            }
            Vary { log_uniform: Some(range), .. } => {
                let (low, high) = bounds(*range, "log_uniform", true)?;
                Self::Drawn(Distribution::LogUniform { low, high })
            }
            Vary { normal: Some(one), .. } => {
                let [mean, sd, from, to] = normal(one, "normal", one.mean, one.sd, &Some)?;
                Self::Drawn(Distribution::Normal { mean, sd, from, to })
            }
            Vary { log_normal: Some(one), .. } => {
                if one.mean <= 0.0 {
                    return Err(format!("log_normal must have a mean above 0, has {}", one.mean));
                }
                // Mean and standard deviation of the logarithm, from those of the quantity itself.
                let ratio = one.sd / one.mean;
                let variance = if ratio < 1.0 { (ratio * ratio).ln_1p() } else { 2.0 * ratio.hypot(1.0).ln() };
                let logarithm = |bound: f64| (bound > 0.0).then(|| bound.ln());
                let (mean, sd) = (one.mean.ln() - variance / 2.0, if one.sd > 0.0 { variance.sqrt() } else { 0.0 });
                let [mean, sd, from, to] = normal(one, "log_normal", mean, sd, &logarithm)?;
                Self::Drawn(Distribution::LogNormal { mean, sd, from, to })
            }
            Vary { expression: Some(text), .. } => {
                Self::Derived(text.parse().map_err(|why| format!("expression: {text:?} {why}"))?)
            }
            _ => Self::Column,
        })
    }

    /// The value at the share `u` of a list or a distribution, 0 < u < 1.
    pub fn at(&self, u: f64) -> Option<Scalar> {
        match self {
            Self::Listed(values) => values.get((u * values.len() as f64) as usize).or(values.last()).cloned(),
            Self::Drawn(distribution) => Some(Scalar::Number(distribution.quantile(u))),
            Self::Fixed(_) | Self::Derived(_) | Self::Column => None,
        }
    }

    /// Whether a design draws it.
    pub fn is_free(&self) -> bool {
        matches!(self, Self::Listed(_) | Self::Drawn(_))
    }
}

impl super::Range {
    fn list(&self, name: &str, at: impl Fn(f64, f64) -> f64) -> Result<Source, String> {
        if self.points == 0 || self.points > MOST_VALUES {
            return Err(format!("{name}.points must be from 1 to {MOST_VALUES}, is {}", self.points));
        }
        if self.points > 1 && self.from == self.to {
            return Err(format!("{name} must have a width: its ends are both {}", self.from));
        }
        let last = f64::from(self.points.saturating_sub(1)).max(1.0);
        // Both ends are what was written, to the last bit.
        let value = |k: u32| match k {
            0 => self.from,
            k if k + 1 == self.points => self.to,
            k => at(f64::from(k), last),
        };
        Ok(Source::Listed((0..self.points).map(|k| Scalar::Number(value(k))).collect()))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::vary::{Normal, Range};

    fn source(change: impl FnOnce(&mut Vary)) -> Result<Source, String> {
        let mut vary = Vary::default();
        change(&mut vary);
        Source::of(&vary)
    }

    /// Mean and standard deviation by the midpoints of many quantiles.
    fn moments(source: &Source) -> [f64; 2] {
        let n = 200_000;
        let values = (0..n).map(|k| source.at((f64::from(k) + 0.5) / f64::from(n)).unwrap().number().unwrap());
        let [sum, squares] = values.fold([0.0, 0.0], |[sum, squares], v| [sum + v, squares + v * v]);
        let mean = sum / f64::from(n);
        [mean, (squares / f64::from(n) - mean * mean).sqrt()]
    }

    #[test]
    fn distributions_have_their_moments() {
        let close = |found: [f64; 2], wanted: [f64; 2]| {
            for (found, wanted) in found.iter().zip(wanted) {
                assert!((found / wanted - 1.0).abs() < 1e-3, "{found} {wanted}");
            }
        };
        close(moments(&source(|v| v.uniform = Some([4.0, 14.0])).unwrap()), [9.0, 10.0 / 12f64.sqrt()]);
        // Mean (b - a) / ln(b / a), mean square (b^2 - a^2) / (2 ln(b / a)).
        let log = (100f64).ln();
        let mean = 99.0 / log;
        close(
            moments(&source(|v| v.log_uniform = Some([1.0, 100.0])).unwrap()),
            [mean, (9999.0 / (2.0 * log) - mean * mean).sqrt()],
        );
        let normal = Normal { mean: 10.0, sd: 2.0, low: None, high: None };
        close(moments(&source(|v| v.normal = Some(normal)).unwrap()), [10.0, 2.0]);
        close(moments(&source(|v| v.log_normal = Some(normal)).unwrap()), [10.0, 2.0]);
        // Half a normal distribution: mean + sd sqrt(2 / pi), sd sqrt(1 - 2 / pi).
        let half = Normal { low: Some(10.0), ..normal };
        let share = 2.0 / std::f64::consts::PI;
        close(
            moments(&source(|v| v.normal = Some(half)).unwrap()),
            [10.0 + 2.0 * share.sqrt(), 2.0 * (1.0 - share).sqrt()],
        );
    }

    #[test]
    fn widths_may_be_small_and_no_larger_than_numbers() {
        let narrow = Normal { mean: 1.4, sd: 1e-9, low: None, high: None };
        let at = |u: f64| source(|v| v.log_normal = Some(narrow)).unwrap().at(u).unwrap().number().unwrap();
        assert!((at(0.5) - 1.4).abs() < 1e-12, "{}", at(0.5));
        assert!((at(0.841_344_746) - at(0.5) - 1e-9).abs() < 1e-13, "{:e}", at(0.841_344_746) - at(0.5));
        let wide = Normal { sd: 1e200, ..narrow };
        assert!(source(|v| v.log_normal = Some(wide)).unwrap().at(0.5).unwrap().number().unwrap().is_finite());
        assert!(source(|v| v.uniform = Some([-1.7e308, 1.7e308])).unwrap_err().contains("wider than numbers go"));
    }

    #[test]
    fn lists_end_where_they_were_told() {
        let range = |from, to, points| Some(Range { from, to, points });
        let numbers = |source: Source| match source {
            Source::Listed(values) => values.iter().map(|v| v.number().unwrap()).collect::<Vec<_>>(),
            _ => panic!("no list"),
        };
        let linear = numbers(source(|v| v.linear = range(1.4, 1.42, 3)).unwrap());
        assert_eq!((linear[0], linear[2]), (1.4, 1.42));
        assert_eq!(linear[1], 1.41);
        let fine = numbers(source(|v| v.linear = range(1.40, 1.43, 7)).unwrap());
        assert_eq!(fine, [1.4, 1.405, 1.41, 1.415, 1.42, 1.425, 1.43]);
        let across = numbers(source(|v| v.linear = range(-0.1, 0.2, 4)).unwrap());
        assert!(across == [-0.1, 0.0, 0.1, 0.2] && across[1].is_sign_positive(), "{across:?}");
        let wide = numbers(source(|v| v.linear = range(-1e300, 1e300, 3)).unwrap());
        assert_eq!(wide, [-1e300, 0.0, 1e300]);
        // Whole steps are whole numbers: keys such as seeds ask for them.
        let whole = numbers(source(|v| v.linear = range(1.0, 200.0, 200)).unwrap());
        assert!((1..=200).zip(whole).all(|(k, value)| f64::from(k) == value));
        let log = numbers(source(|v| v.log = range(1.0, 100.0, 3)).unwrap());
        assert!((log[1] - 10.0).abs() < 1e-12 && log[2] == 100.0);
        let counts = numbers(source(|v| v.log = range(1e3, 1e6, 4)).unwrap());
        assert_eq!(counts, [1e3, 1e4, 1e5, 1e6]);
        let small = numbers(source(|v| v.log = range(1e-100, 1e100, 5)).unwrap());
        assert_eq!(small, [1e-100, 1e-50, 1.0, 1e50, 1e100]);
        assert_eq!(numbers(source(|v| v.linear = range(3.0, 9.0, 1)).unwrap()), [3.0]);
        let drawn = source(|v| v.choice = Some(["a", "b"].map(|text| Scalar::Text(text.into())).to_vec())).unwrap();
        assert_eq!(drawn.at(0.49).unwrap(), Scalar::Text("a".into()));
        assert_eq!(drawn.at(1.0 - 1e-17).unwrap(), Scalar::Text("b".into()));
    }

    #[test]
    fn what_cannot_hold_is_refused() {
        let normal = |mean, sd, low, high| Some(Normal { mean, sd, low, high });
        let both = source(|v| (v.uniform, v.fixed) = (Some([0.0, 1.0]), Some(Scalar::Number(1.0))));
        assert_eq!(both.unwrap_err(), "has fixed and uniform, which cannot all hold; keep one");
        for (found, said) in [
            (source(|v| v.uniform = Some([1.0, 1.0])), "must have a width"),
            (source(|v| v.log_uniform = Some([0.0, 1.0])), "above 0"),
            (source(|v| v.normal = normal(1.0, 0.0, None, None)), "an sd above 0"),
            (source(|v| v.normal = normal(1.0, 1.0, Some(100.0), None)), "nothing between its bounds"),
            (source(|v| v.normal = normal(1.0, 1.0, Some(2.0), Some(1.0))), "nothing between its bounds"),
            (source(|v| v.log_normal = normal(0.0, 1.0, None, None)), "a mean above 0"),
            (source(|v| v.log_normal = normal(1.0, -1.0, None, None)), "an sd above 0"),
            (source(|v| v.values = Some(Vec::new())), "at least one value"),
            (source(|v| v.log = Some(Range { from: -1.0, to: 1.0, points: 3 })), "above 0"),
            (source(|v| v.linear = Some(Range { from: 0.0, to: 1.0, points: 0 })), "from 1 to"),
            (source(|v| v.linear = Some(Range { from: 0.0, to: 0.0, points: 2 })), "must have a width"),
            (source(|v| v.expression = Some("1 +".into())), "ends where a value should be"),
        ] {
            let found = found.unwrap_err();
            assert!(found.contains(said), "{found}");
        }
    }
}
