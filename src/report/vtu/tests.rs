use super::super::svg::keep_sample;
use super::*;

/// Places of VTK's nodes in the unit square and cube, from `vtkBiQuadraticQuad.cxx` and `vtkTriQuadraticHexahedron.cxx`
/// (`GetParametricCoords`), times two.
const QUAD_PLACES: [[i32; 2]; 9] = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]];
#[rustfmt::skip]
const HEXAHEDRON_PLACES: [[i32; 3]; 27] = [
    [0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2],
    [1, 0, 0], [2, 1, 0], [1, 2, 0], [0, 1, 0], [1, 0, 2], [2, 1, 2], [1, 2, 2], [0, 1, 2],
    [0, 0, 1], [2, 0, 1], [2, 2, 1], [0, 2, 1],
    [0, 1, 1], [2, 1, 1], [1, 0, 1], [1, 2, 1], [1, 1, 0], [1, 1, 2], [1, 1, 1],
];

/// One element whose lattice is bent by a quadratic map of volume 8 (1 + 1/12 of the bend each way).
fn element(dim: usize, bend: f64) -> Mesh {
    let at = |i: usize| i as f64 - 1.0;
    let nodes = (0..3usize.pow(dim as u32)).map(|a| {
        let [x, y, z] = [at(a % 3), at(a / 3 % 3), if dim == 3 { at(a / 9) } else { 0.0 }];
        // x grows with y², so that faces bulge; z with x², the other way.
        let x_bent = x * (1.0 + bend * y * y);
        if dim == 2 { [x_bent, y, 0.0] } else { [x_bent, y, z * (1.0 - bend * x * x)] }
    });
    let nodes: Vec<_> = nodes.collect();
    Mesh { dim, elements: (0..nodes.len() as u32).collect(), nodes, region: vec![3], facets: vec![] }
}

/// Quadratic Lagrange polynomial of node 0, 1, 2 at t in -1 .. 1, and its derivative.
fn lagrange(node: i32, t: f64) -> (f64, f64) {
    match node {
        0 => (0.5 * t * (t - 1.0), t - 0.5),
        1 => (1.0 - t * t, -2.0 * t),
        _ => (0.5 * t * (t + 1.0), t + 0.5),
    }
}

/// Volume of a cell read as VTK reads it, by 3 Gauss points along each axis.
fn volume(points: &[[f64; 3]]) -> f64 {
    let gauss = [(-0.6f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6f64.sqrt(), 5.0 / 9.0)];
    let mut sum = 0.0;
    for (x, wx) in gauss {
        for (y, wy) in gauss {
            for (z, wz) in gauss {
                let mut j = [[0.0; 3]; 3];
                for (place, point) in HEXAHEDRON_PLACES.iter().zip(points) {
                    let [(a, da), (b, db), (c, dc)] =
                        [lagrange(place[0], x), lagrange(place[1], y), lagrange(place[2], z)];
                    for (row, slope) in j.iter_mut().zip([da * b * c, a * db * c, a * b * dc]) {
                        for (entry, coordinate) in row.iter_mut().zip(point) {
                            *entry += slope * coordinate;
                        }
                    }
                }
                let minor = |a: usize, b: usize| j[1][a] * j[2][b] - j[1][b] * j[2][a];
                sum += wx * wy * wz * (j[0][0] * minor(1, 2) - j[0][1] * minor(0, 2) + j[0][2] * minor(0, 1));
            }
        }
    }
    sum
}

#[test]
fn lattice_nodes_take_their_places_in_vtk() {
    for (place, &node) in QUAD_PLACES.iter().zip(&QUAD_ORDER) {
        assert_eq!([node as i32 % 3, node as i32 / 3], *place);
    }
    for (place, &node) in HEXAHEDRON_PLACES.iter().zip(&HEXAHEDRON_ORDER) {
        assert_eq!([node as i32 % 3, node as i32 / 3 % 3, node as i32 / 9], *place);
    }
}

