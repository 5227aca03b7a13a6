//! Layered paths from one height to the touched face.

use super::site::Site;
use crate::trace::cpu::fresnel::{fresnel, reflectance};
use crate::trace::cpu::{Limits, Path};
use crate::trace::leds::Led;
use crate::trace::model::Model;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Heights on an LED.
pub const ROWS: usize = 16;
/// Places along the wall at each.
pub const PLACES: usize = 4;

/// What paths of one number of reflections from one height bring to a distance r.
#[derive(Clone, Copy)]
pub struct Term {
    /// Light per area that would enter through true contact and through the gap, of radiance 1 per area at psi = 0.
    pub enters: [f64; 2],
    /// What tissue as a half space sends of that towards the map's two directions.
    pub toward: [f64; 2],
    /// n sin(theta).
    pub s: f64,
    /// How far the path gets from one outer face to the other, mm.
    pub across: f64,
}

impl Term {
    /// Between this and the next.
    #[inline]
    fn mix(&self, next: &Self, u: f64) -> Self {
        let mix = |a: f64, b: f64| a + u * (b - a);
        Self {
            enters: [0, 1].map(|k| mix(self.enters[k], next.enters[k])),
            toward: [0, 1].map(|k| mix(self.toward[k], next.toward[k])),
            s: mix(self.s, next.s),
            across: mix(self.across, next.across),
        }
    }
}

/// Terms from one height of an LED: of each number of reflections, at even distances.
pub struct Row {
    /// Half its length, mm.
    pub half: f64,
    /// Area that it stands for, mm^2.
    pub area: f64,
    /// Index of its layer.
    pub n: f64,
    /// By the distance, then by the number of reflections: those of one distance are read together.
    terms: Vec<Term>,
    reflections: usize,
}

impl Row {
    /// Between the terms of two neighbouring distances, `u` of the way from the first: one a number of reflections.
    #[inline]
    pub fn between(&self, first: usize, u: f64) -> impl Iterator<Item = Term> {
        let (here, next) = self.terms[first * self.reflections..].split_at(self.reflections);
        here.iter().zip(next).map(move |(here, next)| here.mix(next, u))
    }
}

/// Thickness of a layer, mm.
pub fn thickness(model: &Model<f64>, k: usize) -> f64 {
    model.faces[k].z - model.faces[k - 1].z
}

/// Rows of places on an LED, with the terms of fewer than so many reflections; `shift` moves them.
pub fn rows_of(model: &Model<f64>, led: &Led<f64>, site: &Site, reflections: u32, shift: f64) -> Vec<Row> {
    (0..ROWS)
        .into_par_iter()
        .map(|i| {
            // Even in the angle on the rim: the widths of the rows, and their lengths, go to zero together and
            // smoothly.
            let (sin, cos) = (PI * (i as f64 + shift) / ROWS as f64).sin_cos();
            let height = led.height + led.radius * cos;
            let layer = (1..model.faces.len()).find(|&k| height <= model.faces[k].z).unwrap_or(model.faces.len() - 1);
            let distance = |k: usize| site.near + (site.far - site.near) * k as f64 / site.steps as f64;
            let path = Path::new(model, Limits::default());
            let mut ways: Vec<(Way, f64)> =
                (0..reflections).map(|m| (Way::new(model, height, layer, m), 0.0)).collect();
            let mut terms = Vec::with_capacity(ways.len() * (site.steps + 1));
            for k in 0..=site.steps {
                terms.extend(ways.iter_mut().map(|(way, t)| way.term(&path, distance(k).max(1e-9), t)));
            }
            let half = led.radius * sin;
            Row {
                half,
                area: 2.0 * half * half * PI / ROWS as f64,
                n: model.layers[layer].n,
                terms,
                reflections: ways.len(),
            }
        })
        .collect()
}

/// Paths from one height to the touched face with one number of reflections: downward first if that is odd.
struct Way<'m> {
    model: &'m Model<f64>,
    layer: usize,
    turns: u32,
    /// Depth within each layer, mm; 0 for the surround.
    depths: Vec<f64>,
    /// Least index on the way.
    least: f64,
}

