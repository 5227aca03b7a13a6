use super::*;

fn assert_sound(mesh: &Mesh, least_scaled: f64, worst_aspect: f64) {
    let quality = mesh.quality();
    assert!(quality.least_jacobian > 0.05, "{quality:?}");
    assert!(quality.least_scaled_jacobian > least_scaled, "{quality:?}");
    assert!(quality.worst_aspect < worst_aspect, "{quality:?}");
}

#[test]
fn default_phantom_has_the_unknowns_meant() {
    let mesh = phantom(vec![sphere(8.0, 5.0)]).build_2d().unwrap();
    let unknowns = 2 * mesh.nodes.len();
    assert!((12_000..20_000).contains(&unknowns), "{unknowns} {:?}", mesh.quality());
    assert_sound(&mesh, 0.3, 12.0);
}

#[test]
fn all_phantom_inclusions_are_conforming_and_sound() {
    for (diameter, top) in [
        (2.0, 5.0),
        (8.0, 5.0),
        (14.0, 5.0),
        (7.0, 3.0),
        (7.0, 7.0),
        (7.0, 11.2),
        (10.0, 5.0),
        (8.0, 0.05),
        (8.0, 16.9),
    ] {
        for resolution in [Resolution::PLANE, Resolution::PLANE.halved()] {
            let mesh = PhantomMesh { resolution, ..phantom(vec![sphere(diameter, top)]) }.build_2d().unwrap();
            assert_conforming(&mesh, 2.0 * (30.0 + 25.0), 1e-9);
            println!("{diameter} {top} {:?}", mesh.quality());
            assert_sound(&mesh, 0.2, 40.0);
        }
    }
}

#[test]
fn nodes_of_the_surface_lie_on_it_to_round_off() {
    let shape =
        InclusionShape { center_mm: [3.0, 0.0, 9.0], surface: Star::Ellipsoid { semi_axes_mm: [5.0, 1.0, 3.0] } };
    let mesh = PhantomMesh { symmetry: [false; 2], ..phantom(vec![shape]) }.build_2d().unwrap();
    let of = |region: u32| {
        let elements = (0..mesh.element_count()).filter(|&e| mesh.region[e] == region);
        elements.flat_map(|e| mesh.element(e).to_vec()).collect::<std::collections::BTreeSet<u32>>()
    };
    let shared: Vec<u32> = of(0).intersection(&of(1)).copied().collect();
    assert!(shared.len() > 60);
    for node in shared {
        let [x, z, _] = mesh.nodes[node as usize];
        let off = ((x - 3.0) / 5.0).powi(2) + ((z - 9.0) / 3.0).powi(2) - 1.0;
        assert!(off.abs() < 1e-12, "{off}");
    }
}

#[test]
fn areas_and_volumes_of_regions_converge_at_fourth_order_or_better() {
    let errors: Vec<[f64; 2]> = [1, 2, 4]
        .map(|subdivision| {
            let resolution = Resolution { subdivision, ..Resolution::PLANE };
            let mesh = PhantomMesh { resolution, ..phantom(vec![sphere(8.0, 5.0)]) }.build_2d().unwrap();
            let whole = 30.0 * 25.0;
            let area = measure(&mesh, 1, false);
            assert!((area + measure(&mesh, 0, false) - whole).abs() < 1e-9 * whole);
            let volume = 4.0 / 3.0 * PI * 64.0;
            [(area / (0.5 * PI * 16.0) - 1.0).abs(), (measure(&mesh, 1, true) / volume - 1.0).abs()]
        })
        .to_vec();
    for pair in errors.windows(2) {
        assert!(pair[0].iter().zip(pair[1]).all(|(coarse, fine)| (coarse / fine).log2() > 3.7), "{errors:?}");
    }
    assert!(errors[1].iter().all(|&error| error < 1e-5), "{errors:?}");
}

#[test]
fn meshes_of_a_ladder_are_nested() {
    let base = phantom(vec![sphere(8.0, 5.0)]);
    let (fine, coarse) = (base.build_2d().unwrap(), base.halved().build_2d().unwrap());
    assert_eq!(fine.element_count(), 4 * coarse.element_count());
    let fine_lines = base.contact_lines().unwrap();
    for line in base.halved().contact_lines().unwrap().0 {
        assert!(fine_lines.0.iter().any(|&x| (x - line).abs() < 1e-12));
    }
}

