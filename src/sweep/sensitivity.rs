//! Which variables matter for which figure, from the records of a complete design.

use super::{RandomNumbers, State, Sweep};
use crate::output::Records;
use crate::vary::Design;
use crate::vary::sensitivity::{Effects, Indices, effects, indices};

/// Standard deviations in half of a 95 % interval.
const NORMAL: f64 = 1.959_964;

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
    /// A point that has no such figure: an incomplete design says nothing that can be trusted. A figure that is the
    /// same at all points.
    pub fn sensitivity(&self, records: &Records) -> Vec<(&'static str, Result<Sensitivity, String>)> {
        let columns: Vec<&'static str> = self.columns().collect();
        // Of each figure its values, and the standard deviations that their intervals claim.
        let mut figures = vec![[const { Vec::new() }; 2]; columns.len()];
        let mut missing = vec![None; columns.len()];
        for row in 0..self.plan.count() {
            let record = self.record(records, row).filter(|record| record.status == State::Done);
            let values = record.map(|record| record.figures).unwrap_or_default();
            for (k, ([figures, noise], missing)) in figures.iter_mut().zip(&mut missing).enumerate() {
                match values.get(k).map(|told| (told.value, told.low.zip(told.high))) {
                    Some((Some(value), ends)) => {
                        figures.push(value);
                        noise.push(ends.map_or(0.0, |(low, high)| (high - low) / (2.0 * NORMAL)));
                    }
                    _ => *missing = missing.or(Some(row)),
                }
            }
        }
        let free = self.plan.free();
        let ordered: Vec<bool> = free.iter().map(|&k| self.plan.is_ordered(k)).collect();
        let of = |([figures, noise], missing): (&[Vec<f64>; 2], &Option<usize>)| {
            if let Some(row) = missing {
                return Err(format!("the design is not complete: point {row} has no such figure"));
            }
            match self.file.sweep.design {
                Design::Morris { .. } => {
                    let units: Vec<Vec<f64>> = (0..self.plan.count()).map(|row| self.plan.unit(row)).collect();
                    effects(&ordered, &units, figures, noise).map(Sensitivity::Effects)
                }
                Design::Saltelli { .. } => {
                    let common = self.file.sweep.random_numbers == RandomNumbers::Common;
                    indices(free.len(), figures, noise, common).map(Sensitivity::Indices)
                }
                _ => Err("its design is not one of sensitivity".into()),
            }
        };
        columns.iter().zip(figures.iter().zip(&missing)).map(|(name, one)| (*name, of(one))).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::output::Item;
    use crate::sweep::record::item;
    use crate::sweep::{Record, Seconds, Told};
    use std::f64::consts::PI;
    use std::path::Path;

    /// A sweep of three variables from -pi to pi whose points are all done, with a function of them as two figures, the
    /// second by its interval known to a standard deviation of 1.
    fn done(folder: &Path, design: &str, function: impl Fn(&[f64]) -> f64) -> (Sweep, Records) {
        let vary: String = (0..3)
            .map(|k| format!("[[vary]]\nname = \"x{k}\"\nkey = \"stack.layer[{k}].n\"\nuniform = [-{PI}, {PI}]\n"))
            .collect();
        let text = format!(
            "[sweep]\nscene = \"preset:contact-disc\"\ndesign = {design}\n{vary}[[measure]]\nkind = \"mean_radiance\"\n\
             [[measure]]\nkind = \"mean_grey\"\n"
        );
        let sweep = Sweep::parse(&text, Path::new("sweep.toml")).unwrap();
        let records = sweep.enter(folder, false, false).unwrap();
        for row in 0..sweep.plan.count() {
            let values = sweep.plan.values(row);
            let x: Vec<f64> = values.iter().map(|value| value.number().unwrap()).collect();
            let value = function(&x);
            let exact = Told { value: Some(value), ..Told::default() };
            let noisy = Told { low: Some(value - NORMAL), high: Some(value + NORMAL), ..exact.clone() };
            let record = Record {
                row,
                status: State::Done,
                reason: None,
                scene_sha256: None,
                values,
                figures: vec![exact, noisy],
                traced: None,
                images: Vec::new(),
                version: String::new(),
                seconds: Seconds::default(),
            };
            records.keep_item(&item(row), &record).unwrap();
        }
        (sweep, records)
    }

    /// Ishigami and Homma's function with a = 7, b = 0.1, by way of records; its indices as in `vary::sensitivity`.
    #[test]
    fn indices_of_records_are_those_of_a_closed_form() {
        let place = tempfile::tempdir().unwrap();
        let design = "{ kind = \"saltelli\", points = 512, seed = 3 }";
        let ishigami = |x: &[f64]| x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin();
        let (sweep, records) = done(&place.path().join("out"), design, ishigami);
        let found = sweep.sensitivity(&records);
        let Ok(Sensitivity::Indices(indices)) = &found[0].1 else { panic!("{found:?}") };
        for (found, [first, total]) in indices.iter().zip([[0.3139, 0.5576], [0.4424, 0.4424], [0.0, 0.2437]]) {
            assert!((found.first.value - first).abs() < 0.06, "{found:?} {first}");
            assert!((found.total.value - total).abs() < 0.06, "{found:?} {total}");
        }
        // Ends are further out where figures have noise; the variance is 13.84.
        let Ok(Sensitivity::Indices(noisy)) = &found[1].1 else { panic!("{found:?}") };
        for (exact, noisy) in indices.iter().zip(noisy) {
            let further = noisy.total.high / exact.total.high * (1.0 - 1.0 / 13.84);
            assert!((further - 1.0).abs() < 0.01, "{exact:?} {noisy:?}");
            assert!(noisy.first.low < exact.first.low - 0.03 && noisy.total.low < exact.total.low, "{noisy:?}");
        }
        // Noise of numbers that points have in common is in no difference of them; that of their own is in all.
        let own = format!("{design}\nrandom_numbers = \"own\"");
        let (of_own, its_records) = done(&place.path().join("own"), &own, ishigami);
        let Ok(Sensitivity::Indices(own)) = &of_own.sensitivity(&its_records)[1].1 else { panic!() };
        for ((exact, common), own) in indices.iter().zip(noisy).zip(own) {
            let behind = |value: f64| value / (1.0 - 1.0 / 13.84);
            assert!((common.total.value - behind(exact.total.value)).abs() < 0.005, "{exact:?} {common:?}");
            assert!((own.total.value - behind(exact.total.value - 1.0 / 13.84)).abs() < 0.005, "{exact:?} {own:?}");
        }
        // One point less, and nothing is said.
        std::fs::remove_file(place.path().join("out/items/0000007.json")).unwrap();
        let found = sweep.sensitivity(&records);
        assert!(found[0].1.as_ref().unwrap_err().contains("point 7 has no such figure"), "{found:?}");
        // Of several figures each names its own point.
        let mut record: Record = match records.item(&item(2)) {
            Item::There(record) => record,
            other => panic!("{other:?}"),
        };
        record.figures.truncate(1);
        records.keep_item(&item(2), &record).unwrap();
        let found = sweep.sensitivity(&records);
        for (k, row) in [(0, 7), (1, 2)] {
            let said = format!("point {row} has no such figure");
            assert!(found[k].1.as_ref().unwrap_err().contains(&said), "{found:?}");
        }
    }

    #[test]
    fn effects_of_records_are_the_slopes_of_a_linear_function() {
        let place = tempfile::tempdir().unwrap();
        let design = "{ kind = \"morris\", trajectories = 6, seed = 1 }";
        let (sweep, records) = done(&place.path().join("out"), design, |x| 1.0 + 2.0 * x[0] - 3.0 * x[1]);
        let found = sweep.sensitivity(&records);
        let Ok(Sensitivity::Effects(effects)) = &found[0].1 else { panic!("{found:?}") };
        for (one, slope) in effects.iter().zip([2.0, -3.0, 0.0]) {
            // Over half of the range of 2 pi.
            assert!((one.mean.value - slope * PI).abs() < 1e-9, "{one:?}");
            assert!((one.mean_absolute.value - (slope * PI).abs()).abs() < 1e-9 && one.spread < 1e-9, "{one:?}");
        }
    }
}
