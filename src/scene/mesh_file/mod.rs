//! Triangle meshes from OBJ, STL and PLY files.
//!
//! Own readers of the parts that a surface needs. Crates for these formats were tried and left: they hold coordinates
//! in f32 (a nanometre at 12 mm, which shows in facet normals), one overflows on hostile indices and splits shared
//! vertices by group, one takes any binary STL that begins with "solid" for text, and one allocates what a header
//! promises. Every count here is bounded by what the file holds.

mod obj;
mod ply;
mod stl;

use super::data_file::{DataFileError, Defect};
use super::inputs::Input;

/// Largest file, bytes.
const MAX_BYTES: u64 = 256 << 20;
/// Most triangles of a mesh.
const MAX_TRIANGLES: usize = 5_000_000;
/// Most vertices of a mesh: three for each triangle.
const MAX_VERTICES: usize = 3 * MAX_TRIANGLES;

/// A triangle mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriangleMesh {
    /// Vertices, mm, in the scene's coordinates.
    pub vertices: Vec<[f64; 3]>,
    /// Indices of each triangle's vertices, in the order of the file.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    fn add_vertex(&mut self, vertex: [f64; 3]) -> Result<u32, String> {
        if !vertex.iter().all(|coordinate| coordinate.is_finite()) {
            return Err(format!("a vertex must be three finite numbers, is {vertex:?}"));
        }
        if self.vertices.len() == MAX_VERTICES {
            return Err(format!("must have at most {MAX_VERTICES} vertices"));
        }
        self.vertices.push(vertex);
        u32::try_from(self.vertices.len() - 1).map_err(|error| error.to_string())
    }

    /// Adds a polygon as a fan around its first vertex.
    fn add_polygon(&mut self, corners: &[u32]) -> Result<(), String> {
        let [first, rest @ ..] = corners else {
            return Err("a face must have at least 3 vertices, has 0".to_owned());
        };
        if rest.len() < 2 {
            return Err(format!("a face must have at least 3 vertices, has {}", corners.len()));
        }
        for pair in rest.windows(2) {
            if self.triangles.len() == MAX_TRIANGLES {
                return Err(format!("must have at most {MAX_TRIANGLES} triangles"));
            }
            if let [second, third] = pair {
                self.triangles.push([*first, *second, *third]);
            }
        }
        Ok(())
    }
}

/// Reads a mesh; the format is told by the file's extension. Polygons become fans of triangles; equal vertices of an
/// STL file become one.
///
/// # Errors
/// When the file breaks its format or a limit, or holds no triangle.
pub fn read_mesh(input: &Input) -> Result<TriangleMesh, DataFileError> {
    let path = &input.path;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let parse = match extension.as_str() {
        "obj" => obj::parse,
        "stl" => stl::parse,
        "ply" => ply::parse,
        _ => return Err(Defect::new(None, "must be a mesh in .obj, .stl or .ply").in_file(path)),
    };
    let mesh = parse(input.at_most(MAX_BYTES)?).and_then(checked);
    mesh.map_err(|defect| defect.in_file(path))
}

/// Refuses an empty mesh and indices beyond the vertices.
fn checked(mesh: TriangleMesh) -> Result<TriangleMesh, Defect> {
    if mesh.triangles.is_empty() {
        return Err(Defect::new(None, "must have at least one triangle"));
    }
    let count = mesh.vertices.len();
    match mesh.triangles.iter().flatten().find(|&&index| index as usize >= count) {
        Some(index) => {
            Err(Defect::new(None, format!("a face names vertex {index} (counted from 0) of {count} vertices")))
        }
        None => Ok(mesh),
    }
}

/// Lines of a text file with their numbers, from 1.
fn text_lines(bytes: &[u8]) -> impl Iterator<Item = (usize, std::borrow::Cow<'_, str>)> {
    // Names may be in any encoding; what is read is ASCII.
    bytes.split(|&byte| byte == b'\n').enumerate().map(|(index, line)| (index + 1, String::from_utf8_lossy(line)))
}

#[cfg(test)]
mod tests;
