//! A cycle takes most of any error away, and no longer where one of its parts is wrong.

use super::*;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Boundary, Footprint, InclusionShape, PhantomMesh, PhantomShape, Resolution, Star};
use crate::mechanics::solid::element_system;

/// Cycles after which the contraction is read: that of the slowest error.
const CYCLES: usize = 16;
/// Share of an error that a cycle of a right hierarchy may leave.
const LEFT: f64 = 0.85;

fn body() -> Mesh {
    let ball = InclusionShape { center_mm: [0.0, 0.0, 9.0], surface: Star::Ellipsoid { semi_axes_mm: [4.0; 3] } };
    PhantomMesh {
        shape: PhantomShape::Cylinder { radius_mm: 30.0, height_mm: 25.0 },
        inclusions: vec![ball],
        footprint: Footprint::Round { radius_mm: 15.0 },
        symmetry: [true; 2],
        resolution: Resolution::SOLID.finer(0.4),
        offset_mm: [0.0; 2],
        layers_mm: Vec::new(),
    }
    .build_3d()
    .unwrap()
}

/// A hierarchy of the body on its base, without entries.
fn hierarchy(mesh: &Mesh) -> Multigrid {
    let mut held = vec![[false; 3]; mesh.nodes.len()];
    mesh.boundary_nodes(Boundary::Base).into_iter().for_each(|node| held[node as usize] = [true; 3]);
    for (axis, boundary) in [Boundary::SymmetryX, Boundary::SymmetryY].into_iter().enumerate() {
        mesh.boundary_nodes(boundary).into_iter().for_each(|node| held[node as usize][axis] = true);
    }
    Multigrid::new(mesh, held, &[])
}

/// Adds the stiffness of the body of 5 kPa with a ball of another modulus.
fn fill(multigrid: &mut Multigrid, mesh: &Mesh, ball_kpa: f64) {
    multigrid.clear();
    for e in 0..mesh.element_count() {
        let nodes = mesh.element_positions(e);
        let material = Material::linear(if mesh.region[e] == 1 { ball_kpa } else { 5.0 }, 0.3).unwrap();
        let (still, bulk) = (vec![[0.0; 3]; nodes.len()], 2.0 * material.law.shear_kpa());
        let system =
            element_system(Kinematics::ThreeDimensional, &nodes, &still, &[0.0; 4], &material, None, Some(bulk));
        multigrid.add_elements(&[(mesh.element(e), &system.unwrap().stiffness)]);
    }
}

/// Share of an error that a cycle leaves in the end, in the size of the residual.
fn left(multigrid: &mut Multigrid) -> f64 {
    let n = 3 * multigrid.fine.nodes();
    let held: Vec<bool> = multigrid.transfer.held[0].iter().flatten().copied().collect();
    let force = |k: usize| if held[k] { 0.0 } else { (k as f64 * 0.618_034).fract() - 0.5 };
    let mut rest: Vec<f64> = (0..n).map(force).collect();
    let size = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut share = 1.0;
    for _ in 0..CYCLES {
        let before = size(&rest);
        let step = multigrid.cycle(&rest);
        let mut taken = vec![0.0; n];
        multigrid.multiply(&step, &mut taken);
        rest.iter_mut().zip(&taken).for_each(|(rest, taken)| *rest -= taken);
        share = size(&rest) / before;
    }
    share
}

#[test]
fn a_cycle_takes_most_of_an_error_unless_a_part_of_it_is_wrong() {
    let mesh = body();
    let mut multigrid = hierarchy(&mesh);
    for ball_kpa in [5.0, 5e3, 5e-3] {
        fill(&mut multigrid, &mesh, ball_kpa);
        multigrid.finish().unwrap();
        let share = left(&mut multigrid);
        println!("ball of {ball_kpa} kPa: {share:.3} left");
        assert!(share < LEFT, "ball of {ball_kpa} kPa: {share}");
    }
    let smoothers = |multigrid: &mut Multigrid, change: &dyn Fn(&mut [Smoother; 2])| {
        fill(multigrid, &mesh, 120.0);
        multigrid.finish().unwrap();
        multigrid.smoothers.iter_mut().for_each(change);
        left(multigrid)
    };
    let right = smoothers(&mut multigrid, &|_| ());
    assert!(right < LEFT, "{right}");
    let narrow = smoothers(&mut multigrid, &|both| both[0].largest *= 0.3);
    let wide = smoothers(&mut multigrid, &|both| both[0].largest *= 10.0);
    let coarse = smoothers(&mut multigrid, &|both| both[1].largest *= 0.3);
    // Smoothers and coarsest factor of a ball a thousand times softer.
    fill(&mut multigrid, &mesh, 0.12);
    multigrid.finish().unwrap();
    let old = (multigrid.smoothers.clone(), multigrid.aggregates.take());
    fill(&mut multigrid, &mesh, 120.0);
    multigrid.fine.fix();
    multigrid.coarse.fix();
    (multigrid.smoothers, multigrid.aggregates) = old;
    let stale = left(&mut multigrid);
    println!("right {right:.3}, too narrow {narrow:.3}, too wide {wide:.3}, coarse {coarse:.3}, stale {stale:.3}");
    for (what, share) in [("narrow", narrow), ("wide", wide), ("coarse too narrow", coarse), ("stale", stale)] {
        assert!(share.is_nan() || share > LEFT, "{what}: {share}");
    }
}
