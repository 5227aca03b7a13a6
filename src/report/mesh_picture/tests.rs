use super::super::svg::{assert_well_formed, keep_sample};
use super::*;

/// A grid of quadratic elements over [0, width] x [bottom, bottom + height], bent by `bend`, with regions by its
/// middle.
fn grid([columns, rows]: [usize; 2], bend: &dyn Fn([f64; 2]) -> [f64; 2], region: &dyn Fn([f64; 2]) -> u32) -> Mesh {
    let nodes_across = 2 * columns + 1;
    let place =
        |n: usize| [(n % nodes_across) as f64 / (2 * columns) as f64, (n / nodes_across) as f64 / (2 * rows) as f64];
    let nodes: Vec<[f64; 2]> = (0..nodes_across * (2 * rows + 1)).map(place).collect();
    let mut elements = Vec::new();
    let mut regions = Vec::new();
    for e in 0..columns * rows {
        let corner = 2 * (e % columns) + 2 * (e / columns) * nodes_across;
        let lattice = (0..9).map(|a| corner + a % 3 + a / 3 * nodes_across);
        elements.extend(lattice.map(|n| n as u32));
        regions.push(region(bend(nodes[corner + nodes_across + 1])));
    }
    let nodes = nodes.into_iter().map(bend).map(|[x, z]| [x, z, 0.0]).collect();
    Mesh { dim: 2, nodes, elements, region: regions, facets: vec![] }
}

/// The upper body: 30 mm wide, 25 mm high, with a ball of 4 mm about (0, 10), around which the grid is pulled.
fn phantom() -> Mesh {
    let bend = |[s, t]: [f64; 2]| {
        let (x, z) = (30.0 * s.powf(1.4), 25.0 * t.powf(1.2));
        [x, z]
    };
    grid([40, 30], &bend, &|[x, z]| u32::from(x.hypot(z - 9.0) < 4.0))
}

fn sensor() -> Mesh {
    grid([24, 16], &|[s, t]| [15.0 * s, -10.0 * (1.0 - t)], &|[_, z]| {
        if z < -5.0 {
            0
        } else if z < -2.0 {
            1
        } else {
            2
        }
    })
}

/// A press of some millimetres: the face at z = 0 is pushed down in the middle, everything follows smoothly.
fn press(mesh: &Mesh) -> Vec<[f64; 3]> {
    let fade = |z: f64| if z < 0.0 { 1.0 + z / 10.0 } else { 1.0 - 0.2 * z / 25.0 };
    let push = |[x, z, _]: [f64; 3]| {
        [0.02 * x * (-x * x / 150.0).exp() * (z + 5.0) / 10.0, -1.6 * (-x * x / 90.0).exp() * fade(z), 0.0]
    };
    mesh.nodes.iter().map(|&p| push(p)).collect()
}

fn pressure(mesh: &Mesh, at: f64) -> Vec<f64> {
    mesh.nodes.iter().map(|[x, z, _]| 4.0 * (-(x * x + (z - at) * (z - at)) / 60.0).exp()).collect()
}

fn picture<'a>(bodies: Vec<MeshBody<'a>>) -> MeshPicture<'a> {
    MeshPicture {
        title: "Pressed phantom",
        subtitle: "neo-Hookean, press of 2 mm, deformation to scale",
        bodies,
        values: AxisName { quantity: "pressure", unit: "kPa" },
        range: None,
        horizontal: "r",
        mirrored: true,
        view_mm: None,
    }
}

#[test]
fn two_bodies_are_drawn_whole_with_axes_and_units_in_a_small_file() {
    let (upper, lower) = (phantom(), sensor());
    let (moved_up, moved_low) = (press(&upper), press(&lower));
    let (p_up, p_low) = (pressure(&upper, 4.0), pressure(&lower, 0.0));
    let body = |mesh, displacement_mm, values| MeshBody { mesh, displacement_mm, values: MeshValues::Node(values) };
    let mut whole = picture(vec![body(&upper, &moved_up, &p_up), body(&lower, &moved_low, &p_low)]);
    let svg = mesh_picture(&whole).unwrap();
    assert_well_formed(&svg);
    for text in ["r (mm)", "z (mm)", "pressure (kPa)", "Pressed phantom"] {
        assert!(svg.contains(&format!(">{text}<")), "{text}");
    }
    // 1,584 elements, 3,300 edges twice at about 20 bytes, and a bitmap.
    assert!(svg.len() < 450_000, "{}", svg.len());
    keep_sample("mesh.svg", &svg);
    whole.view_mm = Some([[-8.0, 8.0], [-6.0, 8.0]]);
    keep_sample("mesh-zoom.svg", mesh_picture(&whole).unwrap());
    let signed: Vec<f64> = p_up.iter().map(|p| p - 1.0).collect();
    let cells: Vec<f64> = signed.iter().take(upper.element_count()).copied().collect();
    whole = picture(vec![body(&upper, &[], &signed)]);
    whole.mirrored = false;
    keep_sample("mesh-signed.svg", mesh_picture(&whole).unwrap());
    whole.bodies[0].values = MeshValues::Cell(&cells);
    assert_well_formed(&mesh_picture(&whole).unwrap());
}

