//! Which parameters make sense.

use super::{Law, Material, OgdenTerm};

/// Parameters that make no material.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MaterialError {
    /// A modulus or exponent that is not positive, or not finite.
    #[error("{what} is {value}; it must be positive and finite")]
    NotPositive {
        /// Which parameter, with its unit.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Poisson's ratio outside 0 to 0.5.
    #[error("Poisson's ratio is {poisson}; it must lie between 0 and 0.5, both included")]
    Poisson {
        /// The ratio.
        poisson: f64,
    },
    /// Yeoh coefficients with which the shear stress would not always rise with the shear.
    #[error("Yeoh coefficients {} {} {} kPa are unstable; c1 must be positive, c3 not negative, and c2 not negative either unless 3 c2^2 < 5 c1 c3", .c_kpa[0], .c_kpa[1], .c_kpa[2])]
    Yeoh {
        /// The coefficients.
        c_kpa: [f64; 3],
    },
    /// Ogden's law without terms.
    #[error("Ogden's law has no terms; it needs at least one")]
    OgdenEmpty,
    /// A term of Ogden's law whose modulus and exponent have not the same sign.
    #[error(
        "Ogden term {number} has modulus {shear_kpa} kPa and exponent {exponent}; their product must be positive and finite"
    )]
    OgdenTerm {
        /// Its number, from 1.
        number: usize,
        /// Its modulus.
        shear_kpa: f64,
        /// Its exponent.
        exponent: f64,
    },
    /// A Prony share outside 0 to 1.
    #[error("Prony term {number} has a share of {share}; it must be at least 0 and below 1")]
    Share {
        /// Its number, from 1.
        number: usize,
        /// Its share.
        share: f64,
    },
    /// Prony shares that leave no stress.
    #[error("the Prony shares add up to {sum}; the sum must be below 1")]
    ShareSum {
        /// Their sum.
        sum: f64,
    },
    /// A Prony time that is not positive.
    #[error("Prony term {number} has a time of {time_s} s; it must be positive and finite")]
    Time {
        /// Its number, from 1.
        number: usize,
        /// Its time.
        time_s: f64,
    },
}

impl Material {
    /// Whether the parameters make a stable material.
    ///
    /// # Errors
    /// The first parameter that does not, with its value.
    pub fn check(&self) -> Result<(), MaterialError> {
        if !(0.0..=0.5).contains(&self.poisson) {
            return Err(MaterialError::Poisson { poisson: self.poisson });
        }
        self.law.check()?;
        for (number, term) in (1..).zip(&self.relaxation) {
            if !(0.0..1.0).contains(&term.share) {
                return Err(MaterialError::Share { number, share: term.share });
            }
            if !is_positive(term.time_s) {
                return Err(MaterialError::Time { number, time_s: term.time_s });
            }
        }
        let sum = self.relaxation.iter().map(|term| term.share).sum::<f64>();
        if sum < 1.0 { Ok(()) } else { Err(MaterialError::ShareSum { sum }) }
    }
}

impl Law {
    /// Whether the parameters make a stable law.
    ///
    /// # Errors
    /// The first parameter that does not, with its value.
    pub fn check(&self) -> Result<(), MaterialError> {
        match self {
            Self::Linear { shear_kpa } | Self::NeoHookean { shear_kpa } => {
                positive("the shear modulus, kPa,", *shear_kpa)
            }
            Self::Yeoh { c_kpa } => {
                if is_stable_yeoh(c_kpa) {
                    Ok(())
                } else {
                    Err(MaterialError::Yeoh { c_kpa: *c_kpa })
                }
            }
            Self::Ogden { terms } => check_ogden(terms),
            Self::Exponential { modulus_kpa, exponent } => {
                positive("the modulus b of the exponential law, kPa,", *modulus_kpa)?;
                positive("the exponent m of the exponential law", *exponent)
            }
        }
    }
}

fn is_positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

fn positive(what: &'static str, value: f64) -> Result<(), MaterialError> {
    if is_positive(value) { Ok(()) } else { Err(MaterialError::NotPositive { what, value }) }
}

/// In simple shear s the stress is 2 s g'(s^2). It rises always when c1 + 6 c2 x + 15 c3 x^2 > 0 for all x >= 0.
fn is_stable_yeoh([c1, c2, c3]: &[f64; 3]) -> bool {
    let finite = c1.is_finite() && c2.is_finite() && c3.is_finite();
    finite && *c1 > 0.0 && *c3 >= 0.0 && (*c2 >= 0.0 || 3.0 * c2 * c2 < 5.0 * c1 * c3)
}

fn check_ogden(terms: &[OgdenTerm]) -> Result<(), MaterialError> {
    if terms.is_empty() {
        return Err(MaterialError::OgdenEmpty);
    }
    for (number, &OgdenTerm { shear_kpa, exponent }) in (1..).zip(terms) {
        // Both finite as well: an infinite factor makes the product infinite.
        if !is_positive(shear_kpa * exponent) {
            return Err(MaterialError::OgdenTerm { number, shear_kpa, exponent });
        }
    }
    Ok(())
}
