//! What is said of a study: tables, pictures and words.

use super::PageError;
use super::facts::{columns, figure, interval, version};
use super::paper_study::PaperPage;
use super::said::Said;
use super::tables::table;
use crate::calibrate::FrameModel;
use crate::estimate::{Detected, Value};
use crate::progress::Stage;
use crate::report::{AxisName, Item, LogPlot, LogPoint, LogSeries, LogStyle, Report, Section, Table, log_plot};
use crate::statistics::RankHistogram;
use crate::study::{Parts, Quantity, Reader, Smallest, Summary, Told, Trial, UnknownSummary, readings, trials};
use serde_json::json;
use std::path::PathBuf;

/// A study, to be told of.
struct Page<'a> {
    /// Its name.
    name: &'a str,
    /// What it is of.
    description: &'a str,
    /// What came out.
    summary: &'a Summary,
    /// The calibration.
    model: &'a FrameModel,
}

/// Folders of a study's sweeps.
pub struct Folders {
    /// Phantoms with an inclusion.
    pub phantoms: PathBuf,
    /// Phantoms without, where they are asked for.
    pub empty: Option<PathBuf>,
}

/// What a study is.
pub struct About<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its file.
    pub parts: &'a Parts,
    /// Its own folder, as it is said.
    pub out: &'a str,
    /// The command that asked for it.
    pub command: &'a str,
}

impl About<'_> {
    /// What the images of its sweeps say by a reader; none where `observe` says no.
    ///
    /// # Errors
    /// Folders that cannot be read so, a picture that cannot be drawn.
    pub fn said(
        &self,
        reader: &Reader,
        folders: &Folders,
        observe: &(dyn Fn(Stage) -> bool + Sync),
    ) -> Result<Option<Said>, PageError> {
        let &Self { name, parts, out, command } = self;
        let sweeps = if folders.empty.is_some() { 2.0 } else { 1.0 };
        let heard = |before: f64| {
            move |done: usize, all: usize| {
                let share = (before + done as f64 / all.max(1) as f64) / sweeps;
                observe(Stage { done: share, what: &format!("phantom {done} of {all}") })
            }
        };
        let description = &parts.description;
        match reader {
            Reader::Paper(paper, calibration) => {
                let found = readings(&folders.phantoms, paper, calibration.as_ref(), parts.exposure_ms, &heard(0.0))?;
                let Some(found) = found else { return Ok(None) };
                let page = PaperPage { name, description, summary: &paper.summary(&found) };
                page.said(&found, out, command).map(Some)
            }
            Reader::Model(model) => {
                let phantoms = trials(model, &folders.phantoms, parts.how(false), &heard(0.0))?;
                let empty = match &folders.empty {
                    Some(folder) if phantoms.is_some() => trials(model, folder, parts.how(true), &heard(1.0))?,
                    _ => Some(Vec::new()),
                };
                let (Some(phantoms), Some(empty)) = (phantoms, empty) else { return Ok(None) };
                let summary = Summary::of(&phantoms, &empty)?;
                Page { name, description, summary: &summary, model }.said(&phantoms, &empty, out, command).map(Some)
            }
        }
    }
}

/// A quantity in words, and its unit.
fn named(name: &str) -> (&'static str, &'static str) {
    match name {
        "size_mm" => ("size", "mm"),
        "depth_mm" => ("depth to its top", "mm"),
        _ => ("Young's modulus", "kPa"),
    }
}

/// A share in percent, or a dash.
fn share(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{} %", figure(100.0 * value)))
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
fn csv(phantoms: &[Trial], empty: &[Trial]) -> Result<String, PageError> {
    let quantities = ["size_mm", "depth_mm", "youngs_kpa"];
    let ends = |name: &str| ["", "_low", "_high", "_undefined"].map(|end| format!("{name}{end}"));
    let mut heads = ["sweep", "row", "exposure"].map(str::to_owned).to_vec();
    heads.extend(quantities.map(|name| format!("true_{name}")));
    heads.extend(["phantom_youngs_kpa".to_owned(), "detected".to_owned()]);
    heads.extend(quantities.iter().flat_map(|name| ends(name)));
    heads.extend(quantities.map(|name| format!("{name}_bound")));
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
            cells.extend((0..3).map(|k| number(truth.zip(trial.bounds[k]).map(|(truth, bound)| truth[k] * bound))));
            cells
        };
        trials.iter().map(row).collect()
    };
    let rows = of_sweep("phantoms", phantoms).into_iter().chain(of_sweep("empty", empty));
    table("estimates.csv", heads, rows)
}

