//! Light from the LEDs to the touched face of a flat stack, without photons.
//!
//! Between flat, smooth faces and black walls a path that inner interfaces only refract is, unfolded at the outer
//! faces, one straight layered path. With s = n sin(theta), the same in all layers, and depth D_k in layer k, it
//! reaches r(s) = sum D_k s / sqrt(n_k^2 - s^2). So what a point of an LED sends to a point of the face by paths of m
//! reflections is one solution of r(s) = r and, with c = sqrt(n^2 - s^2) at the LED,
//!
//! ```text
//! dE = L cos(psi) (s/n)^2 / (r c dr/ds) T dA
//! ```
//!
//! for radiance L, angle psi to the LED's normal seen from above, and T of all interfaces and layers on the way. That
//! is summed over m and over 64 places on each LED, which are shifted at random from replicate to replicate: what the
//! sum over places leaves is noise, not bias. It is summed at points of the face, with cubics between them, as near to
//! each other as the radius of an LED, its distance and the thickness of the stack ask for. Photons that met outer
//! faces alone, fewer times than the sum reaches, then leave nothing in the map. Light that inner interfaces reflect,
//! that tissue sends back or that was reflected more often is left to them (docs/decisions/unfolding.md).

mod site;
#[cfg(test)]
mod tests;
mod way;

use super::cpu::fresnel::reflectance;
use super::cpu::{Limits, Path, V3};
use super::leds::Led;
use super::model::Model;
use rayon::prelude::*;
use site::{Site, Spot};
use way::{PLACES, ROWS, Row, Term, rows_of, thickness};

/// Most terms of a replicate; above, photons do it. An entry of a table takes as long as so many terms.
const MOST_TERMS: f64 = 1.2e7;
const ENTRY: f64 = 30.0;
/// Most parts of a texel along a side.
const MOST_PARTS: f64 = 16.0;

/// Number of reflections below which unfolding finds paths: those that outer faces reflect totally, and two more; 0
/// where it does not suit the LEDs and the tissue.
pub fn reflections(model: &Model<f64>) -> u32 {
    let Some(site) = Site::of(model) else { return 0 };
    let top = model.faces.len() - 1;
    let critical = model.surround_n;
    let reach: f64 = (1..=top)
        .map(|k| thickness(model, k) * critical / (model.layers[k].n_sq - critical * critical).max(0.0).sqrt())
        .sum();
    let reflections = (site.far / reach).ceil() + 2.0;
    let rows = (model.leds.len() * ROWS) as f64 * reflections;
    let terms = rows * ((site.across * site.across * PLACES) as f64 + ENTRY * site.steps as f64);
    if terms < MOST_TERMS { reflections as u32 } else { 0 }
}

/// Light per area that meets the tissue straight from the LEDs, of each texel: the map's two numbers, in film units.
/// `shift`, in [0, 1), moves the places on the LEDs.
pub fn direct_light(model: &Model<f64>, reflections: u32, shift: [f64; 2]) -> [Vec<f64>; 2] {
    match Site::of(model) {
        Some(site) => on_texels(model, &site, &on_points(model, &site, reflections, shift)),
        None => [0; 2].map(|_| vec![0.0; model.map_size[0] * model.map_size[1]]),
    }
}

/// The same at the points of the face.
fn on_points(model: &Model<f64>, site: &Site, reflections: u32, shift: [f64; 2]) -> Vec<[f64; 2]> {
    // LEDs of like height and radius share their rows.
    let like = |led: &Led<f64>| {
        let same = |other: &Led<f64>| [other.height, other.radius] == [led.height, led.radius];
        model.leds.iter().position(same).unwrap_or(0)
    };
    let rows = |(k, led): (usize, &Led<f64>)| match like(led) == k {
        true => rows_of(model, led, site, reflections, shift[0]),
        false => Vec::new(),
    };
    let rows: Vec<Vec<Row>> = model.leds.iter().enumerate().map(rows).collect();
    let sources: Vec<(&Led<f64>, &[Row])> = model.leds.iter().map(|led| (led, rows[like(led)].as_slice())).collect();
    let point = |k: usize, i: usize| site.low[k] + site.step(k) * i as f64;
    (0..site.across * site.across)
        .into_par_iter()
        .map_init(
            || Path::new(model, Limits::default()),
            |path, k| {
                let at = [point(0, k % site.across), point(1, k / site.across)];
                at_point(path, site, &sources, at, shift[1])
            },
        )
        .collect()
}

