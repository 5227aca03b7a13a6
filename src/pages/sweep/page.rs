//! The page of a sweep.

use super::pictures::Drawn;
use crate::figure::Digits;
use crate::output::Records;
use crate::pages::PageError;
use crate::pages::facts::{figure, interval, scene_rows, version};
use crate::report::explore::{Point, Points};
use crate::report::{AxisName, Bar, BarPlot, Item, Report, Section, Table, bar_plot};
use crate::sweep::{Format, Kept, KeptLoad, Record, Sensitivity, State, Status, Sweep};
use crate::vary::Scalar;
use crate::vary::sensitivity::Interval;
use std::collections::BTreeMap;

/// Most rows of the table of points; `points.csv` has them all.
const MOST_ROWS: usize = 200;
/// Most reasons that are told.
const MOST_REASONS: usize = 20;
/// Most points that can be gone through one by one: some hundred kB of page.
const MOST_POINTS: usize = 2000;

/// What was asked, how far it is, pictures, sensitivity, points.
pub fn page(
    sweep: &Sweep,
    records: &Records,
    status: &Status,
    drawn: &Drawn,
    command: &str,
) -> Result<Report, PageError> {
    let row = |name: &str, value: String| (name.to_owned(), value);
    let share = 100.0 * status.ended() as f64 / status.points.max(1) as f64;
    let facts = vec![
        row("points", format!("{}, {} % ended", status.points, figure(share))),
        row("done", status.done.to_string()),
        row("rejected", status.rejected.to_string()),
        row("failed", status.failed.to_string()),
        row("varies", sweep.free_names().join(", ")),
        row("measured", sweep.columns().collect::<Vec<_>>().join(", ")),
    ];
    let mut sections = Vec::new();
    let mut items = Vec::new();
    if status.ended() < status.points {
        let missing = status.points - status.ended();
        items.push(Item::Warning(format!("{missing} points are not computed yet: this page is of the others.")));
    }
    items.extend(drawn.pictures.iter().map(|picture| {
        let caption = format!("{} against {}, {}.", picture.figure, picture.against, picture.said);
        Item::picture(&picture.svg, &caption.clone(), caption)
    }));
    if !drawn.left.is_empty() {
        items.push(Item::Text(format!("Not drawn: {}; points.csv has them.", drawn.left.join(", "))));
    }
    sections.push(Section { title: "Figures".into(), items });
    if sweep.asks_sensitivity() {
        sections.push(sensitivity(sweep, records)?);
    }
    if status.rejected + status.failed > 0 {
        sections.push(reasons(sweep, records));
    }
    sections.push(points(sweep, records));
    let one_by_one = Item::Points(one_by_one(sweep, records));
    sections.insert(1, Section { title: String::new(), items: vec![one_by_one] });
    let mut provenance = scene_rows(&sweep.base.scene.name, &sweep.base.sha256, &sweep.base.inputs());
    provenance.extend([version(), row("command", command.to_owned())]);
    let asked = &sweep.file.sweep.description;
    let summary = if asked.is_empty() { sweep.base.scene.description.clone() } else { asked.clone() };
    Ok(Report { title: format!("tirtouch: {}", sweep.name), summary, facts, sections, provenance })
}