impl Page<'_> {
    /// All that is said, of a folder `out`, by a command.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    fn said(&self, phantoms: &[Trial], empty: &[Trial], out: &str, command: &str) -> Result<Said, PageError> {
        Ok(Said {
            table: ("estimates.csv", csv(phantoms, empty)?),
            report: self.report(phantoms, command)?,
            text: self.text(out),
            summary: json!(self.summary),
        })
    }

    /// In words.
    fn text(&self, out: &str) -> String {
        let row = |name: &str, value: String| (name.to_owned(), value);
        let mut rows = self.facts();
        let told = |known: usize, error: String, half: Option<f64>, held: String| match known {
            0 => "known of none".to_owned(),
            _ => format!(
                "known of {known}; median error {error}; half width {}; intervals of 95 % hold {held}",
                share(half)
            ),
        };
        for quantity in self.quantities().map(|(_, quantity)| quantity) {
            let held = quantity.coverage.first().map_or(String::new(), |all| percent(&all.share));
            let error = percent(&quantity.median_error);
            rows.push(row(named(quantity.name).0, told(quantity.known, error, quantity.median_half_width, held)));
        }
        for one in self.others() {
            let error = share(one.median_error);
            rows.push(row(&one.name, told(one.known, error, one.median_half_width, percent(&one.share))));
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
        if self.quantities().next().is_none() {
            return vec![row("presses", self.summary.phantoms.to_string())];
        }
        vec![
            row("with an inclusion", found(self.summary.phantoms, &self.summary.found)),
            row("without", found(self.summary.empty, &self.summary.false_alarms)),
        ]
    }

    /// Size, depth and modulus, as far as the calibration varies them, each with its place among the three.
    fn quantities(&self) -> impl Iterator<Item = (usize, &Quantity)> {
        self.summary.quantities.iter().enumerate().filter(|(k, _)| self.model.unknown(*k).is_some())
    }

    /// Unknowns that are none of these.
    fn others(&self) -> impl Iterator<Item = &UnknownSummary> {
        let is_told = |name: &str| (0..3).any(|figure| self.model.name(figure) == Some(name));
        self.summary.unknowns.iter().filter(move |one| !is_told(&one.name))
    }

    /// The page.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    fn report(&self, trials: &[Trial], command: &str) -> Result<Report, PageError> {
        let (mut facts, mut sections) = (self.facts(), Vec::new());
        if self.quantities().next().is_some() {
            facts.push(("smallest found in 95 of 100".to_owned(), super::facts::said(&self.summary.smallest_mm, "mm")));
            let mut items = vec![Item::Table(self.errors()), Item::Table(self.bounds())];
            items.extend((!self.summary.smallest_by_depth.is_empty()).then(|| Item::Table(self.smallest())));
            sections.push(Section { title: "Errors".into(), items });
        }
        for (k, quantity) in self.quantities() {
            sections.push(section(k, quantity, trials)?);
        }
        if !self.summary.unknowns.is_empty() {
            let mut items = vec![Item::Table(self.unknowns())];
            for one in self.others() {
                let of = |trial: &Trial| {
                    let other = trial.others.iter().find(|other| other.name == one.name)?;
                    point(other.truth, &other.value)
                };
                let first = trials.iter().filter(|trial| trial.exposure == 0);
                items.extend(picture(&one.name, "", first.filter_map(of).collect())?);
            }
            sections.push(Section { title: "All unknowns".into(), items });
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

    /// Errors of all quantities over what their frames could tell at best.
    fn bounds(&self) -> Table {
        let columns = ["", "median bound", "bound below 20 % of", "error over bound"];
        let row = |quantity: &Quantity| {
            vec![
                named(quantity.name).0.to_owned(),
                share(quantity.median_bound),
                format!("{} of {} known", quantity.bounded, quantity.known),
                super::facts::said(&quantity.error_over_bound, ""),
            ]
        };
        Table {
            caption: "Errors over the Cramér-Rao bound, root mean square where that is below 20 %: by noise of camera \
                      and light, powers of LEDs, and forces where they are told, without the calibration's own error; \
                      1 is the least that unbiased estimates reach"
                .into(),
            columns: columns.map(str::to_owned).to_vec(),
            rows: self.quantities().map(|(_, quantity)| row(quantity)).collect(),
        }
    }

    /// The smallest that is found, by depth.
    fn smallest(&self) -> Table {
        let row =
            |one: &Smallest| vec![one.name.clone(), one.told.to_string(), super::facts::said(&one.smallest_mm, "mm")];
        Table {
            caption: "The smallest diameter that is found in 95 of 100".into(),
            columns: ["phantoms", "told of", "diameter"].map(str::to_owned).to_vec(),
            rows: self.summary.smallest_by_depth.iter().map(row).collect(),
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
                share(quantity.median_half_width),
                quantity.coverage.first().map_or("-".into(), |all| percent(&all.share)),
            ]
        };
        Table {
            caption: "Estimates against the truth, where they are known; in brackets intervals of 95 %".into(),
            columns: columns.map(str::to_owned).to_vec(),
            rows: self.quantities().map(|(_, quantity)| row(quantity)).collect(),
        }
    }
}

