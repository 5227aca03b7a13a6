//! Moduli and the parameters that are refused.

use super::super::{Law, Material, MaterialError, OgdenTerm, Prony, shear_from_youngs};

#[test]
fn moduli_follow_youngs_modulus_and_poissons_ratio() {
    assert_eq!(shear_from_youngs(3.0, 0.5), 1.0);
    let half = Material::neo_hookean(60.0, 0.5).unwrap();
    assert!(half.bulk_kpa() == f64::INFINITY && half.law == Law::NeoHookean { shear_kpa: 20.0 });
    // kappa = E/(3 (1 - 2 nu)); constrained modulus kappa + 4/3 mu = 1667.11 E at nu = 0.4999 (physics.md).
    let nearly = Material::linear(60.0, 0.4999).unwrap();
    assert!((nearly.bulk_kpa() / (60.0 / (3.0 * 0.0002)) - 1.0).abs() < 1e-9);
    assert!(((nearly.bulk_kpa() + 4.0 / 3.0 * nearly.law.shear_kpa()) / 60.0 - 1667.11).abs() < 0.005);
    assert!((nearly.youngs_kpa() - 60.0).abs() < 1e-12);
    let cork = Material::linear(60.0, 0.0).unwrap();
    assert!((cork.bulk_kpa() - 20.0).abs() < 1e-12 && (cork.law.shear_kpa() - 30.0).abs() < 1e-12);
    assert!((super::ogden().shear_kpa() - 0.5 * (26.0 + 1.5 + 2.0)).abs() < 1e-12);
}

#[test]
fn law_that_makes_no_sense_is_refused() {
    let one = |shear_kpa, exponent| Law::Ogden { terms: vec![OgdenTerm { shear_kpa, exponent }] };
    for law in [
        Law::Linear { shear_kpa: 0.0 },
        Law::NeoHookean { shear_kpa: -1.0 },
        Law::NeoHookean { shear_kpa: f64::NAN },
        Law::NeoHookean { shear_kpa: f64::INFINITY },
        Law::Exponential { modulus_kpa: 0.0, exponent: 9.0 },
        Law::Exponential { modulus_kpa: 4.0, exponent: 0.0 },
        Law::Yeoh { c_kpa: [0.0, 1.0, 1.0] },
        Law::Yeoh { c_kpa: [7.0, -4.0, 0.0] },
        Law::Yeoh { c_kpa: [7.0, 0.0, -0.1] },
        Law::Yeoh { c_kpa: [1.0, -1.5, 1.0] },
        Law::Ogden { terms: vec![] },
        one(1.0, -2.0),
        one(1.0, 0.0),
        one(f64::NAN, 2.0),
    ] {
        assert!(law.check().is_err(), "{law:?}");
        assert!(Material::elastic(law, 0.4).is_err());
    }
    for law in super::finite_laws() {
        law.check().unwrap();
    }
    assert!(one(-1.0, -2.0).check().is_ok());
}

#[test]
fn poissons_ratio_outside_its_range_is_refused() {
    for poisson in [-0.01, 0.500001, f64::NAN] {
        assert!(matches!(Material::linear(60.0, poisson), Err(MaterialError::Poisson { .. })), "{poisson}");
    }
}

#[test]
fn relaxation_that_makes_no_sense_is_refused() {
    let material = || Material::neo_hookean(60.0, 0.49).unwrap();
    let with = |terms: &[(f64, f64)]| {
        material().with_relaxation(terms.iter().map(|&(share, time_s)| Prony { share, time_s }).collect())
    };
    assert!(matches!(with(&[(0.1, 1.0), (1.0, 1.0)]), Err(MaterialError::Share { number: 2, .. })));
    assert!(matches!(with(&[(-0.1, 1.0)]), Err(MaterialError::Share { number: 1, .. })));
    assert!(matches!(with(&[(0.5, 1.0), (0.5, 10.0)]), Err(MaterialError::ShareSum { sum: 1.0 })));
    assert!(matches!(with(&[(0.5, 0.0)]), Err(MaterialError::Time { number: 1, .. })));
    assert!(with(&[(0.5, f64::INFINITY)]).is_err());
    let relaxing = with(&[(0.2, 1.0), (0.3, 10.0)]).unwrap();
    assert!((relaxing.relaxed_shear_kpa() / relaxing.law.shear_kpa() - 0.5).abs() < 1e-15);
}

#[test]
fn errors_name_the_numbers() {
    let error = Law::Yeoh { c_kpa: [7.0, -4.0, 0.0] }.check().unwrap_err().to_string();
    assert!(error.contains("7 -4 0 kPa"), "{error}");
    let error = Material::linear(60.0, 0.6).unwrap_err().to_string();
    assert!(error.contains("0.6"), "{error}");
}
