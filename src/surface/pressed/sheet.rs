//! A smooth interface from the displacements of finite elements.
//!
//! Displacements are continuous from element to element, slopes are not: on the mesh of a default press they jump by up
//! to 0.04 near the edge, and light sees slopes. So they are recovered (polynomial-preserving recovery: Zhang and Naga,
//! SIAM J. Sci. Comput. 26, 1192, 2005): about every corner of the elements a cubic is fitted to the nodes of all
//! elements that meet there, where displacements are most accurate. Within an element its corners' cubics are blended,
//! with weights that are level at its borders. Slopes then are of third order in the size of the elements, and
//! continuous: along r everywhere, over the plane at the corners and wherever lines of the mesh run straight on; where
//! such a line has a kink they jump by what two cubics differ, of third order as well.
//!
//! The edge of a sensor is singular, and blurs the elements that meet it: slopes of cubics fitted there went up and
//! down by a fifth while the edge moved by one element, and with them the light. So where the edge is round the corners
//! of these elements take the nearest cubic that sees none of them. At the straight edges of a rectangle elements are
//! three times as wide, and cubics drawn on over two of them were further off: there, and where there is no cubic, the
//! last elements count by their own displacement.
//!
//! The tracer's block keeps its walls where they were. A pressed body bulges past them, and the singular bend of its
//! edge with it, but for what elements at the outline see of it. From the outline of the undeformed face outwards,
//! which matters where a round face is pressed in a rectangular stack, an interface levels off, straight away from the
//! axis.

use crate::mechanics::element::ShapeFunctions;
use crate::mechanics::mesh::{Footprint, Mesh};
use crate::mechanics::press::Pressed;
use crate::mechanics::press::facets::{Facet, FacetMesh};
use faer::Mat;
use faer::linalg::solvers::SolveLstsq as _;
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};

/// An interface: its displacement along z above every place, mm.
pub struct Sheet {
    face: FacetMesh,
    cubics: Vec<Cubic>,
    /// Which of them the corners of elements have.
    of_corner: HashMap<u32, usize>,
    outline: Footprint,
    /// Length over which the slope falls by a factor of e beyond the outline, mm.
    levelling_mm: f64,
}

/// Share of the soft layers' thickness over which an interface levels off: a rule (docs/PHYSICS.md, "To light").
const LEVELLING: f64 = 0.1;
/// Halvings that find the end of the elements: to 1e-9 of the way.
const HALVINGS: usize = 30;
/// Share of the way to the outline over which the slope there is taken.
const SLOPE_STEP: f64 = 1e-4;

impl Sheet {
    /// The upper face of a sensor's layer. Displacements alone: a rounded rim is left out.
    pub fn of_layer(pressed: &Pressed, sensor: &Mesh, moved: &[[f64; 3]], region: u32, soft_mm: f64) -> Self {
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
        Self::new(FacetMesh::of(pressed, facets.collect()), pressed.setup.phantom.footprint, LEVELLING * soft_mm)
    }

    fn new(face: FacetMesh, outline: Footprint, levelling_mm: f64) -> Self {
        let mut around: HashMap<u32, Vec<&Facet>> = HashMap::new();
        for facet in &face.facets {
            face.corners().iter().for_each(|&c| around.entry(facet.nodes[c]).or_default().push(facet));
        }
        let fitted =
            |(corner, facets): (&u32, &Vec<&Facet>)| Some((*corner, Cubic::recovered(&face, *corner, facets)?));
        let fitted: BTreeMap<u32, Cubic> = around.iter().filter_map(fitted).collect();
        let corners = |facet: &Facet| face.corners().iter().map(|&c| facet.nodes[c]).collect::<Vec<u32>>();
        let ends = face.facets.iter().filter(|facet| corners(facet).iter().any(|c| !fitted.contains_key(c)));
        let drawn_on = face.axes == 1 || matches!(outline, Footprint::Round { .. });
        let blurred: HashSet<u32> = ends.filter(|_| drawn_on).flat_map(corners).collect();
        let sound = |(corner, cubic): (u32, Cubic)| (!blurred.contains(&corner)).then_some((corner, cubic));
        let (sound, cubics): (Vec<u32>, Vec<Cubic>) = fitted.into_iter().filter_map(sound).unzip();
        let mut of_corner: HashMap<u32, usize> = sound.iter().copied().zip(0..).collect();
        for facet in face.facets.iter().filter(|_| drawn_on) {
            for &c in face.corners() {
                let apart = |cubic: &Cubic| (0..2).map(|i| (cubic.center[i] - facet.places[c][i]).powi(2)).sum::<f64>();
                let nearest = |a: &usize, b: &usize| apart(&cubics[*a]).total_cmp(&apart(&cubics[*b]));
                if let Entry::Vacant(place) = of_corner.entry(facet.nodes[c]) {
                    (0..cubics.len()).min_by(nearest).map(|k| place.insert(k));
                }
            }
        }
        Self { face, cubics, of_corner, outline, levelling_mm }
    }

