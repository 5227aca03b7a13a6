//! From the words of a scene to materials and shapes.

use super::material::{Law, Material, MaterialError, OgdenTerm, Prony};
use super::mesh::{Footprint, InclusionShape, PhantomShape, Star};
use crate::scene::{DataFileError, Elastic, Face, Inclusion, InclusionBody, PhantomBody, TriangleMesh, read_mesh};
use std::path::Path;
use std::sync::Arc;

/// The material of an elastic law.
///
/// # Errors
/// When a parameter makes no sense; never for a law of a validated scene.
pub fn material(elastic: &Elastic) -> Result<Material, MaterialError> {
    let poisson = elastic.poisson();
    let material = match elastic {
        Elastic::Linear { youngs_kpa, .. } => Material::linear(*youngs_kpa, poisson),
        Elastic::NeoHookean { youngs_kpa, .. } => Material::neo_hookean(*youngs_kpa, poisson),
        Elastic::Yeoh { c_kpa, .. } => Material::elastic(Law::Yeoh { c_kpa: *c_kpa }, poisson),
        Elastic::Ogden { terms, .. } => {
            let term =
                |term: &crate::scene::OgdenTerm| OgdenTerm { shear_kpa: term.shear_kpa, exponent: term.exponent };
            Material::elastic(Law::Ogden { terms: terms.iter().map(term).collect() }, poisson)
        }
        Elastic::Exponential { modulus_kpa, exponent, .. } => {
            Material::elastic(Law::Exponential { modulus_kpa: *modulus_kpa, exponent: *exponent }, poisson)
        }
    }?;
    let relaxation = elastic.relaxation().iter().map(|term| Prony { share: term.share, time_s: term.time_s });
    material.with_relaxation(relaxation.collect())
}

/// The outer shape of a phantom.
pub fn phantom_shape(body: &PhantomBody) -> PhantomShape {
    match *body {
        PhantomBody::Cylinder { radius_mm, height_mm } => PhantomShape::Cylinder { radius_mm, height_mm },
        PhantomBody::Block { size_mm, height_mm } => PhantomShape::Block { size_mm, height_mm },
    }
}

/// The outline of the contact.
pub fn footprint(face: &Face) -> Footprint {
    match *face {
        Face::Round { radius_mm } => Footprint::Round { radius_mm },
        Face::Rectangle { half_widths_mm } => Footprint::Rectangle { half_widths_mm },
    }
}

/// The shape and place of an inclusion; a mesh is read from its file, relative to `folder`.
///
/// # Errors
/// When the file of a mesh cannot be read or is none.
pub fn inclusion_shape(inclusion: &Inclusion, folder: &Path) -> Result<InclusionShape, DataFileError> {
    let (surface, reach_mm) = match &inclusion.shape {
        InclusionBody::Sphere { diameter_mm } => {
            (Star::Ellipsoid { semi_axes_mm: [diameter_mm / 2.0; 3] }, diameter_mm / 2.0)
        }
        &InclusionBody::Ellipsoid { semi_axes_mm } => (Star::Ellipsoid { semi_axes_mm }, semi_axes_mm[2]),
        InclusionBody::Mesh { file, scale } => {
            let mesh = scaled(read_mesh(&folder.join(file))?, *scale);
            let reach_mm = mesh.vertices.iter().fold(0.0, |reach: f64, vertex| reach.max(-vertex[2]));
            (Star::Mesh(Arc::new(mesh)), reach_mm)
        }
    };
    let [x, y] = inclusion.center_mm;
    Ok(InclusionShape { center_mm: [x, y, inclusion.center_depth_mm(reach_mm)], surface })
}

fn scaled(mut mesh: TriangleMesh, scale: f64) -> TriangleMesh {
    for coordinate in mesh.vertices.iter_mut().flatten() {
        *coordinate *= scale;
    }
    mesh
}