#[test]
fn a_curved_edge_is_its_own_bezier_curve() {
    // One element with a bulge of 1 mm on its right side: the control point lies 2 mm out.
    let mut mesh = grid([1, 1], &|[s, t]| [2.0 * s, 2.0 * t], &|_| 0);
    mesh.nodes[5][0] += 1.0;
    let body = MeshBody { mesh: &mesh, displacement_mm: &[], values: MeshValues::Cell(&[1.0]) };
    let mut drawn = picture(vec![body]);
    drawn.mirrored = false;
    drawn.view_mm = Some([[0.0, 6.4], [0.0, 5.6]]);
    let svg = mesh_picture(&drawn).unwrap();
    // 100 pixels a millimetre from (86, 76 + 560): (2, 0) to (2, 2) by way of (4, 1).
    assert!(svg.contains("286 636Q486 536 286 436"), "{svg}");
}

#[test]
fn inner_edges_are_thin_and_borders_of_regions_and_bodies_thick() {
    let mesh = grid([2, 1], &|p| p, &|[x, _]| u32::from(x > 0.5));
    fn thick(mesh: &Mesh) -> [usize; 2] {
        let body = MeshBody { mesh, displacement_mm: &[], values: MeshValues::Cell(&[0.0, 0.0]) };
        let all = edges::edges(&Shape::new(&body).unwrap());
        [all.len(), all.iter().filter(|edge| edge.is_outline).count()]
    }
    assert_eq!(thick(&mesh), [7, 7]);
    let one = Mesh { region: vec![0, 0], ..mesh };
    assert_eq!(thick(&one), [7, 6]);
}

#[test]
fn every_pixel_of_a_body_is_painted() {
    let mesh = phantom();
    let values = vec![1.0; mesh.element_count()];
    let body = MeshBody { mesh: &mesh, displacement_mm: &[], values: MeshValues::Cell(&values) };
    let drawn = picture(vec![body]);
    let shapes = vec![Shape::new(&drawn.bodies[0]).unwrap()];
    let inside = Axes { area: [0.0, 0.0, 400.0, 300.0], low: [1.0, 1.0], high: [29.0, 24.0] };
    let colors = Colors { low: 0.0, high: 1.0, beyond: [false; 2] };
    let holes =
        |sides: &[f64]| paint::bitmap(&inside, &shapes, sides, &colors).1.chunks(4).filter(|p| p[3] == 0).count();
    assert_eq!(holes(&[1.0]), 0);
    assert!(holes(&[-1.0]) > 100_000, "the mirror image lies outside");
}

#[test]
fn the_scale_has_two_hues_only_for_both_signs() {
    let mesh = grid([2, 1], &|p| p, &|_| 0);
    let ends = |values: &[f64]| {
        let drawn = picture(vec![MeshBody { mesh: &mesh, displacement_mm: &[], values: MeshValues::Cell(values) }]);
        let shapes = [Shape::new(&drawn.bodies[0]).unwrap()];
        let colors = Colors::choose(&drawn, &shapes).unwrap();
        (colors.low, colors.high, colors.beyond)
    };
    assert_eq!(ends(&[1.0, 3.0]), (0.0, 3.0, [false; 2]));
    assert_eq!(ends(&[-1.0, 3.0]), (-3.0, 3.0, [false; 2]));
    assert_eq!(ends(&[-0.01, 3.0]), (0.0, 3.0, [true, false]));
    assert_eq!(ends(&[0.0, 0.0]), (0.0, 1.0, [false; 2]));
}

#[test]
fn what_does_not_fit_is_a_typed_error() {
    let mesh = grid([1, 1], &|p| p, &|_| 0);
    let text = |mesh: &Mesh, displacement_mm: &[[f64; 3]], values: &[f64]| {
        let drawn = picture(vec![MeshBody { mesh, displacement_mm, values: MeshValues::Cell(values) }]);
        mesh_picture(&drawn).unwrap_err().to_string()
    };
    assert!(text(&mesh, &[], &[1.0, 2.0]).contains("number of values"));
    assert!(text(&mesh, &[[0.0; 3]; 2], &[1.0]).contains("number of displacements"));
    assert!(text(&mesh, &[], &[f64::NAN]).contains("finite"));
    assert!(text(&Mesh { dim: 3, ..mesh.clone() }, &[], &[1.0]).contains("dimension"));
    let mut broken = mesh.clone();
    broken.elements[3] = 99;
    assert!(text(&broken, &[], &[1.0]).contains("a node of an element"));
    let mut drawn = picture(vec![]);
    drawn.view_mm = Some([[1.0, 1.0], [0.0, 1.0]]);
    assert!(mesh_picture(&drawn).unwrap_err().to_string().contains("size of the view"));
    drawn.view_mm = None;
    assert_well_formed(&mesh_picture(&drawn).unwrap());
}
