use std::sync::Arc;

use super::*;
use crate::scene::TriangleMesh;

fn solid(inclusions: Vec<InclusionShape>) -> PhantomMesh {
    PhantomMesh { resolution: Resolution::SOLID, ..phantom(inclusions) }
}

fn block(inclusions: Vec<InclusionShape>) -> PhantomMesh {
    PhantomMesh {
        shape: PhantomShape::Block { size_mm: [60.0, 50.0], height_mm: 25.0 },
        footprint: Footprint::Rectangle { half_widths_mm: [12.0, 10.0] },
        symmetry: [false; 2],
        ..solid(inclusions)
    }
}

fn ellipsoid(center_mm: [f64; 3], semi_axes_mm: [f64; 3]) -> InclusionShape {
    InclusionShape { center_mm, surface: Star::Ellipsoid { semi_axes_mm } }
}

fn assert_sound(mesh: &Mesh, least_scaled: f64, worst_aspect: f64) {
    let quality = mesh.quality();
    println!("{quality:?}");
    assert!(quality.least_jacobian > 0.05, "{quality:?}");
    assert!(quality.least_scaled_jacobian > least_scaled, "{quality:?}");
    assert!(quality.worst_aspect < worst_aspect, "{quality:?}");
}

/// Surface of a quarter of a cylinder.
fn quarter_surface(radius: f64, height: f64) -> f64 {
    0.5 * PI * radius * radius + 0.5 * PI * radius * height + 2.0 * radius * height
}

#[test]
fn a_quarter_and_its_images_are_the_whole() {
    let quarter = PhantomMesh { resolution: Resolution::SOLID.halved(), ..phantom(vec![sphere(8.0, 5.0)]) };
    let part = quarter.build_3d().unwrap();
    let whole = part.whole([true; 2]);
    let volume = |mesh: &Mesh, region: u32| measure(mesh, region, false);
    assert!((0..2).all(|region| (volume(&whole.mesh, region) / volume(&part, region) - 4.0).abs() < 1e-9));
    // Nodes on the planes are not there twice.
    let around = 2.0 * PI * 30.0 * 55.0;
    assert_conforming(&whole.mesh, around, 2e-3 * around);
    let [found, expected] = [&whole.mesh, &part].map(Mesh::quality);
    assert!((found.least_jacobian / expected.least_jacobian - 1.0).abs() < 1e-9);
    for (node, (of, signs)) in whole.mesh.nodes.iter().zip(&whole.nodes) {
        assert!((0..3).all(|i| node[i] == signs[i] * part.nodes[*of as usize][i]));
    }
    let middle = |mesh: &Mesh, e: usize| mesh.nodes[mesh.element(e)[13] as usize];
    for (e, (of, signs)) in whole.elements.iter().enumerate() {
        let (at, source) = (middle(&whole.mesh, e), middle(&part, *of as usize));
        assert!((0..3).all(|i| at[i] == signs[i] * source[i]) && whole.mesh.region[e] == part.region[*of as usize]);
    }
    assert_eq!(part.whole([false; 2]).mesh, part);
}

#[test]
fn default_quarter_has_the_elements_meant() {
    let mesh = solid(vec![sphere(8.0, 5.0)]).build_3d().unwrap();
    assert!((1_500..4_000).contains(&mesh.element_count()), "{:?}", mesh.quality());
    assert_conforming(&mesh, quarter_surface(30.0, 25.0), 0.5);
    let wide = Resolution { ring_share: 1.0, ..Resolution::SOLID };
    assert_sound(&PhantomMesh { resolution: wide, ..solid(vec![sphere(8.0, 5.0)]) }.build_3d().unwrap(), 0.2, 15.0);
    // Rings about the contact are a third as wide as they are high.
    assert_sound(&mesh, 0.2, 20.0);
    let coarse = solid(vec![sphere(8.0, 5.0)]).halved().build_3d().unwrap();
    assert!((4..12).contains(&(mesh.element_count() / coarse.element_count())), "{:?}", coarse.quality());
    assert_sound(&coarse, 0.2, 15.0);
    for boundary in [Boundary::SymmetryX, Boundary::SymmetryY, Boundary::Touched, Boundary::Base, Boundary::Side] {
        assert!(!mesh.boundary_facets(boundary).is_empty());
    }
}

#[test]
fn all_phantom_inclusions_are_sound() {
    for (diameter, top) in [(2.0, 5.0), (14.0, 5.0), (7.0, 3.0), (7.0, 11.2), (8.0, 0.1)] {
        let mesh = solid(vec![sphere(diameter, top)]).build_3d().unwrap();
        assert_conforming(&mesh, quarter_surface(30.0, 25.0), 0.5);
        assert_sound(&mesh, 0.1, 60.0);
    }
}