/// True against estimated, where an estimate is known.
fn picture(name: &str, unit: &'static str, points: Vec<LogPoint>) -> Result<Option<Item>, PageError> {
    if points.is_empty() {
        return Ok(None);
    }
    let ends = points.iter().map(|point| point.at[0]).fold([f64::INFINITY, 0.0f64], |[a, b], x| [a.min(x), b.max(x)]);
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
    Ok(Some(Item::picture(&svg, &format!("Estimated against true {name}"), "Where an estimate is known.")))
}

/// A truth, and what is told of it; none where a logarithm cannot show it.
fn point(truth: f64, told: &Value) -> Option<LogPoint> {
    match *told {
        Value::Known { value, low, high } if truth.min(low) > 0.0 => {
            Some(LogPoint { bar: Some([low, high]), ..LogPoint::plain([truth, value]) })
        }
        _ => None,
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
            point(truth, [&trial.estimates.size_mm, &trial.estimates.depth_mm, &trial.estimates.youngs_kpa][k])
        })
        .collect();
    items.extend(picture(name, unit, points)?);
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::calibrate::ready;
    use crate::estimate::Estimates;
    use crate::study::Other;
    use std::path::Path;

    fn trial(row: usize) -> Trial {
        let value = Value::known(5.1, 4.8, 5.4);
        Trial {
            row,
            exposure: 0,
            truth: None,
            phantom_youngs_kpa: Some(5.0),
            estimates: Estimates::undefined("nothing is asked of it"),
            ranks: [None; 3],
            bounds: [None; 3],
            others: vec![Other { name: "contact".into(), truth: 5.0, value }],
        }
    }

    /// A study of a sensor's own numbers says nothing of an inclusion that nobody asked for.
    #[test]
    fn what_a_calibration_does_not_vary_is_left_out() {
        let of_inclusions = ready().unwrap();
        let text = serde_json::to_string(of_inclusions).unwrap();
        let bench = text.replace(r#""roles":["size","depth","youngs","#, r#""roles":["other","other","other","#);
        let bench = FrameModel::parse(&bench, Path::new("bench.json")).unwrap();
        let trials: Vec<Trial> = (0..20).map(trial).collect();
        let summary = Summary::of(&trials, &[]).unwrap();
        let told = |model: &FrameModel| {
            let page = Page { name: "bench", description: "", summary: &summary, model };
            let report = page.report(&trials, "").unwrap();
            (page.text("out"), report.sections.iter().map(|section| section.title.clone()).collect::<Vec<_>>())
        };
        let (text, sections) = told(&bench);
        assert!(text.contains("presses") && text.contains("20") && !text.contains("depth"), "{text}");
        assert!(text.contains("contact") && text.contains("known of 20; median error 2 %; half width 6 %"), "{text}");
        assert_eq!(sections, ["All unknowns"]);
        let (text, sections) = told(of_inclusions);
        assert!(text.contains("with an inclusion") && text.contains("depth to its top"), "{text}");
        assert!(sections.len() > 3 && sections[0] == "Errors", "{sections:?}");
    }
}
