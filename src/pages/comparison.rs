//! Two images compared.

use crate::film::compare::{Comparison, Deviations, LevelTest, Paired, Tolerance};
use serde_json::{Value, json};
use std::fmt::Write;

/// What is said of a comparison, for people.
pub fn table(comparison: &Comparison) -> String {
    let verdict = if comparison.passed { "same" } else { "DIFFERENT" };
    let mut text = format!("{verdict} (chance of a false alarm {})\n", comparison.level);
    let columns = ["cells", "largest z", "mean z^2", "p", "would see"];
    let _ = write!(text, "{:<14}", "level");
    columns.iter().for_each(|column| _ = write!(text, "{column:>11}"));
    text.push('\n');
    for test in &comparison.tests {
        let _ = writeln!(text, "{}", row(test));
    }
    if let Some(paired) = &comparison.paired {
        let _ = write!(text, "{}", pairs(paired));
    }
    let _ = writeln!(text, "mean A {:.6e}, mean B {:.6e}", comparison.mean_a, comparison.mean_b);
    match &comparison.ratio {
        Some(ratio) => {
            let _ = writeln!(text, "B/A {:.6} (95 %: {:.6} to {:.6})", ratio.value, ratio.low, ratio.high);
        }
        None => text.push_str("B/A undefined: A is dark\n"),
    }
    text
}

const DIFFERS: &str = "  <- differs";

fn row(test: &LevelTest) -> String {
    let name = match test.edge {
        0 => "whole image".to_owned(),
        1 => "pixels".to_owned(),
        edge => format!("blocks of {edge}"),
    };
    let Some(change) = test.smallest_change else {
        return format!("{name:<14}{:>11}  too little light to test", 0);
    };
    let mark = if test.passed { "" } else { DIFFERS };
    let figures =
        format!("{:>11.2}{:>11.3}{:>11.2e}{:>11}", test.max_z, test.mean_square, test.p_value, percent(change));
    format!("{name:<14}{:>11}{figures}{mark}", test.cells)
}

/// The comparison replicate by replicate, in words.
fn pairs(paired: &Paired) -> String {
    let Paired { groups, regions, max_z, p_value, .. } = paired;
    let mark = if paired.passed { "" } else { DIFFERS };
    let mut text = format!(
        "same seed and work: also compared replicate by replicate\n\
         {groups} pairs, {regions} regions: largest z {max_z:.2}, p {p_value:.2e}{mark}\n"
    );
    if let (Some(ratio), Some(change)) = (&paired.ratio, paired.smallest_change) {
        let [value, low, high] = [ratio.value, ratio.low, ratio.high];
        let change = percent(change);
        let _ = writeln!(text, "B/A of pairs {value:.6} (95 %: {low:.6} to {high:.6}), would see {change}");
    }
    text
}

fn percent(share: f64) -> String {
    if share < 1e-3 { format!("{:.0e} %", 100.0 * share) } else { format!("{:.2} %", 100.0 * share) }
}

/// What is said of a comparison pixel by pixel, for programs.
pub fn strict_json(found: &Deviations) -> Value {
    let first = match found.first {
        Some(first) => json!(first),
        None => json!({"undefined": "nothing differs"}),
    };
    json!({
        "passed": found.passed,
        "allowed": found.tolerance.map_or_else(|| json!("not a bit"), |tolerance| json!(tolerance)),
        "pixels": found.pixels,
        "outside": found.outside,
        "first": first,
        "largest_relative": found.largest_relative,
        "largest_absolute": found.largest_absolute,
    })
}

/// The same for people.
pub fn strict_text(found: &Deviations) -> String {
    let allowed = match found.tolerance {
        None => "not a bit may differ".to_owned(),
        Some(Tolerance { relative, absolute }) => {
            format!("pixels may differ by {relative} of their light or by {absolute}")
        }
    };
    let verdict = if found.passed { "same" } else { "DIFFERENT" };
    let mut text = format!("{verdict} ({allowed})\n");
    if let Some(first) = found.first {
        let (outside, pixels) = (found.outside, found.pixels);
        let of = if found.tolerance.is_some() { "pixels" } else { "means and variances" };
        let values = if found.tolerance.is_some() { pixels } else { 2 * pixels };
        let _ = writeln!(
            text,
            "{outside} of {values} {of} differ; the first: {} in row {}, column {}, A {:e}, B {:e}",
            first.channel, first.row, first.column, first.a, first.b
        );
    }
    let (relative, absolute) = (found.largest_relative, found.largest_absolute);
    let _ = writeln!(text, "largest deviation of a mean: {relative:.3e} of its light, {absolute:.3e} W/(m^2 sr)");
    text
}