#[test]
fn volumes_converge_at_fourth_order() {
    let errors = [1, 2].map(|subdivision| {
        let resolution = Resolution { subdivision, ..Resolution::SOLID };
        let mesh = PhantomMesh { resolution, ..phantom(vec![sphere(8.0, 5.0)]) }.build_3d().unwrap();
        let (ball, whole) = (PI / 3.0 * 64.0, PI / 4.0 * 900.0 * 25.0);
        let volume = measure(&mesh, 1, false);
        [(volume / ball - 1.0).abs(), ((volume + measure(&mesh, 0, false)) / whole - 1.0).abs()]
    });
    assert!(errors[0].iter().zip(errors[1]).all(|(coarse, fine)| (coarse / fine).log2() > 3.6), "{errors:?}");
    assert!(errors[0].iter().all(|&error| error < 1e-3), "{errors:?}");
}

#[test]
fn nodes_of_an_ellipsoid_off_the_axis_lie_on_it() {
    let (center, semi) = ([2.0, -3.0, 9.0], [4.0, 2.0, 3.0]);
    let mesh = PhantomMesh { symmetry: [false; 2], ..solid(vec![ellipsoid(center, semi)]) }.build_3d().unwrap();
    let of = |region: u32| {
        let elements = (0..mesh.element_count()).filter(|&e| mesh.region[e] == region);
        elements.flat_map(|e| mesh.element(e).to_vec()).collect::<std::collections::BTreeSet<u32>>()
    };
    let shared: Vec<u32> = of(0).intersection(&of(1)).copied().collect();
    assert!(shared.len() > 200);
    for node in shared {
        let at = mesh.nodes[node as usize];
        let off = (0..3).map(|i| ((at[i] - center[i]) / semi[i]).powi(2)).sum::<f64>() - 1.0;
        assert!(off.abs() < 1e-12, "{off}");
    }
    assert_conforming(&mesh, 2.0 * PI * 900.0 + 2.0 * PI * 30.0 * 25.0, 1.0);
    assert!((measure(&mesh, 1, false) / (4.0 / 3.0 * PI * 24.0) - 1.0).abs() < 2e-3);
}

#[test]
fn several_inclusions_in_a_block_under_a_rectangle() {
    let inclusions = vec![ellipsoid([-8.0, 2.0, 8.0], [4.0; 3]), ellipsoid([5.0, -3.0, 6.0], [3.0, 3.0, 2.0])];
    let body = block(inclusions);
    let mesh = body.build_3d().unwrap();
    assert_conforming(&mesh, 2.0 * (60.0 * 50.0 + 60.0 * 25.0 + 50.0 * 25.0), 1e-6);
    assert_sound(&mesh, 0.1, 40.0);
    let volume = measure(&mesh, 0, false) + measure(&mesh, 1, false) + measure(&mesh, 2, false);
    assert!((volume - 75_000.0).abs() < 1e-6);
    for edge in [-12.0, 12.0] {
        assert!(mesh.boundary_nodes(Boundary::Touched).iter().any(|&n| mesh.nodes[n as usize][0] == edge));
    }
}

#[test]
fn sensors_share_the_nodes_of_the_contact() {
    let inside = |at: [f64; 3], footprint: Footprint| match footprint {
        Footprint::Round { radius_mm } => at[0].hypot(at[1]) < radius_mm + 1e-9,
        Footprint::Rectangle { half_widths_mm: half } => (0..2).all(|i| at[i].abs() < half[i] + 1e-9),
    };
    let round_on_block = PhantomMesh { footprint: Footprint::Round { radius_mm: 12.0 }, ..block(vec![]) };
    let rectangle_on_round = PhantomMesh { footprint: block(vec![]).footprint, ..solid(vec![sphere(8.0, 5.0)]) };
    for body in [solid(vec![sphere(8.0, 0.5)]), block(vec![sphere(8.0, 5.0)]), round_on_block, rectangle_on_round] {
        let sensor = SensorMesh {
            footprint: body.footprint,
            layers_mm: vec![5.0, 3.0, 2.0],
            symmetry: body.symmetry,
            resolution: body.resolution,
            edge_radius_mm: 0.0,
        };
        let (tissue, stack) = (body.build_3d().unwrap(), sensor.build_3d(Some(&body)).unwrap());
        assert_sound(&tissue, 0.1, 40.0);
        assert_sound(&stack, 0.2, 40.0);
        let quarter = if body.symmetry[0] { 0.25 } else { 1.0 };
        let area = match body.footprint {
            Footprint::Round { radius_mm } => PI * radius_mm * radius_mm,
            Footprint::Rectangle { half_widths_mm: half } => 4.0 * half[0] * half[1],
        };
        for (region, thickness) in [(0, 5.0), (1, 3.0), (2, 2.0)] {
            assert!((measure(&stack, region, false) / (quarter * area * thickness) - 1.0).abs() < 1e-3);
        }
        let touched = |mesh: &Mesh| -> Vec<[f64; 3]> {
            let nodes = mesh.boundary_nodes(Boundary::Touched).into_iter().map(|n| mesh.nodes[n as usize]);
            nodes.filter(|&at| inside(at, body.footprint)).collect()
        };
        let (above, below) = (touched(&tissue), touched(&stack));
        assert_eq!(above.len(), below.len());
        let near = |a: &[f64; 3]| below.iter().any(|b| (0..2).all(|i| (a[i] - b[i]).abs() < 1e-9));
        assert!(above.iter().all(near));
        assert!(sensor.build_3d(None).unwrap().element_count() > 10);
    }
}

