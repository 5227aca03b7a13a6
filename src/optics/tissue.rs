//! Diffuse reflectance of tissue.

/// Diffuse reflectance of an index-matched, semi-infinite scattering medium (diffusion theory; Flock et al. 1989,
/// eq. 19 with A = 1). Coefficients per mm: reduced scattering and absorption.
pub fn diffuse_reflectance(reduced_scattering_per_mm: f64, absorption_per_mm: f64) -> f64 {
    let albedo = reduced_scattering_per_mm / (reduced_scattering_per_mm + absorption_per_mm);
    let root = (3.0 * (1.0 - albedo)).sqrt();
    albedo / (1.0 + 2.0 * (1.0 - albedo) + (1.0 + 2.0 / 3.0) * root)
}

#[cfg(test)]
mod tests {
    #[test]
    fn scattering_1_and_absorption_0_01_per_mm_return_0_76() {
        assert!((super::diffuse_reflectance(1.0, 0.01) - 0.76).abs() < 0.005);
    }
}
