//! Figures of a sweep against what varies.

use crate::figure::Digits;
use crate::output::Records;
use crate::pages::PageError;
use crate::report::{AxisName, Bar, BarPlot, Curve, CurvePlot, CurveStyle, HeatMap, bar_plot, curve_plot, heat_map};
use crate::sweep::{State, Sweep};
use crate::vary::Scalar;
use std::collections::{BTreeMap, BTreeSet};

/// Most curves in one picture, and most pictures of one figure.
const MOST: usize = 6;
/// Most bars in one picture.
const MOST_BARS: usize = 48;

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

/// What is drawn, and variables that are not.
pub struct Drawn {
    /// Pictures of every figure.
    pub pictures: Vec<Picture>,
    /// Variables that change and are in no picture of a figure.
    pub left: Vec<String>,
}

/// Pictures of every figure. One axis: a curve with its band. Others beside it, with few sets of values: a curve for
/// each of them; a grid of two with many values: a map. Choices alone: a bar a point. Else: the figure against each
/// variable of numbers, one dot a point.
pub fn draw(sweep: &Sweep, records: &Records) -> Result<Drawn, PageError> {
    let names: Vec<&str> = sweep.plan.names().collect();
    let done: Vec<_> = (0..sweep.plan.count())
        .filter_map(|row| sweep.record(records, row).filter(|record| record.status == State::Done))
        .collect();
    let free = sweep.plan.free();
    // What changes: a list of one value does not, and a table of points has columns alone.
    let first = |k: usize| done.first().and_then(|first| first.values.get(k));
    let changes = |&k: &usize| done.len() < 2 || done.iter().any(|one| one.values.get(k) != first(k));
    let free: Vec<usize> = if free.is_empty() { (0..names.len()).collect() } else { free };
    let free: Vec<usize> = free.into_iter().filter(changes).collect();
    let (mut pictures, mut drawn, mut has_figures) = (Vec::new(), BTreeSet::new(), false);
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
        has_figures = true;
        let one = Drawing { sweep: &sweep.name, figure: name, seen: &seen, names: &names };
        match (one.along(&free), &free[..]) {
            (Some((x, by)), _) => pictures.push(one.curves(x, &by)?),
            (None, &[a, b]) if one.is_grid(a, b) => pictures.push(one.map(a, b)?),
            (None, [_, ..]) if !free.iter().any(|&x| one.is_numeric(x)) => match seen.len() <= MOST_BARS {
                true => pictures.push(one.bars(&free)?),
                false => continue,
            },
            _ => {
                for &x in free.iter().filter(|&&x| one.is_numeric(x)).take(MOST) {
                    pictures.push(one.dots(x)?);
                    drawn.insert(x);
                }
                continue;
            }
        }
        drawn.extend(&free);
    }
    let left = free
        .iter()
        .filter(|k| has_figures && !drawn.contains(k))
        .filter_map(|&k| names.get(k).map(|name| (*name).to_owned()));
    Ok(Drawn { pictures, left: left.collect() })
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

    /// The variable of numbers that takes most values, and the others, where these take few sets of values, of which
    /// each makes a curve.
    fn along(&self, free: &[usize]) -> Option<(usize, Vec<usize>)> {
        let numbers = free.iter().copied().filter(|&x| self.is_numeric(x));
        let x = numbers.max_by_key(|&x| (self.groups(&[x]).len(), std::cmp::Reverse(x)))?;
        let by: Vec<usize> = free.iter().copied().filter(|&k| k != x).collect();
        let curves = self.groups(&by).len();
        (curves <= MOST && (by.is_empty() || self.seen.len() >= 2 * curves)).then_some((x, by))
    }

    /// Whether there is a point for most pairs of values of two variables of numbers, and for none two.
    fn is_grid(&self, a: usize, b: usize) -> bool {
        let count = |variable: usize| self.groups(&[variable]).len();
        let pairs: BTreeSet<_> = self.seen.iter().map(|seen| [a, b].map(|k| self.x(seen, k).to_bits())).collect();
        let all = self.seen.len();
        self.is_numeric(a) && self.is_numeric(b) && pairs.len() == all && count(a) * count(b) <= 2 * all
    }

    /// Points by the values of variables, in the order in which these come.
    fn groups(&self, by: &[usize]) -> Vec<(String, Vec<&Seen>)> {
        let values = |by: usize| self.seen.iter().filter_map(move |seen| seen.values.get(by)?.number());
        let digits: Vec<(usize, Digits)> = by.iter().map(|&by| (by, Digits::of(values(by)))).collect();
        let written = |seen: &Seen, (by, digits): &(usize, Digits)| -> Option<String> {
            let value = seen.values.get(*by)?;
            let value = value.number().map_or_else(|| value.to_string(), |number| digits.written(number));
            Some(format!("{} = {value}", self.name(*by)))
        };
        let mut groups: Vec<(String, Vec<&Seen>)> = Vec::new();
        let mut places = BTreeMap::new();
        for seen in self.seen {
            let name = digits.iter().filter_map(|one| written(seen, one)).collect::<Vec<_>>().join(", ");
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

    fn curves(&self, x: usize, by: &[usize]) -> Result<Picture, PageError> {
        let curves = self.groups(by).into_iter().map(|(name, mut seen)| {
            seen.sort_by(|a, b| self.x(a, x).total_cmp(&self.x(b, x)));
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

    /// A bar a point, named by its values.
    fn bars(&self, variables: &[usize]) -> Result<Picture, PageError> {
        let name = |seen: &Seen| {
            let values = variables.iter().filter_map(|&k| seen.values.get(k)).map(ToString::to_string);
            values.collect::<Vec<_>>().join(", ")
        };
        let names: Vec<String> = self.seen.iter().map(name).collect();
        let bar = |seen: &Seen| Bar { value: seen.value, interval: seen.interval.unwrap_or([seen.value; 2]) };
        let against = variables.iter().map(|&k| self.name(k)).collect::<Vec<_>>().join(", ");
        let svg = bar_plot(&BarPlot {
            title: self.figure,
            subtitle: &format!("{}: against {against}; lines: 95 % intervals", self.sweep),
            x: AxisName { quantity: self.figure, unit: "" },
            kinds: vec![self.figure],
            rows: names.iter().map(String::as_str).zip(self.seen.iter().map(|seen| vec![bar(seen)])).collect(),
        })?;
        Ok(Picture { figure: self.figure, against, svg, said: "each bar a point with its 95 % interval" })
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
