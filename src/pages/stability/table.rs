//! The rows as text, CSV and JSON.

use crate::pages::PageError;
use crate::pages::facts::figure;
use crate::stability::{Part, Row};
use serde_json::{Value, json};

/// All rows as an object, with the GPU's name where one was checked.
pub fn all_json(rows: &[Row], adapter: Option<&str>) -> Value {
    let failed = rows.iter().filter(|row| !row.passed).count();
    let rows: Vec<_> = rows.iter().map(json).collect();
    json!({"passed": failed == 0, "failed": failed, "adapter": adapter, "rows": rows})
}

/// A row as an object.
fn json(row: &Row) -> Value {
    let number = |value: f64| match value.is_finite() {
        true => json!(value),
        false => json!({"undefined": row.reason}),
    };
    json!({
        "part": row.part,
        "case": row.case,
        "quantity": row.quantity,
        "computed_by": row.computed_by,
        "reference": row.reference,
        "reference_is": row.reference_is,
        "found": number(row.found),
        "error": number(row.error),
        "allowed": row.allowed,
        "relative": row.relative,
        "reason": row.reason,
        "passed": row.passed,
    })
}

/// All rows as CSV.
pub fn csv(rows: &[Row]) -> Result<String, PageError> {
    let failed = |error: csv::Error| PageError::Table { file: "stability.csv", error: error.into() };
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(failed)?;
    let bytes = writer.into_inner().map_err(|error| failed(error.into_error().into()))?;
    String::from_utf8(bytes).map_err(|error| failed(std::io::Error::other(error).into()))
}

/// All rows for reading: a heading for each part, a line for each row.
pub fn text(rows: &[Row], adapter: Option<&str>, out: Option<&str>) -> String {
    let mut lines = Vec::new();
    for (part, name) in [(Part::Light, "light"), (Part::Mechanics, "mechanics"), (Part::Image, "images")] {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.part == part).collect();
        if rows.is_empty() {
            continue;
        }
        lines.push(format!("{name}: {} rows", rows.len()));
        lines.extend(rows.iter().map(|row| line(row)));
    }
    let failed = rows.iter().filter(|row| !row.passed).count();
    lines.push(match failed {
        0 => format!("all {} rows pass", rows.len()),
        failed => format!("{failed} of {} rows FAIL", rows.len()),
    });
    lines.extend(adapter.map(|adapter| format!("gpu: {adapter}")));
    lines.extend(out.map(|out| format!("folder: {out}")));
    lines.join("\n")
}

fn line(row: &Row) -> String {
    let verdict = if row.passed { "pass" } else { "FAIL" };
    if row.found.is_nan() {
        return format!("  {verdict}  {} [{}]: {}", row.case, row.computed_by, row.reason);
    }
    let share = if row.relative { " of it" } else { "" };
    format!(
        "  {verdict}  {} [{}]: {} {} for {} ({}), error {} of {}{share} allowed ({})",
        row.case,
        row.computed_by,
        row.quantity,
        digits(row.found),
        digits(row.reference),
        row.reference_is,
        figure(row.error),
        figure(row.allowed),
        row.reason
    )
}

/// Seven digits, without trailing zeros.
fn digits(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let text = format!("{value:.7}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    format!("{value:.6e}")
}
