//! A flat frictionless punch on bonded linear layers on a rigid base, by an integral equation.
//!
//! In Hankel space (u_r, u_z, s_rz, s_zz) of an isotropic layer obey four ordinary equations over the depth. Their
//! compliance C, (u_r, u_z) = C (s_rz, s_zz), obeys a Riccati equation, which is stable from the base, where C = 0, up
//! to the face. The face's c(k) = -C_zz then stands in the dual integral equations of the punch, which Abel's transform
//! makes a Fredholm equation of the second kind on (0, a) (Sneddon, "Mixed boundary value problems in potential
//! theory", 1966; Hayes et al., J. Biomech. 5, 1972, for one layer).

use faer::Mat;
use faer::linalg::solvers::Solve;

/// A layer: thickness, mm, Young's modulus, kPa, and Poisson's ratio.
#[derive(Debug, Clone, Copy)]
pub struct Layer {
    pub thickness_mm: f64,
    pub youngs_kpa: f64,
    pub poisson: f64,
}

/// Places of Gauss' rule on the punch's radius.
const PLACES: usize = 32;
/// Panels of Gauss' rule over the wave numbers.
const PANELS: usize = 24;
/// Wave number times the touched layer's thickness from which on the layer is a half space: e^-40 is left.
const FAR: f64 = 20.0;
/// Steps of Runge and Kutta's rule over a layer, and more by its thickness times the wave number.
const STEPS: [f64; 2] = [60.0, 30.0];

/// Force per depth of a punch of radius `a`, N/mm; the touched layer is the first.
pub fn stiffness(layers: &[Layer], a: f64) -> f64 {
    let top = layers[0];
    let surface = |k: f64| compliance(layers, k) * k / half_space(top) - 1.0;
    let most = FAR / top.thickness_mm;
    let (nodes, weights) = gauss(PLACES);
    let waves: Vec<[f64; 3]> = (0..PANELS)
        .flat_map(|panel| {
            let width = most / PANELS as f64;
            nodes.iter().zip(&weights).map(move |(x, w)| [(panel as f64 + 0.5 * (1.0 + x)) * width, 0.5 * w * width])
        })
        .map(|[k, weight]| [k, weight, surface(k)])
        .collect();
    let places: Vec<f64> = nodes.iter().map(|x| 0.5 * a * (1.0 + x)).collect();
    let kernel = |s: f64, t: f64| waves.iter().map(|[k, w, g]| w * g * (k * s).cos() * (k * t).cos()).sum::<f64>();
    let pi = std::f64::consts::PI;
    let matrix = Mat::from_fn(PLACES, PLACES, |i, j| {
        f64::from(i == j) + 2.0 / pi * 0.5 * a * weights[j] * kernel(places[i], places[j])
    });
    let phi = matrix.partial_piv_lu().solve(Mat::from_fn(PLACES, 1, |_, _| 2.0 / (pi * half_space(top))));
    1e-3 * 2.0 * pi * (0..PLACES).map(|i| 0.5 * a * weights[i] * phi[(i, 0)]).sum::<f64>()
}

fn shear(layer: Layer) -> f64 {
    0.5 * layer.youngs_kpa / (1.0 + layer.poisson)
}

/// Compliance of a half space times the wave number, 1/kPa.
fn half_space(layer: Layer) -> f64 {
    (1.0 - layer.poisson) / shear(layer)
}

/// Depth per pressure of a wave number on the face, mm/kPa.
fn compliance(layers: &[Layer], k: f64) -> f64 {
    let mut c = [[0.0; 2]; 2];
    for &layer in layers.iter().rev() {
        let (mu, nu) = (shear(layer), layer.poisson);
        let share = nu / (1.0 - nu);
        // d(u, s)/dz = [[A, B], [D, E]] (u, s), z into the body.
        let a = [[0.0, k], [-k * share, 0.0]];
        let b = [[1.0 / mu, 0.0], [0.0, (1.0 - 2.0 * nu) / (2.0 * mu * (1.0 - nu))]];
        let d = [[2.0 * mu * k * k / (1.0 - nu), 0.0], [0.0, 0.0]];
        let e = [[0.0, k * share], [-k, 0.0]];
        let slope = |c: [[f64; 2]; 2]| {
            let (ac, ce, cdc) = (product(a, c), product(c, e), product(product(c, d), c));
            map(|i, j| ac[i][j] + b[i][j] - ce[i][j] - cdc[i][j])
        };
        let steps = (STEPS[0] + STEPS[1] * k * layer.thickness_mm).ceil();
        // Up, against z.
        let h = -layer.thickness_mm / steps;
        for _ in 0..steps as usize {
            let moved = |by: f64, slope: [[f64; 2]; 2]| map(|i, j| c[i][j] + by * slope[i][j]);
            let one = slope(c);
            let two = slope(moved(0.5 * h, one));
            let three = slope(moved(0.5 * h, two));
            let four = slope(moved(h, three));
            c = map(|i, j| c[i][j] + h / 6.0 * (one[i][j] + 2.0 * (two[i][j] + three[i][j]) + four[i][j]));
        }
    }
    -c[1][1]
}

fn map(entry: impl Fn(usize, usize) -> f64) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| entry(i, j)))
}

fn product(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    map(|i, j| a[i][0] * b[0][j] + a[i][1] * b[1][j])
}

/// Nodes and weights of Gauss' rule on (-1, 1), by Newton's method on Legendre's polynomial.
fn gauss(n: usize) -> (Vec<f64>, Vec<f64>) {
    let legendre = |x: f64| {
        let (mut p, mut before) = (x, 1.0);
        for k in 2..=n {
            let k = k as f64;
            (p, before) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k, p);
        }
        (p, n as f64 * (x * p - before) / (x * x - 1.0))
    };
    let rule = (0..n).map(|i| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..20 {
            let (p, slope) = legendre(x);
            x -= p / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * legendre(x).1.powi(2)))
    });
    rule.unzip()
}
