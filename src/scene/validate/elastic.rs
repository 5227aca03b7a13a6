//! Rules of elastic laws: stable materials, and a stack whose rigid layers lie below all others.

use super::bounds::{ANY, POSITIVE, number};
use super::{Invalid, all};
use crate::scene::{Elastic, Layer, OgdenTerm, Relaxation};

/// Terms of Ogden's law, and of a relaxation. Fits have up to six; more only cost time.
const MAX_TERMS: usize = 16;

/// The parameters make a stable material.
pub(super) fn check(key: &str, elastic: &Elastic) -> Result<(), Invalid> {
    let positive = |name: &str, value: f64, example: f64| number(&format!("{key}.{name}"), value, POSITIVE, example);
    let law = match elastic {
        Elastic::Linear { youngs_kpa, .. } | Elastic::NeoHookean { youngs_kpa, .. } => {
            positive("youngs_kpa", *youngs_kpa, 5.0)
        }
        Elastic::Yeoh { c_kpa, .. } => yeoh(&format!("{key}.c_kpa"), *c_kpa),
        Elastic::Ogden { terms, .. } => ogden(&format!("{key}.terms"), terms),
        Elastic::Exponential { modulus_kpa, exponent, .. } => {
            all([positive("modulus_kpa", *modulus_kpa, 4.4), positive("exponent", *exponent, 9.2)])
        }
    };
    all([
        law,
        number(&format!("{key}.poisson"), elastic.poisson(), 0.0..=0.5, 0.4999),
        relaxation(&format!("{key}.relaxation"), elastic.relaxation()),
    ])
}

/// In simple shear s the stress rises always when c1 + 6 c2 x + 15 c3 x^2 > 0 for all x = s^2 >= 0.
fn yeoh(key: &str, c_kpa: [f64; 3]) -> Result<(), Invalid> {
    let [c1, c2, c3] = c_kpa;
    all([
        number(&format!("{key}[0]"), c1, POSITIVE, 0.8),
        number(&format!("{key}[1]"), c2, ANY, 0.0),
        number(&format!("{key}[2]"), c3, 0.0.., 0.0),
    ])?;
    if c2 < 0.0 && 3.0 * c2 * c2 >= 5.0 * c1 * c3 {
        let least = -(5.0 * c1 * c3 / 3.0).sqrt();
        let message = format!(
            "must be above {least} beside c1 = {c1} and c3 = {c3}, or the stress falls as the shear grows, is {c2}; \
             for example 0.0"
        );
        return Err(Invalid::new(format!("{key}[1]"), message));
    }
    Ok(())
}

fn ogden(key: &str, terms: &[OgdenTerm]) -> Result<(), Invalid> {
    if terms.is_empty() || terms.len() > MAX_TERMS {
        let message = format!(
            "must have from 1 to {MAX_TERMS} terms, has {}; for example [{{ shear_kpa = 1.7, exponent = 2.0 }}]",
            terms.len()
        );
        return Err(Invalid::new(key, message));
    }
    let one = |(index, term): (usize, &OgdenTerm)| {
        number(&format!("{key}[{index}].exponent"), term.exponent, ANY, 2.0)?;
        let product = term.shear_kpa * term.exponent;
        if !product.is_finite() || product <= 0.0 {
            let message = format!(
                "must be of the sign of the exponent {}, neither of them 0, is {}; for example {:?}",
                term.exponent,
                term.shear_kpa,
                1.0_f64.copysign(term.exponent)
            );
            return Err(Invalid::new(format!("{key}[{index}].shear_kpa"), message));
        }
        Ok(())
    };
    all(terms.iter().enumerate().map(one))
}

fn relaxation(key: &str, terms: &[Relaxation]) -> Result<(), Invalid> {
    if terms.len() > MAX_TERMS {
        return Err(Invalid::new(key, format!("must have at most {MAX_TERMS} terms, has {}", terms.len())));
    }
    all(terms.iter().enumerate().flat_map(|(index, term)| {
        [
            number(&format!("{key}[{index}].share"), term.share, 0.0..1.0, 0.2),
            number(&format!("{key}[{index}].time_s"), term.time_s, POSITIVE, 10.0),
        ]
    }))?;
    let sum: f64 = terms.iter().map(|term| term.share).sum();
    if sum >= 1.0 {
        let message = format!("the shares must add up to less than 1, or no stress is left, add up to {sum}");
        return Err(Invalid::new(key, message));
    }
    Ok(())
}

/// Every law of the stack's layers, touch side first; below a rigid layer all are rigid.
pub(super) fn check_stack(layers: &[Layer]) -> Result<(), Invalid> {
    let rigid = layers.iter().position(|layer| layer.elastic.is_none());
    let one = |(index, layer): (usize, &Layer)| {
        let key = format!("stack.layer[{index}].elastic");
        match (&layer.elastic, rigid.filter(|above| *above < index)) {
            (Some(elastic), None) => check(&key, elastic),
            (Some(_), Some(above)) => {
                let message = format!(
                    "lies below stack.layer[{above}], which is rigid: only the lowest layers may be; give that one \
                     elastic too, or leave it out here"
                );
                Err(Invalid::new(key, message))
            }
            (None, _) => Ok(()),
        }
    };
    all(layers.iter().enumerate().map(one))
}
