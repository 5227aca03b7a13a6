//! Refractive index against wavelength.
//!
//! Formulas and ranges: refractiveindex.info database (CC0), entries Schneider 2009 (Sylgard 184), Schott N-BK7,
//! BOROFLOAT33 and D263TECO. Wavelengths are in vacuum.

use super::{Layer, Material, Stack};

impl Material {
    /// Refractive index at a vacuum wavelength in nm; none outside the range of the fit.
    pub fn n(self, wavelength_nm: f64) -> Option<f64> {
        let (least, most) = self.fitted_range_nm();
        (least..=most).contains(&wavelength_nm).then(|| self.formula(wavelength_nm / 1000.0).sqrt())
    }

    /// Shortest and longest vacuum wavelength of the fit, nm.
    pub fn fitted_range_nm(self) -> (f64, f64) {
        match self {
            Self::PdmsSylgard184 => (350.0, 700.0),
            Self::NBk7 => (300.0, 2500.0),
            Self::Borofloat33 => (240.0, 1550.0),
            Self::D263t => (334.0, 2325.0),
        }
    }

    /// Name as in a scene file.
    pub fn name(self) -> &'static str {
        match self {
            Self::PdmsSylgard184 => "pdms_sylgard184",
            Self::NBk7 => "n_bk7",
            Self::Borofloat33 => "borofloat33",
            Self::D263t => "d263t",
        }
    }

    /// n^2 at a wavelength in um.
    fn formula(self, lambda: f64) -> f64 {
        match self {
            Self::PdmsSylgard184 => sellmeier(lambda, 1.0, &[(1.0093, 0.013185)]),
            Self::NBk7 => sellmeier(
                lambda,
                1.0,
                &[(1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653)],
            ),
            // This entry gives its poles as wavelengths, not as their squares.
            Self::Borofloat33 => sellmeier(lambda, 1.3542, &[(0.78657, 0.10856 * 0.10856), (0.18285, 4.427 * 4.427)]),
            Self::D263t => sellmeier(
                lambda,
                1.0,
                &[(1.23795755, 0.00863080926), (0.0466468888, 0.0469074501), (2.46700556, 264.146296)],
            ),
        }
    }
}

/// n^2 = constant + sum of B L^2/(L^2 - C), L in um, C in um^2.
fn sellmeier(lambda: f64, constant: f64, terms: &[(f64, f64)]) -> f64 {
    let lambda2 = lambda * lambda;
    constant + terms.iter().map(|(b, c)| b * lambda2 / (lambda2 - c)).sum::<f64>()
}

impl Layer {
    /// Refractive index at a vacuum wavelength in nm. A validated layer has `n` or a material that covers the scene's
    /// wavelength; for any other this is NaN, which no optical formula hides.
    pub fn index(&self, wavelength_nm: f64) -> f64 {
        self.n.or_else(|| self.material.and_then(|material| material.n(wavelength_nm))).unwrap_or(f64::NAN)
    }
}

impl Stack {
    /// Height of the undeformed touched face above the lowest face, mm.
    pub fn height_mm(&self) -> f64 {
        self.layer.iter().map(|layer| layer.thickness_mm).sum()
    }

    /// Heights of the undeformed interfaces, lowest face first (0), touched face last, mm.
    pub fn interface_heights_mm(&self) -> Vec<f64> {
        let mut height = 0.0;
        let above = self.layer.iter().rev().map(|layer| {
            height += layer.thickness_mm;
            height
        });
        std::iter::once(0.0).chain(above).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_match_the_reference_table() {
        let wavelengths = [486.1, 532.0, 589.3, 632.8];
        let table = [
            (Material::PdmsSylgard184, [1.43838, 1.43479, 1.43148, 1.42957]),
            (Material::NBk7, [1.52238, 1.51947, 1.51673, 1.51509]),
            (Material::Borofloat33, [1.47642, 1.47386, 1.47143, 1.46997]),
            (Material::D263t, [1.52999, 1.52649, 1.52322, 1.52129]),
        ];
        for (material, expected) in table {
            for (wavelength, n) in wavelengths.into_iter().zip(expected) {
                let computed = material.n(wavelength).unwrap_or(f64::NAN);
                // The table is rounded to five decimals.
                assert!((computed - n).abs() <= 0.5e-5 + 1e-12, "{material:?} {wavelength}: {computed} for {n}");
            }
        }
    }

    #[test]
    fn no_index_outside_the_fitted_range() {
        assert_eq!(Material::PdmsSylgard184.n(349.9), None);
        assert_eq!(Material::PdmsSylgard184.n(700.1), None);
        assert!(Material::PdmsSylgard184.n(700.0).is_some());
        assert_eq!(Material::NBk7.n(f64::NAN), None);
    }
}
