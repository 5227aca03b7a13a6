//! A rigid flat punch on layers bonded to each other and to a rigid base, without friction, for any Poisson's ratio and
//! any thickness (Hayes et al., J. Biomech. 5, 541, 1972, for one layer).
//!
//! In units of the punch's radius a, with a length h and E* = E / (1 - nu^2) of the touched layer, a function phi on
//! (0, 1) obeys phi(t) - (a / pi h) int_0^1 phi(s) [K(a (t + s) / h) + K(a (t - s) / h)] ds = 1,
//! K(u) = int_0^inf (1 - L(x)) cos(u x) dx, where L(k h) is the compliance of the face under waves of number k against
//! that of a half space of the touched layer. The force is 2 E* a w kappa with kappa = int phi, the pressure
//! E* w / (pi a) (phi(1) / sqrt(1 - r^2) - int_r^1 phi'(t) / sqrt(t^2 - r^2) dt).
//!
//! Of one layer L is known in closed form. Of several it is integrated: in Hankel space (u_r, u_z, s_rz, s_zz) obey
//! four ordinary equations over the depth, and the compliance C, (u_r, u_z) = C (s_rz, s_zz), a Riccati equation, which
//! is stable from the base, where C = 0, up to the face.

use std::f64::consts::PI;
use tirtouch::mechanics::contact::Grip;
use tirtouch::mechanics::element::PressureOrder;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{Footprint, PhantomMesh, PhantomShape, Resolution};
use tirtouch::mechanics::press::{ContactPoint, Load, SensorBody, Setup, TIME_STEPS};

/// The punch as a press: a rigid sensor of this radius whose edge is rounded by a thousandth of it, mm, pressed little.
pub const RADIUS_MM: f64 = 5.0;
pub const RIM_MM: f64 = 0.005;
const DEPTH_MM: f64 = 1e-3;

/// A layer; the touched one is the first.
#[derive(Debug, Clone, Copy)]
pub struct Layer {
    pub thickness_mm: f64,
    pub youngs_kpa: f64,
    pub poisson: f64,
}

/// One layer whose height is the radius over `a_over_h`.
pub fn one(a_over_h: f64, poisson: f64) -> [Layer; 1] {
    [Layer { thickness_mm: RADIUS_MM / a_over_h, youngs_kpa: 5.0, poisson }]
}

/// The press of layers by the rounded punch.
pub fn rounded(layers: &[Layer], resolution: Resolution) -> Setup {
    let height_mm: f64 = layers.iter().map(|layer| layer.thickness_mm).sum();
    let (body, above) = layers.split_last().unwrap();
    let material = |layer: &Layer| Material::linear(layer.youngs_kpa, layer.poisson).unwrap();
    Setup {
        kinematics: Kinematics::Axisymmetric,
        pressure: PressureOrder::Linear,
        phantom: PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: RADIUS_MM + 8.0 * height_mm, height_mm },
            inclusions: Vec::new(),
            footprint: Footprint::Round { radius_mm: RADIUS_MM },
            symmetry: [true, true],
            resolution,
            offset_mm: [0.0; 2],
            layers_mm: above.iter().map(|layer| layer.thickness_mm).collect(),
        },
        phantom_materials: std::iter::once(body).chain(above).map(material).collect(),
        sensor: SensorBody::Rigid { edge_radius_mm: RIM_MM },
        grip: Grip::Frictionless,
        load: Load::Depths(vec![DEPTH_MM]),
        seconds_per_mm: None,
        hold_s: 0.0,
        time_steps: TIME_STEPS,
        tilt_deg: [0.0; 2],
    }
}

/// Nodes of the rule over the punch and over each part of the waves (Gauss and Legendre); parts of the waves and their
/// end, beyond which 1 - L is none, and ends within the first part, where L begins.
const NODES: usize = 24;
const PARTS: usize = 40;
const LAST_WAVE: f64 = 30.0;
const FIRST_ENDS: [f64; 3] = [0.02, 0.08, 0.25];

/// The solution.
pub struct Punched {
    /// E* of the touched layer, kPa.
    plane_kpa: f64,
    /// The punch's radius over the touched layer's thickness h.
    a_over_h: f64,
    /// Wave number x, 1 - L times its weight, and int phi(s) cos(a s x / h) ds.
    waves: Vec<[f64; 3]>,
    /// Node, weight and phi there.
    nodes: Vec<[f64; 3]>,
}

impl Punched {
    pub fn on(layers: &[Layer]) -> Self {
        let top = layers[0];
        match layers {
            [_] => Self::new(top, &|x| closed_form(x, top.poisson)),
            _ => Self::new(top, &|x| integrated(x, layers)),
        }
    }