/// Why points have no figures.
fn reasons(sweep: &Sweep, records: &Records) -> Section {
    let mut found: BTreeMap<(&str, String), Vec<usize>> = BTreeMap::new();
    for row in 0..sweep.plan.count() {
        if let Some(record) = sweep.record(records, row).filter(|record| record.status != State::Done) {
            let why = record.reason.unwrap_or_default();
            found.entry((State::word(Some(record.status)), why)).or_default().push(row);
        }
    }
    let mut found: Vec<_> = found.into_iter().collect();
    found.sort_by_key(|(_, rows)| std::cmp::Reverse(rows.len()));
    let mut items = Vec::new();
    if found.len() > MOST_REASONS {
        let left: usize = found[MOST_REASONS..].iter().map(|(_, rows)| rows.len()).sum();
        items.push(Item::Text(format!("{left} more points have other reasons: points.csv has them all.")));
        found.truncate(MOST_REASONS);
    }
    let shown = |rows: &[usize]| {
        let first = rows.iter().take(5).map(ToString::to_string).collect::<Vec<_>>().join(", ");
        if rows.len() > 5 { format!("{first} ...") } else { first }
    };
    let row = |((status, why), rows): ((&str, String), Vec<usize>)| {
        vec![status.to_owned(), rows.len().to_string(), shown(&rows), why]
    };
    let table = Table {
        caption: "Points without figures, by their reason".into(),
        columns: ["status", "points", "rows", "reason"].map(str::to_owned).to_vec(),
        rows: found.into_iter().map(row).collect(),
    };
    items.insert(0, Item::Table(table));
    Section { title: "Rejected and failed".into(), items }
}

fn within(interval: &Interval) -> String {
    format!("{} ({} to {})", figure(interval.value), figure(interval.low), figure(interval.high))
}

/// A bar of each kind for each variable; `lines` says what its intervals are.
fn bars(
    (figure, sweep): (&str, &Sweep),
    [quantity, lines]: [&str; 2],
    kinds: &[&str],
    rows: Vec<(&str, Vec<&Interval>)>,
) -> Result<Item, PageError> {
    let bar = |one: &&Interval| Bar { value: one.value, interval: [one.low, one.high] };
    let svg = bar_plot(&BarPlot {
        title: figure,
        subtitle: &format!("{}: {quantity}; lines: 95 % {lines}", sweep.name),
        x: AxisName { quantity, unit: "" },
        kinds: kinds.to_vec(),
        rows: rows.into_iter().map(|(name, all)| (name, all.iter().map(bar).collect())).collect(),
    })?;
    let caption = format!("{figure}: {quantity}.");
    Ok(Item::picture(&svg, &caption.clone(), caption))
}

/// What intervals of sensitivities are.
const TRAJECTORIES: &str = "over trajectories, with noise";
const RESAMPLING: &str = "by resampling, with noise";

fn sensitivity(sweep: &Sweep, records: &Records) -> Result<Section, PageError> {
    let names = sweep.free_names();
    let mut items = Vec::new();
    for (figure_name, found) in sweep.sensitivity(records) {
        let place = (figure_name, sweep);
        match &found {
            Ok(Sensitivity::Effects(all)) => {
                let rows = all.iter().zip(&names).map(|(one, name)| (*name, vec![&one.mean_absolute])).collect();
                items.push(bars(
                    place,
                    ["mean of absolute effects over half of each range", TRAJECTORIES],
                    &["effect"],
                    rows,
                )?);
            }
            Ok(Sensitivity::Indices(all)) => {
                let rows = all.iter().zip(&names).map(|(one, name)| (*name, vec![&one.first, &one.total])).collect();
                items.push(bars(place, ["share of the variance", RESAMPLING], &["alone", "with all others"], rows)?);
            }
            Err(_) => {}
        }
        let (caption, columns, rows): (String, Vec<&str>, Vec<Vec<String>>) = match &found {
            Err(why) => {
                items.push(Item::Warning(format!("{figure_name}: no sensitivity: {why}.")));
                continue;
            }
            Ok(Sensitivity::Effects(all)) => (
                format!("{figure_name}: elementary effects over half of each range (95 % {TRAJECTORIES})"),
                vec!["variable", "mean of absolute effects", "mean", "spread"],
                (all.iter().zip(&names))
                    .map(|(one, name)| {
                        vec![(*name).to_owned(), within(&one.mean_absolute), within(&one.mean), figure(one.spread)]
                    })
                    .collect(),
            ),
            Ok(Sensitivity::Indices(all)) => (
                format!("{figure_name}: shares of its variance (95 % {RESAMPLING})"),
                vec!["variable", "alone", "with all others"],
                (all.iter().zip(&names))
                    .map(|(one, name)| vec![(*name).to_owned(), within(&one.first), within(&one.total)])
                    .collect(),
            ),
        };
        let columns = columns.into_iter().map(str::to_owned).collect();
        items.push(Item::Table(Table { caption, columns, rows }));
    }
    Ok(Section { title: "Sensitivity".into(), items })
}

