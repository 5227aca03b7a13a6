//! What is said of a sweep: tables, and words.

mod dataset;
mod page;
#[cfg(feature = "parquet")]
mod parquet;
mod pictures;
mod table;

pub use table::{Points, points};

use super::PageError;
use super::facts::{columns, figure};
use crate::output::Records;
use crate::sweep::{Status, Sweep};

/// Writes the tables, the labels of a data set and the report of whatever records are there, which `command` made. Of
/// several workers that come to their end one writes after the other: what is there last is of all records.
///
/// # Errors
/// A file that cannot be written, a picture that cannot be drawn.
pub fn write(sweep: &Sweep, records: &Records, command: &str) -> Result<Status, PageError> {
    records.in_turn(|| write_all(sweep, records, command))
}

fn write_all(sweep: &Sweep, records: &Records, command: &str) -> Result<Status, PageError> {
    records.write("points.csv", &table::points_csv(sweep, records)?)?;
    #[cfg(feature = "parquet")]
    records.write_bytes("points.parquet", &parquet::points_parquet(&points(sweep, records))?)?;
    records.write("times.csv", &table::times_csv(sweep, records)?)?;
    if sweep.asks_sensitivity() {
        records.write("sensitivity.csv", &table::sensitivity_csv(sweep, records)?)?;
    }
    if let Some(images) = &sweep.file.sweep.images {
        for split in ["train", "test"] {
            if sweep.kept(records).any(|(row, _)| images.split(row) == split) {
                let labels = dataset::metadata_csv(sweep, images, records, split)?;
                records.write(&format!("{split}/metadata.csv"), &labels)?;
            }
        }
        records.write("README.md", &dataset::card(sweep, images, records))?;
    }
    let status = Status::of(sweep, records);
    let drawn = pictures::draw(sweep, records)?;
    records.write("report.html", &page::page(sweep, records, &status, &drawn, command)?.to_html())?;
    Ok(status)
}

/// How far a sweep is, in words.
pub fn text(sweep: &Sweep, status: &Status, place: &str) -> String {
    let row = |name: &str, value: String| (name.to_owned(), value);
    let share = 100.0 * status.ended() as f64 / status.points.max(1) as f64;
    let mut rows = vec![
        row("points", format!("{}, {} % ended", status.points, figure(share))),
        row("done", status.done.to_string()),
        row("rejected", format!("{}: they break a constraint or a rule of scenes", status.rejected)),
        row("failed", status.failed.to_string()),
    ];
    if status.damaged > 0 {
        rows.push(row("damaged", format!("{} records cannot be read and are computed again", status.damaged)));
    }
    if status.workers > 0 {
        rows.push(row("workers", format!("{} at work", status.workers)));
    }
    let table = match status.tables {
        true => "points.csv has a row for each point, with its reason",
        false => "`sweep collect` writes its tables",
    };
    rows.push(row("folder", format!("{place}: {table}")));
    format!("{}\n{}", sweep.name, columns(&rows))
}
