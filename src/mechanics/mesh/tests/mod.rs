//! Meshes: areas, conformity, surfaces, errors.

use std::f64::consts::PI;

use super::*;

mod anywhere;
mod fitted;
mod layered;
mod plane;
mod solid;
mod verification;

/// The phantom of the press: radius 30, height 25, sensor radius 15 mm.
fn phantom(inclusions: Vec<InclusionShape>) -> PhantomMesh {
    PhantomMesh {
        shape: PhantomShape::Cylinder { radius_mm: 30.0, height_mm: 25.0 },
        inclusions,
        footprint: Footprint::Round { radius_mm: 15.0 },
        symmetry: [true, true],
        resolution: Resolution::PLANE,
        offset_mm: [0.0; 2],
        layers_mm: Vec::new(),
    }
}

/// A sphere on the axis by diameter and depth of its top, mm.
fn sphere(diameter: f64, top: f64) -> InclusionShape {
    let radius = 0.5 * diameter;
    InclusionShape { center_mm: [0.0, 0.0, top + radius], surface: Star::Ellipsoid { semi_axes_mm: [radius; 3] } }
}

/// Area or volume of a region, weighted by 2 pi r on request.
fn measure(mesh: &Mesh, region: u32, round: bool) -> f64 {
    mesh.integral(|of, at| {
        if of != region {
            0.0
        } else if round {
            2.0 * PI * at[0]
        } else {
            1.0
        }
    })
}

/// Every face is shared by two elements or a facet of the boundary, and the boundary has the right measure: a gap or
/// an overlap inside would add to it.
fn assert_conforming(mesh: &Mesh, boundary_measure: f64, tolerance: f64) {
    let mut faces = std::collections::HashMap::new();
    for element in 0..mesh.element_count() as u32 {
        for side in 0..2 * mesh.dim as u8 {
            let mut nodes = mesh.facet_nodes(Facet { element, side, boundary: Boundary::Side });
            nodes.sort_unstable();
            *faces.entry(nodes).or_insert(0) += 1;
        }
    }
    assert!(faces.values().all(|&uses| uses == 1 || uses == 2));
    assert_eq!(faces.values().filter(|&&uses| uses == 1).count(), mesh.facets.len());
    let mut sum = 0.0;
    for &facet in &mesh.facets {
        let nodes: Vec<[f64; 3]> = mesh.facet_nodes(facet).iter().map(|&n| mesh.nodes[n as usize]).collect();
        sum += super::quality::face_measure(mesh.dim, &nodes);
    }
    assert!((sum - boundary_measure).abs() < tolerance, "boundary {sum}, expected {boundary_measure}");
}

#[test]
#[should_panic(expected = "boundary")]
fn a_mesh_with_a_gap_inside_does_not_pass_as_conforming() {
    let mut mesh = phantom(vec![sphere(8.0, 5.0)]).build_2d().unwrap();
    // One element of the inclusion gets nodes of its own, as if they had not been welded.
    let element = (0..mesh.element_count()).find(|&e| mesh.region[e] == 1).unwrap();
    for a in element * 9..(element + 1) * 9 {
        mesh.nodes.push(mesh.nodes[mesh.elements[a] as usize]);
        mesh.elements[a] = mesh.nodes.len() as u32 - 1;
    }
    mesh.facets = super::builder::boundary(&mesh);
    assert_conforming(&mesh, 2.0 * (30.0 + 25.0), 1e-9);
}
