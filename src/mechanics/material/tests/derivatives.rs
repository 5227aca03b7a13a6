//! Stress is the derivative of energy, tangent that of stress; nothing depends on the observer.

use super::super::{Law, Response, Tensor};
use super::{CARCINOMA, Random, derivative_errors, finite_laws, ogden, product, size};

/// Deformations and the step of differences for each: about a hundredth of the distance to where a law is not smooth
/// (the unstrained state, for the exponential one), or of the stretch.
fn deformations() -> Vec<(Tensor, f64)> {
    let mut random = Random(1);
    let mut all = Vec::new();
    let nearby = [1e-2, 1e-3, 1e-5, 1e-7];
    for _ in 0..20 {
        for strain in [1e-3, 1e-2, 0.1] {
            let stretches = random.vector().map(|s| 1.0 + strain * s);
            all.push((random.stretched(stretches), 5e-3 * strain));
        }
        let stretches = random.vector().map(|s| (0.8 * s).exp());
        all.push((random.stretched(stretches), 1e-3 * stretches.iter().copied().fold(1.0, f64::min)));
        for apart in nearby {
            let s = (0.5 * random.next()).exp();
            all.push((random.stretched([s, s + apart, 1.7 * s]), 3e-4));
            all.push((random.stretched([s, s, 0.6 * s]), 3e-4));
        }
    }
    all
}

/// The largest errors of a law over all deformations.
fn worst(respond: &dyn Fn(&Tensor) -> Option<Response>) -> [f64; 2] {
    deformations().iter().fold([0.0, 0.0], |[stress, tangent], (f, step)| {
        let [s, t] = derivative_errors(respond, f, *step);
        [stress.max(s), tangent.max(t)]
    })
}

/// Fourth-order differences at a hundredth of the scale of change: (1e-2)^4 times derivatives of a few units; round-off
/// 1e-16 over the smallest relative step 5e-6, for the energy divided by the strain once more.
const TOLERANCE: f64 = 2e-7;

#[test]
fn stress_is_the_derivative_of_energy_and_tangent_that_of_stress() {
    for law in finite_laws() {
        let [stress, tangent] = worst(&|f| law.isochoric(f));
        println!("{law:?}: stress {stress:.1e}, tangent {tangent:.1e}");
        assert!(stress < TOLERANCE && tangent < TOLERANCE, "{law:?}: {stress:e} {tangent:e}");
    }
    let law = Law::Linear { shear_kpa: 14.0 };
    let [stress, tangent] = worst(&|f| law.isochoric(f));
    assert!(stress < TOLERANCE && tangent < TOLERANCE, "{stress:e} {tangent:e}");
}

#[test]
fn a_wrong_sign_or_a_missing_term_turns_the_differences_red() {
    let law = ogden();
    let wrong_stress = worst(&|f| {
        let mut response = law.isochoric(f)?;
        response.stress[1] = -response.stress[1];
        Some(response)
    });
    assert!(wrong_stress[0] > 0.1 && wrong_stress[1] > 0.1, "{wrong_stress:?}");
    // A thousandth more of the term that comes from J^(-2/3): symmetric, and right where there is no stress.
    let law = Law::NeoHookean { shear_kpa: 14.0 };
    let [stress, tangent] = worst(&|f| {
        let mut response = law.isochoric(f)?;
        let inverse = super::cofactor(f).map(|row| row.map(|entry| entry / super::determinant(f)));
        for (r, row) in response.tangent.iter_mut().enumerate() {
            for (c, entry) in row.iter_mut().enumerate() {
                *entry +=
                    1e-3 * (response.stress[r] * inverse[c / 3][c % 3] + inverse[r / 3][r % 3] * response.stress[c]);
            }
        }
        Some(response)
    });
    assert!(stress < TOLERANCE && tangent > 1e-4, "{stress:e} {tangent:e}");
}

#[test]
fn tangent_is_symmetric() {
    for law in finite_laws() {
        for (f, _) in deformations() {
            let tangent = law.isochoric(&f).unwrap().tangent;
            let modulus = tangent.iter().map(|row| size(row)).fold(0.0, f64::max);
            for (r, row) in tangent.iter().enumerate() {
                for (entry, column) in row.iter().zip(&tangent) {
                    // Sums of ten terms of the size of the modulus.
                    assert!((entry - column[r]).abs() < 1e-14 * modulus, "{law:?} {f:?}");
                }
            }
        }
    }
}

