//! Every law against closed forms and finite differences.
#![allow(clippy::unwrap_used)]

mod closed_forms;
mod convexity;
mod derivatives;
mod parameters;
mod relaxation;

use super::algebra::{cofactor, determinant};
use super::{Law, OgdenTerm, Response, Tensor};

const IDENTITY: Tensor = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Numbers in -1 to 1 (splitmix64, Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| self.next())
    }

    /// A rotation: a random unit quaternion.
    fn rotation(&mut self) -> Tensor {
        let q: [f64; 4] = std::array::from_fn(|_| self.next());
        let norm = q.iter().map(|q| q * q).sum::<f64>().sqrt();
        let [w, x, y, z] = q.map(|q| q / norm);
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }

    /// A rotation, stretches, a rotation.
    fn stretched(&mut self, stretches: [f64; 3]) -> Tensor {
        product(&product(&self.rotation(), &diagonal(stretches)), &self.rotation())
    }
}

fn diagonal([a, b, c]: [f64; 3]) -> Tensor {
    [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]]
}

fn product(a: &Tensor, b: &Tensor) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn size(entries: &[f64]) -> f64 {
    entries.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()))
}

/// Two terms of either sign, as fitted to rubber, at the size of a soft silicone.
fn ogden() -> Law {
    let term = |shear_kpa, exponent| OgdenTerm { shear_kpa, exponent };
    Law::Ogden { terms: vec![term(20.0, 1.3), term(0.3, 5.0), term(-1.0, -2.0)] }
}

/// Invasive carcinoma in physics.md.
const CARCINOMA: Law = Law::Exponential { modulus_kpa: 37.0, exponent: 24.0 };

/// One of each, those of finite strain.
fn finite_laws() -> Vec<Law> {
    vec![
        Law::NeoHookean { shear_kpa: 14.0 },
        Law::Yeoh { c_kpa: [7.0, -0.4, 0.2] },
        ogden(),
        Law::Exponential { modulus_kpa: 4.4, exponent: 9.2 },
        CARCINOMA,
    ]
}

/// The stress with the pressure that an incompressible body has when its face normal to `free` bears no load.
fn stress_beside_free_face(law: &Law, f: &Tensor, free: usize) -> [f64; 9] {
    let response = law.isochoric(f).unwrap();
    let inverse = cofactor(f).map(|row| row.map(|entry| entry / determinant(f)));
    let pressure = response.stress[4 * free] / inverse[free][free];
    std::array::from_fn(|r| response.stress[r] - pressure * inverse[r / 3][r % 3])
}

/// The largest differences of stress and tangent from finite differences of energy and stress, relative to the tangent;
/// stress differences are taken as strains, by the step. Differences of fourth order: (8 (W(h) - W(-h)) - (W(2h) -
/// W(-2h)))/(12 h).
fn derivative_errors(respond: &dyn Fn(&Tensor) -> Option<Response>, f: &Tensor, step: f64) -> [f64; 2] {
    let at = respond(f).unwrap();
    let modulus = at.tangent.iter().map(|row| size(row)).fold(0.0, f64::max);
    let (mut stress_error, mut tangent_error) = (0.0f64, 0.0f64);
    for c in 0..9 {
        let moved = |steps: f64| {
            let mut f = *f;
            f[c / 3][c % 3] += steps * step;
            respond(&f).unwrap()
        };
        let (m2, m1, p1, p2) = (moved(-2.0), moved(-1.0), moved(1.0), moved(2.0));
        let slope = |of: &dyn Fn(&Response) -> f64| (8.0 * (of(&p1) - of(&m1)) - (of(&p2) - of(&m2))) / (12.0 * step);
        let scale = size(&at.stress).max(modulus * step);
        stress_error = stress_error.max((slope(&|r| r.energy) - at.stress[c]).abs() / scale);
        for r in 0..9 {
            tangent_error = tangent_error.max((slope(&|x| x.stress[r]) - at.tangent[r][c]).abs() / modulus);
        }
    }
    [stress_error, tangent_error]
}
