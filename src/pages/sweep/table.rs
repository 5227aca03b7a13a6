//! Tables of a sweep, made of its records.

use crate::output::Records;
use crate::pages::PageError;
use crate::pages::tables::table;
use crate::sweep::{Sensitivity, State, Sweep, Told};
use crate::vary::Scalar;
use crate::vary::sensitivity::Interval;

/// Points as rows of cells.
pub struct Points {
    /// Names of the columns: `row`, `status`, what varies, each figure with its `_low` and `_high`, `relative_error`,
    /// `note`.
    pub head: Vec<String>,
    /// The points in the order of the design; a cell without a value is none.
    pub rows: Vec<Vec<Option<Scalar>>>,
}

/// What is known of each point. Equal sweeps have equal ones: times are not among it.
pub fn points(sweep: &Sweep, records: &Records) -> Points {
    let names: Vec<String> = sweep.plan.names().map(str::to_owned).collect();
    let columns: Vec<&str> = sweep.columns().collect();
    let of_figure = |name: &&str| [(*name).to_owned(), format!("{name}_low"), format!("{name}_high")];
    let head = ["row".to_owned(), "status".to_owned()].into_iter().chain(names.iter().cloned());
    let head = head.chain(columns.iter().flat_map(of_figure)).chain(["relative_error".to_owned(), "note".to_owned()]);
    let number = |value: Option<f64>| value.map(Scalar::Number);
    let rows = (0..sweep.plan.count()).map(|row| {
        let record = sweep.record(records, row);
        let status = State::word(record.as_ref().map(|record| record.status));
        // What a design asked for is known before it is computed.
        let values = match &record {
            Some(record) if !record.values.is_empty() => record.values.clone(),
            _ => sweep.plan.values(row),
        };
        let figures = record.as_ref().map(|record| record.figures.as_slice()).unwrap_or_default();
        let figure = |k: usize| {
            let Told { value, low, high, .. } = figures.get(k).cloned().unwrap_or_default();
            [value, low, high].map(number)
        };
        let noted = |(name, told): (&&str, &Told)| told.note.as_ref().map(|note| format!("{name}: {note}"));
        let notes = record.as_ref().and_then(|record| record.reason.clone()).into_iter();
        let notes: Vec<String> = notes.chain(columns.iter().zip(figures).filter_map(noted)).collect();
        let notes = (!notes.is_empty()).then(|| Scalar::Text(notes.join("; ")));
        let error = record.as_ref().and_then(|record| record.traced.as_ref()?.relative_error);
        let cells = [Some(Scalar::Number(row as f64)), Some(Scalar::Text(status.to_owned()))].into_iter();
        let cells = cells.chain((0..names.len()).map(|k| values.get(k).cloned()));
        cells.chain((0..columns.len()).flat_map(figure)).chain([number(error), notes]).collect()
    });
    Points { head: head.collect(), rows: rows.collect() }
}

/// `points.csv`: one row a point in the order of the design, with its status. Equal sweeps give equal bytes.
///
/// # Errors
/// Never for what a sweep holds.
pub fn points_csv(sweep: &Sweep, records: &Records) -> Result<String, PageError> {
    let Points { head, rows } = points(sweep, records);
    let cell = |cell: Option<Scalar>| cell.map_or(String::new(), |cell| cell.to_string());
    table("points.csv", head, rows.into_iter().map(|row| row.into_iter().map(cell).collect()))
}

/// `times.csv`: where the time of each point went, seconds.
///
/// # Errors
/// Never for what a sweep holds.
pub fn times_csv(sweep: &Sweep, records: &Records) -> Result<String, PageError> {
    let head = ["row", "press_s", "light_s", "figures_s", "spp", "photons", "adapter"].map(str::to_owned);
    let rows = (0..sweep.plan.count()).filter_map(|row| {
        let record = sweep.record(records, row)?;
        let seconds = record.seconds;
        let (spp, photons, adapter) = match record.traced {
            Some(traced) => (traced.spp.to_string(), traced.photons.to_string(), traced.adapter),
            None => Default::default(),
        };
        let times = [seconds.press, seconds.light, seconds.figures].map(|time| format!("{time:.4}"));
        Some([row.to_string()].into_iter().chain(times).chain([spp, photons, adapter]).collect())
    });
    table("times.csv", head.to_vec(), rows)
}

/// `sensitivity.csv`: what each variable does to each figure; a figure without says why.
///
/// # Errors
/// Never for what a sweep holds.
pub fn sensitivity_csv(sweep: &Sweep, records: &Records) -> Result<String, PageError> {
    let head = ["figure", "variable", "quantity", "value", "low", "high", "note"].map(str::to_owned);
    let names = sweep.free_names();
    let within = |one: &Interval| [one.value, one.low, one.high].map(Some);
    let mut rows = Vec::new();
    for (figure, found) in sweep.sensitivity(records) {
        let mut add = |variable: &str, quantity: &str, [value, low, high]: [Option<f64>; 3]| {
            let [value, low, high] =
                [value, low, high].map(|value| value.map_or(String::new(), |value| value.to_string()));
            rows.push([figure.into(), variable.into(), quantity.into(), value, low, high, String::new()].to_vec());
        };
        match found {
            Ok(Sensitivity::Effects(all)) => {
                for (one, name) in all.iter().zip(&names) {
                    add(name, "mean_absolute_effect", within(&one.mean_absolute));
                    add(name, "mean_effect", within(&one.mean));
                    add(name, "spread_of_effects", [Some(one.spread), None, None]);
                }
            }
            Ok(Sensitivity::Indices(all)) => {
                for (one, name) in all.iter().zip(&names) {
                    add(name, "first_index", within(&one.first));
                    add(name, "total_index", within(&one.total));
                }
            }
            Err(why) => {
                let empty = String::new;
                rows.push([figure.into(), empty(), empty(), empty(), empty(), empty(), why].to_vec());
            }
        }
    }
    table("sensitivity.csv", head.to_vec(), rows.into_iter())
}