    /// Displacement above a place of the footprint, mm; 0 where there are no elements.
    pub fn height(&self, at: [f64; 2]) -> f64 {
        let at = self.face.meshed(at);
        let distance = at[0].hypot(at[1]);
        let outline = match self.outline {
            Footprint::Round { radius_mm } => radius_mm / distance,
            Footprint::Rectangle { half_widths_mm: [a, b] } => (a / at[0].abs()).min(b / at[1].abs()),
        };
        let share = self.end(at, outline.min(1.0));
        let within = |share: f64| self.within(at.map(|c| share * c));
        let Some(height) = within(share) else { return 0.0 };
        if share == 0.0 || share == 1.0 {
            return height;
        }
        let slope =
            within((1.0 - SLOPE_STEP) * share).map_or(0.0, |before| height - before) / (SLOPE_STEP * share * distance);
        let beyond = (1.0 - share) * distance / self.levelling_mm;
        height - slope * self.levelling_mm * (-beyond).exp_m1()
    }

    /// Share of the way from the middle to a place up to which there are elements, at most `most`.
    fn end(&self, at: [f64; 2], most: f64) -> f64 {
        let covered = |share: f64| self.face.locate(at.map(|c| share * c)).is_some();
        if covered(most) {
            return most;
        }
        let (mut inside, mut outside) = (0.0, most);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if covered(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }

    /// Displacement at a place on the elements.
    fn within(&self, at: [f64; 2]) -> Option<f64> {
        let (k, xi) = self.face.locate(at)?;
        let facet = &self.face.facets[k];
        // 3 t^2 - 2 t^3 is level at both ends.
        let [right, back] = xi.map(|c| (0.5 * (1.0 + c)).clamp(0.0, 1.0)).map(|t| t * t * (3.0 - 2.0 * t));
        let weights = match self.face.axes {
            1 => [1.0 - right, right, 0.0, 0.0],
            _ => [(1.0 - right) * (1.0 - back), right * (1.0 - back), (1.0 - right) * back, right * back],
        };
        let own = || {
            let shape = ShapeFunctions::at(self.face.axes, [xi[0], xi[1], 0.0]);
            facet.values.iter().zip(&shape.value).map(|(v, n)| v * n).sum()
        };
        let value = |&c: &usize| self.of_corner.get(&facet.nodes[c]).map_or_else(own, |&k| self.cubics[k].at(at));
        Some(self.face.corners().iter().zip(weights).map(|(c, w)| w * value(c)).sum())
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
    /// The one that fits the nodes of all elements about a corner best; `None` where fewer than three elements meet (in
    /// one dimension two), mirrored ones counted: their nodes lie on too few lines.
    fn recovered(face: &FacetMesh, corner: u32, facets: &[&Facet]) -> Option<Self> {
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
        let most = if self.axes == 1 { 0 } else { 3 };
        (0..=most).flat_map(move |j| (0..=3 - j).map(move |i| x.powi(i) * y.powi(j)))
    }

    fn at(&self, at: [f64; 2]) -> f64 {
        self.terms(at).zip(&self.coefficients).map(|(term, c)| term * c).sum()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A grid of facets over [0, 4] x [0, 4], slanted, unequal and with kinked lines; along r if `axes` is 1.
    fn face(axes: usize, divisions: usize, value: impl Fn([f64; 2]) -> f64) -> FacetMesh {
        let lines = 2 * divisions + 1;
        let place = |i: usize, j: usize| {
            let [s, t] = [i, j].map(|k| k as f64 / (lines - 1) as f64);
            let graded = |s: f64| 4.0 * (s + 0.15 * s * (1.0 - s));
            if axes == 1 {
                return [graded(s), 0.0];
            }
            let slant = 1.6 * s * t * (1.0 - s) * (1.0 - t);
            let kink = [0.0, 0.5, 1.0, 0.5][i % 4] / divisions as f64 * 3.2 * t * (1.0 - t);
            [graded(s) + slant, graded(t) - slant + kink]
        };
        let across = if axes == 1 { 1 } else { 3 };
        let facet = |k: usize| {
            let (x, y) = (2 * (k % divisions), 2 * (k / divisions));
            let at = move |a: usize| (x + a % 3, y + a / 3);
            let places: Vec<_> = (0..3 * across).map(|a| place(at(a).0, at(a).1)).collect();
            Facet {
                nodes: (0..3 * across).map(|a| (at(a).0 + lines * at(a).1) as u32).collect(),
                values: places.iter().map(|&place| value(place)).collect(),
                places,
            }
        };
        let count = if axes == 1 { divisions } else { divisions * divisions };
        FacetMesh::new(axes, [true, axes == 2], (0..count).map(facet).collect())
    }

    fn sheet(axes: usize, divisions: usize, value: impl Fn([f64; 2]) -> f64) -> Sheet {
        let outline = Footprint::Rectangle { half_widths_mm: [4.0, 4.0] };
        Sheet::new(face(axes, divisions, value), outline, 1.0)
    }

    /// The same with the elements' own displacements.
    fn unrecovered(axes: usize, divisions: usize, value: impl Fn([f64; 2]) -> f64) -> Sheet {
        Sheet { of_corner: HashMap::new(), ..sheet(axes, divisions, value) }
    }

    /// Even in both coordinates, as mirrors ask.
    fn bump([x, y]: [f64; 2]) -> f64 {
        -(-(x * x + 0.5 * y * y) / 5.0).exp()
    }

    fn slope(sheet: &Sheet, [x, y]: [f64; 2], step: f64) -> f64 {
        (sheet.height([x + step, y]) - sheet.height([x, y])) / step
    }

    #[test]
    fn parabolas_are_kept() {
        let parabola = |[x, y]: [f64; 2]| 0.3 - 0.2 * x * x + 0.1 * y * y;
        for (axes, reach) in [(1, 3.0), (2, 2.5)] {
            // In the last elements their own parabolas count, and unequal halves bend these.
            let sheet = sheet(axes, 4, parabola);
            for k in 0..400 {
                let at = [f64::from(k) * 0.754_877_67 % 1.0, f64::from(k) * 0.569_840_29 % 1.0]
                    .map(|u| reach * (2.0 * u - 1.0));
                let at = if axes == 1 { [at[0], 0.0] } else { at };
                let off = sheet.height(at) - parabola(at);
                assert!(off.abs() < 1e-12, "{off} at {at:?}");
            }
        }
    }

    /// The largest jump of the slope along x at corners and middles of inner borders of elements.
    fn jump(sheet: &Sheet) -> f64 {
        let borders = sheet.face.facets.iter().flat_map(|facet| facet.places.iter().step_by(3));
        let inner = borders.filter(|[x, y]| *x > 0.1 && x.max(*y) < 2.7);
        inner.map(|&at| (slope(sheet, at, 1e-6) - slope(sheet, at, -1e-6)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn slopes_do_not_jump_along_r_and_over_the_plane_by_less_than_a_fourth() {
        // Rounding of heights of 1 over steps of 1e-6, and the bending over them: below 1e-5.
        assert!(jump(&sheet(1, 8, bump)) < 1e-5);
        assert!(jump(&unrecovered(1, 8, bump)) > 1e-3);
        for divisions in [8, 16] {
            let [recovered, own] = [sheet(2, divisions, bump), unrecovered(2, divisions, bump)].map(|s| jump(&s));
            assert!(recovered < 0.25 * own, "{recovered} against {own}");
        }
    }

    #[test]
    fn slopes_gain_an_order_over_those_of_the_elements() {
        for axes in [1, 2] {
            let error = |sheet: &Sheet| {
                let spots = (1..2000).map(|k| (f64::from(k) * 0.754_877_67 % 1.0, f64::from(k) * 0.569_840_29 % 1.0));
                let squares = spots.map(|(u, v)| {
                    let at = [2.5 * u, if axes == 2 { 2.5 * v } else { 0.0 }];
                    (slope(sheet, at, 1e-6) + 0.4 * at[0] * bump(at)).powi(2)
                });
                squares.sum::<f64>().sqrt()
            };
            let rate = |of: &dyn Fn(usize) -> Sheet| (error(&of(8)) / error(&of(16))).log2();
            // Quadratic elements have slopes of second order.
            let own = rate(&|divisions| unrecovered(axes, divisions, bump));
            let recovered = rate(&|divisions| sheet(axes, divisions, bump));
            assert!((own - 2.0).abs() < 0.25, "{own}");
            assert!(recovered > 2.75, "{recovered}");
        }
    }

    #[test]
    fn beyond_the_outline_an_interface_levels_off() {
        // The elements have a step of their own where none that meets the outline's element lies.
        let step = |at: [f64; 2]| bump(at) - if at[0] > 3.45 { 0.5 } else { 0.0 };
        let sheet = Sheet::new(face(1, 16, step), Footprint::Round { radius_mm: 3.0 }, 0.5);
        let at_outline = slope(&sheet, [3.0, 0.0], -1e-6);
        // Elements of 0.25: slopes to 1e-3 or better.
        assert!((at_outline + 0.4 * 3.0 * bump([3.0, 0.0])).abs() < 1e-3, "{at_outline}");
        let height = |r: f64| sheet.height([0.6 * r, 0.8 * r]);
        let fall = |d: f64| at_outline * 0.5 * (1.0 - (-d / 0.5).exp());
        for d in [0.0, 0.1, 0.5, 2.0, 10.0] {
            // The slope is taken over 3e-4 mm, where it changes by 1e-4.
            assert!((height(3.0 + d) - height(3.0) - fall(d)).abs() < 1e-4, "{d}");
        }
    }

    #[test]
    fn elements_that_end_before_the_outline_count_to_their_end() {
        let short = Sheet::new(face(1, 16, bump), Footprint::Round { radius_mm: 5.0 }, 0.5);
        // A cubic that saw no more than half a mm before the last two elements, of 0.25 mm: its fourth derivative bends
        // it by up to 1e-3.
        assert!((short.height([4.0, 0.0]) - bump([4.0, 0.0])).abs() < 1e-3);
        let end = slope(&short, [4.0, 0.0], -1e-6);
        assert!((short.height([60.0, 0.0]) - short.height([4.0, 0.0]) - 0.5 * end).abs() < 1e-4);
    }

    #[test]
    fn a_rectangle_levels_off_along_rays_from_the_axis() {
        let sheet = Sheet::new(face(2, 8, bump), Footprint::Rectangle { half_widths_mm: [2.0, 3.0] }, 0.5);
        for outline in [[2.0, 0.0], [-2.0, 1.0], [0.0, 3.0], [1.0, -3.0], [2.0, 3.0]] {
            let [x, y]: [f64; 2] = outline;
            let radius = x.hypot(y);
            // Elements of half a mm: heights to 1e-3, slopes to 1e-2.
            let at = |d: f64| sheet.height(outline.map(|c| c * (1.0 + d / radius)));
            assert!((at(0.0) - bump(outline)).abs() < 1e-3, "{outline:?}");
            let slope = -(0.4 * x * x + 0.2 * y * y) / radius * bump(outline);
            let [before, after] = [-1e-5, 1e-5].map(|d| (at(d) - at(0.0)) / d);
            assert!((before - slope).abs() < 1e-2 && (after - before).abs() < 1e-3, "{before}, {after}, {slope}");
            assert!((at(20.0) - at(0.0) - 0.5 * before).abs() < 1e-3, "{outline:?}");
        }
        assert!((sheet.height([0.0, 0.0]) - bump([0.0, 0.0])).abs() < 1e-3);
    }
}
