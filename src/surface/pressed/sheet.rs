//! A smooth interface from the displacements of finite elements.
//!
//! Displacements are continuous from element to element, slopes are not: on the mesh of a default press they jump by up to
//! 0.04 near the edge, and light sees slopes. So they are recovered (Zienkiewicz and Zhu, Int. J. Numer. Methods Eng. 33,
//! 1331, 1992): about every corner of the elements a cubic is fitted to the nodes of all elements that meet there, where displacements
//! are most accurate. Within an element its corners' cubics are blended, with weights that are level at its borders;
//! height and slope are then continuous. At the rim, where too few elements meet, an element's own displacement counts.
//!
//! The tracer's block keeps its walls where they were. A pressed body bulges past them, and the singular bend of its edge
//! lies outside. From the outline of the undeformed face outwards, which matters where a round face is pressed in a
//! rectangular stack, an interface levels off.

use super::face::{Face, Facet};
use crate::mechanics::element::Shape;
use crate::mechanics::mesh::{Footprint, Mesh};
use crate::mechanics::press::{Pressed, SensorBody};
use faer::Mat;
use faer::linalg::solvers::SolveLstsq as _;
use std::collections::{BTreeMap, HashSet};

/// An interface: its displacement along z above every place, mm.
pub struct Sheet {
    face: Face,
    /// Of each facet, which cubics are its corners', in the order of its nodes.
    corners: Vec<Vec<usize>>,
    /// `None` at the rim.
    recovered: Vec<Option<Cubic>>,
    outline: Footprint,
    /// Length over which the slope falls by a factor of e beyond the outline, mm.
    levelling_mm: f64,
}

/// Share of the soft layers' thickness over which an interface levels off: a pressed edge falls about as far.
const LEVELLING: f64 = 0.1;
/// Halvings that find the rim: to 1e-9 of the way.
const RIM_HALVINGS: usize = 30;
/// Share of the way to the rim over which the slope there is taken.
const RIM_STEP: f64 = 1e-4;

impl Sheet {
    /// The upper face of a sensor's layer. Displacements alone: a rounded rim is left out.
    pub fn of_layer(pressed: &Pressed, sensor: &Mesh, moved: &[[f64; 3]], region: u32) -> Self {
        let up = sensor.dim - 1;
        let side = 3usize.pow(up as u32);
        let layer = || (0..sensor.element_count()).filter(|&e| sensor.region[e] == region).map(|e| sensor.element(e));
        let covered: HashSet<u32> = layer().flat_map(|nodes| &nodes[..side]).copied().collect();
        let tops = layer().map(|nodes| &nodes[2 * side..]).filter(|top| !covered.contains(&top[0]));
        let facets = tops.map(|nodes| {
            let place = |&a: &u32| {
                let (x, u) = (sensor.nodes[a as usize], moved[a as usize]);
                [x[0] + u[0], if up == 2 { x[1] + u[1] } else { 0.0 }]
            };
            Facet {
                nodes: nodes.to_vec(),
                places: nodes.iter().map(place).collect(),
                values: nodes.iter().map(|&a| moved[a as usize][up]).collect(),
            }
        });
        let thickness_mm = match &pressed.setup.sensor {
            SensorBody::Layers { layers, .. } => layers.iter().map(|(thickness_mm, _)| thickness_mm).sum(),
            SensorBody::Rigid { .. } => 0.0,
        };
        Self::new(Face::of(pressed, facets.collect()), pressed.setup.phantom.footprint, LEVELLING * thickness_mm)
    }

    fn new(face: Face, outline: Footprint, levelling_mm: f64) -> Self {
        let corners: &[usize] = if face.axes == 1 { &[0, 2] } else { &[0, 2, 6, 8] };
        let mut around: BTreeMap<u32, Vec<&Facet>> = BTreeMap::new();
        for facet in &face.facets {
            corners.iter().for_each(|&c| around.entry(facet.nodes[c]).or_default().push(facet));
        }
        let recovered = around.iter().map(|(&corner, facets)| Cubic::recovered(&face, corner, facets)).collect();
        let rank: BTreeMap<u32, usize> = around.keys().enumerate().map(|(k, &corner)| (corner, k)).collect();
        let of_facet = |facet: &Facet| corners.iter().map(|&c| rank[&facet.nodes[c]]).collect();
        Self { corners: face.facets.iter().map(of_facet).collect(), recovered, face, outline, levelling_mm }
    }

