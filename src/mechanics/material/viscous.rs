//! Quasi-static linear relaxation of the isochoric stress.
//!
//! Simo, Comput. Methods Appl. Mech. Eng. 60 (1987); Holzapfel, Nonlinear Solid Mechanics (2000), section 6.10. The
//! second Piola-Kirchhoff stress is S = (1 - sum g_i) S_iso + sum H_i with H_i' + H_i/tau_i = g_i S_iso'. A step dt is
//! H_i <- exp(-dt/tau_i) H_i + g_i a_i (S_iso - S_iso before), a_i = (1 - exp(-dt/tau_i)) tau_i/dt, which is exact for
//! a stress that changes linearly within the step. (Holzapfel takes exp(-dt/(2 tau_i)) for a_i, of the same order.)
//!
//! So S = factor S_iso(F) + frozen, where the factor and the frozen stress do not depend on F. This is the derivative
//! of factor W_iso + frozen : (F^T F - 1)/2: the step has a potential.
//!
//! The frozen stress is a deviator in the configuration where it arose, and only nearly one in the present one. Its
//! spherical part there adds to the pressure of the element; the total stress is what counts.

use super::algebra::{cofactor, determinant, twice_green_strain};
use super::{Material, Response, Tensor};
use serde::{Deserialize, Serialize};

/// A term of the relaxation: g (1 - exp(-t/tau)) of the instantaneous stress is gone after t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prony {
    /// g, 0 to below 1: share of the instantaneous modulus.
    pub share: f64,
    /// tau, s.
    pub time_s: f64,
}

/// What a point of a material remembers: stresses at the end of the last step, kPa, as xx, yy, zz, yz, zx, xy.
///
/// Elastic materials remember nothing.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct History {
    /// Elastic isochoric second Piola-Kirchhoff stress.
    elastic: [f64; 6],
    /// H_i, one for each Prony term.
    pub(super) terms: Vec<[f64; 6]>,
}

/// Entries of a symmetric tensor in the order of [`History`].
const SYMMETRIC: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)];

impl Prony {
    /// exp(-dt/tau) and a = (1 - exp(-dt/tau)) tau/dt, 1 at dt = 0 and 0 at infinity.
    fn step(&self, dt_s: f64) -> (f64, f64) {
        let x = dt_s / self.time_s;
        ((-x).exp(), if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 })
    }
}

impl Material {
    /// Isochoric response, as [`super::Law::isochoric`], at the end of a step of `dt_s` seconds after `history`.
    ///
    /// Without a history the response is the instantaneous, elastic one. With one, the stress is the relaxed one, the
    /// tangent its derivative, and the energy the incremental potential whose derivative it is (not the stored energy;
    /// only its changes within the step mean something). A step of 0 s is instantaneous, an infinite one relaxes fully.
    /// `None` also for a negative step.
    #[inline]
    pub fn isochoric(&self, f: &Tensor, history: Option<(&History, f64)>) -> Option<Response> {
        let elastic = self.law.isochoric(f)?;
        let Some((history, dt_s)) = history.filter(|_| !self.relaxation.is_empty()) else {
            return Some(elastic);
        };
        if dt_s < 0.0 || dt_s.is_nan() {
            return None;
        }
        let (factor, frozen) = history.frozen(&self.relaxation, dt_s);
        let response = if self.law.is_small_strain() {
            relaxed_linear(f, &elastic, factor, &frozen)
        } else {
            relaxed(f, &elastic, factor, &frozen)
        };
        response.is_finite().then_some(response)
    }

    /// The elastic isochoric second Piola-Kirchhoff stress F^(-1) P (at small strain: the stress).
    fn elastic_stress(&self, f: &Tensor) -> Option<[f64; 6]> {
        let p = self.law.isochoric(f)?.stress;
        if self.law.is_small_strain() {
            return Some(SYMMETRIC.map(|(i, j)| p[3 * i + j]));
        }
        let (cofactor, det) = (cofactor(f), determinant(f));
        Some(SYMMETRIC.map(|(i, j)| (0..3).map(|k| cofactor[k][i] * p[3 * k + j]).sum::<f64>() / det))
    }
}

impl History {
    /// The history of a point that was never deformed.
    pub fn rest(material: &Material) -> Self {
        Self { elastic: [0.0; 6], terms: vec![[0.0; 6]; material.relaxation.len()] }
    }

    /// The history after a further step of `dt_s` seconds that ends at `f`; `None` where [`Material::isochoric`] is.
    pub fn advance(&self, material: &Material, f: &Tensor, dt_s: f64) -> Option<Self> {
        if material.relaxation.is_empty() {
            return Some(Self::default());
        }
        if dt_s < 0.0 || dt_s.is_nan() {
            return None;
        }
        let elastic = material.elastic_stress(f)?;
        let terms = self.terms.iter().zip(&material.relaxation);
        let terms = terms.map(|(h, prony)| {
            let (decay, a) = prony.step(dt_s);
            std::array::from_fn(|c| decay * h[c] + prony.share * a * (elastic[c] - self.elastic[c]))
        });
        Some(Self { elastic, terms: terms.collect() })
    }

    /// S = factor S_iso + frozen after a step.
    fn frozen(&self, relaxation: &[Prony], dt_s: f64) -> (f64, Tensor) {
        assert_eq!(self.terms.len(), relaxation.len(), "a history of another material");
        let mut factor = 1.0;
        let mut frozen = [0.0; 6];
        for (h, prony) in self.terms.iter().zip(relaxation) {
            let (decay, a) = prony.step(dt_s);
            factor -= prony.share * (1.0 - a);
            for c in 0..6 {
                frozen[c] += decay * h[c] - prony.share * a * self.elastic[c];
            }
        }
        let mut tensor = [[0.0; 3]; 3];
        for ((i, j), entry) in SYMMETRIC.into_iter().zip(frozen) {
            tensor[i][j] = entry;
            tensor[j][i] = entry;
        }
        (factor, tensor)
    }
}

/// P = factor P_iso + F S, with the geometric tangent d_ik S_JL of the frozen stress S.
fn relaxed(f: &Tensor, elastic: &Response, factor: f64, frozen: &Tensor) -> Response {
    let mut response = scaled(elastic, factor);
    response.energy += 0.5 * contract(frozen, &twice_green_strain(f));
    for (i, row) in f.iter().enumerate() {
        for (j, column) in frozen.iter().enumerate() {
            response.stress[3 * i + j] += row[0] * column[0] + row[1] * column[1] + row[2] * column[2];
            for (l, entry) in column.iter().enumerate() {
                response.tangent[3 * i + j][3 * i + l] += entry;
            }
        }
    }
    response
}

/// The same at small strain, where the stress measures are one.
fn relaxed_linear(f: &Tensor, elastic: &Response, factor: f64, frozen: &Tensor) -> Response {
    let mut response = scaled(elastic, factor);
    response.energy += contract(frozen, f) - (frozen[0][0] + frozen[1][1] + frozen[2][2]);
    for (r, stress) in response.stress.iter_mut().enumerate() {
        *stress += frozen[r / 3][r % 3];
    }
    response
}

fn scaled(response: &Response, factor: f64) -> Response {
    Response {
        energy: factor * response.energy,
        stress: response.stress.map(|entry| factor * entry),
        tangent: response.tangent.map(|row| row.map(|entry| factor * entry)),
    }
}

/// a : b.
fn contract(a: &Tensor, b: &Tensor) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a * b).sum()
}
