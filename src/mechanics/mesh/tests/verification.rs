use super::shapes::{cook, patch, shell};
use super::*;

#[test]
fn distorted_patches_fill_the_unit_square_and_cube() {
    for (dim, around) in [(2, 4.0), (3, 6.0)] {
        for bend in [0.0, 0.05] {
            let mesh = patch(dim, 3, 0.25, bend, 7).unwrap();
            assert_eq!(mesh.element_count(), 3usize.pow(dim as u32));
            assert_conforming(&mesh, around, 1e-12);
            assert!((measure(&mesh, 0, false) - 1.0).abs() < 1e-12);
            let quality = mesh.quality();
            assert!(quality.least_scaled_jacobian < 0.95, "not distorted: {quality:?}");
            assert!(!mesh.boundary_facets(Boundary::Touched).is_empty());
            assert_eq!(mesh, patch(dim, 3, 0.25, bend, 7).unwrap());
            assert_ne!(mesh.nodes, patch(dim, 3, 0.25, bend, 8).unwrap().nodes);
        }
    }
    assert!(matches!(patch(2, 3, 2.0, 0.0, 7), Err(MeshError::Folded { .. })));
}

#[test]
fn edges_of_a_patch_without_bend_are_straight() {
    let straight = |bend: f64| {
        let mesh = patch(2, 4, 0.25, bend, 3).unwrap();
        (0..mesh.element_count()).all(|e| {
            let p = mesh.element_positions(e);
            [[0, 1, 2], [6, 7, 8], [0, 3, 6], [2, 5, 8]]
                .iter()
                .all(|[a, m, b]| (0..2).all(|i| (p[*m][i] - 0.5 * (p[*a][i] + p[*b][i])).abs() < 1e-12))
        })
    };
    assert!(straight(0.0));
    assert!(!straight(0.05));
}

#[test]
fn volume_of_a_shell_converges_at_fourth_order() {
    let volume = 2.0 / 3.0 * PI * 7.0;
    let errors = [2, 4, 8].map(|n| {
        let mesh = shell(1.0, 2.0, n, 2 * n).unwrap();
        for node in mesh.boundary_nodes(Boundary::Touched) {
            let [x, z, _] = mesh.nodes[node as usize];
            assert!((x.hypot(z) - 1.0).abs() < 1e-12);
        }
        (measure(&mesh, 0, true) / volume - 1.0).abs()
    });
    assert!(errors.windows(2).all(|pair| (pair[0] / pair[1]).log2() > 3.7), "{errors:?}");
    assert!(errors[2] < 1e-6, "{errors:?}");
    for boundary in [Boundary::Touched, Boundary::Side] {
        assert_eq!(shell(1.0, 2.0, 3, 5).unwrap().boundary_facets(boundary).len(), 5);
    }
    for boundary in [Boundary::Base, Boundary::SymmetryX] {
        assert_eq!(shell(1.0, 2.0, 3, 5).unwrap().boundary_facets(boundary).len(), 3);
    }
    assert!(shell(2.0, 1.0, 3, 5).is_err());
}

#[test]
fn cooks_membrane_has_its_area() {
    let mesh = cook(4).unwrap();
    assert!((measure(&mesh, 0, false) - 48.0 * 0.5 * (44.0 + 16.0)).abs() < 1e-9);
    let loaded = mesh.boundary_nodes(Boundary::Touched);
    assert!(loaded.iter().any(|&n| mesh.nodes[n as usize] == [48.0, 52.0, 0.0]));
    assert_eq!(mesh.boundary_facets(Boundary::Base).len(), 4);
}

#[test]
fn a_layer_is_graded_to_the_edge_of_a_punch() {
    let radius = 2.0;
    let resolution =
        Resolution { coarsest_mm: 2.0, edge_mm: 0.01, growth: 0.4, ..Resolution::PLANE.scaled(radius / 15.0) };
    let layer = PhantomMesh {
        shape: PhantomShape::Cylinder { radius_mm: 40.0, height_mm: 5.0 },
        footprint: Footprint::Round { radius_mm: radius },
        resolution,
        ..phantom(vec![])
    };
    let lines = layer.contact_lines().unwrap().0;
    let last = lines.len() - 1;
    assert_eq!(lines[last], radius);
    assert!(lines[last] - lines[last - 1] < 0.01);
    let mesh = layer.build_2d().unwrap();
    assert_conforming(&mesh, 90.0, 1e-9);
    assert!(mesh.element_count() < 5000, "{:?}", mesh.quality());
}
