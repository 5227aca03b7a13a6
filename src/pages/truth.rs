//! What is truly in a phantom, in words.

use super::facts::figure;
use crate::pipeline::{TrueInclusion, Truth};
use crate::report::{Item, Table};
use crate::scene::{Press, PressStep};

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

/// The phantom itself, its layers and its inclusions, a line each; nothing where there is no phantom.
pub fn phantom_rows(truth: &Truth) -> Vec<(String, String)> {
    let Some(itself) = truth.phantom_youngs_kpa.value() else { return Vec::new() };
    let phantom = ("phantom".to_owned(), format!("{} kPa{}", figure(itself), skin(truth)));
    let inclusions = truth_rows(truth).into_iter().filter(|_| !truth.inclusions.is_empty());
    std::iter::once(phantom).chain(inclusions.map(|(_, words)| ("inclusion".to_owned(), words))).collect()
}

/// What a press does, load by load.
pub fn loads(press: &Press) -> String {
    let list = |values: &[f64]| values.iter().copied().map(figure).collect::<Vec<_>>().join(", ");
    match (&press.depths_mm, &press.forces_n) {
        (Some(depths), _) => format!("to {} mm", list(depths)),
        (_, Some(forces)) => format!("to {} N", list(forces)),
        _ => press.step.iter().map(step).collect::<Vec<_>>().join("; "),
    }
}

fn step(step: &PressStep) -> String {
    let to = step.depth_mm.map(|depth| format!("to {} mm", figure(depth)));
    let slide = step.slide_mm.map(|[x, y]| format!("slid to ({}, {}) mm", figure(x), figure(y)));
    let hold = (step.hold_s > 0.0).then(|| format!("held {} s", figure(step.hold_s)));
    [to, slide, hold].into_iter().flatten().collect::<Vec<_>>().join(", ")
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
        let rows = phantom_rows(&truth(&phantom, false));
        assert_eq!(rows.iter().map(|row| row.0.as_str()).collect::<Vec<_>>(), ["phantom", "inclusion", "inclusion"]);
        assert_eq!(phantom_rows(&truth(&phantom, true)), [("phantom".to_owned(), "5 kPa".to_owned())]);
    }

    #[test]
    fn loads_are_told_one_by_one() {
        let press = Press { depths_mm: Some(vec![1.0, 2.5]), ..Press::default() };
        assert_eq!(loads(&press), "to 1, 2.5 mm");
        let slide = PressStep { depth_mm: None, slide_mm: Some([1.0, 0.0]), hold_s: 3.0 };
        let step = vec![PressStep { depth_mm: Some(2.0), slide_mm: None, hold_s: 0.0 }, slide];
        assert_eq!(loads(&Press { step, ..Press::default() }), "to 2 mm; slid to (1, 0) mm, held 3 s");
    }
}