    /// Of a compliance L.
    fn new(top: Layer, compliance: &dyn Fn(f64) -> f64) -> Self {
        let (a_over_h, plane_kpa) = (RADIUS_MM / top.thickness_mm, top.youngs_kpa / (1.0 - top.poisson * top.poisson));
        let part = LAST_WAVE / PARTS as f64;
        let ends = (0..=PARTS).map(|k| k as f64 * part);
        let mut ends: Vec<f64> = ends.chain(FIRST_ENDS).collect();
        ends.sort_by(f64::total_cmp);
        let within = |ends: &[f64]| {
            let [from, to] = [ends[0], ends[1]];
            gauss().into_iter().map(move |[x, weight, _]| [from + (to - from) * x, (to - from) * weight])
        };
        let waves: Vec<[f64; 3]> =
            ends.windows(2).flat_map(within).map(|[x, weight]| [x, weight * (1.0 - compliance(x)), 0.0]).collect();
        let mut layer = Self { plane_kpa, a_over_h, waves, nodes: gauss() };
        let places: Vec<[f64; 2]> = layer.nodes.iter().map(|&[t, weight, _]| [t, weight]).collect();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for (i, &[t, _]) in places.iter().enumerate() {
            let entry = |j: usize| f64::from(u8::from(i == j)) - places[j][1] * layer.kernel(t, places[j][0]);
            rows.push((0..places.len()).map(entry).chain([1.0]).collect());
        }
        for (node, phi) in layer.nodes.iter_mut().zip(solve(rows)) {
            node[2] = phi;
        }
        for wave in &mut layer.waves {
            let part = |[s, weight, phi]: &[f64; 3]| weight * phi * (a_over_h * s * wave[0]).cos();
            wave[2] = layer.nodes.iter().map(part).sum();
        }
        layer
    }

    /// Force on the sharp punch in place of the rounded one, N.
    pub fn force_n(&self) -> f64 {
        2e-3 * self.plane_kpa * RADIUS_MM * DEPTH_MM * self.kappa()
    }

    /// Pressure under it within 0.9 of its radius.
    pub fn face(&self) -> Vec<ContactPoint> {
        let point = |k: u32| {
            let r = 0.005 * f64::from(k);
            let pressure_kpa = self.plane_kpa * DEPTH_MM / RADIUS_MM * self.pressure(r);
            let (displacement_mm, reference_mm) = ([0.0; 3], [RADIUS_MM * r, 0.0, 0.0]);
            let (shear_kpa, gap_mm, force_mn, area_mm2) = (0.0, 0.0, 0.0, 0.0);
            ContactPoint { node: k, reference_mm, displacement_mm, pressure_kpa, shear_kpa, gap_mm, force_mn, area_mm2 }
        };
        (0..=180).map(point).collect()
    }

    /// Force over 2 E* a w.
    pub fn kappa(&self) -> f64 {
        self.nodes.iter().map(|[_, weight, phi]| weight * phi).sum()
    }

    /// Pressure over E* w / a at a distance from the axis in radii, below 1.
    fn pressure(&self, r: f64) -> f64 {
        let reach = (1.0 - r * r).sqrt();
        // t^2 = r^2 + s^2 takes the root away; phi is even, so that phi' / t goes on to the axis.
        let slope = |s: f64| {
            let t = r.hypot(s);
            self.slope(t) / t
        };
        let inner: f64 = self.nodes.iter().map(|[s, weight, _]| reach * weight * slope(reach * s)).sum();
        (self.phi(1.0) / reach - inner) / PI
    }

    fn phi(&self, t: f64) -> f64 {
        let ratio = self.a_over_h;
        1.0 + 2.0 * ratio / PI * self.waves.iter().map(|[x, m, part]| m * part * (ratio * t * x).cos()).sum::<f64>()
    }

    fn slope(&self, t: f64) -> f64 {
        let ratio = self.a_over_h;
        let wave = |[x, m, part]: &[f64; 3]| -x * m * part * (ratio * t * x).sin();
        2.0 * ratio * ratio / PI * self.waves.iter().map(wave).sum::<f64>()
    }

    fn kernel(&self, t: f64, s: f64) -> f64 {
        let ratio = self.a_over_h;
        let wave = |[x, m, _]: &[f64; 3]| 2.0 * m * (ratio * t * x).cos() * (ratio * s * x).cos();
        ratio / PI * self.waves.iter().map(wave).sum::<f64>()
    }
}

