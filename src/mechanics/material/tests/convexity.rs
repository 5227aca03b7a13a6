//! Ellipticity: the energy is convex along lines F + t a b, the condition that no shear band forms.

use super::super::{Law, Tensor};
use super::{CARCINOMA, Random, cofactor, size};

/// The least of (a b) : tangent : (a b) over random deformations and directions, relative to the largest tangent entry;
/// at fixed volume only, where b F^(-1) a = 0, or in all directions.
fn least_curvature(law: &Law, fixed_volume: bool) -> f64 {
    let mut random = Random(5);
    let mut least = f64::INFINITY;
    for _ in 0..3000 {
        let strain = 0.6 * random.next().abs();
        let stretches = random.vector().map(|s| (strain * s).exp());
        let f = random.stretched(stretches);
        let (a, mut b) = (random.vector(), random.vector());
        if fixed_volume {
            // J changes by cof F : (a b): take the component along v = (cof F)^T a out of b.
            let cofactor = cofactor(&f);
            let v: [f64; 3] = std::array::from_fn(|j| (0..3).map(|i| cofactor[i][j] * a[i]).sum());
            let share = dot(&v, &b) / dot(&v, &v);
            b = std::array::from_fn(|j| b[j] - share * v[j]);
        }
        let tangent = law.isochoric(&f).unwrap().tangent;
        let direction: [f64; 9] = std::array::from_fn(|r| a[r / 3] * b[r % 3]);
        let curvature =
            (0..9).map(|r| direction[r] * (0..9).map(|c| tangent[r][c] * direction[c]).sum::<f64>()).sum::<f64>();
        let modulus = tangent.iter().map(|row| size(row)).fold(0.0, f64::max);
        least = least.min(curvature / (modulus * dot(&a, &a) * dot(&b, &b)));
    }
    least
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[test]
fn polyconvex_laws_are_convex_along_every_rank_one_line() {
    for law in [Law::NeoHookean { shear_kpa: 14.0 }, Law::Yeoh { c_kpa: [7.0, 0.4, 0.2] }, CARCINOMA] {
        let least = least_curvature(&law, false);
        assert!(least > -1e-14, "{law:?}: {least:e}");
    }
}

#[test]
fn every_law_is_elliptic_at_fixed_volume() {
    for law in super::finite_laws() {
        let least = least_curvature(&law, true);
        assert!(least > 0.0, "{law:?}: {least:e}");
    }
}

#[test]
fn a_law_that_softens_is_found_out() {
    let softening = Law::Yeoh { c_kpa: [7.0, -4.0, 0.0] };
    assert!(softening.check().is_err());
    assert!(least_curvature(&softening, true) < -1e-3);
}

#[test]
fn exponential_energy_lies_below_its_chords() {
    // The energy itself, not the tangent, along lines of fixed volume from large deformations.
    let mut random = Random(6);
    for _ in 0..500 {
        let stretches = random.vector().map(|s| (0.5 * s).exp());
        let f = random.stretched(stretches);
        let a = random.vector();
        let cofactor = cofactor(&f);
        let v: [f64; 3] = std::array::from_fn(|j| (0..3).map(|i| cofactor[i][j] * a[i]).sum());
        let w = random.vector();
        let b = [v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]];
        let energy = |t: f64| {
            let f: Tensor = std::array::from_fn(|i| std::array::from_fn(|j| f[i][j] + t * a[i] * b[j]));
            CARCINOMA.isochoric(&f).unwrap().energy
        };
        let (start, middle, end) = (energy(-0.3), energy(0.0), energy(0.3));
        assert!(middle <= 0.5 * (start + end) * (1.0 + 1e-14));
    }
}
