//! What is truly in a phantom, in words.

use super::facts::figure;
use crate::pipeline::{TrueInclusion, Truth};
use crate::report::{Item, Table};

/// In a line for each inclusion.
pub fn truth_rows(truth: &Truth) -> Vec<(String, String)> {
    let row = |words: String| ("true inclusion".to_owned(), words);
    let words = |one: &TrueInclusion| {
        let [size, depth, modulus] = [one.size_mm, one.depth_mm, one.youngs_kpa].map(figure);
        row(format!("{size} mm across, {depth} mm deep to its top, {modulus} kPa"))
    };
    match (truth.phantom_youngs_kpa.reason(), truth.inclusions.as_slice()) {
        (Some(reason), _) => vec![row(format!("none: {reason}"))],
        (None, []) => vec![row("none".into())],
        (None, inclusions) => inclusions.iter().map(words).collect(),
    }
}

/// The inclusions as a table of a report, if there are any.
pub fn truth_table(truth: &Truth) -> Option<Item> {
    let itself = truth.phantom_youngs_kpa.value().filter(|_| !truth.inclusions.is_empty())?;
    let row = |one: &TrueInclusion| [one.size_mm, one.depth_mm, one.youngs_kpa].map(figure).to_vec();
    Some(Item::Table(Table {
        caption: format!("What the phantom holds; itself it has {} kPa{}", figure(itself), skin(truth)),
        columns: ["true size (mm)", "depth to its top (mm)", "Young's modulus (kPa)"].map(str::to_owned).to_vec(),
        rows: truth.inclusions.iter().map(row).collect(),
    }))
}

/// The layers in words.
fn skin(truth: &Truth) -> String {
    let layers = truth.phantom_layers.iter();
    let words = layers.map(|layer| format!("{} mm of {} kPa", figure(layer.thickness_mm), figure(layer.youngs_kpa)));
    match words.collect::<Vec<_>>() {
        none if none.is_empty() => String::new(),
        layers => format!(", below {}", layers.join(" over ")),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{Inputs, Phantom};

    #[test]
    fn inclusions_are_told_one_by_one() {
        let mut phantom = crate::scene::preset("phantom-size-8mm").unwrap().scene.phantom.unwrap();
        let truth = |phantom: &Phantom, without| Truth::of(Some(phantom), &Inputs::default(), without).unwrap();
        assert_eq!(truth_rows(&truth(&phantom, false))[0].1, "8 mm across, 5 mm deep to its top, 120 kPa");
        assert!(truth_table(&truth(&phantom, true)).is_none());
        phantom.inclusion.push(phantom.inclusion[0].clone());
        assert_eq!(truth_rows(&truth(&phantom, false)).len(), 2);
    }
}