/// A surface of triangles through the corners of an octahedron, refined and pushed out to `radius` of the direction.
fn star(refinements: usize, radius: impl Fn([f64; 3]) -> f64) -> TriangleMesh {
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    let mut triangles = Vec::new();
    let n = 1 << refinements;
    for octant in 0..8 {
        let sign = |i: usize| if octant >> i & 1 == 0 { 1.0 } else { -1.0 };
        let mut vertex = |a: usize, b: usize| {
            let u = [(n - a - b) as f64 * sign(0), a as f64 * sign(1), b as f64 * sign(2)];
            let length = u.iter().map(|x| x * x).sum::<f64>().sqrt();
            let u = u.map(|x| x / length);
            vertices.push(u.map(|x| x * radius(u)));
            vertices.len() as u32 - 1
        };
        for a in 0..n {
            for b in 0..n - a {
                triangles.push([vertex(a, b), vertex(a + 1, b), vertex(a, b + 1)]);
                if a + b + 2 <= n {
                    triangles.push([vertex(a + 1, b), vertex(a + 1, b + 1), vertex(a, b + 1)]);
                }
            }
        }
    }
    TriangleMesh { vertices, triangles }
}

#[test]
fn a_star_of_triangles_keeps_its_volume() {
    let wavy = |u: [f64; 3]| 4.0 * (1.0 + 0.2 * u[2] * u[0] + 0.1 * u[1]);
    let surface = star(4, wavy);
    let corner = |t: &[u32; 3], i: usize| surface.vertices[t[i] as usize];
    let volume: f64 = surface
        .triangles
        .iter()
        .map(|t| {
            let (a, b, c) = (corner(t, 0), corner(t, 1), corner(t, 2));
            (a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0]))
                .abs()
                / 6.0
        })
        .sum();
    let shape = InclusionShape { center_mm: [1.0, -1.0, 9.0], surface: Star::Mesh(Arc::new(surface)) };
    let mesh = block(vec![shape]).build_3d().unwrap();
    assert_sound(&mesh, 0.1, 40.0);
    // Elements of 1 to 2 mm across flat triangles of 0.3 mm.
    assert!((measure(&mesh, 1, false) / volume - 1.0).abs() < 5e-3);
}

#[test]
fn errors_in_three_dimensions_name_their_numbers() {
    // Two balls, one within the other: every ray meets two surfaces.
    let (mut twice, inner) = (star(1, |_| 4.0), star(1, |_| 2.0));
    let offset = twice.vertices.len() as u32;
    twice.vertices.extend(inner.vertices);
    twice.triangles.extend(inner.triangles.iter().map(|t| t.map(|vertex| vertex + offset)));
    let shape = InclusionShape { center_mm: [0.0, 0.0, 9.0], surface: Star::Mesh(Arc::new(twice)) };
    assert!(matches!(block(vec![shape]).build_3d(), Err(MeshError::NotStarShaped { inclusion: 1, hits: 2, .. })));
    let far = PhantomMesh { footprint: Footprint::Rectangle { half_widths_mm: [25.0; 2] }, ..solid(vec![]) };
    assert!(matches!(far.build_3d(), Err(MeshError::TooFarOut { .. })));
    let error = block(vec![ellipsoid([27.0, 0.0, 10.0], [4.0; 3])]).build_3d().unwrap_err().to_string();
    assert!(error.contains("inclusion 1 is -1 mm from the side"), "{error}");
    // A sensor of another outline than the phantom was meshed for.
    let body = solid(vec![]);
    let sensor = SensorMesh {
        footprint: Footprint::Round { radius_mm: 9.0 },
        layers_mm: vec![10.0],
        symmetry: body.symmetry,
        resolution: body.resolution,
        edge_radius_mm: 0.0,
    };
    assert!(matches!(sensor.build_3d(Some(&body)), Err(MeshError::NoSharedEdge { .. })));
    let resolution = Resolution { coarsest_mm: 0.1, ..Resolution::SOLID };
    assert!(matches!(PhantomMesh { resolution, ..block(vec![]) }.build_3d(), Err(MeshError::TooMany { .. })));
}