#[test]
fn a_bent_hexahedron_keeps_its_volume_in_vtk_order() {
    let mesh = element(3, 0.2);
    let vtu = Vtu::of_bodies(&[&mesh], 0.0).unwrap();
    let cell: Vec<[f64; 3]> = vtu.connectivity.iter().map(|&i| vtu.points[i as usize]).collect();
    // The map's determinant is (1 + b y²)(1 - b x²); its integral over the cube is 2 (2 + 2b/3)(2 - 2b/3).
    let expected = 2.0 * (2.0 + 0.4 / 3.0) * (2.0 - 0.4 / 3.0);
    assert!((volume(&cell) - expected).abs() < 1e-12, "{} {expected}", volume(&cell));
    // The order that VTK's documentation prints (faces -y, +x, +y, -x, -z, +z) would be wrong.
    let mut wrong = cell.clone();
    for (to, from) in [(20, 22), (21, 21), (22, 23), (23, 20)] {
        wrong[to] = cell[from];
    }
    assert!((volume(&wrong) - expected).abs() > 0.1, "{}", volume(&wrong));
}

#[test]
fn a_plane_lies_in_x_and_z() {
    let mesh = element(2, 0.0);
    let mut vtu = Vtu::of_bodies(&[&mesh, &mesh], 12.0).unwrap();
    let vectors: Vec<[f64; 3]> = (0..18).map(|i| [f64::from(i), -1.0, 0.0]).collect();
    vtu.point_vectors("displacement_mm", &vectors).unwrap();
    assert_eq!(vtu.points[5], [1.0, 0.0, 12.0]);
    assert_eq!(vtu.point_data[0].values, Values::Float((0..18).flat_map(|i| [f64::from(i), 0.0, -1.0]).collect()));
    assert_eq!(vtu.connectivity[9..13], [9, 11, 17, 15]);
    assert_eq!(vtu.cell_data[0].values, Values::Integer(vec![0, 1]));
    assert_eq!(vtu.cell_data[1].values, Values::Integer(vec![3, 3]));
}

#[test]
fn arrays_are_their_length_and_their_bytes() {
    let mut vtu = Vtu::of_bodies(&[&element(2, 0.0)], 0.0).unwrap();
    vtu.cell_field("a \"b\" <c>", 1, Values::Float(vec![1.5])).unwrap();
    let text = String::from_utf8(vtu.to_bytes()).unwrap();
    let data = text.split("&lt;c&gt;\"").nth(1).unwrap().split(['>', '<']).nth(1).unwrap();
    let bytes = STANDARD.decode(data).unwrap();
    assert_eq!(bytes[..8], 8u64.to_le_bytes());
    assert_eq!(bytes[8..], 1.5f64.to_le_bytes());
}

#[test]
fn what_does_not_fit_is_refused() {
    let mut mesh = element(3, 0.0);
    let mut vtu = Vtu::of_bodies(&[&mesh], 0.0).unwrap();
    assert_eq!(
        vtu.cell_field("pressure_kpa", 1, Values::Float(vec![1.0, 2.0])).unwrap_err().to_string(),
        "field \"pressure_kpa\" has 2 values, needs 1"
    );
    assert!(vtu.point_vectors("u", &[[0.0; 3]; 28]).is_err() && vtu.point_vectors("u", &[[0.0; 3]; 26]).is_err());
    assert!(matches!(vtu.cell_field("p", 1, Values::Float(vec![f64::NAN])), Err(VtuError::NotFinite(_))));
    mesh.elements[4] = 27;
    assert_eq!(Vtu::of_bodies(&[&mesh], 0.0), Err(VtuError::Mesh(0)));
    mesh.elements.truncate(9);
    assert_eq!(Vtu::of_bodies(&[&mesh], 0.0), Err(VtuError::Mesh(0)));
}

/// The samples of the next test were read back by meshio 5.3.5 (all fields) and VTK 9.7.2, whose own interpolation in
/// the cells met the bent map at random places to 5e-16.
#[test]
fn a_file_is_one_piece_of_xml_with_every_field() {
    for dim in [2, 3] {
        let mesh = element(dim, 0.2);
        let mut vtu = Vtu::of_bodies(&[&mesh], 0.0).unwrap();
        let vectors: Vec<[f64; 3]> = mesh.nodes.iter().map(|p| [0.1 * p[0], 0.2 * p[1], 0.3 * p[2]]).collect();
        vtu.point_vectors("displacement_mm", &vectors).unwrap();
        vtu.cell_field("pressure_kpa", 1, Values::Float(vec![2.5])).unwrap();
        let bytes = vtu.to_bytes();
        let text = String::from_utf8(bytes.clone()).unwrap();
        assert_eq!(text.matches("<DataArray ").count(), 8);
        assert_eq!(text.matches("<DataArray ").count(), text.matches("</DataArray>").count());
        keep_sample(&format!("sample{dim}.vtu"), bytes);
    }
}