    /// Displacement above a place of the footprint, mm; 0 where there are no elements.
    pub fn height(&self, at: [f64; 2]) -> f64 {
        let at = self.face.meshed(at);
        let distance = at[0].hypot(at[1]);
        let within = |share: f64| self.within(at.map(|c| share * c));
        let outline = match self.outline {
            Footprint::Round { radius_mm } => radius_mm / distance,
            Footprint::Rectangle { half_widths_mm: [a, b] } => (a / at[0].abs()).min(b / at[1].abs()),
        };
        let most = outline.min(1.0);
        let share = if within(most).is_some() { most } else { self.rim(at, most) };
        let Some(height) = within(share) else { return 0.0 };
        match within((1.0 - RIM_STEP) * share) {
            Some(before) if share < 1.0 => {
                let slope = (height - before) / (RIM_STEP * share * distance);
                let beyond = (1.0 - share) * distance / self.levelling_mm;
                height - slope * self.levelling_mm * (-beyond).exp_m1()
            }
            _ => height,
        }
    }

    /// Share of the way from the middle to a place at which the elements end; they end before `end`.
    fn rim(&self, at: [f64; 2], end: f64) -> f64 {
        let (mut inside, mut outside) = (0.0, end);
        for _ in 0..RIM_HALVINGS {
            let middle = 0.5 * (inside + outside);
            match self.face.locate(at.map(|c| middle * c)) {
                Some(_) => inside = middle,
                None => outside = middle,
            }
        }
        inside
    }

    /// Displacement at a place on the elements.
    fn within(&self, at: [f64; 2]) -> Option<f64> {
        let (k, xi) = self.face.locate(at)?;
        // 3 t^2 - 2 t^3 is level at both ends.
        let [right, back] = xi.map(|c| (0.5 * (1.0 + c)).clamp(0.0, 1.0)).map(|t| t * t * (3.0 - 2.0 * t));
        let weights = match self.face.axes {
            1 => [1.0 - right, right, 0.0, 0.0],
            _ => [(1.0 - right) * (1.0 - back), right * (1.0 - back), (1.0 - right) * back, right * back],
        };
        let own = || {
            let shape = Shape::at(self.face.axes, [xi[0], xi[1], 0.0]);
            self.face.facets[k].values.iter().zip(&shape.value).map(|(v, n)| v * n).sum()
        };
        let value = |&c: &usize| self.recovered[c].as_ref().map_or_else(own, |cubic| cubic.at(at));
        Some(self.corners[k].iter().zip(weights).map(|(c, w)| w * value(c)).sum())
    }
}

/// A cubic of one or two coordinates about a place.
struct Cubic {
    axes: usize,
    center: [f64; 2],
    per_mm: f64,
    coefficients: Vec<f64>,
}

impl Cubic {
    /// The one that fits the nodes of all elements about a corner best; `None` where fewer than three elements meet (in one
    /// dimension two), mirrored ones counted: their nodes lie on too few lines.
    fn recovered(face: &Face, corner: u32, facets: &[&Facet]) -> Option<Self> {
        let mut nodes: BTreeMap<u32, ([f64; 2], f64)> = BTreeMap::new();
        for facet in facets {
            let carried = facet.places.iter().copied().zip(facet.values.iter().copied());
            nodes.extend(facet.nodes.iter().copied().zip(carried));
        }
        let (center, _) = nodes[&corner];
        let mut samples: Vec<([f64; 2], f64)> = nodes.into_values().collect();
        let mut elements = facets.len();
        for axis in (0..2).filter(|&axis| face.mirrored[axis] && center[axis] == 0.0) {
            let mut images = samples.clone();
            images.retain(|(place, _)| place[axis] != 0.0);
            images.iter_mut().for_each(|(place, _)| place[axis] = -place[axis]);
            samples.extend(images);
            elements *= 2;
        }
        if elements <= face.axes {
            return None;
        }
        let distance = |x: [f64; 2]| (x[0] - center[0]).hypot(x[1] - center[1]);
        let reach = samples.iter().map(|&(place, _)| distance(place)).fold(0.0, f64::max);
        let mut fit = Self { axes: face.axes, center, per_mm: reach.recip(), coefficients: Vec::new() };
        let rows: Vec<Vec<f64>> = samples.iter().map(|&(place, _)| fit.terms(place).collect()).collect();
        let terms = if face.axes == 1 { 4 } else { 10 };
        let matrix = Mat::from_fn(rows.len(), terms, |i, j| rows[i][j]);
        let values = Mat::from_fn(rows.len(), 1, |i, _| samples[i].1);
        let solved = matrix.qr().solve_lstsq(&values);
        fit.coefficients = (0..terms).map(|j| solved[(j, 0)]).collect();
        Some(fit)
    }

