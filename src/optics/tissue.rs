//! Light that a half space of scattering tissue sends back (S. Chandrasekhar, Radiative Transfer, Dover 1960, chapters
//! IV and V).
//!
//! The scattering is taken as isotropic with the reduced coefficient (similarity), the surface as matched in index:
//! what a real boundary reflects is the tracer's. With the albedo w of one scattering, the cosines mu_i of the light
//! that comes and mu_o of that which leaves,
//!
//! ```text
//! pi f(mu_i, mu_o) = w/4 H(mu_i) H(mu_o) / (mu_i + mu_o)
//! 1/H(mu) = sqrt(1 - w) + w/2 integral of x H(x) / (x + mu) dx, from 0 to 1
//! ```
//!
//! f being the radiance that leaves over the flux per area that comes, and R(mu_i) = 1 - sqrt(1 - w) H(mu_i) all that
//! leaves.

/// Points of the integral over x = t^3 in the tracers: H is then known to 2.4e-5 (see the test), so that what leaves is
/// to 1e-5.
pub const POINTS: usize = 8;

/// Tissue as an endless half space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// Albedo w of one scattering.
    pub albedo: f64,
    /// 1/H(mu) is `floor` plus the sum of `weight / (place + mu)`.
    pub floor: f64,
    /// Places and weights.
    pub terms: [[f64; 2]; POINTS],
}

impl HalfSpace {
    /// Of the reduced scattering and the absorption, per mm.
    pub fn new(reduced_scattering_per_mm: f64, absorption_per_mm: f64) -> Self {
        let albedo = reduced_scattering_per_mm / (reduced_scattering_per_mm + absorption_per_mm);
        let floor = (absorption_per_mm / (reduced_scattering_per_mm + absorption_per_mm)).sqrt();
        let terms = solve(albedo, floor, &gauss_legendre(POINTS));
        let mut fixed = [[0.0; 2]; POINTS];
        fixed.iter_mut().zip(terms).for_each(|(fixed, term)| *fixed = term);
        Self { albedo, floor, terms: fixed }
    }

    /// Chandrasekhar's H.
    pub fn h(&self, mu: f64) -> f64 {
        evaluate(self.floor, &self.terms, mu)
    }

    /// Share of light of cosine `mu` that leaves again.
    pub fn returned(&self, mu: f64) -> f64 {
        1.0 - self.floor * self.h(mu)
    }

    /// The same of Lambertian light.
    pub fn returned_diffuse(&self) -> f64 {
        let [points, weights] = split(&gauss_legendre(64));
        points.iter().zip(weights).map(|(mu, weight)| weight * 2.0 * mu * self.returned(*mu)).sum()
    }

    /// Radiance that leaves at the cosine `mu_o` over that of a white Lambertian face, for light of cosine `mu_i`: pi
    /// f.
    pub fn sent(&self, mu_i: f64, mu_o: f64) -> f64 {
        0.25 * self.albedo * self.h(mu_i) * self.h(mu_o) / (mu_i + mu_o)
    }
}

/// Places x and weights w/2 x H(x) dx of the sum in 1/H, by iteration. Plain iteration swings about the answer; its
/// mean with the step before halves the error each time, or better.
fn solve(albedo: f64, floor: f64, rule: &[[f64; 2]]) -> Vec<[f64; 2]> {
    // With x = t^3 the points crowd where H bends most: at 0, as x ln x.
    let places: Vec<[f64; 2]> = rule.iter().map(|[t, weight]| [t.powi(3), weight * 3.0 * t * t]).collect();
    let terms = |h: &[f64]| -> Vec<[f64; 2]> {
        places.iter().zip(h).map(|([x, weight], h)| [*x, 0.5 * albedo * x * h * weight]).collect()
    };
    let mut h = vec![1.0; places.len()];
    for _ in 0..100 {
        let terms = terms(&h);
        h.iter_mut().zip(&places).for_each(|(h, [x, _])| *h = 0.5 * (*h + evaluate(floor, &terms, *x)));
    }
    terms(&h)
}

fn evaluate(floor: f64, terms: &[[f64; 2]], mu: f64) -> f64 {
    1.0 / (floor + terms.iter().map(|[place, weight]| weight / (place + mu)).sum::<f64>())
}

fn split(rule: &[[f64; 2]]) -> [Vec<f64>; 2] {
    [0, 1].map(|k| rule.iter().map(|pair| pair[k]).collect())
}

