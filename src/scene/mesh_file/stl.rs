//! STL, binary and text. It names no vertices: equal coordinates become one vertex.

use super::{TriangleMesh, text_lines};
use crate::scene::data_file::Defect;
use std::collections::HashMap;

/// Bytes before the triangles: a free header and their count.
const HEADER_BYTES: usize = 84;
/// Bytes of a triangle: a normal, three vertices, an attribute.
const TRIANGLE_BYTES: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, Defect> {
    // Some programs begin binary files with "solid" too: the size that the count promises tells them from text.
    let promised = bytes
        .get(80..HEADER_BYTES)
        .and_then(|count| count.try_into().ok())
        .and_then(|count| usize::try_from(u32::from_le_bytes(count)).ok())
        .and_then(|count| count.checked_mul(TRIANGLE_BYTES)?.checked_add(HEADER_BYTES));
    match promised {
        Some(size) if size == bytes.len() => binary(bytes, size),
        _ if bytes.trim_ascii_start().starts_with(b"solid") => text(bytes),
        Some(size) if size < bytes.len() => binary(bytes, size),
        _ => Err(Defect::new(None, "is neither text STL (it would begin with solid) nor a whole binary STL")),
    }
}

#[derive(Default)]
struct Merged {
    mesh: TriangleMesh,
    known: HashMap<[u64; 3], u32>,
}

impl Merged {
    fn vertex(&mut self, vertex: [f64; 3]) -> Result<u32, String> {
        // Adding zero makes -0 equal to 0 in its bits too.
        let bits = vertex.map(|coordinate| (coordinate + 0.0).to_bits());
        if let Some(&index) = self.known.get(&bits) {
            return Ok(index);
        }
        let index = self.mesh.add_vertex(vertex)?;
        self.known.insert(bits, index);
        Ok(index)
    }
}

fn binary(bytes: &[u8], size: usize) -> Result<TriangleMesh, Defect> {
    let mut merged = Merged::default();
    for triangle in bytes.get(HEADER_BYTES..size).unwrap_or_default().chunks_exact(TRIANGLE_BYTES) {
        let mut numbers = triangle.chunks_exact(4).map(|four| match *four {
            [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => f64::NAN,
        });
        // The normal follows from the vertices.
        let mut numbers = numbers.by_ref().skip(3);
        let mut corners = [0; 3];
        for corner in &mut corners {
            let mut vertex = [f64::NAN; 3];
            for coordinate in &mut vertex {
                *coordinate = numbers.next().unwrap_or(f64::NAN);
            }
            *corner = merged.vertex(vertex).map_err(|message| Defect::new(None, message))?;
        }
        merged.mesh.add_polygon(&corners).map_err(|message| Defect::new(None, message))?;
    }
    Ok(merged.mesh)
}

fn text(bytes: &[u8]) -> Result<TriangleMesh, Defect> {
    let mut merged = Merged::default();
    let mut corners = Vec::new();
    for (line, content) in text_lines(bytes) {
        let mut words = content.split_whitespace();
        let done = match words.next() {
            Some("vertex") => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                match <[f64; 3]>::try_from(numbers) {
                    Ok(vertex) => merged.vertex(vertex).map(|index| corners.push(index)),
                    Err(_) => Err("a vertex must be three numbers".to_owned()),
                }
            }
            Some("endloop") => {
                let done = merged.mesh.add_polygon(&corners);
                corners.clear();
                done
            }
            _ => Ok(()),
        };
        done.map_err(|message| Defect::new(line, message))?;
    }
    if !corners.is_empty() {
        return Err(Defect::new(None, "ends inside a facet"));
    }
    Ok(merged.mesh)
}