#[test]
fn rotation_leaves_energy_alone_and_turns_the_stress() {
    let mut random = Random(2);
    for law in finite_laws() {
        for _ in 0..50 {
            let stretches = random.vector().map(|s| (0.5 * s).exp());
            let f = random.stretched(stretches);
            let q = random.rotation();
            let (before, after) = (law.isochoric(&f).unwrap(), law.isochoric(&product(&q, &f)).unwrap());
            // Round-off of F, magnified by the exponent and by stretches down to 0.6.
            assert!((after.energy / before.energy - 1.0).abs() < 1e-12, "{law:?}");
            let p: Tensor = std::array::from_fn(|i| std::array::from_fn(|j| before.stress[3 * i + j]));
            let turned = product(&q, &p);
            for (r, entry) in after.stress.iter().enumerate() {
                assert!((entry - turned[r / 3][r % 3]).abs() < 1e-12 * size(&before.stress), "{law:?}");
            }
        }
    }
}

#[test]
fn kirchhoff_stress_is_a_deviator() {
    for law in finite_laws() {
        for (f, _) in deformations() {
            let p = law.isochoric(&f).unwrap().stress;
            let terms: Vec<f64> = (0..9).map(|r| p[r] * f[r / 3][r % 3]).collect();
            // The stress has an error of round-off of the moduli: 1e-15 of 37 kPa and below.
            assert!(terms.iter().sum::<f64>().abs() < 1e-13 * (1.0 + size(&terms)), "{law:?}");
        }
    }
}

#[test]
fn rigid_rotation_gives_no_stress() {
    let mut random = Random(3);
    for law in finite_laws() {
        for _ in 0..100 {
            let response = law.isochoric(&random.rotation()).unwrap();
            assert!(size(&response.stress) < 1e-12 && response.energy.abs() < 1e-12, "{law:?} {response:?}");
        }
    }
}

#[test]
fn every_law_starts_as_hookes() {
    for law in finite_laws() {
        let (got, hooke) = (
            law.isochoric(&super::IDENTITY).unwrap(),
            Law::Linear { shear_kpa: law.shear_kpa() }.isochoric(&super::IDENTITY).unwrap(),
        );
        assert_eq!(got.energy, 0.0);
        assert!(size(&got.stress) == 0.0);
        for (got, hooke) in got.tangent.iter().flatten().zip(hooke.tangent.iter().flatten()) {
            assert!((got - hooke).abs() < 1e-14 * law.shear_kpa(), "{law:?}: {got} {hooke}");
        }
    }
}

#[test]
fn small_strains_keep_their_digits() {
    // Strain 1e-9: the relative error of the energy is that of the law's next order, 1e-9 m, and the round-off
    // 1e-16/1e-9 of F itself. I1 - 3 as it stands would give noise.
    let f = [[1.0, 1e-9, 0.0], [1e-9, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for law in [Law::NeoHookean { shear_kpa: 14.0 }, CARCINOMA, ogden()] {
        let got = law.isochoric(&f).unwrap();
        let hooke = Law::Linear { shear_kpa: law.shear_kpa() }.isochoric(&f).unwrap();
        assert!((got.stress[1] / hooke.stress[1] - 1.0).abs() < 3e-7, "{law:?}");
        assert!((got.energy / hooke.energy - 1.0).abs() < 3e-7, "{law:?} {} {}", got.energy, hooke.energy);
    }
}

#[test]
fn inverted_or_overflowing_deformations_have_no_response() {
    let mirror = super::diagonal([-1.0, 1.0, 1.0]);
    let flat = super::diagonal([0.0, 1.0, 1.0]);
    let undefined = super::diagonal([f64::NAN, 1.0, 1.0]);
    let infinite = super::diagonal([f64::INFINITY, 1.0, 1.0]);
    for law in finite_laws() {
        for f in [&mirror, &flat, &undefined, &infinite] {
            assert_eq!(law.isochoric(f), None, "{law:?}");
        }
    }
    // exp(24 e) overflows at e = 29.6, I1 about 2600.
    assert_eq!(CARCINOMA.isochoric(&super::diagonal([60.0, 1.0, 1.0 / 60.0])), None);
    let linear = Law::Linear { shear_kpa: 1.0 };
    assert!(linear.isochoric(&mirror).is_some() && linear.isochoric(&undefined).is_none());
}
