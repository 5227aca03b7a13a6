//! Homogeneous deformations of incompressible bodies, the pressure eliminated by a free face.

use super::super::{Law, OgdenTerm};
use super::{Random, diagonal, size, stress_beside_free_face};

/// Nominal stress along x at stretch l, the other faces free.
fn uniaxial(law: &Law, l: f64) -> f64 {
    stress_beside_free_face(law, &diagonal([l, l.powf(-0.5), l.powf(-0.5)]), 1)[0]
}

/// Nominal stress along x at stretch l, y held, z free.
fn plane_strain(law: &Law, l: f64) -> f64 {
    stress_beside_free_face(law, &diagonal([l, 1.0, 1.0 / l]), 2)[0]
}

#[test]
fn neo_hookean_follows_its_curves() {
    let law = Law::NeoHookean { shear_kpa: 1.0 };
    // Rounded to five digits: -1.34082, -1.15313. Then the formulas to round-off.
    assert!((uniaxial(&law, 2.0) - 1.75).abs() < 1e-13);
    assert!((uniaxial(&law, 0.7) + 1.34082).abs() < 5e-6);
    assert!((plane_strain(&law, 0.8) + 1.153125).abs() < 1e-13);
    for l in [0.3, 0.7, 0.999, 1.001, 1.5, 4.0] {
        assert!((uniaxial(&law, l) - (l - l.powi(-2))).abs() < 1e-13, "{l}");
        assert!((plane_strain(&law, l) - (l - l.powi(-3))).abs() < 1e-13 * (1.0 + l.powi(-3)), "{l}");
    }
}

#[test]
fn yeoh_follows_its_uniaxial_curve() {
    let c_kpa = [7.0, -0.4, 0.2];
    for l in [0.4f64, 0.9, 1.2, 3.0] {
        // P = 2 (l - l^-2) dW/dI1.
        let x = l * l + 2.0 / l - 3.0;
        let want = 2.0 * (l - l.powi(-2)) * (c_kpa[0] + 2.0 * c_kpa[1] * x + 3.0 * c_kpa[2] * x * x);
        assert!((uniaxial(&Law::Yeoh { c_kpa }, l) / want - 1.0).abs() < 1e-12, "{l}");
    }
}

#[test]
fn ogden_follows_its_uniaxial_curve() {
    let Law::Ogden { terms } = super::ogden() else { panic!("not Ogden's law") };
    for l in [0.4f64, 0.9, 1.2, 3.0] {
        // P = sum of mu_k (l^(a_k - 1) - l^(-a_k/2 - 1)).
        let term = |t: &OgdenTerm| t.shear_kpa * (l.powf(t.exponent - 1.0) - l.powf(-0.5 * t.exponent - 1.0));
        let want = terms.iter().map(term).sum::<f64>();
        assert!((uniaxial(&super::ogden(), l) / want - 1.0).abs() < 1e-12, "{l}");
    }
}

#[test]
fn laws_that_contain_the_neo_hookean_one_equal_it() {
    let neo_hookean = Law::NeoHookean { shear_kpa: 14.0 };
    let yeoh = Law::Yeoh { c_kpa: [7.0, 0.0, 0.0] };
    let ogden = Law::Ogden { terms: vec![OgdenTerm { shear_kpa: 14.0, exponent: 2.0 }] };
    let mut random = Random(4);
    for round in 0..400 {
        let mut stretches = random.vector().map(|s| (0.7 * s).exp());
        if round >= 200 {
            // Two stretches equal, or apart by 1e-16 ... 0.1, on both sides of where the quotient changes its form.
            stretches[1] = stretches[0] + 10f64.powi(-(round % 17));
        }
        if round >= 300 {
            stretches[2] = stretches[0] - 10f64.powi(-(round / 17) % 17 - 1);
        }
        let f = random.stretched(stretches);
        let want = neo_hookean.isochoric(&f).unwrap();
        for law in [&yeoh, &ogden] {
            let got = law.isochoric(&f).unwrap();
            // Stretches from 0.5 to 2: conditions of 16 in F^T F, squared by the division by stretches.
            assert!((got.energy - want.energy).abs() < 1e-13 * (14.0 + want.energy));
            for (got, want) in got.stress.iter().zip(&want.stress) {
                assert!((got - want).abs() < 1e-12 * 14.0, "{law:?}");
            }
            let modulus = want.tangent.iter().map(|row| size(row)).fold(0.0, f64::max);
            for (got, want) in got.tangent.iter().flatten().zip(want.tangent.iter().flatten()) {
                assert!((got - want).abs() < 1e-12 * modulus, "{law:?}");
            }
        }
    }
}

#[test]
fn exponential_law_is_the_tissue_law_for_small_uniaxial_strain() {
    // Fat, gland, invasive carcinoma, DCIS.
    for (b, m) in [(4.4, 9.2), (14.4, 19.6), (37.0, 24.0), (56.0, 24.0)] {
        let law = Law::Exponential { modulus_kpa: b, exponent: m };
        for strain in [1e-2f64, 1e-3, 1e-4, -1e-4, -1e-3, -1e-2] {
            // It stiffens either way. e = |eps| (1 - eps/3) and de/dl = 1 - 2/3 eps: the next order is -eps.
            let want = strain.signum() * b / m * (m * strain.abs()).exp_m1();
            let relative = uniaxial(&law, 1.0 + strain) / want - 1.0;
            assert!((relative + strain).abs() < m * strain * strain, "{b} {m} {strain}: {relative}");
        }
        // At finite strain P = (b/m) (exp(m e) - 1) (l - l^-2)/(3 e).
        for l in [0.6f64, 0.9, 1.3] {
            let e = ((l * l + 2.0 / l - 3.0) / 3.0).sqrt();
            let want = b / m * (m * e).exp_m1() * (l - l.powi(-2)) / (3.0 * e);
            assert!((uniaxial(&law, l) / want - 1.0).abs() < 1e-12, "{b} {m} {l}");
        }
    }
}

#[test]
fn exponential_law_of_vanishing_exponent_is_neo_hookean() {
    let f = diagonal([1.4, 0.9, 0.8]);
    let soft = Law::Exponential { modulus_kpa: 3.0, exponent: 1e-9 }.isochoric(&f).unwrap();
    let want = Law::NeoHookean { shear_kpa: 1.0 }.isochoric(&f).unwrap();
    for (got, want) in soft.stress.iter().zip(&want.stress) {
        assert!((got - want).abs() < 1e-9);
    }
}
