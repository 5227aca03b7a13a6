//! What frames say of the tissue, in words.

use super::Source;
use crate::estimate::Value;
use crate::estimate::tissue::Tissue;
use crate::pages::facts::figure;
use crate::report::{Item, Section, Table};

/// An estimate with its name, unit and true value, where that is known.
struct Estimate<'a> {
    name: &'static str,
    unit: &'static str,
    value: &'a Value,
    truth: Option<f64>,
}

fn estimates<'a>(tissue: &'a Tissue, source: &Source) -> Vec<Estimate<'a>> {
    let truth = &source.truth;
    let inclusion = truth.inclusions.first();
    let thickness = source.computed.as_ref().map(|computed| computed.setup.tissue.shape.height_mm());
    let own = truth.phantom_youngs_kpa.value();
    let youngs = inclusion.map(|one| one.youngs_kpa);
    let contrast = youngs.zip(own).map(|(inclusion, own)| inclusion / own);
    let one = |name, unit, value, truth| Estimate { name, unit, value, truth };
    let mut all = vec![
        one("thickness of the tissue", "mm", &tissue.thickness_mm, thickness),
        one("modulus of the tissue", "kPa", &tissue.tissue_youngs_kpa, own),
        one("radius of the inclusion", "mm", &tissue.radius_mm, inclusion.map(|one| 0.5 * one.size_mm)),
        one("modulus of the inclusion", "kPa", &tissue.inclusion_youngs_kpa, youngs),
        one("inclusion over tissue", "", &tissue.contrast, contrast),
    ];
    let depth = tissue.depth_mm.as_ref();
    all.extend(depth.map(|value| one("depth of the inclusion", "mm", value, inclusion.map(|one| one.depth_mm))));
    all
}

/// A line for each estimate, and one for the fit.
pub fn rows(tissue: &Tissue, source: &Source) -> Vec<(String, String)> {
    let words = |one: &Estimate| {
        let truth = one.truth.map_or(String::new(), |truth| format!("; true {}", figure(truth)));
        let unit = if one.unit.is_empty() { String::new() } else { format!(" {}", one.unit) };
        match one.value {
            Value::Known { value, low, high } => {
                format!("{}{unit} (95 %: {} to {}){truth}", figure(*value), figure(*low), figure(*high))
            }
            Value::Undefined { reason } => format!("undefined: {reason}{truth}"),
        }
    };
    let all = estimates(tissue, source);
    let lines = all.iter().map(|one| (one.name.to_owned(), words(one)));
    lines.chain([("fit".to_owned(), fit(tissue))]).collect()
}

fn fit(tissue: &Tissue) -> String {
    let noise = &tissue.noise;
    format!(
        "{} features, {} known; it leaves {} times the noise, which is {} % of the pressure and {} kPa; {} scans",
        tissue.features,
        tissue.held,
        figure(tissue.reduced_chi_square.sqrt()),
        figure(100.0 * noise.share),
        figure(noise.constant_kpa),
        tissue.scans
    )
}

/// The same as a part of the report.
pub fn section(tissue: &Tissue, source: &Source) -> Section {
    let row = |one: &Estimate| {
        let (estimate, interval) = match one.value {
            Value::Known { value, low, high } => (figure(*value), format!("{} to {}", figure(*low), figure(*high))),
            Value::Undefined { reason } => (format!("undefined: {reason}"), String::new()),
        };
        let name = if one.unit.is_empty() { one.name.to_owned() } else { format!("{} ({})", one.name, one.unit) };
        vec![name, estimate, interval, one.truth.map_or(String::new(), figure)]
    };
    let table =
        |caption: &str, columns: Vec<String>, rows| Item::Table(Table { caption: caption.to_owned(), columns, rows });
    let columns = ["", "estimate", "95 % interval", "true"].map(str::to_owned).to_vec();
    let mut items = vec![
        Item::Text(format!("Least squares over the features of all frames: {}.", fit(tissue))),
        table("The tissue", columns, estimates(tissue, source).iter().map(row).collect()),
    ];
    if !tissue.correlation.rows.is_empty() {
        let names = tissue.correlation.names.iter().map(|name| (*name).to_owned());
        let cells = |(name, row): (&&str, &Vec<f64>)| {
            std::iter::once((*name).to_owned()).chain(row.iter().map(|r| format!("{r:.2}"))).collect()
        };
        let rows = tissue.correlation.names.iter().zip(&tissue.correlation.rows).map(cells).collect();
        items.push(table("Correlation of their errors", std::iter::once(String::new()).chain(names).collect(), rows));
    }
    Section { title: "The tissue that fits".to_owned(), items }
}
