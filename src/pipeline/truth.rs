//! What is truly in a phantom: what its estimates are measured against, and the label of its image.

use crate::figure::Figure;
use crate::mechanics::from_scene::{inclusion_shape, material};
use crate::mechanics::mesh::Star;
use crate::mechanics::press::PressError;
use crate::scene::{Elastic, Inclusion, Inputs, Phantom};
use serde::Serialize;

/// A phantom and its inclusions. The first three figures are those of the inclusion, where there is one and no other.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Truth {
    /// Diameter of the inclusion: that of a circle of the same area as the ellipse of its widths along x and y, mm.
    pub size_mm: Figure,
    /// From the touched face to the inclusion's nearest point, mm.
    pub depth_mm: Figure,
    /// Young's modulus of the inclusion at small strain, kPa.
    pub youngs_kpa: Figure,
    /// Young's modulus of the phantom itself, kPa.
    pub phantom_youngs_kpa: Figure,
    /// Its layers, the touched one first.
    pub phantom_layers: Vec<TrueLayer>,
    /// All inclusions.
    pub inclusions: Vec<TrueInclusion>,
}

/// A layer of a phantom.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrueLayer {
    /// Thickness, mm.
    pub thickness_mm: f64,
    /// Young's modulus at small strain, kPa.
    pub youngs_kpa: f64,
}

/// An inclusion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrueInclusion {
    /// Diameter of a circle of the same area as the ellipse of its widths along x and y, mm: that of a sphere is its
    /// own.
    pub size_mm: f64,
    /// Widths along x, y and z, mm.
    pub widths_mm: [f64; 3],
    /// Place of its centre along x and y, mm.
    pub center_mm: [f64; 2],
    /// From the touched face to its nearest point, mm.
    pub depth_mm: f64,
    /// Young's modulus at small strain, kPa.
    pub youngs_kpa: f64,
}

impl Truth {
    /// Of a scene's phantom; its meshes are some of `files`. `without` its inclusions it holds none.
    ///
    /// # Errors
    /// When an inclusion's mesh cannot be read, or a material makes no sense.
    pub fn of(phantom: Option<&Phantom>, files: &Inputs, without: bool) -> Result<Self, PressError> {
        let Some(phantom) = phantom else { return Ok(Self::unknown("the scene has no phantom")) };
        let inclusions = phantom.inclusion.iter().filter(|_| !without).map(|one| TrueInclusion::of(one, files));
        let inclusions = inclusions.collect::<Result<Vec<_>, _>>()?;
        let layer = |layer: &crate::scene::PhantomLayer| {
            Ok(TrueLayer { thickness_mm: layer.thickness_mm, youngs_kpa: modulus_kpa(&layer.material)? })
        };
        let of_one = |pick: fn(&TrueInclusion) -> f64| match inclusions.as_slice() {
            [one] => Figure::known(pick(one)),
            [] => Figure::undefined("the phantom holds no inclusion"),
            several => Figure::undefined(format!("there are {} inclusions", several.len())),
        };
        Ok(Self {
            size_mm: of_one(|one| one.size_mm),
            depth_mm: of_one(|one| one.depth_mm),
            youngs_kpa: of_one(|one| one.youngs_kpa),
            phantom_youngs_kpa: Figure::known(modulus_kpa(&phantom.material)?),
            phantom_layers: phantom.layer.iter().map(layer).collect::<Result<_, PressError>>()?,
            inclusions,
        })
    }

    /// None, for a reason.
    pub fn unknown(reason: &'static str) -> Self {
        let none = || Figure::undefined(reason);
        let [size_mm, depth_mm, youngs_kpa, phantom_youngs_kpa] = [none(), none(), none(), none()];
        let (phantom_layers, inclusions) = Default::default();
        Self { size_mm, depth_mm, youngs_kpa, phantom_youngs_kpa, phantom_layers, inclusions }
    }
}