#[test]
fn the_next_coarser_mesh_is_nested_whatever_the_subdivision() {
    let of = |subdivision| Resolution { subdivision, ..Resolution::PLANE };
    for (subdivision, divisor) in [(3, 3), (9, 3), (4, 2)] {
        let (fine, coarse) = (of(subdivision), of(subdivision).coarsened());
        assert_eq!(coarse.subdivision * divisor, subdivision);
        let lines =
            |resolution| PhantomMesh { resolution, ..phantom(vec![sphere(8.0, 5.0)]) }.contact_lines().unwrap().0;
        let lines_of_fine = lines(fine);
        for line in lines(coarse) {
            assert!(lines_of_fine.iter().any(|&x| (x - line).abs() < 1e-9), "{subdivision}: {line}");
        }
    }
    assert_eq!(of(1).coarsened(), of(1).halved());
}

#[test]
fn several_inclusions_in_full_width() {
    let at = |x: f64, z: f64, semi: [f64; 3]| InclusionShape {
        center_mm: [x, 0.0, z],
        surface: Star::Ellipsoid { semi_axes_mm: semi },
    };
    let inclusions = vec![
        at(-8.0, 8.0, [4.0, 4.0, 4.0]),
        at(1.0, 6.0, [3.0, 3.0, 2.0]),
        at(15.0, 10.0, [2.0, 2.0, 2.0]),
        at(1.2, 15.0, [4.0, 4.0, 3.0]),
    ];
    let mesh = PhantomMesh {
        shape: PhantomShape::Block { size_mm: [80.0, 80.0], height_mm: 25.0 },
        symmetry: [false; 2],
        ..phantom(inclusions)
    }
    .build_2d()
    .unwrap();
    assert_conforming(&mesh, 2.0 * (80.0 + 25.0), 1e-9);
    println!("{:?}", mesh.quality());
    assert_sound(&mesh, 0.2, 40.0);
    for (region, area) in [(1, 16.0), (2, 6.0), (3, 4.0), (4, 12.0)] {
        assert!((measure(&mesh, region, false) / (PI * area) - 1.0).abs() < 1e-4);
    }
}

#[test]
fn half_of_a_symmetric_mesh_is_the_mesh_of_the_half() {
    let half = phantom(vec![sphere(8.0, 5.0)]).build_2d().unwrap();
    let whole = PhantomMesh { symmetry: [false; 2], ..phantom(vec![sphere(8.0, 5.0)]) }.build_2d().unwrap();
    for mesh in [&half, &whole] {
        assert_conforming(mesh, 2.0 * (25.0 + if mesh.nodes.len() == half.nodes.len() { 30.0 } else { 60.0 }), 1e-9);
    }
    assert!(!half.boundary_nodes(Boundary::SymmetryX).is_empty());
    assert!(whole.boundary_nodes(Boundary::SymmetryX).is_empty());
    assert!((measure(&whole, 1, false) - 2.0 * measure(&half, 1, false)).abs() < 1e-3);
}

#[test]
fn sensor_shares_the_nodes_of_the_contact() {
    let body = phantom(vec![sphere(8.0, 0.5)]);
    let sensor = SensorMesh {
        footprint: body.footprint,
        layers_mm: vec![5.0, 3.0, 2.0],
        symmetry: body.symmetry,
        resolution: body.resolution,
        edge_radius_mm: 0.0,
    };
    let (tissue, stack) = (body.build_2d().unwrap(), sensor.build_2d(Some(&body)).unwrap());
    assert_conforming(&stack, 2.0 * (15.0 + 10.0), 1e-9);
    for (region, thickness) in [(0, 5.0), (1, 3.0), (2, 2.0)] {
        assert!((measure(&stack, region, false) - 15.0 * thickness).abs() < 1e-9);
    }
    let touched = |mesh: &Mesh| {
        let mut x: Vec<f64> = mesh
            .boundary_nodes(Boundary::Touched)
            .iter()
            .map(|&n| mesh.nodes[n as usize][0])
            .filter(|&x| x <= 15.0)
            .collect();
        x.sort_by(f64::total_cmp);
        x
    };
    let (above, below) = (touched(&tissue), touched(&stack));
    assert_eq!(above.len(), below.len());
    assert!(above.iter().zip(&below).all(|(a, b)| (a - b).abs() < 1e-12));
    assert_conforming(&sensor.build_2d(None).unwrap(), 50.0, 1e-9);
}

