//! What is said of a sweep: tables, and words.

pub mod dataset;
pub mod page;
pub mod pictures;
pub mod table;

use super::facts::{columns, figure};
use crate::sweep::{Status, Sweep};

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
    rows.push(row("folder", format!("{place}: points.csv has a row for each point, with its reason")));
    format!("{}\n{}", sweep.name, columns(&rows))
}
