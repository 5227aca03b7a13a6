//! What is truly in a phantom: what its estimates are measured against.

use super::Failure;
use super::facts::figure;
use crate::mechanics::from_scene::{inclusion_shape, material};
use crate::mechanics::mesh::Star;
use crate::report::{Item, Table};
use crate::scene::{Elastic, Inclusion, Phantom};
use serde_json::{Value, json};
use std::path::Path;

/// A phantom and its inclusions.
pub(super) struct Truth(Result<Known, &'static str>);

struct Known {
    /// Young's modulus of the phantom itself, kPa.
    youngs_kpa: f64,
    /// Thickness, mm, and Young's modulus, kPa, of its layers, the touched one first.
    layers: Vec<[f64; 2]>,
    inclusions: Vec<Held>,
}

/// An inclusion.
struct Held {
    /// Widths along x, y and z, mm.
    widths_mm: [f64; 3],
    /// Place of its centre along x and y, mm.
    center_mm: [f64; 2],
    /// From the touched face to its nearest point, mm.
    depth_mm: f64,
    /// Young's modulus at small strain, kPa.
    youngs_kpa: f64,
}

impl Truth {
    /// Of a scene's phantom; files are relative to `folder`. `without` its inclusions it holds none.
    ///
    /// # Errors
    /// When an inclusion's mesh cannot be read, or a material makes no sense.
    pub fn of(phantom: Option<&Phantom>, folder: &Path, without: bool) -> Result<Self, Failure> {
        let Some(phantom) = phantom else { return Ok(Self::unknown("the scene has no phantom")) };
        let youngs_kpa = modulus_kpa(&phantom.material)?;
        let inclusions = phantom.inclusion.iter().filter(|_| !without).map(|one| held(one, folder));
        let inclusions = inclusions.collect::<Result<_, _>>()?;
        let layers = phantom.layer.iter().map(|layer| Ok([layer.thickness_mm, modulus_kpa(&layer.material)?]));
        let layers = layers.collect::<Result<_, Failure>>()?;
        Ok(Self(Ok(Known { youngs_kpa, layers, inclusions })))
    }

    /// None, for a reason.
    pub fn unknown(reason: &'static str) -> Self {
        Self(Err(reason))
    }

    /// What `--json` says.
    pub fn json(&self) -> Value {
        let inclusion = |one: &Held| {
            json!({
                "size_mm": one.size_mm(),
                "widths_mm": one.widths_mm,
                "center_mm": one.center_mm,
                "depth_mm": one.depth_mm,
                "youngs_kpa": one.youngs_kpa,
            })
        };
        let layer = |[thickness, youngs]: &[f64; 2]| json!({"thickness_mm": thickness, "youngs_kpa": youngs});
        json!({
            "size_mm": self.of_one(Held::size_mm),
            "depth_mm": self.of_one(|one| one.depth_mm),
            "youngs_kpa": self.of_one(|one| one.youngs_kpa),
            "phantom_youngs_kpa": match &self.0 {
                Ok(known) => json!(known.youngs_kpa),
                Err(reason) => json!({"undefined": reason}),
            },
            "phantom_layers": self.layers().iter().map(layer).collect::<Vec<_>>(),
            "inclusions": self.inclusions().iter().map(inclusion).collect::<Vec<_>>(),
        })
    }

    /// In a line for each inclusion.
    pub fn rows(&self) -> Vec<(String, String)> {
        let row = |words: String| ("true inclusion".to_owned(), words);
        let words = |one: &Held| {
            let [size, depth, modulus] = [one.size_mm(), one.depth_mm, one.youngs_kpa].map(figure);
            row(format!("{size} mm across, {depth} mm deep to its top, {modulus} kPa"))
        };
        match (&self.0, self.inclusions()) {
            (Err(reason), _) => vec![row(format!("none: {reason}"))],
            (Ok(_), []) => vec![row("none".into())],
            (Ok(_), inclusions) => inclusions.iter().map(words).collect(),
        }
    }

    /// A figure of the inclusion, where there is one and no other.
    fn of_one(&self, pick: impl Fn(&Held) -> f64) -> Value {
        match (&self.0, self.inclusions()) {
            (Err(reason), _) => json!({"undefined": reason}),
            (Ok(_), [one]) => json!(pick(one)),
            (Ok(_), []) => json!({"undefined": "the phantom holds no inclusion"}),
            (Ok(_), several) => json!({"undefined": format!("there are {} inclusions", several.len())}),
        }
    }

    fn inclusions(&self) -> &[Held] {
        self.0.as_ref().map_or(&[], |known| &known.inclusions)
    }

    fn layers(&self) -> &[[f64; 2]] {
        self.0.as_ref().map_or(&[], |known| &known.layers)
    }

    /// The inclusions as a table of a report, if there are any.
    pub fn table(&self) -> Option<Item> {
        let known = self.0.as_ref().ok().filter(|known| !known.inclusions.is_empty())?;
        let row = |one: &Held| [one.size_mm(), one.depth_mm, one.youngs_kpa].map(figure).to_vec();
        Some(Item::Table(Table {
            caption: format!("What the phantom holds; itself it has {} kPa{}", figure(known.youngs_kpa), known.skin()),
            columns: ["true size (mm)", "depth to its top (mm)", "Young's modulus (kPa)"].map(str::to_owned).to_vec(),
            rows: known.inclusions.iter().map(row).collect(),
        }))
    }
}

impl Known {
    /// The layers in words.
    fn skin(&self) -> String {
        let words = |[thickness, youngs]: &[f64; 2]| format!("{} mm of {} kPa", figure(*thickness), figure(*youngs));
        match self.layers.iter().map(words).collect::<Vec<_>>() {
            none if none.is_empty() => String::new(),
            layers => format!(", below {}", layers.join(" over ")),
        }
    }
}

impl Held {
    /// Diameter of a circle of the same area as the ellipse of its widths along x and y, mm: that of a sphere is its
    /// own.
    fn size_mm(&self) -> f64 {
        (self.widths_mm[0] * self.widths_mm[1]).sqrt()
    }
}

/// Young's modulus at small strain, kPa, to the digit where the scene gives it.
fn modulus_kpa(elastic: &Elastic) -> Result<f64, Failure> {
    match elastic {
        Elastic::Linear { youngs_kpa, .. } | Elastic::NeoHookean { youngs_kpa, .. } => Ok(*youngs_kpa),
        _ => Ok(material(elastic).map_err(|error| Failure::input(error.to_string()))?.youngs_kpa()),
    }
}

fn held(inclusion: &Inclusion, folder: &Path) -> Result<Held, Failure> {
    let shape = inclusion_shape(inclusion, folder)?;
    let (low, high) = match &shape.surface {
        Star::Ellipsoid { semi_axes_mm } => (semi_axes_mm.map(|semi| -semi), *semi_axes_mm),
        Star::Mesh(mesh) => {
            let end = |pick: fn(f64, f64) -> f64| {
                [0, 1, 2].map(|axis| mesh.vertices.iter().fold(0.0, |end: f64, vertex| pick(end, vertex[axis])))
            };
            (end(f64::min), end(f64::max))
        }
    };
    let [x, y, center_depth_mm] = shape.center_mm;
    Ok(Held {
        widths_mm: [0, 1, 2].map(|axis| high[axis] - low[axis]),
        center_mm: [x, y],
        depth_mm: center_depth_mm + low[2],
        youngs_kpa: modulus_kpa(&inclusion.material)?,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{DepthTo, InclusionBody, preset};

    fn truth(change: impl FnOnce(&mut Inclusion), folder: &Path) -> Value {
        let mut phantom = preset("phantom-size-8mm").unwrap().scene.phantom.unwrap();
        change(&mut phantom.inclusion[0]);
        Truth::of(Some(&phantom), folder, false).unwrap().json()["inclusions"][0].take()
    }

    #[test]
    fn a_truth_is_that_of_the_shape_whatever_its_depth_is_counted_to() {
        let plain = truth(|_| {}, Path::new(""));
        assert_eq!((&plain["size_mm"], &plain["widths_mm"]), (&json!(8.0), &json!([8.0, 8.0, 8.0])));
        let moved = |one: &mut Inclusion| {
            one.shape = InclusionBody::Ellipsoid { semi_axes_mm: [4.0, 1.0, 3.0] };
            (one.depth_mm, one.depth_to, one.center_mm) = (9.0, DepthTo::Center, [2.0, -1.0]);
        };
        let moved = truth(moved, Path::new(""));
        // The circle of the same area as an ellipse of 8 by 2 mm: 4 mm.
        assert_eq!((&moved["size_mm"], &moved["depth_mm"]), (&json!(4.0), &json!(6.0)));
        assert_eq!(moved["center_mm"], json!([2.0, -1.0]));
    }

    #[test]
    fn a_mesh_has_the_widths_of_its_vertices() {
        let folder = tempfile::tempdir().unwrap();
        let octahedron = "v 1 0 0\nv -1 0 0\nv 0 4 0\nv 0 -4 0\nv 0 0 3\nv 0 0 -2\n\
                          f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
        std::fs::write(folder.path().join("lump.obj"), octahedron).unwrap();
        let lump = |one: &mut Inclusion| {
            one.shape = InclusionBody::Mesh { file: "lump.obj".into(), scale: 2.0 };
            (one.depth_mm, one.depth_to) = (5.0, DepthTo::Top);
        };
        let found = truth(lump, folder.path());
        assert_eq!((&found["widths_mm"], &found["depth_mm"]), (&json!([4.0, 16.0, 10.0]), &json!(5.0)));
    }

    #[test]
    fn without_inclusions_or_phantom_there_is_less_to_know() {
        let scene = preset("phantom-size-8mm").unwrap().scene;
        let without = Truth::of(scene.phantom.as_ref(), Path::new(""), true).unwrap();
        assert_eq!(without.json()["inclusions"], json!([]));
        assert!(without.json()["phantom_youngs_kpa"].as_f64().unwrap() > 0.0 && without.table().is_none());
        assert!(without.json()["size_mm"]["undefined"].as_str().unwrap().contains("no inclusion"));
        let none = Truth::of(None, Path::new(""), false).unwrap().json();
        assert!(none["youngs_kpa"]["undefined"].as_str().unwrap().contains("no phantom"));
    }

    #[test]
    fn a_single_inclusion_is_the_truth_and_of_several_none_is() {
        let mut phantom = preset("phantom-size-8mm").unwrap().scene.phantom.unwrap();
        let truth = |phantom: &Phantom| Truth::of(Some(phantom), Path::new(""), false).unwrap();
        let one = truth(&phantom).json();
        assert_eq!((&one["size_mm"], &one["depth_mm"], &one["youngs_kpa"]), (&json!(8.0), &json!(5.0), &json!(120.0)));
        let line = truth(&phantom).rows();
        assert_eq!(line[0].1, "8 mm across, 5 mm deep to its top, 120 kPa");
        phantom.inclusion.push(phantom.inclusion[0].clone());
        assert!(truth(&phantom).json()["size_mm"]["undefined"].as_str().unwrap().contains("2 inclusions"));
        assert_eq!(truth(&phantom).rows().len(), 2);
    }
}