impl<'m> Way<'m> {
    fn new(model: &'m Model<f64>, height: f64, layer: usize, turns: u32) -> Self {
        let up = turns.is_multiple_of(2);
        let part = |k: usize| match (k == layer, up) {
            (true, true) => model.faces[k].z - height,
            (true, false) => height - model.faces[k - 1].z,
            (false, up) if (k > layer) == up => thickness(model, k),
            _ => 0.0,
        };
        let whole = |k: usize| f64::from(turns) * thickness(model, k);
        let depths: Vec<f64> = std::iter::once(0.0).chain((1..model.faces.len()).map(|k| part(k) + whole(k))).collect();
        let crossed = (1..model.faces.len()).filter(|&k| depths[k] > 0.0);
        let least = crossed.map(|k| model.layers[k].n).fold(f64::INFINITY, f64::min);
        Self { model, layer, turns, depths, least }
    }

    /// The term at a distance. `t` is the tangent of the angle in the layer of the least index: guess and answer. The
    /// distance is a concave function of it, so Newton's method needs no bracket.
    fn term(&self, path: &Path<f64>, r: f64, t: &mut f64) -> Term {
        if self.least == f64::INFINITY {
            return Term { enters: [0.0; 2], toward: [0.0; 2], s: 0.0, across: 0.0 };
        }
        let layers = &self.model.layers;
        let (least, top) = (self.least, self.depths.len() - 1);
        let excess = |k: usize| layers[k].n_sq - least * least;
        let mut slope = 0.0;
        for _ in 0..40 {
            let mut reach = 0.0;
            slope = 0.0;
            for k in (1..=top).filter(|&k| self.depths[k] > 0.0) {
                let q = layers[k].n_sq + excess(k) * *t * *t;
                let d = self.depths[k] * least / q.sqrt();
                reach += d * *t;
                slope += d * layers[k].n_sq / q;
            }
            let step = (r - reach) / slope;
            *t = (*t + step).max(0.0);
            if step.abs() <= 1e-7 * (1.0 + *t) {
                break;
            }
        }
        let scale = 1.0 / (1.0 + *t * *t);
        let s = least * *t * scale.sqrt();
        let cosine = |k: usize| ((layers[k].n_sq + excess(k) * *t * *t) * scale).max(0.0).sqrt();
        // dr/ds from dr/dt.
        let ds = least * scale * scale.sqrt();
        let source = layers[self.layer];
        // A place on an interface that only light of the layer beyond could leave along it sends nothing.
        let leaves = f64::from(u8::from(source.n_sq > s * s));
        let geometry = leaves * (s * s / source.n_sq) / (r * cosine(self.layer).max(f64::MIN_POSITIVE) * slope) * ds;
        let mut through = geometry * self.outer(cosine(1), 0).powi(self.turns.div_ceil(2) as i32);
        through *= self.outer(cosine(top), top).powi((self.turns / 2) as i32);
        let mut across = 0.0;
        let mut optical = 0.0;
        for k in (1..=top).filter(|&k| self.depths[k] > 0.0) {
            across += thickness(self.model, k) * s / cosine(k);
            optical += layers[k].absorption * self.depths[k] * layers[k].n / cosine(k);
            let partly = if self.turns.is_multiple_of(2) { k >= self.layer } else { k < self.layer };
            let passes = self.turns + u32::from(partly);
            if k < top && passes > 0 {
                let r = fresnel(cosine(k), cosine(k + 1), layers[k].n_sq, layers[k + 1].n_sq);
                through *= (1.0 - r).powi(passes as i32);
            }
        }
        through *= (-optical).exp();
        let tissue = path.boundary(0.0, 0.0, cosine(top));
        let enters = [through * (1.0 - tissue.contact), through * (1.0 - tissue.gap)];
        Term { enters, toward: path.toward_map(cosine(top)), s, across }
    }

    /// Reflectance of the lowest (0) or of the untouched highest face.
    fn outer(&self, cosine: f64, face: usize) -> f64 {
        let layer = self.model.layers[face.max(1)];
        reflectance(cosine, layer.side_dn_sq, layer.n_sq)
    }
}