/// Places and weights of Gauss and Legendre on (0, 1), by Newton's method on the polynomial.
fn gauss_legendre(n: usize) -> Vec<[f64; 2]> {
    // The polynomial of degree n and its derivative.
    let legendre = |x: f64| {
        let (mut last, mut this) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (last, this) = (this, ((2.0 * k - 1.0) * x * this - (k - 1.0) * last) / k);
        }
        [this, n as f64 * (last - x * this) / (1.0 - x * x)]
    };
    let point = |k: usize| {
        let mut x = -(std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..10 {
            let [value, slope] = legendre(x);
            x -= value / slope;
        }
        let slope = legendre(x)[1];
        [0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..n).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// H of the same half space by many points of the integral.
    fn fine(albedo: f64) -> impl Fn(f64) -> f64 {
        let floor = (1.0 - albedo).sqrt();
        let terms = solve(albedo, floor, &gauss_legendre(128));
        move |mu| evaluate(floor, &terms, mu)
    }

    fn cosines() -> impl Iterator<Item = f64> {
        (0..=400).map(|k| (f64::from(k) / 400.0).powi(2))
    }

    #[test]
    fn gauss_and_legendre_integrate_powers() {
        for power in 0..16 {
            let sum: f64 = gauss_legendre(8).iter().map(|[x, weight]| weight * x.powi(power)).sum();
            assert!((sum * f64::from(power + 1) - 1.0).abs() < 1e-14, "{power}: {sum}");
        }
    }

    /// Chandrasekhar's table XI: H of isotropic scattering without absorption, to its last digit.
    #[test]
    fn h_is_that_of_chandrasekhars_table() {
        for (mu, listed) in [(0.0, 1.0), (0.5, 2.0128), (1.0, 2.9078)] {
            assert!((fine(1.0)(mu) - listed).abs() < 5e-5, "{}", fine(1.0)(mu));
        }
    }

    #[test]
    fn eight_points_know_h_to_3e_5() {
        for [scattering, absorption] in [[1.0, 0.0], [1.0, 0.01], [1.0, 0.1], [5.0, 0.01], [1.0, 1.0], [1e-3, 1.0]] {
            let tissue = HalfSpace::new(scattering, absorption);
            let fine = fine(tissue.albedo);
            for mu in cosines() {
                let off = tissue.h(mu) - fine(mu);
                assert!(off.abs() < 3e-5, "{scattering} {absorption} at {mu}: {off}");
            }
            // Integral of H: 2/w (1 - sqrt(1 - w)).
            let sum: f64 = gauss_legendre(64).iter().map(|[t, w]| w * 3.0 * t * t * tissue.h(t.powi(3))).sum();
            let exact = 2.0 / (1.0 + tissue.floor);
            assert!((sum - exact).abs() < 1e-5 * exact, "{sum} {exact}");
        }
    }

    #[test]
    fn what_comes_back_is_as_listed() {
        let (dim, dark) = (HalfSpace::new(1.0, 0.01), HalfSpace::new(1.0, 0.1));
        for (found, listed, exact) in [
            (dim.returned(1.0), 0.754, 0.753_762),
            (dim.returned(0.5), 0.816, 0.815_981),
            (dim.returned_diffuse(), 0.7955, 0.795_470),
            (dark.returned_diffuse(), 0.4955, 0.495_478),
        ] {
            // To the last digit listed, and by 128 points (3e-5 of H times sqrt(1 - w) below 0.31).
            assert!((found - listed).abs() <= 5.01e-4 && (found - exact).abs() < 1e-5, "{found} {listed}");
        }
    }

    #[test]
    fn tissue_that_absorbs_nothing_returns_all() {
        let white = HalfSpace::new(2.0, 0.0);
        for mu in cosines() {
            assert_eq!(white.returned(mu), 1.0);
        }
        assert!((white.returned_diffuse() - 1.0).abs() < 1e-14);
    }

    /// What leaves in all directions is what is returned, and directions may be exchanged.
    #[test]
    fn all_that_is_sent_is_what_is_returned() {
        for absorption in [0.0, 0.01, 0.1, 1.0] {
            let tissue = HalfSpace::new(1.0, absorption);
            for mu in [0.02, 0.3, 0.7, 1.0] {
                let sum: f64 = gauss_legendre(64)
                    .iter()
                    .map(|[t, w]| w * 3.0 * t * t * 2.0 * t.powi(3) * tissue.sent(mu, t.powi(3)))
                    .sum();
                // Twice the error of H, of the product of two.
                assert!((sum - tissue.returned(mu)).abs() < 6e-5, "{absorption} at {mu}: {sum}");
                assert!((tissue.sent(mu, 0.4) - tissue.sent(0.4, mu)).abs() < 1e-15);
            }
        }
    }
}
