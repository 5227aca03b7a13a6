//! What is said of a study: tables, pictures and words.

use super::PageError;
use super::facts::{columns, figure, interval, version};
use super::tables::table;
use crate::calibrate::FrameModel;
use crate::estimate::{Detected, Value};
use crate::report::{AxisName, Item, LogPlot, LogPoint, LogSeries, LogStyle, Report, Section, Table, log_plot};
use crate::statistics::RankHistogram;
use crate::study::{Quantity, Summary, Told, Trial, UnknownSummary};

/// A study, to be told of.
pub struct Page<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it is of.
    pub description: &'a str,
    /// What came out.
    pub summary: &'a Summary,
    /// The calibration.
    pub model: &'a FrameModel,
}

/// A quantity in words, and its unit.
fn named(name: &str) -> (&'static str, &'static str) {
    match name {
        "size_mm" => ("size", "mm"),
        "depth_mm" => ("depth to its top", "mm"),
        _ => ("Young's modulus", "kPa"),
    }
}

/// A share in percent, or why there is none.
fn percent(value: &Value) -> String {
    match value.scaled(100.0) {
        Value::Known { value, low, high } => {
            let (value, range) = interval(value, low, high);
            format!("{value} % ({range})")
        }
        Value::Undefined { reason } => format!("undefined: {reason}"),
    }
}

/// Every trial as a row: truth, estimates with their intervals, reasons.
pub fn csv(phantoms: &[Trial], empty: &[Trial]) -> Result<String, PageError> {
    let quantities = ["size_mm", "depth_mm", "youngs_kpa"];
    let ends = |name: &str| ["", "_low", "_high", "_undefined"].map(|end| format!("{name}{end}"));
    let mut heads = ["sweep", "row", "exposure"].map(str::to_owned).to_vec();
    heads.extend(quantities.map(|name| format!("true_{name}")));
    heads.extend(["phantom_youngs_kpa".to_owned(), "detected".to_owned()]);
    heads.extend(quantities.iter().flat_map(|name| ends(name)));
    let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    let of_sweep = |sweep: &'static str, trials: &'_ [Trial]| -> Vec<Vec<String>> {
        let row = |trial: &Trial| {
            let told = [&trial.estimates.size_mm, &trial.estimates.depth_mm, &trial.estimates.youngs_kpa];
            let truth = trial.truth.map(|truth| [truth.size_mm, truth.depth_mm, truth.youngs_kpa]);
            let mut cells = vec![sweep.to_owned(), trial.row.to_string(), trial.exposure.to_string()];
            cells.extend((0..3).map(|k| number(truth.map(|truth| truth[k]))));
            cells.push(number(trial.phantom_youngs_kpa));
            cells.push(match &trial.estimates.detected {
                Detected::Known(found) => found.to_string(),
                Detected::Undefined { undefined } => undefined.clone(),
            });
            cells.extend(told.into_iter().flat_map(|value| match value {
                Value::Known { value, low, high } => {
                    [value.to_string(), low.to_string(), high.to_string(), String::new()]
                }
                Value::Undefined { reason } => [String::new(), String::new(), String::new(), reason.clone()],
            }));
            cells
        };
        trials.iter().map(row).collect()
    };
    let rows = of_sweep("phantoms", phantoms).into_iter().chain(of_sweep("empty", empty));
    table("estimates.csv", heads, rows)
}

