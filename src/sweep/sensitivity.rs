//! Which variables matter for which figure, from the records of a complete design.

use super::{State, Sweep};
use crate::output::Records;
use crate::vary::Design;
use crate::vary::sensitivity::{Effects, Indices, effects, indices};

/// What a design says of one figure.
#[derive(Debug, Clone, PartialEq)]
pub enum Sensitivity {
    /// Of a Morris design: effects of each variable.
    Effects(Vec<Effects>),
    /// Of a Saltelli design: indices of each variable.
    Indices(Vec<Indices>),
}

impl Sweep {
    /// Names of the variables that a design draws.
    pub fn free_names(&self) -> Vec<&str> {
        let free = self.plan.free();
        self.plan.names().enumerate().filter(|(k, _)| free.contains(k)).map(|(_, name)| name).collect()
    }

    /// Whether its design is one of sensitivity.
    pub fn asks_sensitivity(&self) -> bool {
        matches!(self.file.sweep.design, Design::Morris { .. } | Design::Saltelli { .. })
    }

    /// What the design says of each figure.
    ///
    /// # Errors
    /// A point that has no such figure: an incomplete design says nothing that can be trusted. A figure that is the same
    /// at all points.
    pub fn sensitivity(&self, records: &Records) -> Vec<(&'static str, Result<Sensitivity, String>)> {
        let columns: Vec<&'static str> = self.columns().collect();
        let mut figures = vec![Vec::with_capacity(self.plan.count()); columns.len()];
        let mut missing = None;
        for row in 0..self.plan.count() {
            let record = self.record(records, row).filter(|record| record.status == State::Done);
            let values = record.map(|record| record.figures).unwrap_or_default();
            for (k, figures) in figures.iter_mut().enumerate() {
                match values.get(k).and_then(|told| told.value) {
                    Some(value) => figures.push(value),
                    None => missing = missing.or(Some(row)),
                }
            }
        }
        let free = self.plan.free().len();
        let of = |figures: &[f64]| {
            if let (Some(row), true) = (missing, figures.len() < self.plan.count()) {
                return Err(format!("the design is not complete: point {row} has no such figure"));
            }
            match self.file.sweep.design {
                Design::Morris { .. } => {
                    let units: Vec<Vec<f64>> = (0..self.plan.count()).map(|row| self.plan.unit(row)).collect();
                    effects(free, &units, figures).map(Sensitivity::Effects)
                }
                Design::Saltelli { .. } => indices(free, figures).map(Sensitivity::Indices),
                _ => Err("its design is not one of sensitivity".into()),
            }
        };
        columns.iter().zip(&figures).map(|(name, figures)| (*name, of(figures))).collect()
    }
}