/// How the values of each variable are written: so that they are told apart.
fn digits(sweep: &Sweep) -> Vec<Digits> {
    let rows: Vec<Vec<Scalar>> = (0..sweep.plan.count().min(MOST_POINTS)).map(|row| sweep.plan.values(row)).collect();
    let of = |k: usize| Digits::of(rows.iter().filter_map(|values| values.get(k)?.number()));
    (0..sweep.plan.names().count()).map(of).collect()
}

/// What varies and what was measured of a point, in words.
fn cells_of(record: Option<&Record>, digits: &[Digits], columns: usize) -> Vec<String> {
    let value = |(k, digits): (usize, &Digits)| {
        let value = record.and_then(|record| record.values.get(k));
        let written = |value: &Scalar| value.number().map_or_else(|| value.to_string(), |n| digits.written(n));
        value.map_or("-".to_owned(), written)
    };
    let told = |k: usize| {
        let told = record.and_then(|record| record.figures.get(k));
        match told.map(|told| (told.value, told.low, told.high)) {
            Some((Some(value), Some(low), Some(high))) => {
                let (value, range) = interval(value, low, high);
                format!("{value} ({range})")
            }
            Some((Some(value), ..)) => figure(value),
            _ => "-".to_owned(),
        }
    };
    digits.iter().enumerate().map(value).chain((0..columns).map(told)).collect()
}

/// The points that are done, with the images that lie beside the page.
fn one_by_one(sweep: &Sweep, records: &Records) -> Points {
    let owned = |name: &str| name.to_owned();
    let names: Vec<String> = sweep.plan.names().map(owned).chain(sweep.columns().map(owned)).collect();
    let (digits, measured) = (digits(sweep), sweep.columns().count());
    let images = |row: usize, record: &Record| match &sweep.file.sweep.images {
        Some(images) if images.format == Format::Png => {
            let load = |load: KeptLoad| format!("{} mm, {} N", figure(load.depth_mm), figure(load.force_n));
            let place =
                |kept: &Kept| [format!("{}/{}", images.split(row), kept.file), kept.load.map(load).unwrap_or_default()];
            record.images.iter().map(place).collect()
        }
        _ => Vec::new(),
    };
    let point = |row: usize| {
        let record = sweep.record(records, row).filter(|record| record.status == State::Done)?;
        let values = cells_of(Some(&record), &digits, measured);
        Some(Point { row, values, images: images(row, &record) })
    };
    let along = match sweep.free_names()[..] {
        [only] => names.iter().position(|name| name == only),
        _ => None,
    };
    Points { names, along, points: (0..sweep.plan.count()).filter_map(point).take(MOST_POINTS).collect() }
}

fn points(sweep: &Sweep, records: &Records) -> Section {
    let columns = ["row".to_owned(), "status".to_owned()].into_iter();
    let columns = columns.chain(sweep.plan.names().map(str::to_owned)).chain(sweep.columns().map(str::to_owned));
    let digits = digits(sweep);
    let rows = (0..sweep.plan.count().min(MOST_ROWS)).map(|row| {
        let record = sweep.record(records, row);
        let status = State::word(record.as_ref().map(|record| record.status));
        let cells = [row.to_string(), status.to_owned()].into_iter();
        cells.chain(cells_of(record.as_ref(), &digits, sweep.columns().count())).collect()
    });
    let table = Table {
        caption: "Points, in the order of the design".into(),
        columns: columns.collect(),
        rows: rows.collect(),
    };
    let mut items = vec![Item::Table(table)];
    if sweep.plan.count() > MOST_ROWS {
        items.push(Item::Text(format!("The first {MOST_ROWS} of {}; points.csv has them all.", sweep.plan.count())));
    }
    Section { title: "Points".into(), items }
}
