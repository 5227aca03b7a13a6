//! The things drawn: layers, what touches, rays, LEDs, camera.

use super::super::svg::{Anchor, Svg};
use super::{CAMERA_PX, Frame, LED_PX, SideView};

/// Looks of LEDs and tissue, here and in the legend.
pub(super) const LED_FILL: &str = r##"fill="#f2cc60" stroke="#7d4e00""##;
pub(super) const TISSUE_FILL: &str = r##"fill="#e9b8a6""##;

/// The layers, deeper blue for a higher index.
pub(super) fn bands(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let indices = view.layers.iter().map(|layer| layer.n);
    let (low, high) = indices.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), n| (l.min(n), h.max(n)));
    for (layer, faces) in view.layers.iter().zip(view.interfaces_mm.windows(2)) {
        let [upper, lower] = faces else { continue };
        let share = if high > low { (layer.n - low) / (high - low) } else { 0.5 };
        let mix = |from: f64, to: f64| (from + share * (to - from)).round() as u8;
        let fill = [mix(234.0, 176.0), mix(243.0, 206.0), mix(251.0, 235.0)];
        let mut outline = frame.polyline(upper);
        outline.extend(frame.polyline(lower).into_iter().rev());
        let [r, g, b] = fill;
        svg.path(&outline, true, &format!(r##"fill="#{r:02x}{g:02x}{b:02x}""##));
    }
}

pub(super) fn field_of_view(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let right = frame.polyline(&view.view_edge_mm);
    let left: Vec<[f64; 2]> = view.view_edge_mm.iter().map(|&[x, z]| frame.at([-x, z])).collect();
    // Filled in the surround only: the layers keep their colours.
    let below = view.view_edge_mm.iter().take_while(|p| p[1] <= 0.0).count();
    let outline: Vec<_> = right.iter().take(below).chain(left.iter().take(below).rev()).copied().collect();
    svg.path(&outline, true, r##"fill="#e3b341" fill-opacity="0.16""##);
    for edge in [&right, &left] {
        svg.path(edge, false, r##"fill="none" stroke="#9a6700" stroke-dasharray="5 4" stroke-opacity="0.8""##);
    }
}

pub(super) fn tissue(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let Some(face) = view.interfaces_mm.first() else {
        return;
    };
    let top = face.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max) + 0.12 * view.half_width_mm;
    for &[from, to] in &view.contact_mm {
        let mut outline = vec![[from, top], [from, height_at(face, from)]];
        outline.extend(face.iter().filter(|p| p[0] > from && p[0] < to));
        outline.extend([[to, height_at(face, to)], [to, top]]);
        let drawn = frame.polyline(&outline);
        svg.path(&drawn, true, TISSUE_FILL);
        let contact = drawn.get(1..drawn.len() - 1).unwrap_or_default();
        svg.path(contact, false, r##"fill="none" stroke="#a0402a" stroke-width="3""##);
    }
}

/// Height of a polyline at x, linear between its points.
fn height_at(face: &[[f64; 2]], x: f64) -> f64 {
    let piece = face.windows(2).find_map(|pair| match pair {
        [a, b] if (a[0]..=b[0]).contains(&x) && b[0] > a[0] => Some(a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1])),
        _ => None,
    });
    piece.or(face.first().map(|p| p[1])).unwrap_or(0.0)
}

pub(super) fn rays(svg: &mut Svg, view: &SideView, frame: &Frame) {
    // Many rays are drawn thinner so that they remain lines.
    let width = if view.rays.len() > 24 { 0.8 } else { 1.4 };
    svg.group(&format!(r#"fill="none" stroke-linejoin="round" stroke-width="{width}" stroke-opacity="0.85""#));
    for ray in &view.rays {
        let points: Vec<[f64; 2]> = ray.points_mm.iter().map(|&[x, _, z]| frame.at([x, z])).collect();
        let points = within(&points, [frame.left - LED_PX, frame.top - 8.0, frame.right + LED_PX, frame.bottom]);
        let (color, dashes, _) = ray.fate.look();
        svg.path(&points, false, &stroke(color, dashes));
    }
    svg.end_group();
}

/// A polyline up to where it leaves the rectangle (left, top, right, bottom).
pub(super) fn within(points: &[[f64; 2]], [left, top, right, bottom]: [f64; 4]) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::with_capacity(points.len());
    for &[x, y] in points {
        let Some(&[x0, y0]) = kept.last() else {
            kept.push([x, y]);
            continue;
        };
        // Share of the segment inside, from each edge that it crosses.
        let share = |from: f64, to: f64, low: f64, high: f64| {
            let edge = if to > high { high } else { low };
            if (low..=high).contains(&to) { 1.0 } else { ((edge - from) / (to - from)).clamp(0.0, 1.0) }
        };
        let t = share(x0, x, left, right).min(share(y0, y, top, bottom));
        kept.push([x0 + t * (x - x0), y0 + t * (y - y0)]);
        if t < 1.0 {
            break;
        }
    }
    kept
}

pub(super) fn stroke(color: &str, dashes: &str) -> String {
    if dashes.is_empty() {
        format!(r#"stroke="{color}""#)
    } else {
        format!(r#"stroke="{color}" stroke-dasharray="{dashes}""#)
    }
}

pub(super) fn leds(svg: &mut Svg, view: &SideView, frame: &Frame) {
    for led in &view.leds {
        let [x, top] = frame.at([led.x_mm, led.z_mm + 0.5 * led.diameter_mm]);
        let height = led.diameter_mm * frame.scale;
        let left = if led.x_mm < 0.0 { x - LED_PX } else { x };
        svg.rect([left, top, LED_PX, height], &format!(r#"rx="3" {LED_FILL}"#));
    }
}

pub(super) fn camera(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let Some(&pinhole) = view.view_edge_mm.first() else {
        return;
    };
    let [x, y] = frame.at(pinhole);
    svg.path(&[[x, y], [x - 12.0, y + 12.0], [x + 12.0, y + 12.0]], true, r##"fill="#57606a""##);
    svg.rect([x - 22.0, y + 12.0, 44.0, CAMERA_PX - 12.0], r##"rx="4" fill="#57606a""##);
    svg.text([x + 32.0, y + 27.0], Anchor::Start, "tt-ink", "camera");
}
