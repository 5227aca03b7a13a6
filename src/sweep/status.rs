//! How far a sweep is, by its records.

use super::record;
use super::{Record, State, Sweep};
use crate::output::{Item, Records};
use serde::Serialize;
use serde_json::{Value, json};

/// How far a sweep is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Status {
    /// Points of the design.
    pub points: usize,
    /// Points with figures.
    pub done: usize,
    /// Points that break a constraint or a rule.
    pub rejected: usize,
    /// Points that could not be computed.
    pub failed: usize,
    /// Records that cannot be read, or whose images are gone; they are computed again.
    pub damaged: usize,
    /// Other workers in the folder.
    pub workers: usize,
    /// Whether the folder has the points' table.
    #[serde(skip)]
    pub tables: bool,
}

impl Status {
    /// Of a sweep's records.
    pub fn of(sweep: &Sweep, records: &Records) -> Self {
        let (points, workers, tables) = (sweep.plan.count(), records.workers(), records.has("points.csv"));
        let mut status = Self { points, workers, tables, ..Self::default() };
        for row in 0..sweep.plan.count() {
            match sweep.item(records, row) {
                Item::There(record) => match record.status {
                    State::Done => status.done += 1,
                    State::Rejected => status.rejected += 1,
                    State::Failed => status.failed += 1,
                },
                Item::Damaged => status.damaged += 1,
                Item::Missing => {}
            }
        }
        status
    }

    /// With the name of the sweep, for programs.
    pub fn json(&self, sweep: &Sweep) -> Value {
        let mut told = json!(self);
        told["name"] = json!(sweep.name);
        told
    }

    /// The same of a run that took so many seconds, and computed so many points itself.
    pub fn run_json(&self, sweep: &Sweep, seconds: f64, computed: usize) -> Value {
        let mut told = self.json(sweep);
        told["seconds"] = json!(seconds);
        told["points_per_minute"] = json!(60.0 * computed as f64 / seconds);
        told
    }

    /// Refuses a sweep whose points have all ended, and none is done.
    ///
    /// # Errors
    /// That, with the reason of the first.
    pub fn nothing(&self, sweep: &Sweep, records: &Records) -> Result<(), String> {
        if self.done > 0 || self.points == 0 || self.ended() < self.points {
            return Ok(());
        }
        let why = sweep.record(records, 0).and_then(|record| record.reason).unwrap_or_default();
        Err(format!("none of {} points is done: point 0: {why}", self.points))
    }

    /// Points that have a record.
    pub fn ended(&self) -> usize {
        self.done + self.rejected + self.failed
    }
}

impl Sweep {
    /// Names of all figures, in the order of a record's.
    pub fn columns(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.file.measure.iter().flat_map(|measure| measure.columns().iter().copied())
    }

    /// Names of the tables' columns but those of what varies.
    pub(super) fn own_columns(&self) -> Vec<String> {
        let figures = self.columns().flat_map(|name| ["", "_low", "_high"].map(|end| format!("{name}{end}")));
        let fixed = ["row", "status", "relative_error", "note"];
        let labels: Vec<&str> = match self.file.sweep.images {
            Some(_) => super::images::LABELS.iter().copied().chain(self.of_load().iter().copied()).collect(),
            None => Vec::new(),
        };
        figures.chain(fixed.into_iter().chain(labels).map(str::to_owned)).collect()
    }

    /// What is kept of a point. A record whose images are gone is as good as a damaged one.
    pub fn item(&self, records: &Records, row: usize) -> Item<Record> {
        let is_whole = |record: &Record| match &self.file.sweep.images {
            Some(images) => images.files(record).all(|name| records.has(&name)),
            None => true,
        };
        match records.item(&record::item(row)) {
            Item::There(record) if !is_whole(&record) => Item::Damaged,
            found => found,
        }
    }

    /// A point's record, where it has one.
    pub fn record(&self, records: &Records, row: usize) -> Option<Record> {
        match self.item(records, row) {
            Item::There(record) => Some(record),
            Item::Missing | Item::Damaged => None,
        }
    }
}
