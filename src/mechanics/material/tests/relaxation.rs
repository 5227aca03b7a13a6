//! Relaxation against the Prony series and its convolution.

use super::super::{History, Law, Material, Prony, Tensor};
use super::{Random, derivative_errors, diagonal, finite_laws, product, size};

const TERMS: [Prony; 2] = [Prony { share: 0.25, time_s: 0.8 }, Prony { share: 0.4, time_s: 30.0 }];

fn relaxing(law: Law) -> Material {
    Material { law, poisson: 0.5, relaxation: TERMS.to_vec() }
}

/// 1 - sum of g + sum of g exp(-t/tau).
fn series(t: f64) -> f64 {
    1.0 - TERMS.iter().map(|term| term.share * -(-t / term.time_s).exp_m1()).sum::<f64>()
}

fn all_laws() -> Vec<Law> {
    let mut laws = finite_laws();
    laws.push(Law::Linear { shear_kpa: 14.0 });
    laws
}

const HELD: Tensor = [[1.2, 0.3, 0.0], [-0.1, 0.8, 0.2], [0.1, 0.0, 1.1]];

#[test]
fn held_strain_relaxes_by_the_prony_series() {
    for law in all_laws() {
        let material = relaxing(law);
        let elastic = material.isochoric(&HELD, None).unwrap();
        let mut history = History::rest(&material).advance(&material, &HELD, 0.0).unwrap();
        let mut t = 0.0;
        for dt in [0.0, 0.01, 0.3, 0.3, 2.0, 11.0, 100.0, 0.5] {
            t += dt;
            let now = material.isochoric(&HELD, Some((&history, dt))).unwrap();
            for (now, elastic) in now.stress.iter().zip(&elastic.stress) {
                assert!((now - series(t) * elastic).abs() < 1e-12 * size(&elastic_sizes(&material)), "{material:?}");
            }
            history = history.advance(&material, &HELD, dt).unwrap();
        }
    }
}

fn elastic_sizes(material: &Material) -> [f64; 9] {
    material.isochoric(&HELD, None).unwrap().stress
}

#[test]
fn instantaneous_and_long_term_responses_are_the_given_and_the_remaining_modulus() {
    for law in all_laws() {
        let material = relaxing(law);
        let elastic = material.isochoric(&HELD, None).unwrap();
        let rest = History::rest(&material);
        for (dt, share) in [(0.0, 1.0), (f64::INFINITY, 0.35)] {
            let now = material.isochoric(&HELD, Some((&rest, dt))).unwrap();
            for (now, elastic) in now.tangent.iter().flatten().zip(elastic.tangent.iter().flatten()) {
                assert!((now - share * elastic).abs() <= 1e-15 * elastic.abs(), "{material:?}");
            }
            assert!((now.energy / (share * elastic.energy) - 1.0).abs() < 1e-14);
        }
    }
}

