//! What is said of a study of the TSIS paper's figures: its table beside the paper's, a picture, words.

use super::PageError;
use super::facts::{columns, figure, said, version};
use super::said::Said;
use super::tables::table;
use crate::estimate::{Stiffness, Value};
use crate::report::{AxisName, Item, LogPlot, LogPoint, LogSeries, LogStyle, Report, Section, Table, log_plot};
use crate::study::{PaperSummary, Phantom, Reading};
use serde_json::json;

/// A study of the paper's figures, to be told of.
pub struct PaperPage<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it is of.
    pub description: &'a str,
    /// What came out.
    pub summary: &'a PaperSummary,
}

/// A number that may be missing.
fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), figure)
}

/// Every image, or pair of images, as a row.
fn csv(readings: &[Reading]) -> Result<String, PageError> {
    let heads =
        ["row", "truth", "press_mm", "value", "undefined", "force_n", "pressure_kpa", "deformation", "warnings"];
    let cell = |value: Option<&Value>| value.and_then(Value::best).map(f64::to_string).unwrap_or_default();
    let row = |reading: &Reading| {
        let of = |pick: fn(&Stiffness) -> &Value| cell(reading.stiffness.as_ref().map(pick));
        let why = match &reading.value {
            Value::Known { .. } => String::new(),
            Value::Undefined { reason } => reason.clone(),
        };
        vec![
            reading.row.to_string(),
            reading.truth.to_string(),
            reading.press_mm.to_string(),
            cell(Some(&reading.value)),
            why,
            of(|found| &found.force_n),
            of(|found| &found.pressure_kpa),
            of(|found| &found.deformation),
            reading.warnings.join("; "),
        ]
    };
    table("readings.csv", heads.map(str::to_owned).to_vec(), readings.iter().map(row))
}

impl PaperPage<'_> {
    /// All that is said, of a folder `out`, by a command.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn said(&self, readings: &[Reading], out: &str, command: &str) -> Result<Said, PageError> {
        Ok(Said {
            table: ("readings.csv", csv(readings)?),
            report: self.report(readings, command)?,
            text: self.text(out),
            summary: json!(self.summary),
        })
    }

    /// In words.
    fn text(&self, out: &str) -> String {
        let [_, unit] = self.summary.figure.named();
        let [_, true_unit] = self.summary.figure.truth();
        let mut rows: Vec<(String, String)> = Vec::new();
        for phantom in &self.summary.phantoms {
            let told = format!(
                "{}; sd {}; known of {} of {}; ratio {}, published {}, true {}",
                said(&phantom.mean, unit),
                number(phantom.standard_deviation),
                phantom.known,
                phantom.readings,
                number(phantom.ratio),
                number(phantom.published_ratio),
                figure(phantom.true_ratio),
            );
            rows.push((format!("{} {true_unit}", phantom.truth), told));
            if phantom.warned > 0 {
                rows.push((String::new(), format!("{} of these with a warning: see readings.csv", phantom.warned)));
            }
        }
        rows.push(("order".to_owned(), self.order()));
        rows.push(("folder".to_owned(), out.to_owned()));
        rows.push(("report".to_owned(), format!("{out}/report.html")));
        format!("{}\n{}", self.name, columns(&rows))
    }

    /// Whether the order of means is the paper's, in words.
    fn order(&self) -> String {
        let follows = if self.summary.figure.rises() { "rise" } else { "fall" };
        let order = match self.summary.same_order {
            Some(true) => format!("means {follows} with the truth, as the paper's do"),
            Some(false) => "not the paper's: means do not follow the truth throughout".to_owned(),
            None => {
                return "undefined: the figure of an image is not known, and the mean of the others is not that of all"
                    .to_owned();
            }
        };
        match self.summary.apart {
            Some(true) => order,
            _ => format!("{order}; but intervals of neighbours overlap: the means do not tell it"),
        }
    }

    /// As one page.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    fn report(&self, readings: &[Reading], command: &str) -> Result<Report, PageError> {
        let [name, unit] = self.summary.figure.named();
        let [true_name, true_unit] = self.summary.figure.truth();
        let row = |phantom: &Phantom| {
            vec![
                format!("{} {true_unit}", phantom.truth),
                match phantom.warned {
                    0 => format!("{} of {}", phantom.known, phantom.readings),
                    warned => format!("{} of {}, {warned} with a warning", phantom.known, phantom.readings),
                },
                said(&phantom.mean, unit),
                number(phantom.standard_deviation),
                number(phantom.ratio),
                number(phantom.published_ratio),
                figure(phantom.true_ratio),
            ]
        };
        let heads = ["", "known of", "mean", "sd", "ratio", "published", "true"];
        let means = Table {
            caption: format!(
                "{name}, in {unit}: mean, its interval of 95 %, standard deviation; ratios of means to the first"
            ),
            columns: heads.map(str::to_owned).to_vec(),
            rows: self.summary.phantoms.iter().map(row).collect(),
        };
        let mut items = vec![Item::Table(means), Item::Text(format!("Order: {}.", self.order()))];
        let first = self.summary.phantoms.first().and_then(|phantom| phantom.mean.best().copied());
        let point = |phantom: &Phantom| Some(LogPoint::plain([phantom.truth, *phantom.mean.best()?]));
        let published = |phantom: &Phantom| Some(LogPoint::plain([phantom.truth, first? * phantom.published_ratio?]));
        let series = |name: &str, points: Vec<LogPoint>, style| LogSeries { name: name.into(), points, style };
        let of_readings = readings.iter().filter_map(|reading| {
            let value = reading.value.best().copied().filter(|value| *value > 0.0)?;
            Some(LogPoint::plain([reading.truth, value]))
        });
        let series = vec![
            series("images", of_readings.collect(), LogStyle::Points),
            series("means", self.summary.phantoms.iter().filter_map(point).collect(), LogStyle::Line),
            series(
                "published ratios, from the first mean",
                self.summary.phantoms.iter().filter_map(published).collect(),
                LogStyle::Line,
            ),
        ];
        let series: Vec<LogSeries> = series.into_iter().filter(|series| !series.points.is_empty()).collect();
        if !series.is_empty() {
            let svg = log_plot(&LogPlot {
                title: name,
                subtitle: "each dot an image or a pair of images; lines join means",
                x: AxisName { quantity: &format!("true {true_name}"), unit: true_unit },
                y: AxisName { quantity: name, unit },
                mark: "",
                series,
            })?;
            items.push(Item::picture(&svg, &format!("{name} against the true {true_name}"), "Where it is known."));
        }
        let provenance = vec![version(), ("command".to_owned(), command.to_owned())];
        let sections = vec![Section { title: "The figure and the truth".into(), items }];
        let summary = self.description.to_owned();
        Ok(Report { title: format!("tirtouch: {}", self.name), summary, facts: Vec::new(), sections, provenance })
    }
}
