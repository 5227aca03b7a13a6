#![allow(clippy::unwrap_used)]
use super::*;
use proptest::prelude::*;

const OBJ: &str =
    "# a square\no plate\nv 0 0 1.5\nv 1 0 1.5 1.0\nv 1 1 1.5\nvn 0 0 1\nv 0 1 1.5\nf 1/7/1 2//1 3 -1 # quad\n";
const STL: &str = "solid plate\nfacet normal 0 0 1\nouter loop\nvertex 0 0 1.5\nvertex 1 0 1.5\nvertex 1 1 1.5\nendloop\n\
                   endfacet\nfacet normal 0 0 1\nouter loop\nvertex -0 0 1.5\nvertex 1 1 1.5\nvertex 0 1 1.5\nendloop\n\
                   endfacet\nendsolid\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\nproperty float x\nproperty uchar red\n\
                   property float y\nproperty double z\nelement face 1\nproperty list uchar int vertex_indices\n\
                   element edge 1\nproperty int a\nend_header\n0 9 0 1.5\n1 9 0 1.5\n1 9 1 1.5\n0 9 1 1.5\n4 0 1 2 3\n7\n";

fn square() -> TriangleMesh {
    TriangleMesh {
        vertices: vec![[0.0, 0.0, 1.5], [1.0, 0.0, 1.5], [1.0, 1.0, 1.5], [0.0, 1.0, 1.5]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

fn binary_stl() -> Vec<u8> {
    // A header that begins with "solid", as some programs write.
    let mut bytes = b"solid but binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(2_u32.to_le_bytes());
    for triangle in square().triangles {
        bytes.extend([0; 12]);
        for corner in triangle {
            for coordinate in square().vertices[corner as usize] {
                bytes.extend((coordinate as f32).to_le_bytes());
            }
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn binary_ply() -> Vec<u8> {
    let mut bytes = PLY.split("end_header").next().unwrap().replace("ascii", "binary_little_endian").into_bytes();
    bytes.extend(b"end_header\n");
    for [x, y, z] in square().vertices {
        bytes.extend((x as f32).to_le_bytes());
        bytes.push(9);
        bytes.extend((y as f32).to_le_bytes());
        bytes.extend(z.to_le_bytes());
    }
    bytes.push(4);
    for index in 0..4_i32 {
        bytes.extend(index.to_le_bytes());
    }
    bytes.extend(7_i32.to_le_bytes());
    bytes
}

#[test]
fn every_format_gives_the_same_square() {
    assert_eq!(obj::parse(OBJ.as_bytes()).unwrap(), square());
    assert_eq!(stl::parse(STL.as_bytes()).unwrap(), square());
    assert_eq!(stl::parse(&binary_stl()).unwrap(), square());
    assert_eq!(ply::parse(PLY.as_bytes()).unwrap(), square());
    assert_eq!(ply::parse(&binary_ply()).unwrap(), square());
}

#[test]
fn the_extension_tells_the_format_in_any_case() {
    for (name, bytes) in [("a.obj", OBJ.as_bytes()), ("b.STL", STL.as_bytes()), ("c.Ply", PLY.as_bytes())] {
        assert_eq!(read_mesh(&Input::new(name, bytes)).unwrap(), square(), "{name}");
    }
    assert!(read_mesh(&Input::new("x.glb", [])).unwrap_err().message.contains(".obj, .stl or .ply"));
}

#[test]
fn obj_faults_are_named_with_their_line() {
    for (text, line, part) in [
        ("v 0 0\n", Some(1), "three numbers"),
        ("v 0 0 nan\n", Some(1), "finite"),
        ("v 0 0 0\nf 1 1\n", Some(2), "at least 3"),
        ("v 0 0 0\nf 0 1 1\n", Some(2), "from 1"),
        ("v 0 0 0\nf -2 1 1\n", Some(2), "from 1"),
        ("v 0 0 0\nf 1 1 2\n", None, "names vertex 1 (counted from 0) of 1"),
        ("v 0 0 0\nf 1 1 9223372036854775807\n", Some(2), "from 1"),
        ("v 0 0 0\nf 1 1 -9223372036854775808\n", Some(2), "from 1"),
        ("v 0 0 0\n", None, "at least one triangle"),
    ] {
        let defect = obj::parse(text.as_bytes()).and_then(checked).unwrap_err();
        assert_eq!(defect.line, line, "{text:?}");
        assert!(defect.message.contains(part), "{text:?}: {}", defect.message);
    }
}

#[test]
fn truncated_files_are_refused() {
    let whole = binary_stl();
    assert!(stl::parse(&whole[..whole.len() - 1]).and_then(checked).is_err());
    assert!(stl::parse(b"").is_err());
    assert!(stl::parse(&STL.as_bytes()[..STL.find("vertex 1 1").unwrap()]).is_err());
    let whole = binary_ply();
    assert!(ply::parse(&whole[..whole.len() - 1]).is_err());
    assert!(ply::parse(&PLY.as_bytes()[..PLY.len() - 3]).is_err());
}

#[test]
fn counts_that_the_file_does_not_hold_cost_nothing() {
    for (from, to) in [
        ("element vertex 4", "element vertex 18446744073709551615"),
        ("element face 1", "element face 18446744073709551615"),
        ("4 0 1 2 3", "4294967295 0 1 2 3"),
        ("element edge 1\nproperty int a", "element void 18446744073709551615"),
    ] {
        let started = std::time::Instant::now();
        let _ = ply::parse(PLY.replace(from, to).as_bytes());
        // The work is bounded by some hundred bytes; a second is a thousand times what that takes.
        assert!(started.elapsed().as_secs_f64() < 1.0, "{to}");
    }
    let mut bytes = binary_stl();
    bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(stl::parse(&bytes).is_err() || stl::parse(&bytes).unwrap().triangles.is_empty());
}

#[test]
fn a_ply_of_another_byte_order_is_refused_by_name() {
    let text = PLY.replace("format ascii 1.0", "format binary_big_endian 1.0");
    let defect = ply::parse(text.as_bytes()).unwrap_err();
    assert_eq!(defect.line, Some(2));
    assert!(defect.message.contains("binary_little_endian"), "{}", defect.message);
}

fn mutated(mut bytes: Vec<u8>, changes: Vec<(usize, u8)>) -> Vec<u8> {
    for (at, byte) in changes {
        let at = at % bytes.len();
        bytes[at] = byte;
    }
    bytes
}

proptest! {
    #[test]
    fn no_mutation_makes_a_mesh_reader_panic(
        which in 0..5_usize,
        changes in proptest::collection::vec((any::<usize>(), any::<u8>()), 0..12),
        keep in 0.5..1.0_f64,
    ) {
        let seeds = [OBJ.into(), STL.into(), binary_stl(), PLY.into(), binary_ply()];
        let mut bytes = mutated(seeds[which].clone(), changes);
        bytes.truncate((bytes.len() as f64 * keep) as usize);
        for parsed in [obj::parse(&bytes), stl::parse(&bytes), ply::parse(&bytes)] {
            if let Ok(mesh) = parsed.and_then(checked) {
                prop_assert!(mesh.triangles.iter().flatten().all(|&index| (index as usize) < mesh.vertices.len()));
                prop_assert!(mesh.vertices.iter().flatten().all(|coordinate| coordinate.is_finite()));
            }
        }
    }
}