    fn terms(&self, at: [f64; 2]) -> impl Iterator<Item = f64> {
        let [x, y] = [0, 1].map(|i| (at[i] - self.center[i]) * self.per_mm);
        let rows = if self.axes == 1 { 0 } else { 3 };
        (0..=rows).flat_map(move |j| (0..=3 - j).map(move |i| x.powi(i) * y.powi(j)))
    }

    fn at(&self, at: [f64; 2]) -> f64 {
        self.terms(at).zip(&self.coefficients).map(|(term, c)| term * c).sum()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A grid of facets over [0, 1] x [0, 1] times `size`, slanted and unequal, mirrored as told; along r if `axes` is 1.
    fn face(axes: usize, divisions: usize, size: f64, mirrored: [bool; 2], value: impl Fn([f64; 2]) -> f64) -> Face {
        let lines = 2 * divisions + 1;
        let place = |i: usize, j: usize| {
            let [s, t] = [i, j].map(|k| k as f64 / (lines - 1) as f64);
            let graded = |s: f64| s + 0.15 * s * (1.0 - s);
            if axes == 1 {
                return [size * graded(s), 0.0];
            }
            let slant = 0.4 * s * t * (1.0 - s) * (1.0 - t);
            [size * (graded(s) + slant), size * (graded(t) - slant)]
        };
        let rows = if axes == 1 { 1 } else { divisions };
        let facet = |k: usize| {
            let (x, y) = (2 * (k % divisions), 2 * (k / divisions));
            let across = if axes == 1 { 1 } else { 3 };
            let at = move |a: usize| (x + a % 3, y + a / 3);
            let places: Vec<_> = (0..3 * across).map(|a| place(at(a).0, at(a).1)).collect();
            Facet {
                nodes: (0..3 * across).map(|a| (at(a).0 + lines * at(a).1) as u32).collect(),
                values: places.iter().map(|&place| value(place)).collect(),
                places,
            }
        };
        Face::new(axes, mirrored, (0..divisions * rows).map(facet).collect())
    }

    fn sheet(axes: usize, divisions: usize, value: impl Fn([f64; 2]) -> f64) -> Sheet {
        let outline = Footprint::Rectangle { half_widths_mm: [4.0, 4.0] };
        Sheet::new(face(axes, divisions, 4.0, [true, axes == 2], value), outline, 1.0)
    }

    /// Even in both coordinates, as mirrors ask.
    fn bump([x, y]: [f64; 2]) -> f64 {
        -(-(x * x + 0.5 * y * y) / 5.0).exp()
    }

    fn slope(sheet: &Sheet, [x, y]: [f64; 2], step: f64) -> f64 {
        (sheet.height([x + step, y]) - sheet.height([x, y])) / step
    }

    #[test]
    fn parabolas_are_kept_on_slanted_elements_up_to_the_rim() {
        let parabola = |[x, y]: [f64; 2]| 0.3 - 0.2 * x * x + 0.1 * y * y;
        for axes in [1, 2] {
            let sheet = sheet(axes, 4, parabola);
            for k in 0..400 {
                let at = [0.0101 * f64::from(k) - 2.0, if axes == 2 { 3.9 - 0.009 * f64::from(k) } else { 0.0 }];
                // The element's own parabola counts at the rim; slanted elements bend it.
                let allowed = if at[1] < 2.5 { 1e-12 } else { 1e-3 };
                let off = sheet.height(at) - parabola(at);
                assert!(off.abs() < allowed, "{off} at {at:?}");
            }
        }
    }

    #[test]
    fn slopes_do_not_jump_where_those_of_the_elements_do() {
        for axes in [1, 2] {
            let sheet = sheet(axes, 6, bump);
            let own = Sheet { recovered: sheet.recovered.iter().map(|_| None).collect(), ..self::sheet(axes, 6, bump) };
            let jump = |sheet: &Sheet, node: [f64; 2]| (slope(sheet, node, 1e-6) - slope(sheet, node, -1e-6)).abs();
            let corners: Vec<[f64; 2]> = sheet.face.facets.iter().map(|facet| facet.places[0]).collect();
            // Not those on the axis, where by symmetry nothing jumps, nor those at the rim.
            let inner = corners.into_iter().filter(|[x, y]| *x > 0.1 && x.max(*y) < 3.0);
            let (smooth, kinked) =
                inner.fold((0.0f64, 0.0f64), |(a, b), node| (a.max(jump(&sheet, node)), b.max(jump(&own, node))));
            assert!(smooth < 1e-5 && kinked > 3e-3, "{smooth} against {kinked}");
        }
    }

    #[test]
    fn slopes_gain_an_order_over_those_of_the_elements() {
        for axes in [1, 2] {
            let error = |divisions: usize, recover: bool| {
                let mut sheet = sheet(axes, divisions, bump);
                if !recover {
                    sheet.recovered.iter_mut().for_each(|fit| *fit = None);
                }
                let spots = (1..2000).map(|k| (f64::from(k) * 0.754_877_67 % 1.0, f64::from(k) * 0.569_840_29 % 1.0));
                let squares = spots.map(|(u, v)| {
                    let at = [2.5 * u, if axes == 2 { 2.5 * v } else { 0.0 }];
                    (slope(&sheet, at, 1e-6) + 0.4 * at[0] * bump(at)).powi(2)
                });
                squares.sum::<f64>().sqrt()
            };
            let [own, recovered] = [false, true].map(|recover| (error(8, recover) / error(16, recover)).log2());
            assert!((own - 2.0).abs() < 0.25, "{own}");
            assert!(recovered > 2.75, "{recovered}");
        }
    }

    #[test]
    fn beyond_the_outline_an_interface_levels_off_whatever_the_elements_do_there() {
        // The elements reach to 4 and have a step beyond the outline at 3.
        let step = |at: [f64; 2]| bump(at) - if at[0] > 3.45 { 0.5 } else { 0.0 };
        let sheet = Sheet::new(face(1, 16, 4.0, [true, false], step), Footprint::Round { radius_mm: 3.0 }, 0.5);
        let at_rim = slope(&sheet, [3.0, 0.0], -1e-6);
        assert!((at_rim + 0.4 * 3.0 * bump([3.0, 0.0])).abs() < 1e-3, "{at_rim}");
        let height = |r: f64| sheet.height([0.6 * r, 0.8 * r]);
        let fall = |d: f64| at_rim * 0.5 * (1.0 - (-d / 0.5).exp());
        for d in [0.0, 0.1, 0.5, 2.0, 10.0] {
            assert!((height(3.0 + d) - height(3.0) - fall(d)).abs() < 1e-4, "{d}");
        }
        // Where the elements end before the outline, they count to their end.
        let short = Sheet::new(face(1, 16, 4.0, [true, false], bump), Footprint::Round { radius_mm: 5.0 }, 0.5);
        assert!((short.height([4.0, 0.0]) - bump([4.0, 0.0])).abs() < 1e-6);
        let end = slope(&short, [4.0, 0.0], -1e-6);
        assert!((short.height([60.0, 0.0]) - short.height([4.0, 0.0]) - 0.5 * end).abs() < 1e-4);
    }
}
