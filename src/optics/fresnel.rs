//! Fresnel reflectance of a smooth interface (Born and Wolf, Principles of Optics, 1.5.2).

/// Power reflectances of the two polarisations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflectance {
    /// Perpendicular to the plane of incidence.
    pub s: f64,
    /// Parallel to the plane of incidence.
    pub p: f64,
}

impl Reflectance {
    /// Of unpolarised light.
    pub fn mean(self) -> f64 {
        0.5 * (self.s + self.p)
    }
}

/// Reflectances from index `n_i` to `n_t` at the incidence cosine `cos_theta_i`; both 1 beyond the critical angle.
pub fn fresnel(cos_theta_i: f64, n_i: f64, n_t: f64) -> Reflectance {
    let a = n_i * cos_theta_i;
    let b_sq = (n_t - n_i) * (n_t + n_i) + a * a;
    if b_sq <= 0.0 {
        return Reflectance { s: 1.0, p: 1.0 };
    }
    let b = b_sq.sqrt();
    let s = (a - b) / (a + b);
    let p = (n_t * n_t * a - n_i * n_i * b) / (n_t * n_t * a + n_i * n_i * b);
    Reflectance { s: s * s, p: p * p }
}

/// Reflectance of unpolarised light.
pub fn reflectance(cos_theta_i: f64, n_i: f64, n_t: f64) -> f64 {
    fresnel(cos_theta_i, n_i, n_t).mean()
}

/// Reflectance of an incoherent slab of index `n` (surfaces of reflectances `first` and `second`), all orders.
pub fn incoherent_slab(first: f64, second: f64) -> f64 {
    if first >= 1.0 {
        return 1.0;
    }
    first + (1.0 - first) * (1.0 - first) * second / (1.0 - first * second)
}

/// Mean of a reflectance over Lambertian light: the integral of R(cos) 2 cos d(cos) over 0 to 1.
pub fn lambertian_mean(reflectance: impl Fn(f64) -> f64) -> f64 {
    lambertian_means(|cos| [reflectance(cos)])[0]
}

/// The same of several functions at once.
pub fn lambertian_means<const N: usize>(functions: impl Fn(f64) -> [f64; N]) -> [f64; N] {
    // Midpoints of sin^2; the kink at the critical angle limits the error to about 1 / steps^1.5.
    let steps = 200_000;
    let mut sums = [0.0; N];
    for k in 0..steps {
        let values = functions((1.0 - (f64::from(k) + 0.5) / f64::from(steps)).sqrt());
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
    }
    sums.map(|sum| sum / f64::from(steps))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_and_brewster() {
        assert!((reflectance(1.0, 1.38, 1.0) - 0.025_492_54).abs() < 1e-7);
        assert!((reflectance(1.0, 1.41, 1.0) - 0.028_942_34).abs() < 1e-7);
        assert!((reflectance(1.0, 1.41, 1.40) - 1.2664e-5).abs() < 1e-9);
        let brewster = 1.41f64.atan();
        assert!((brewster.to_degrees() - 54.6550).abs() < 5e-5);
        assert!(fresnel(brewster.cos(), 1.0, 1.41).p < 1e-30);
        let r = fresnel(0.5, 1.0, 1.41);
        assert!((r.s - 0.144_340).abs() < 5e-7 && (r.p - 0.003_171_80).abs() < 5e-9);
    }

    #[test]
    fn slab_transmission_depolarised_and_with_polarisations_kept_apart() {
        for (angle, mixed, apart) in [(30.0f64, 0.941_288, 0.941_581), (45.0, 0.926_946, 0.928_884)] {
            let cos = angle.to_radians().cos();
            let r = fresnel(cos, 1.0, 1.41);
            let t = |r: f64| 1.0 - incoherent_slab(r, r);
            assert!((t(r.mean()) - mixed).abs() < 5e-7);
            assert!((0.5 * (t(r.s) + t(r.p)) - apart).abs() < 5e-7);
        }
    }

    #[test]
    fn diffuse_reflectance_of_the_touched_face() {
        let external = lambertian_mean(|c| reflectance(c, 1.0, 1.41));
        let internal = lambertian_mean(|c| reflectance(c, 1.41, 1.0));
        assert!((external - 0.07834).abs() < 5e-6);
        assert!((internal - 0.5364).abs() < 5e-5);
        // Detailed balance: 1 - R_int = (1 - R_ext) / n^2.
        assert!((1.0 - internal - (1.0 - external) / (1.41 * 1.41)).abs() < 1e-6);
    }
}