impl Page<'_> {
    /// In words.
    pub fn text(&self, out: &str) -> String {
        let row = |name: &str, value: String| (name.to_owned(), value);
        let mut rows = self.facts();
        for quantity in &self.summary.quantities {
            let (name, _) = named(quantity.name);
            let held = quantity.coverage.first().map_or(String::new(), |all| percent(&all.share));
            let told = match quantity.known {
                0 => "known of none".to_owned(),
                known => format!(
                    "known of {known}; median error {}; half width {}; intervals of 95 % hold {held}",
                    percent(&quantity.median_error),
                    quantity.median_half_width.map_or("-".into(), |half| format!("{} %", figure(100.0 * half))),
                ),
            };
            rows.push(row(name, told));
        }
        rows.push(row("folder", out.to_owned()));
        rows.push(row("report", format!("{out}/report.html")));
        format!("{}\n{}", self.name, columns(&rows))
    }

    fn facts(&self) -> Vec<(String, String)> {
        let row = |name: &str, value: String| (name.to_owned(), value);
        let found = |count: usize, share: &Value| match count {
            0 => "no phantoms".to_owned(),
            count => format!("found in {} of {count}", percent(share)),
        };
        vec![
            row("with an inclusion", found(self.summary.phantoms, &self.summary.found)),
            row("without", found(self.summary.empty, &self.summary.false_alarms)),
        ]
    }

    /// The page.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn report(&self, trials: &[Trial], command: &str) -> Result<Report, PageError> {
        let mut facts = self.facts();
        facts.push(("smallest found in 95 of 100".to_owned(), super::facts::said(&self.summary.smallest_mm, "mm")));
        let mut sections = vec![Section { title: "Errors".into(), items: vec![Item::Table(self.errors())] }];
        for (k, quantity) in self.summary.quantities.iter().enumerate() {
            sections.push(section(k, quantity, trials)?);
        }
        if !self.summary.unknowns.is_empty() {
            sections.push(Section { title: "All unknowns".into(), items: vec![Item::Table(self.unknowns())] });
        }
        let loads: Vec<String> = self.model.depths_mm.iter().map(f64::to_string).collect();
        let provenance = vec![
            version(),
            (
                "calibration".to_owned(),
                format!("of version {}, presses of {} mm", self.model.version, loads.join(", ")),
            ),
            ("command".to_owned(), command.to_owned()),
        ];
        let summary = self.description.to_owned();
        Ok(Report { title: format!("tirtouch: {}", self.name), summary, facts, sections, provenance })
    }

    /// All unknowns of the calibration, by their names.
    fn unknowns(&self) -> Table {
        let share = |value: Option<f64>| value.map_or("-".into(), |value| format!("{} %", figure(100.0 * value)));
        let row = |one: &UnknownSummary| {
            vec![
                one.name.clone(),
                format!("{} of {}", one.known, self.summary.phantoms),
                share(one.median_error),
                share(one.median_half_width),
                percent(&one.share),
            ]
        };
        Table {
            caption:
                "Every unknown of the calibration that the phantoms' sweep varies, by its name there; intervals where \
                      it is known"
                    .into(),
            columns: ["", "known of", "median error", "half width", "intervals that hold"].map(str::to_owned).to_vec(),
            rows: self.summary.unknowns.iter().map(row).collect(),
        }
    }

    /// Errors of all quantities.
    fn errors(&self) -> Table {
        let columns = ["", "known of", "bias", "median error", "root mean square", "half width", "intervals that hold"];
        let row = |quantity: &Quantity| {
            let (name, unit) = named(quantity.name);
            vec![
                name.to_owned(),
                format!("{} of {}", quantity.known, self.summary.phantoms),
                percent(&quantity.relative_bias),
                percent(&quantity.median_error),
                quantity.errors.map_or("-".into(), |errors| format!("{} {unit}", figure(errors.root_mean_square))),
                quantity.median_half_width.map_or("-".into(), |half| format!("{} %", figure(100.0 * half))),
                quantity.coverage.first().map_or("-".into(), |all| percent(&all.share)),
            ]
        };
        Table {
            caption: "Estimates against the truth, where they are known; in brackets intervals of 95 %".into(),
            columns: columns.map(str::to_owned).to_vec(),
            rows: self.summary.quantities.iter().map(row).collect(),
        }
    }
}