/// L of one layer.
fn closed_form(x: f64, nu: f64) -> f64 {
    if x == 0.0 {
        return 0.0;
    }
    let k = 3.0 - 4.0 * nu;
    // Both parts by cosh(2 x), which is beyond large numbers long before the end.
    let (tanh, cosh) = ((2.0 * x).tanh(), (2.0 * x).cosh());
    (k * tanh - 2.0 * x / cosh) / (k + (2.0 * x * x + 5.0 - 12.0 * nu + 8.0 * nu * nu) / cosh)
}

/// How deep waves of number 1 reach, steps of Runge and Kutta's rule over a layer, and more by its thickness.
const REACH: f64 = 20.0;
const STEPS: [f64; 2] = [60.0, 30.0];

/// L of several layers; x is the wave number times the touched one's thickness.
fn integrated(x: f64, layers: &[Layer]) -> f64 {
    let unit = layers[0].thickness_mm;
    let mut c = [[0.0; 2]; 2];
    for layer in layers.iter().rev() {
        let (mu, nu) = (shear_kpa(layer), layer.poisson);
        let share = nu / (1.0 - nu);
        // d(u, s)/dz = [[A, B], [D, E]] (u, s), z into the body.
        let a = [[0.0, x], [-x * share, 0.0]];
        let b = [[1.0 / mu, 0.0], [0.0, (1.0 - 2.0 * nu) / (2.0 * mu * (1.0 - nu))]];
        let d = [[2.0 * mu * x * x / (1.0 - nu), 0.0], [0.0, 0.0]];
        let e = [[0.0, x * share], [-x, 0.0]];
        let slope = |c: [[f64; 2]; 2]| {
            let (ac, ce, cdc) = (product(a, c), product(c, e), product(product(c, d), c));
            entries(|i, j| ac[i][j] + b[i][j] - ce[i][j] - cdc[i][j])
        };
        let depth = (layer.thickness_mm / unit).min(REACH / x);
        let steps = (STEPS[0] + STEPS[1] * x * depth).ceil();
        // Up, against z.
        let h = -depth / steps;
        for _ in 0..steps as usize {
            let moved = |by: f64, slope: [[f64; 2]; 2]| entries(|i, j| c[i][j] + by * slope[i][j]);
            let one = slope(c);
            let two = slope(moved(0.5 * h, one));
            let three = slope(moved(0.5 * h, two));
            let four = slope(moved(h, three));
            c = entries(|i, j| c[i][j] + h / 6.0 * (one[i][j] + 2.0 * (two[i][j] + three[i][j]) + four[i][j]));
        }
    }
    -c[1][1] * x * shear_kpa(&layers[0]) / (1.0 - layers[0].poisson)
}

fn shear_kpa(layer: &Layer) -> f64 {
    0.5 * layer.youngs_kpa / (1.0 + layer.poisson)
}

fn entries(entry: impl Fn(usize, usize) -> f64) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| entry(i, j)))
}

fn product(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    entries(|i, j| a[i][0] * b[0][j] + a[i][1] * b[1][j])
}

/// How far the integrated compliance of one layer, in one and in two parts, is off the closed form, over the waves.
pub fn worst_compliance(poisson: f64) -> f64 {
    let layer = |thickness_mm: f64| Layer { thickness_mm, youngs_kpa: 7.0, poisson };
    let off = |x: f64| {
        let parted = integrated(0.3 * x, &[layer(0.6), layer(1.4)]);
        [integrated(x, &[layer(2.0)]), parted].map(|found| (found - closed_form(x, poisson)).abs())
    };
    (1..=60).flat_map(|k| off(0.1 * f64::from(k))).fold(0.0, f64::max)
}

/// Gauss and Legendre's nodes and weights on (0, 1), by Newton's method.
fn gauss() -> Vec<[f64; 3]> {
    let n = NODES as f64;
    let node = |k: usize| {
        let mut x = (PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        let mut derivative = 1.0;
        for _ in 0..50 {
            let (mut p, mut before) = (1.0, 0.0);
            for j in 0..NODES {
                let j = j as f64;
                (p, before) = (((2.0 * j + 1.0) * x * p - j * before) / (j + 1.0), p);
            }
            derivative = n * (x * p - before) / (x * x - 1.0);
            x -= p / derivative;
        }
        [0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * derivative * derivative), 0.0]
    };
    (0..NODES).map(node).collect()
}

/// Gauss's elimination of rows that end in their right sides; the matrix is close to one.
fn solve(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for k in 0..n {
        let pivot = rows[k].clone();
        for row in rows.iter_mut().skip(k + 1) {
            let share = row[k] / pivot[k];
            row.iter_mut().zip(&pivot).for_each(|(a, b)| *a -= share * b);
        }
    }
    let mut solution = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| rows[k][j] * solution[j]).sum();
        solution[k] = (rows[k][n] - known) / rows[k][k];
    }
    solution
}
