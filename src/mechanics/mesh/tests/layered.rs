//! Layers of the phantom: their measures, with inclusions in boxes and fitted, and what may not cross them.

use super::*;

/// Skin of 3 mm over 4 mm over the rest of the phantom's 25 mm.
const LAYERS_MM: [f64; 2] = [3.0, 4.0];

fn layered(inclusions: Vec<InclusionShape>) -> PhantomMesh {
    PhantomMesh { layers_mm: LAYERS_MM.to_vec(), ..phantom(inclusions) }
}

fn ball(center_mm: [f64; 3], radius: f64) -> InclusionShape {
    InclusionShape { center_mm, surface: Star::Ellipsoid { semi_axes_mm: [radius; 3] } }
}

/// Measures of body, inclusions and layers, the whole of a section of 1 mm2 or of the body.
fn assert_measures(mesh: &Mesh, section: f64, round: bool, inclusions: &[(f64, f64)]) {
    let held = |from: f64, to: f64| -> f64 {
        inclusions.iter().filter(|(at, _)| from < *at && *at < to).map(|(_, volume)| volume).sum()
    };
    let close = |region: usize, expected: f64| {
        let found = measure(mesh, region as u32, round);
        assert!((found / expected - 1.0).abs() < 3e-3, "region {region}: {found}, expected {expected}");
    };
    let first = inclusions.len() + 1;
    let [one, two] = LAYERS_MM;
    close(first, section * one - held(0.0, one));
    close(first + 1, section * two - held(one, one + two));
    close(0, section * (25.0 - one - two) - held(one + two, 25.0));
    for (k, (_, volume)) in inclusions.iter().enumerate() {
        close(k + 1, *volume);
    }
}

fn volume(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

#[test]
fn layers_have_their_heights_whatever_lies_in_them() {
    let axis = ball([0.0, 0.0, 12.0], 4.0);
    let flat = layered(vec![axis.clone(), ball([0.0, 0.0, 5.0], 1.5)]);
    let held = [(12.0, volume(4.0)), (5.0, volume(1.5))];
    assert_measures(&flat.build_2d().unwrap(), PI * 900.0, true, &held);
    let solid = |inclusions: Vec<InclusionShape>| PhantomMesh {
        resolution: Resolution::SOLID.halved(),
        symmetry: [false; 2],
        ..layered(inclusions)
    };
    assert_measures(&solid(Vec::new()).build_3d().unwrap(), PI * 900.0, false, &[]);
    let boxed = solid(vec![ball([5.0, 0.0, 12.0], 4.0)]);
    assert!(boxed.boxed().unwrap());
    assert_measures(&boxed.build_3d().unwrap(), PI * 900.0, false, &[(12.0, volume(4.0))]);
    // Across the contact's circle, 0.1 mm from either face of the second layer.
    let fitted = solid(vec![ball([15.0, 0.0, 5.0], 1.9)]);
    assert!(!fitted.boxed().unwrap());
    let mesh = fitted.build_3d().unwrap();
    assert_measures(&mesh, PI * 900.0, false, &[(5.0, volume(1.9))]);
    for element in (0..mesh.element_count()).filter(|&e| mesh.region[e] == 2) {
        assert!(mesh.element_positions(element).iter().all(|at| at[2] < LAYERS_MM[0] + 1e-9), "the skin sags");
    }
    let around = 2.0 * PI * 30.0 * 55.0;
    assert_conforming(&mesh, around, 2e-3 * around);
}

#[test]
fn an_inclusion_lies_in_one_layer() {
    for (z, radius) in [(3.0, 1.0), (6.5, 1.0), (4.9, 1.9), (10.0, 5.0)] {
        for round in [true, false] {
            let body = layered(vec![ball([0.0, 0.0, z], radius)]);
            let error = if round { body.build_2d() } else { body.build_3d() }.unwrap_err();
            let crosses = matches!(error, MeshError::SticksOut { inclusion: 1, face: "interface of two layers", .. });
            assert!(crosses, "{z}: {error}");
        }
    }
    let thick = PhantomMesh { layers_mm: vec![20.0, 5.0], ..phantom(Vec::new()) };
    assert!(matches!(thick.build_2d(), Err(MeshError::NotPositive { value: 0.0, .. })));
    let none = PhantomMesh { layers_mm: vec![0.0], ..phantom(Vec::new()) };
    assert!(matches!(none.build_2d(), Err(MeshError::NotPositive { value: 0.0, .. })));
}

#[test]
fn without_inclusions_each_is_of_what_surrounds_it() {
    let body = layered(vec![ball([0.0, 0.0, 12.0], 4.0), ball([0.0, 0.0, 5.0], 1.5), ball([0.0, 0.0, 1.5], 1.0)]);
    let materials = ["fat", "lump", "nodule", "mole", "skin", "dermis"];
    assert_eq!(body.plain(&materials), ["fat", "fat", "dermis", "skin", "skin", "dermis"]);
}
