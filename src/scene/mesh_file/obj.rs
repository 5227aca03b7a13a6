//! Wavefront OBJ: `v` and `f` lines; all others are passed over.

use super::{TriangleMesh, text_lines};
use crate::scene::data_file::Defect;

pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, Defect> {
    let mut mesh = TriangleMesh::default();
    let mut corners = Vec::new();
    for (line, content) in text_lines(bytes) {
        let mut words = content.split_whitespace();
        let done = match words.next() {
            Some("v") => vertex(words).and_then(|vertex| mesh.add_vertex(vertex)).map(|_| ()),
            Some("f") => {
                corners.clear();
                words
                    .take_while(|word| !word.starts_with('#'))
                    .try_for_each(|word| {
                        corners.push(index(word, mesh.vertices.len())?);
                        Ok(())
                    })
                    .and_then(|()| mesh.add_polygon(&corners))
            }
            _ => Ok(()),
        };
        done.map_err(|message| Defect::new(line, message))?;
    }
    Ok(mesh)
}

/// The first three numbers; a weight or a colour may follow.
fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<[f64; 3], String> {
    let mut vertex = [0.0; 3];
    for coordinate in &mut vertex {
        let word = words.next().unwrap_or("");
        *coordinate = word.parse().map_err(|_| format!("a vertex must be three numbers, one is {word:?}"))?;
    }
    Ok(vertex)
}

/// The vertex of a face's corner (`3`, `3/1`, `3//2`, or `-1` for the latest so far), counted from 0.
fn index(word: &str, vertices: usize) -> Result<u32, String> {
    let wrong = || format!("a face must name vertices from 1 to {vertices} or back from -1, one is {word:?}");
    let given: i64 = word.split('/').next().unwrap_or("").parse().map_err(|_| wrong())?;
    let count = i64::try_from(vertices).map_err(|_| wrong())?;
    let from_zero = if given < 0 { given.checked_add(count) } else { given.checked_sub(1) };
    // A face may come before its vertices: the upper end is checked when all are read.
    from_zero.filter(|&index| index >= 0).and_then(|index| u32::try_from(index).ok()).ok_or_else(wrong)
}