impl TrueInclusion {
    fn of(inclusion: &Inclusion, files: &Inputs) -> Result<Self, PressError> {
        let shape = inclusion_shape(inclusion, files)?;
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
        let widths_mm = [0, 1, 2].map(|axis| high[axis] - low[axis]);
        Ok(Self {
            size_mm: (widths_mm[0] * widths_mm[1]).sqrt(),
            widths_mm,
            center_mm: [x, y],
            depth_mm: center_depth_mm + low[2],
            youngs_kpa: modulus_kpa(&inclusion.material)?,
        })
    }
}

/// Young's modulus at small strain, kPa, to the digit where the scene gives it.
fn modulus_kpa(elastic: &Elastic) -> Result<f64, PressError> {
    match elastic {
        Elastic::Linear { youngs_kpa, .. } | Elastic::NeoHookean { youngs_kpa, .. } => Ok(*youngs_kpa),
        _ => Ok(material(elastic)?.youngs_kpa()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{DepthTo, InclusionBody, preset};

    fn truth(change: impl FnOnce(&mut Inclusion), files: &Inputs) -> TrueInclusion {
        let mut phantom = preset("phantom-size-8mm").unwrap().scene.phantom.unwrap();
        change(&mut phantom.inclusion[0]);
        Truth::of(Some(&phantom), files, false).unwrap().inclusions[0]
    }

    #[test]
    fn a_truth_is_that_of_the_shape_whatever_its_depth_is_counted_to() {
        let plain = truth(|_| {}, &Inputs::default());
        assert_eq!((plain.size_mm, plain.widths_mm), (8.0, [8.0; 3]));
        let moved = |one: &mut Inclusion| {
            one.shape = InclusionBody::Ellipsoid { semi_axes_mm: [4.0, 1.0, 3.0] };
            (one.depth_mm, one.depth_to, one.center_mm) = (9.0, DepthTo::Center, [2.0, -1.0]);
        };
        let moved = truth(moved, &Inputs::default());
        // The circle of the same area as an ellipse of 8 by 2 mm: 4 mm.
        assert_eq!((moved.size_mm, moved.depth_mm, moved.center_mm), (4.0, 6.0, [2.0, -1.0]));
    }

    #[test]
    fn a_mesh_has_the_widths_of_its_vertices() {
        let octahedron = "v 1 0 0\nv -1 0 0\nv 0 4 0\nv 0 -4 0\nv 0 0 3\nv 0 0 -2\n\
                          f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
        let mut files = Inputs::default();
        files.insert("lump.obj", octahedron.as_bytes());
        let lump = |one: &mut Inclusion| {
            one.shape = InclusionBody::Mesh { file: "lump.obj".into(), scale: 2.0 };
            (one.depth_mm, one.depth_to) = (5.0, DepthTo::Top);
        };
        let found = truth(lump, &files);
        assert_eq!((found.widths_mm, found.depth_mm), ([4.0, 16.0, 10.0], 5.0));
    }

    #[test]
    fn without_inclusions_or_phantom_there_is_less_to_know() {
        let scene = preset("phantom-size-8mm").unwrap().scene;
        let without = Truth::of(scene.phantom.as_ref(), &Inputs::default(), true).unwrap();
        assert!(without.inclusions.is_empty() && without.phantom_youngs_kpa.value().unwrap() > 0.0);
        assert!(without.size_mm.reason().unwrap().contains("no inclusion"));
        let none = Truth::of(None, &Inputs::default(), false).unwrap();
        assert!(none.youngs_kpa.reason().unwrap().contains("no phantom"));
    }

    #[test]
    fn a_single_inclusion_is_the_truth_and_of_several_none_is() {
        let mut phantom = preset("phantom-size-8mm").unwrap().scene.phantom.unwrap();
        let truth = |phantom: &Phantom| Truth::of(Some(phantom), &Inputs::default(), false).unwrap();
        let one = truth(&phantom);
        assert_eq!([&one.size_mm, &one.depth_mm, &one.youngs_kpa].map(Figure::value), [8.0, 5.0, 120.0].map(Some));
        phantom.inclusion.push(phantom.inclusion[0].clone());
        assert!(truth(&phantom).size_mm.reason().unwrap().contains("2 inclusions"));
    }
}