#[test]
fn impossible_inclusions_are_named_with_their_numbers() {
    let error = |inclusions: Vec<InclusionShape>, symmetry: [bool; 2]| {
        PhantomMesh { symmetry, ..phantom(inclusions) }.build_2d().unwrap_err().to_string()
    };
    assert!(error(vec![sphere(8.0, -0.5)], [true; 2]).contains("inclusion 1 is -0.5 mm from the touched face"));
    assert!(error(vec![sphere(8.0, 18.0)], [true; 2]).contains("inclusion 1 is -1 mm from the base"));
    let mut aside = sphere(8.0, 5.0);
    aside.center_mm[0] = 27.0;
    assert!(error(vec![aside.clone()], [false; 2]).contains("inclusion 1 is -1 mm from the side"));
    aside.center_mm[0] = 1.0;
    assert!(error(vec![aside.clone()], [true; 2]).contains("cut by the plane of symmetry x = 0"));
    assert!(error(vec![aside, sphere(2.0, 5.0)], [false; 2]).contains("inclusions 1 and 2 overlap"));
    assert!(error(vec![sphere(0.0, 5.0)], [true; 2]).contains("semi-axis of an inclusion must be positive"));
    assert!(error(vec![sphere(f64::NAN, 5.0)], [true; 2]).contains("must be positive and finite"));
    let resolution = Resolution { coarsest_mm: 1e-3, ..Resolution::PLANE };
    let fine = PhantomMesh { resolution, ..phantom(vec![]) };
    assert!(matches!(fine.build_2d(), Err(MeshError::TooMany { .. })));
}

#[test]
fn boundaries_lie_where_their_names_say() {
    let mesh = phantom(vec![sphere(8.0, 5.0)]).build_2d().unwrap();
    assert_eq!(mesh.bounding_box(), [[0.0; 3], [30.0, 25.0, 0.0]]);
    let cases = [
        (Boundary::Touched, 1, 0.0),
        (Boundary::Base, 1, 25.0),
        (Boundary::SymmetryX, 0, 0.0),
        (Boundary::Side, 0, 30.0),
    ];
    for (boundary, axis, at) in cases {
        let nodes = mesh.boundary_nodes(boundary);
        let there = mesh.nodes.iter().filter(|node| node[axis] == at).count();
        assert_eq!(nodes.len(), there);
        assert!(nodes.iter().all(|&n| mesh.nodes[n as usize][axis] == at));
        assert_eq!(nodes.len(), 2 * mesh.boundary_facets(boundary).len() + 1);
    }
}

#[test]
fn a_rim_is_an_arc_that_the_top_layer_carries() {
    for (edge_radius_mm, tolerance) in [(0.5, 1e-6), (2.0, 1e-6)] {
        let sensor = SensorMesh {
            footprint: Footprint::Round { radius_mm: 15.0 },
            layers_mm: vec![5.0, 3.0, 2.0],
            symmetry: [true, false],
            resolution: Resolution { edge_mm: 0.2, ..Resolution::PLANE },
            edge_radius_mm,
        };
        let mesh = sensor.build_2d(None).unwrap();
        assert_sound(&mesh, 0.45, 40.0);
        // The arc turns by 60 degrees and ends at the side.
        let (sin, cos) = std::f64::consts::FRAC_PI_3.sin_cos();
        let start = 15.0 - edge_radius_mm * sin;
        let mut on_arc = 0;
        for node in mesh.boundary_nodes(Boundary::Touched) {
            let [x, z, _] = mesh.nodes[node as usize];
            let off = if x > start { (x - start).hypot(z + edge_radius_mm) - edge_radius_mm } else { z };
            assert!(off.abs() < 1e-12, "{x} {z}");
            on_arc += usize::from(x > start);
        }
        assert!(on_arc >= 4, "{on_arc}");
        let lost = edge_radius_mm.powi(2) * (sin - 0.5 * std::f64::consts::FRAC_PI_3 - 0.5 * sin * cos);
        let area = mesh.integral(|_, _| 1.0);
        assert!((area - (150.0 - lost)).abs() < tolerance * 150.0, "{area} {lost}");
        // Only the top layer gives way.
        let below = (0..mesh.element_count()).filter(|&e| mesh.region[e] < 2);
        assert!(below.flat_map(|e| mesh.element_positions(e)).all(|[x, z, _]| x <= 15.0 && z <= -2.0 + 1e-12));
    }
}