/// From the points of the face to texels.
fn on_texels(model: &Model<f64>, site: &Site, points: &[[f64; 2]]) -> [Vec<f64>; 2] {
    let [columns, rows] = model.map_size;
    let mut light = [vec![0.0; columns * rows], vec![0.0; columns * rows]];
    // A texel's light is the mean of its points under tissue, of all if none is; of its middle, where points of the
    // face lie further apart.
    let texel = [0, 1].map(|axis| 2.0 * model.half_size[axis] / model.map_size[axis] as f64);
    let parts = [0, 1].map(|axis| (2.0 * texel[axis] / site.step(axis)).ceil().clamp(1.0, MOST_PARTS) as usize);
    // Parts of texels that the box reaches: the texel's number, the place, and the cubic through four points.
    let stencils = |axis: usize| -> Vec<(usize, f64, usize, [f64; 4])> {
        let stencil = |i: usize| {
            let x = (i as f64 + 0.5) / parts[axis] as f64 * texel[axis] - model.half_size[axis];
            let reached = x > site.low[axis] - 0.5 * texel[axis] && x < site.high[axis] + 0.5 * texel[axis];
            let g = ((x - site.low[axis]) / site.step(axis)).clamp(0.0, (site.across - 1) as f64);
            let first = (g.floor() - 1.0).clamp(0.0, (site.across - 4) as f64);
            reached.then(|| (i / parts[axis], x, first as usize, cubic(g - first)))
        };
        (0..parts[axis] * model.map_size[axis]).filter_map(stencil).collect()
    };
    let path = Path::new(model, Limits::default());
    let along_x = stencils(0);
    let mut count = vec![0.0; columns * rows];
    for (y, at_y, row, v) in stencils(1) {
        for &(x, at_x, column, u) in &along_x {
            let weight = if path.tissue_here(at_x, at_y) { 1.0 } else { 1e-9 };
            count[y * columns + x] += weight;
            for (which, light) in light.iter_mut().enumerate() {
                let value = |j: usize, i: usize| u[i] * points[(row + j) * site.across + column + i][which];
                light[y * columns + x] +=
                    weight * (0..4).map(|j| v[j] * (0..4).map(|i| value(j, i)).sum::<f64>()).sum::<f64>();
            }
        }
    }
    for light in &mut light {
        light.iter_mut().zip(&count).for_each(|(v, count)| *v /= f64::max(*count, f64::MIN_POSITIVE));
    }
    light
}

/// Lagrange's weights of four points at 0, 1, 2, 3 for a point between.
fn cubic(x: f64) -> [f64; 4] {
    let [a, b, c, d] = [x, x - 1.0, x - 2.0, x - 3.0];
    [b * c * d / -6.0, a * c * d / 2.0, a * b * d / -2.0, a * b * c / 6.0]
}

/// Light per area at a point of the touched face.
fn at_point(path: &Path<f64>, site: &Site, sources: &[(&Led<f64>, &[Row])], at: [f64; 2], shift: f64) -> [f64; 2] {
    let per_mm = site.steps as f64 / (site.far - site.near);
    let share = path.kernel.half_space.then(|| path.contact_share(at[0], at[1]));
    let mut sum = [0.0; 2];
    for (led, rows) in sources {
        let spot = Spot::of(path.model, led);
        let (depth, along) = (spot.depth(at), spot.along(at));
        let even = led.exponent == 1.0 && led.table.is_none() && led.cos_cutoff == 0.0;
        for row in *rows {
            for place in 0..PLACES {
                // There and back along the row, so that its ends meet.
                let turn = (place as f64 + shift) / PLACES as f64;
                let aside = along - led.along - row.half * (1.0 - 2.0 * (2.0 * turn - 1.0).abs());
                let r = (depth * depth + aside * aside).sqrt();
                let g = ((r - site.near) * per_mm).max(0.0);
                let k = (g as usize).min(site.steps - 1);
                let area = row.area / PLACES as f64 * depth / r;
                for (m, term) in row.between(k, g - k as f64).enumerate() {
                    let radiance = if even {
                        led.radiance
                    } else {
                        radiance(path, &spot, led, row, &term, m, [depth / r, aside / r])
                    };
                    let weight = area * radiance * below_tissue(path, &spot, &term, m, at, [depth, aside]);
                    let enters = match share {
                        Some(share) => {
                            let [contact, gap] = term.enters;
                            term.toward.map(|toward| toward * (gap + share * (contact - gap)))
                        }
                        None => term.enters,
                    };
                    (0..2).for_each(|which| sum[which] += weight * enters[which]);
                }
            }
        }
    }
    sum
}

/// Radiance of an LED along a path whose direction from above has these parts away from the wall and along it.
fn radiance(path: &Path<f64>, spot: &Spot, led: &Led<f64>, row: &Row, term: &Term, m: usize, way: [f64; 2]) -> f64 {
    let sin = term.s / row.n;
    let rise = (1.0 - sin * sin).max(0.0).sqrt();
    // Against the light, as a camera path arrives.
    let [x, y] = spot.back([0.0; 2], way.map(|way| sin * way));
    let z = if m.is_multiple_of(2) { -rise } else { rise };
    path.led_radiance_along(led, sin * way[0], V3 { x, y, z })
}

/// For the mirrors of a path on the touched face: what those below tissue reflect over what they would without.
fn below_tissue(path: &Path<f64>, spot: &Spot, term: &Term, reflections: usize, at: [f64; 2], way: [f64; 2]) -> f64 {
    let mut share = 1.0;
    let distance = (way[0] * way[0] + way[1] * way[1]).sqrt();
    for turn in 1..=reflections / 2 {
        // Back from the point by twice the way across the stack.
        let back = 2.0 * turn as f64 * term.across / distance;
        let [x, y] = spot.back(at, way.map(|way| back * way));
        if path.tissue_here(x, y) {
            let layer = path.model.layers[path.model.faces.len() - 1];
            let a = (layer.n_sq - term.s * term.s).max(0.0).sqrt();
            share *= path.boundary(x, y, a).mixed / reflectance(a, layer.side_dn_sq, layer.n_sq);
        }
    }
    share
}