/// Shear stress at the end of a ramp of simple shear to 0.5 in `time_s`, in `steps` steps.
fn ramp(material: &Material, time_s: f64, steps: usize) -> f64 {
    let dt = time_s / steps as f64;
    let mut history = History::rest(material);
    for step in 1..=steps {
        let f = [[1.0, 0.5 * step as f64 / steps as f64, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        if step == steps {
            return material.isochoric(&f, Some((&history, dt))).unwrap().stress[1];
        }
        history = history.advance(material, &f, dt).unwrap();
    }
    0.0
}

#[test]
fn ramp_is_the_closed_form_convolution_however_it_is_stepped() {
    let material = relaxing(Law::Linear { shear_kpa: 14.0 });
    for time_s in [1e-6, 0.1, 1.0, 20.0, 1e6] {
        // Stress rate times (1 - sum of g) T + sum of g tau (1 - exp(-T/tau)).
        let kept = 1.0 - TERMS.iter().map(|term| term.share).sum::<f64>();
        let fading = |term: &Prony| term.share * term.time_s * -(-time_s / term.time_s).exp_m1() / time_s;
        let want = 14.0 * 0.5 * (kept + TERMS.iter().map(fading).sum::<f64>());
        for steps in [1, 3, 100] {
            let got = ramp(&material, time_s, steps);
            assert!((got / want - 1.0).abs() < 1e-12, "{time_s} {steps}: {got} {want}");
        }
    }
    // Fast and slow: the instantaneous and the long-term modulus.
    assert!((ramp(&material, 1e-9, 5) / 7.0 - 1.0).abs() < 1e-8);
    assert!((ramp(&material, 1e9, 5) / (7.0 * 0.35) - 1.0).abs() < 1e-6);
}

#[test]
fn ramp_of_a_nonlinear_law_converges_with_the_square_of_the_step() {
    let material = relaxing(Law::Exponential { modulus_kpa: 4.4, exponent: 9.2 });
    let fine = ramp(&material, 1.0, 4096);
    let error = |steps| (ramp(&material, 1.0, steps) - fine).abs();
    let rate = (error(16) / error(32)).log2();
    // Second order; 0.1 for the next order at these steps.
    assert!((rate - 2.0).abs() < 0.1, "{rate}");
}

/// A history with stresses in all directions.
fn past(material: &Material) -> History {
    let rest = History::rest(material);
    let first = rest.advance(material, &HELD, 0.5).unwrap();
    first.advance(material, &diagonal([0.9, 1.05, 1.1]), 3.0).unwrap()
}

#[test]
fn relaxed_stress_and_tangent_are_derivatives_of_the_incremental_potential() {
    let mut random = Random(7);
    for law in all_laws() {
        let material = relaxing(law);
        let history = past(&material);
        for dt in [0.0, 0.7, 40.0] {
            for _ in 0..10 {
                let stretches = random.vector().map(|s| (0.4 * s).exp());
                let f = random.stretched(stretches);
                let [stress, tangent] = derivative_errors(&|f| material.isochoric(f, Some((&history, dt))), &f, 3e-4);
                // As for the elastic laws.
                assert!(stress < 2e-7 && tangent < 2e-7, "{material:?} {dt}: {stress:e} {tangent:e}");
            }
        }
    }
}

#[test]
fn missing_geometric_tangent_of_the_history_turns_the_differences_red() {
    let material = relaxing(Law::NeoHookean { shear_kpa: 14.0 });
    let history = past(&material);
    let faulty = |f: &Tensor| {
        let mut response = material.isochoric(f, Some((&history, 0.7)))?;
        // A tangent of the elastic part alone: the factor from that of a history at rest.
        response.tangent = material.isochoric(f, Some((&History::rest(&material), 0.7)))?.tangent;
        Some(response)
    };
    let [stress, tangent] = derivative_errors(&faulty, &diagonal([1.1, 0.9, 1.0]), 3e-4);
    assert!(stress < 2e-7 && tangent > 1e-3, "{stress:e} {tangent:e}");
}

#[test]
fn rotation_turns_the_relaxed_stress() {
    let material = relaxing(Law::NeoHookean { shear_kpa: 14.0 });
    let history = past(&material);
    let q = Random(8).rotation();
    let before = material.isochoric(&HELD, Some((&history, 0.7))).unwrap();
    let after = material.isochoric(&product(&q, &HELD), Some((&history, 0.7))).unwrap();
    let p: Tensor = std::array::from_fn(|i| std::array::from_fn(|j| before.stress[3 * i + j]));
    let turned = product(&q, &p);
    for (r, entry) in after.stress.iter().enumerate() {
        assert!((entry - turned[r / 3][r % 3]).abs() < 1e-12 * size(&before.stress));
    }
    // The history does not change either.
    let advanced = |f: &Tensor| history.advance(&material, f, 0.7).unwrap();
    let (straight, rotated) = (advanced(&HELD), advanced(&product(&q, &HELD)));
    for (a, b) in straight.terms.iter().flatten().zip(rotated.terms.iter().flatten()) {
        assert!((a - b).abs() < 1e-12);
    }
}

#[test]
fn elastic_material_has_no_history_and_time_does_not_run_back() {
    let elastic = Material::neo_hookean(60.0, 0.5).unwrap();
    let history = History::rest(&elastic).advance(&elastic, &HELD, 1.0).unwrap();
    assert_eq!(history, History::default());
    assert_eq!(elastic.isochoric(&HELD, Some((&history, 1.0))), elastic.isochoric(&HELD, None));
    let material = relaxing(Law::NeoHookean { shear_kpa: 14.0 });
    let rest = History::rest(&material);
    assert_eq!(material.isochoric(&HELD, Some((&rest, -1.0))), None);
    assert_eq!(rest.advance(&material, &HELD, f64::NAN), None);
}
