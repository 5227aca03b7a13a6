//! Figures of a sweep against what varies.

use crate::figure::Digits;
use crate::output::Records;
use crate::pages::PageError;
use crate::report::{AxisName, Curve, CurvePlot, CurveStyle, HeatMap, curve_plot, heat_map};
use crate::sweep::{State, Sweep};
use crate::vary::Scalar;
use std::collections::{BTreeMap, BTreeSet};

/// Most curves in one picture, and most pictures of one figure.
pub const MOST: usize = 6;

/// One picture.
pub struct Picture {
    /// The figure.
    pub figure: &'static str,
    /// What it is drawn against.
    pub against: String,
    /// The picture.
    pub svg: String,
    /// How it is read.
    pub said: &'static str,
}

/// A point with the figure: value of each variable, the figure, its interval.
struct Seen {
    values: Vec<Scalar>,
    value: f64,
    interval: Option<[f64; 2]>,
}

/// Pictures of every figure. One axis: a curve with its band. Two, of which one has few values: a curve for each of
/// them; a grid of many values: a map. Else: the figure against each variable, one dot a point.
pub fn draw(sweep: &Sweep, records: &Records) -> Result<Vec<Picture>, PageError> {
    let names: Vec<&str> = sweep.plan.names().collect();
    let done: Vec<_> = (0..sweep.plan.count())
        .filter_map(|row| sweep.record(records, row).filter(|record| record.status == State::Done))
        .collect();
    let free = sweep.plan.free();
    // Of a table of points, what changes.
    let free: Vec<usize> = match free.is_empty() {
        true => (0..names.len())
            .filter(|&k| done.iter().any(|one| one.values.get(k) != done.first().and_then(|first| first.values.get(k))))
            .collect(),
        false => free,
    };
    let mut pictures = Vec::new();
    for (k, name) in sweep.columns().enumerate() {
        let seen: Vec<Seen> = done
            .iter()
            .filter_map(|record| {
                let told = record.figures.get(k)?;
                let interval = told.low.zip(told.high).map(|(low, high)| [low, high]);
                Some(Seen { values: record.values.clone(), value: told.value?, interval })
            })
            .collect();
        if seen.is_empty() {
            continue;
        }
        let one = Drawing { sweep: &sweep.name, figure: name, seen: &seen, names: &names };
        match free[..] {
            [x] if one.is_numeric(x) => pictures.push(one.curves(x, None)?),
            [a, b] if one.is_numeric(a) && one.few(b) => pictures.push(one.curves(a, Some(b))?),
            [a, b] if one.is_numeric(b) && one.few(a) => pictures.push(one.curves(b, Some(a))?),
            [a, b] if one.is_grid(a, b) => pictures.push(one.map(a, b)?),
            _ => {
                for &x in free.iter().filter(|&&x| one.is_numeric(x)).take(MOST) {
                    pictures.push(one.dots(x)?);
                }
            }
        }
    }
    Ok(pictures)
}

struct Drawing<'a> {
    sweep: &'a str,
    figure: &'static str,
    seen: &'a [Seen],
    names: &'a [&'a str],
}

impl Drawing<'_> {
    fn is_numeric(&self, variable: usize) -> bool {
        self.seen.iter().all(|seen| seen.values.get(variable).is_some_and(|value| value.number().is_some()))
    }

    /// Whether a variable takes few values.
    fn few(&self, variable: usize) -> bool {
        self.groups(Some(variable)).len() <= MOST
    }

    /// Whether there is a point for most pairs of values of two variables of numbers, and for none two.
    fn is_grid(&self, a: usize, b: usize) -> bool {
        let count = |variable: usize| self.groups(Some(variable)).len();
        let pairs: BTreeSet<_> = self.seen.iter().map(|seen| [a, b].map(|k| self.x(seen, k).to_bits())).collect();
        let all = self.seen.len();
        self.is_numeric(a) && self.is_numeric(b) && pairs.len() == all && count(a) * count(b) <= 2 * all
    }

    /// Points by the value of a variable, in the order in which values come.
    fn groups(&self, by: Option<usize>) -> Vec<(String, Vec<&Seen>)> {
        let values = |by: usize| self.seen.iter().filter_map(move |seen| seen.values.get(by)?.number());
        let digits = by.map(|by| Digits::of(values(by)));
        let mut groups: Vec<(String, Vec<&Seen>)> = Vec::new();
        let mut places = BTreeMap::new();
        for seen in self.seen {
            let value = by.and_then(|by| seen.values.get(by));
            let name = value.map_or(String::new(), |value| match (value.number(), digits) {
                (Some(number), Some(digits)) => digits.written(number),
                _ => value.to_string(),
            });
            let place = *places.entry(name.clone()).or_insert_with(|| {
                groups.push((name, Vec::new()));
                groups.len() - 1
            });
            groups[place].1.push(seen);
        }
        groups
    }

    fn x(&self, seen: &Seen, variable: usize) -> f64 {
        seen.values.get(variable).and_then(Scalar::number).unwrap_or(0.0)
    }

    fn name(&self, variable: usize) -> &str {
        self.names.get(variable).copied().unwrap_or("")
    }

    fn curves(&self, x: usize, by: Option<usize>) -> Result<Picture, PageError> {
        let curves = self.groups(by).into_iter().map(|(value, mut seen)| {
            seen.sort_by(|a, b| self.x(a, x).total_cmp(&self.x(b, x)));
            let name = by.map_or(String::new(), |by| format!("{} = {value}", self.name(by)));
            let band = seen.iter().filter_map(|seen| seen.interval.map(|[low, high]| [self.x(seen, x), low, high]));
            Curve {
                name,
                points: seen.iter().map(|seen| [self.x(seen, x), seen.value]).collect(),
                band: band.collect(),
                style: CurveStyle::Line,
            }
        });
        self.plot(x, curves.collect(), "band: 95 % interval", "with its 95 % interval")
    }

    fn dots(&self, x: usize) -> Result<Picture, PageError> {
        let points = self.seen.iter().map(|seen| [self.x(seen, x), seen.value]).collect();
        let curve = Curve { name: String::new(), points, band: Vec::new(), style: CurveStyle::Points };
        self.plot(x, vec![curve], "one dot a point; the other variables change too", "each dot a point")
    }

    fn map(&self, x: usize, y: usize) -> Result<Picture, PageError> {
        let against = format!("{} and {}", self.name(x), self.name(y));
        let svg = heat_map(&HeatMap {
            title: self.figure,
            subtitle: &format!("{}: against {against}; a cell a point", self.sweep),
            x: AxisName { quantity: self.name(x), unit: "" },
            y: AxisName { quantity: self.name(y), unit: "" },
            z: AxisName { quantity: self.figure, unit: "" },
            points: self.seen.iter().map(|seen| [self.x(seen, x), self.x(seen, y), seen.value]).collect(),
        })?;
        Ok(Picture { figure: self.figure, against, svg, said: "each cell a point" })
    }

    fn plot(&self, x: usize, curves: Vec<Curve>, shown: &str, said: &'static str) -> Result<Picture, PageError> {
        let svg = curve_plot(&CurvePlot {
            title: self.figure,
            subtitle: &format!("{}: against {}; {shown}", self.sweep, self.name(x)),
            x: AxisName { quantity: self.name(x), unit: "" },
            y: AxisName { quantity: self.figure, unit: "" },
            curves,
            highest: None,
            from_zero: false,
        })?;
        Ok(Picture { figure: self.figure, against: self.name(x).to_owned(), svg, said })
    }
}
