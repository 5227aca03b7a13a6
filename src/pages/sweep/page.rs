//! The page of a sweep.

use super::pictures::Picture;
use crate::output::Records;
use crate::pages::facts::{figure, scene_rows, version};
use crate::report::explore::{Point, Points};
use crate::report::{Item, Report, Section, Table};
use crate::sweep::{Format, Kept, Record, Sensitivity, State, Status, Sweep};
use crate::vary::sensitivity::Interval;

/// Most rows of the table of points; `points.csv` has them all.
const MOST_ROWS: usize = 200;
/// Most points that can be gone through one by one: some hundred kB of page.
const MOST_POINTS: usize = 2000;

/// What was asked, how far it is, pictures, sensitivity, points.
pub fn page(sweep: &Sweep, records: &Records, status: &Status, pictures: &[Picture], command: &str) -> Report {
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
    items.extend(pictures.iter().map(|picture| {
        let what = if picture.is_curve { "with its 95 % interval" } else { "each dot a point" };
        let caption = format!("{} against {}, {what}.", picture.figure, picture.against);
        Item::picture(&picture.svg, &caption.clone(), caption)
    }));
    sections.push(Section { title: "Figures".into(), items });
    if sweep.asks_sensitivity() {
        sections.push(sensitivity(sweep, records));
    }
    sections.push(points(sweep, records));
    let one_by_one = Item::Points(one_by_one(sweep, records));
    sections.insert(1, Section { title: String::new(), items: vec![one_by_one] });
    let mut provenance = scene_rows(&sweep.base.scene.name, &sweep.base.sha256, &sweep.base.inputs());
    provenance.extend([version(), row("command", command.to_owned())]);
    let asked = &sweep.file.sweep.description;
    let summary = if asked.is_empty() { sweep.base.scene.description.clone() } else { asked.clone() };
    Report { title: format!("tirtouch: {}", sweep.name), summary, facts, sections, provenance }
}

fn within(interval: &Interval) -> String {
    format!("{} ({} to {})", figure(interval.value), figure(interval.low), figure(interval.high))
}

fn sensitivity(sweep: &Sweep, records: &Records) -> Section {
    let names = sweep.free_names();
    let mut items = Vec::new();
    for (figure_name, found) in sweep.sensitivity(records) {
        let (caption, columns, rows): (String, Vec<&str>, Vec<Vec<String>>) = match &found {
            Err(why) => {
                items.push(Item::Warning(format!("{figure_name}: no sensitivity: {why}.")));
                continue;
            }
            Ok(Sensitivity::Effects(all)) => (
                format!("{figure_name}: elementary effects over half of each range (95 % by resampling)"),
                vec!["variable", "mean of absolute effects", "mean", "spread"],
                (all.iter().zip(&names))
                    .map(|(one, name)| {
                        vec![(*name).to_owned(), within(&one.mean_absolute), within(&one.mean), figure(one.spread)]
                    })
                    .collect(),
            ),
            Ok(Sensitivity::Indices(all)) => (
                format!("{figure_name}: shares of its variance (95 % by resampling)"),
                vec!["variable", "alone", "with all others"],
                (all.iter().zip(&names))
                    .map(|(one, name)| vec![(*name).to_owned(), within(&one.first), within(&one.total)])
                    .collect(),
            ),
        };
        let columns = columns.into_iter().map(str::to_owned).collect();
        items.push(Item::Table(Table { caption, columns, rows }));
    }
    Section { title: "Sensitivity".into(), items }
}

/// What varies and what was measured of a point, in words.
fn cells_of(record: Option<&Record>, names: usize, columns: usize) -> Vec<String> {
    let value = |k: usize| {
        let value = record.and_then(|record| record.values.get(k));
        value.map_or("-".to_owned(), |value| value.number().map_or_else(|| value.to_string(), figure))
    };
    let told = |k: usize| {
        let told = record.and_then(|record| record.figures.get(k));
        match told.map(|told| (told.value, told.low, told.high)) {
            Some((Some(value), Some(low), Some(high))) => {
                format!("{} ± {}", figure(value), figure(0.5 * (high - low)))
            }
            Some((Some(value), ..)) => figure(value),
            _ => "-".to_owned(),
        }
    };
    (0..names).map(value).chain((0..columns).map(told)).collect()
}

/// The points that are done, with the images that lie beside the page.
fn one_by_one(sweep: &Sweep, records: &Records) -> Points {
    let owned = |name: &str| name.to_owned();
    let names: Vec<String> = sweep.plan.names().map(owned).chain(sweep.columns().map(owned)).collect();
    let [varied, measured] = [sweep.plan.names().count(), sweep.columns().count()];
    let images = |row: usize, record: &Record| match &sweep.file.sweep.images {
        Some(images) if images.format == Format::Png => {
            let load = |(_, depth_mm, force_n)| format!("{} mm, {} N", figure(depth_mm), figure(force_n));
            let place =
                |kept: &Kept| [format!("{}/{}", images.split(row), kept.file), kept.load.map(load).unwrap_or_default()];
            record.images.iter().map(place).collect()
        }
        _ => Vec::new(),
    };
    let point = |row: usize| {
        let record = sweep.record(records, row).filter(|record| record.status == State::Done)?;
        let values = cells_of(Some(&record), varied, measured);
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
    let count = sweep.plan.names().count();
    let rows = (0..sweep.plan.count().min(MOST_ROWS)).map(|row| {
        let record = sweep.record(records, row);
        let status = State::word(record.as_ref().map(|record| record.status));
        let cells = [row.to_string(), status.to_owned()].into_iter();
        cells.chain(cells_of(record.as_ref(), count, sweep.columns().count())).collect()
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
