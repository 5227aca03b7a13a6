//! A rigid flat punch on a layer bonded to a rigid base, without friction, for any Poisson's ratio and any thickness
//! (Hayes et al., J. Biomech. 5, 541, 1972).
//!
//! In units of the punch's radius a, with the layer's height h and E* = E / (1 - nu^2), a function phi on (0, 1) obeys
//! phi(t) - (a / pi h) int_0^1 phi(s) [K(a (t + s) / h) + K(a (t - s) / h)] ds = 1,
//! K(u) = int_0^inf (1 - L(x)) cos(u x) dx, where L is the compliance of the layer's face against that of a half space.
//! The force is 2 E* a w kappa with kappa = int phi, the pressure
//! E* w / (pi a) (phi(1) / sqrt(1 - r^2) - int_r^1 phi'(t) / sqrt(t^2 - r^2) dt).

use std::f64::consts::PI;
use tirtouch::mechanics::contact::Grip;
use tirtouch::mechanics::element::PressureOrder;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{Footprint, PhantomMesh, PhantomShape, Resolution};
use tirtouch::mechanics::press::{ContactPoint, Load, SensorBody, Setup};

/// The punch as a press: a rigid sensor of this radius whose edge is rounded by a thousandth of it, mm, pressed little.
pub const RADIUS_MM: f64 = 5.0;
pub const RIM_MM: f64 = 0.005;
const DEPTH_MM: f64 = 1e-3;
const YOUNGS_KPA: f64 = 5.0;

/// The press of a layer whose height is the radius over `a_over_h`, by the rounded punch.
pub fn rounded(a_over_h: f64, poisson: f64, resolution: Resolution) -> Setup {
    let height_mm = RADIUS_MM / a_over_h;
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
        },
        phantom_materials: vec![Material::linear(YOUNGS_KPA, poisson).unwrap()],
        sensor: SensorBody::Rigid { edge_radius_mm: RIM_MM },
        grip: Grip::Frictionless,
        load: Load::Depths(vec![DEPTH_MM]),
        seconds_per_mm: None,
        hold_s: 0.0,
        tilt_deg: [0.0; 2],
    }
}

/// Nodes of the rule over the punch (Gauss and Legendre), parts of Simpson's over the waves, and their end, beyond which
/// 1 - L is none.
const NODES: usize = 24;
const WAVES: usize = 800;
const LAST_WAVE: f64 = 30.0;

/// The solution for one layer.
pub struct Layer {
    a_over_h: f64,
    poisson: f64,
    /// Wave number x, 1 - L times its weight, and int phi(s) cos(a s x / h) ds.
    waves: Vec<[f64; 3]>,
    /// Node, weight and phi there.
    nodes: Vec<[f64; 3]>,
}

impl Layer {
    pub fn new(a_over_h: f64, poisson: f64) -> Self {
        let step = LAST_WAVE / WAVES as f64;
        let wave = |k: usize| {
            let simpson = if k == 0 || k == WAVES { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
            let x = k as f64 * step;
            [x, simpson * step / 3.0 * (1.0 - compliance(x, poisson)), 0.0]
        };
        let mut layer = Self { a_over_h, poisson, waves: (0..=WAVES).map(wave).collect(), nodes: gauss() };
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
        2e-3 * self.plane_kpa() * RADIUS_MM * DEPTH_MM * self.kappa()
    }

    /// Pressure under it within 0.9 of its radius.
    pub fn face(&self) -> Vec<ContactPoint> {
        let point = |k: u32| {
            let r = 0.005 * f64::from(k);
            let pressure_kpa = self.plane_kpa() * DEPTH_MM / RADIUS_MM * self.pressure(r);
            let (displacement_mm, reference_mm) = ([0.0; 3], [RADIUS_MM * r, 0.0, 0.0]);
            let (shear_kpa, gap_mm, force_mn, area_mm2) = (0.0, 0.0, 0.0, 0.0);
            ContactPoint { node: k, reference_mm, displacement_mm, pressure_kpa, shear_kpa, gap_mm, force_mn, area_mm2 }
        };
        (0..=180).map(point).collect()
    }

    /// E*, kPa.
    fn plane_kpa(&self) -> f64 {
        YOUNGS_KPA / (1.0 - self.poisson * self.poisson)
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

/// L: the face's settlement under a wave of pressure, against that of a half space.
fn compliance(x: f64, nu: f64) -> f64 {
    if x == 0.0 {
        return 0.0;
    }
    let k = 3.0 - 4.0 * nu;
    // Both parts by cosh(2 x), which is beyond large numbers long before the end.
    let (tanh, cosh) = ((2.0 * x).tanh(), (2.0 * x).cosh());
    (k * tanh - 2.0 * x / cosh) / (k + (2.0 * x * x + 5.0 - 12.0 * nu + 8.0 * nu * nu) / cosh)
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
