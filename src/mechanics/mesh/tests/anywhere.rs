//! Inclusions of any size at any place: a conforming mesh, or an error that says why not.

use proptest::prelude::*;

use super::*;

fn inclusion() -> impl Strategy<Value = InclusionShape> {
    let (aside, across, height) = (-28.0..28.0_f64, -8.0..8.0_f64, 0.2..24.8_f64);
    let semi = [0.3..7.0_f64, 0.3..7.0_f64, 0.3..7.0_f64];
    (aside, across, height, semi).prop_map(|(x, y, z, semi_axes_mm)| InclusionShape {
        center_mm: [x, y, z],
        surface: Star::Ellipsoid { semi_axes_mm },
    })
}

fn assert_mesh_or_reason(mesh: Result<Mesh, MeshError>, whole: f64, around: f64, tolerance: f64) {
    match mesh {
        Ok(mesh) => {
            let sum = mesh.integral(|_, _| 1.0);
            assert!((sum / whole - 1.0).abs() < tolerance, "measure {sum}, expected {whole}");
            assert_conforming(&mesh, around, tolerance * around);
            let quality = mesh.quality();
            assert!(quality.least_scaled_jacobian > 0.0, "{quality:?}");
        }
        Err(error) => assert!(!matches!(error, MeshError::Folded { .. } | MeshError::NotPositive { .. }), "{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn in_the_plane(inclusions in prop::collection::vec(inclusion(), 1..4)) {
        let body = PhantomMesh { symmetry: [false; 2], resolution: Resolution::PLANE.halved(), ..phantom(inclusions) };
        assert_mesh_or_reason(body.build_2d(), 60.0 * 25.0, 2.0 * (60.0 + 25.0), 1e-9);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn in_a_block(inclusions in prop::collection::vec(inclusion(), 1..3), round in any::<bool>()) {
        let half_widths_mm = [12.0, 10.0];
        let body = PhantomMesh {
            shape: PhantomShape::Block { size_mm: [60.0, 50.0], height_mm: 25.0 },
            footprint: if round { Footprint::Round { radius_mm: 15.0 } } else { Footprint::Rectangle { half_widths_mm } },
            symmetry: [false; 2],
            resolution: Resolution::SOLID.halved(),
            inclusions, offset_mm: [0.0; 2], layers_mm: Vec::new(),
        };
        let around = 2.0 * (60.0 * 50.0 + 60.0 * 25.0 + 50.0 * 25.0);
        assert_mesh_or_reason(body.build_3d(), 75_000.0, around, 1e-9);
    }

    #[test]
    fn in_a_cylinder(inclusions in prop::collection::vec(inclusion(), 1..3)) {
        let body = PhantomMesh { symmetry: [false; 2], resolution: Resolution::SOLID.halved(), ..phantom(inclusions) };
        // The rim is a chain of parabolas.
        assert_mesh_or_reason(body.build_3d(), PI * 900.0 * 25.0, 2.0 * PI * 30.0 * 55.0, 2e-3);
    }
}
