//! How far a sweep is, by its records.

use super::record::item;
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
    /// Records that cannot be read; they are computed again.
    pub damaged: usize,
    /// Other workers in the folder.
    pub workers: usize,
}

impl Status {
    /// Of a sweep's records.
    pub fn of(sweep: &Sweep, records: &Records) -> Self {
        let mut status = Self { points: sweep.plan.count(), workers: records.workers(), ..Self::default() };
        for row in 0..sweep.plan.count() {
            match records.item::<Record>(&item(row)) {
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

    /// The same of a run that took so many seconds, and found so many points ended.
    pub fn run_json(&self, sweep: &Sweep, seconds: f64, before: usize) -> Value {
        let (mut told, computed) = (self.json(sweep), self.ended().saturating_sub(before));
        told["seconds"] = json!(seconds);
        told["points_per_minute"] = json!(60.0 * computed as f64 / seconds);
        told
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

    /// A point's record, where it has one.
    pub fn record(&self, records: &Records, row: usize) -> Option<Record> {
        match records.item(&item(row)) {
            Item::There(record) => Some(record),
            Item::Missing | Item::Damaged => None,
        }
    }
}
