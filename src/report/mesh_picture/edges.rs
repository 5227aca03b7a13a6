//! Edges of elements as quadratic curves.

use super::super::axes::Axes;
use super::super::svg::Svg;
use super::Shape;
use std::collections::BTreeMap;

/// Lattice nodes of an element's four edges: end, middle, end.
const EDGES: [[usize; 3]; 4] = [[0, 1, 2], [2, 5, 8], [6, 7, 8], [0, 3, 6]];
/// Looks of inner edges and of outlines of bodies and regions.
const INNER: &str =
    r##"fill="none" stroke="#1f2328" stroke-opacity="0.38" stroke-width="0.5" stroke-linejoin="round""##;
const OUTLINE: &str =
    r##"fill="none" stroke="#1f2328" stroke-width="1.6" stroke-linejoin="round" stroke-linecap="round""##;
/// A bend smaller than this, in pixels, is drawn straight.
const STRAIGHT_PX: f64 = 0.1;

/// An edge: its nodes, the region on its first side, and whether it divides regions or bounds the body.
pub(super) struct Edge {
    nodes: [u32; 3],
    region: u32,
    pub(super) is_outline: bool,
}

pub(super) fn draw(svg: &mut Svg, axes: &Axes, shape: &Shape, sides: &[f64]) {
    let (outline, inner): (Vec<Edge>, Vec<Edge>) = edges(shape).into_iter().partition(|edge| edge.is_outline);
    let is_mirrored = sides.len() > 1;
    let on_mirror = |edge: &Edge| is_mirrored && edge.nodes.iter().all(|&n| is_on_axis(shape, n));
    let (mirror, outline): (Vec<Edge>, Vec<Edge>) = outline.into_iter().partition(on_mirror);
    for &side in sides {
        svg.commands(&commands(axes, shape, &inner, side), INNER);
    }
    // Drawn once: the two halves share it.
    svg.commands(&commands(axes, shape, &mirror, 1.0), INNER);
    for &side in sides {
        svg.commands(&commands(axes, shape, &outline, side), OUTLINE);
    }
}

/// Whether a node lies on the plane of the mirror before the deformation.
fn is_on_axis(shape: &Shape, node: u32) -> bool {
    let size = shape.mesh.nodes.iter().fold(0.0f64, |most, p| most.max(p[0].abs()));
    // Rounding of a mesher's arithmetic.
    shape.mesh.nodes[node as usize][0].abs() <= 1e-9 * size
}

/// Every edge once.
pub(super) fn edges(shape: &Shape) -> Vec<Edge> {
    let mut found: BTreeMap<(u32, u32), Edge> = BTreeMap::new();
    for (e, &region) in shape.mesh.region.iter().enumerate() {
        let element = shape.mesh.element(e);
        for places in EDGES {
            let nodes = places.map(|i| element[i]);
            let key = (nodes[0].min(nodes[2]), nodes[0].max(nodes[2]));
            let edge = found.entry(key).or_insert(Edge { nodes, region: u32::MAX, is_outline: true });
            if edge.region == u32::MAX {
                edge.region = region;
            } else {
                edge.is_outline = edge.region != region;
            }
        }
    }
    found.into_values().collect()
}

/// SVG commands of edges, on one side of the mirror; an edge that goes on where the last one ended needs no start.
fn commands(axes: &Axes, shape: &Shape, edges: &[Edge], side: f64) -> String {
    let at = |node: u32| {
        let [x, z] = shape.places[node as usize];
        axes.at([side * x, z])
    };
    let text = |[x, y]: [f64; 2]| {
        let round = |v: f64| {
            let text = format!("{v:.1}");
            text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
        };
        format!("{} {}", round(x), round(y))
    };
    let mut d = String::new();
    let mut pen = None;
    for nodes in ordered(edges) {
        let [a, m, b] = nodes.map(at);
        if pen != Some(nodes[0]) {
            d.push_str(&format!("M{}", text(a)));
        }
        // The quadratic through a, m, b at parameters 0, 1/2, 1 is the Bezier curve with this control point.
        let control = [0, 1].map(|k| 2.0 * m[k] - 0.5 * (a[k] + b[k]));
        let bend = [0, 1].map(|k| m[k] - 0.5 * (a[k] + b[k]));
        if bend[0].hypot(bend[1]) < STRAIGHT_PX {
            d.push_str(&format!("L{}", text(b)));
        } else {
            d.push_str(&format!("Q{} {}", text(control), text(b)));
        }
        pen = Some(nodes[2]);
    }
    d
}

/// The edges' nodes, turned and ordered so that each goes on from the one before where an edge is left that does.
fn ordered(edges: &[Edge]) -> Vec<[u32; 3]> {
    let mut at_node: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (i, edge) in edges.iter().enumerate() {
        at_node.entry(edge.nodes[0]).or_default().push(i);
        at_node.entry(edge.nodes[2]).or_default().push(i);
    }
    let mut is_left = vec![true; edges.len()];
    let mut order = Vec::with_capacity(edges.len());
    for start in 0..edges.len() {
        let mut next = is_left[start].then_some((start, edges[start].nodes[0]));
        while let Some((i, from)) = next {
            is_left[i] = false;
            let [a, m, b] = edges[i].nodes;
            let turned = if a == from { [a, m, b] } else { [b, m, a] };
            order.push(turned);
            let ahead = at_node.get(&turned[2]).map_or(&[][..], Vec::as_slice);
            next = ahead.iter().rfind(|&&i| is_left[i]).map(|&i| (i, turned[2]));
        }
    }
    order
}