/// One quantity: true against estimated, coverage, ranks, repeats, reasons.
fn section(k: usize, quantity: &Quantity, trials: &[Trial]) -> Result<Section, PageError> {
    let (name, unit) = named(quantity.name);
    let mut items = Vec::new();
    let points: Vec<LogPoint> = trials
        .iter()
        .filter(|trial| trial.exposure == 0)
        .filter_map(|trial| {
            let truth = trial.truth?;
            let truth = [truth.size_mm, truth.depth_mm, truth.youngs_kpa][k];
            let told = [&trial.estimates.size_mm, &trial.estimates.depth_mm, &trial.estimates.youngs_kpa][k];
            match *told {
                Value::Known { value, low, high } => {
                    Some(LogPoint { bar: Some([low, high]), ..LogPoint::plain([truth, value]) })
                }
                Value::Undefined { .. } => None,
            }
        })
        .collect();
    if !points.is_empty() {
        let ends =
            points.iter().map(|point| point.at[0]).fold([f64::INFINITY, 0.0f64], |[a, b], x| [a.min(x), b.max(x)]);
        let svg = log_plot(&LogPlot {
            title: &format!("True and estimated {name}"),
            subtitle: "each point a phantom with its 95 % interval; the line: what is true",
            x: AxisName { quantity: &format!("true {name}"), unit },
            y: AxisName { quantity: &format!("estimated {name}"), unit },
            mark: "",
            series: vec![
                LogSeries { name: "estimated".into(), points, style: LogStyle::Points },
                LogSeries {
                    name: "true".into(),
                    points: ends.map(|x| LogPoint::plain([x, x])).to_vec(),
                    style: LogStyle::Line,
                },
            ],
        })?;
        items.push(Item::picture(&svg, &format!("Estimated against true {name}"), "Where an estimate is known."));
    }
    let rows = quantity
        .coverage
        .iter()
        .map(|group| vec![group.name.clone(), group.known.to_string(), group.held.to_string(), percent(&group.share)]);
    let columns = ["phantoms", "known of", "held in", "share"].map(str::to_owned).to_vec();
    items.push(Item::Table(Table {
        caption: "Intervals of 95 % that hold the truth".into(),
        columns,
        rows: rows.collect(),
    }));
    items.push(Item::Text(match &quantity.ranks {
        Told::Known(ranks) => ranks_said(ranks),
        Told::Undefined { undefined } => format!("No histogram of ranks: {undefined}."),
    }));
    let told = |name: &str, value: &Value, unit: &str| format!("{name}: {}. ", super::facts::said(value, unit));
    let mut more = told("Agreement of exposures, ICC(A,1)", &quantity.repeats, "");
    if let Told::Known(repeats) = &quantity.repeatability {
        more += &told("Standard error of a repeat", &repeats.standard_error, unit);
    }
    if let Told::Known(agreement) = &quantity.agreement {
        more += &told("Mean difference to the truth", &agreement.mean, unit);
        more += &told("Limits of agreement: low", &agreement.low_limit, unit);
        more += &told("high", &agreement.high_limit, unit);
    }
    match &quantity.conformal_factor {
        Told::Known(factor) => {
            more += &format!("Intervals {} times as wide would hold 95 % of these.", figure(*factor))
        }
        Told::Undefined { undefined } => more += &format!("No factor that intervals need: {undefined}."),
    }
    items.push(Item::Text(more));
    if !quantity.reasons.is_empty() {
        let rows =
            quantity.reasons.iter().map(|reason| vec![reason.why.clone(), reason.phantoms.to_string()]).collect();
        let columns = ["why it is undefined", "phantoms"].map(str::to_owned).to_vec();
        items.push(Item::Table(Table { caption: "Undefined".into(), columns, rows }));
    }
    let mut title = name.to_owned();
    title.get_mut(..1).map(str::make_ascii_uppercase);
    Ok(Section { title, items })
}

fn ranks_said(ranks: &RankHistogram) -> String {
    let counts: Vec<String> = ranks.counts.iter().map(usize::to_string).collect();
    format!(
        "Ranks of the truth among draws of the posterior, by tenths: {}. Even ranks would be as uneven with a \
         probability of {}; ranks at both ends say that intervals are too short, in the middle that they are too wide.",
        counts.join(", "),
        figure(ranks.p_value)
    )
}
