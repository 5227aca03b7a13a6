//! What tissue does with light that enters it, as plain numbers of the tracers.
//!
//! Tissue of a given diffuse reflectance is Lambertian. Tissue given by coefficients is a half space
//! (`optics::tissue`), which sends different light to different directions. A map cannot hold all of them: it holds
//! what leaves towards two, and what lies between follows from the form H(mu)/(mu + mu_k) of both. For light of cosine
//! mu_i that leaves at mu_o this is off by exactly the product over both k of (mu_i - mu_k)(mu_o - mu_k) / ((mu_i +
//! mu_k)(mu_o + mu_k)), as the determinants of Cauchy's matrix have it.

use super::real::Real;
use crate::optics::fresnel;
use crate::optics::tissue::{self, POINTS};

/// Cosines of the map's two directions. A pinhole of 60 degrees sees 0.91 to 1 straight, guided light comes at 0 to
/// 0.7: for these together, of even radiance, the map is off by 0.04 % at most (see the test).
pub const MAP_COSINES: [f64; 2] = [0.3, 0.96];

/// What tissue does with light that enters it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scatter<T> {
    /// Returns the same share of all light, alike in all directions.
    Lambertian(Lambertian<T>),
    /// Is a half space of scatterers.
    HalfSpace(HalfSpace<T>),
}

/// A diffuse reflectance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lambertian<T> {
    /// Share returned.
    pub albedo: T,
    /// Diffuse internal reflectance, tissue to guide, through true contact.
    pub reentry_contact: T,
    /// The same through the air gap.
    pub reentry_gap: T,
}

/// A half space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace<T> {
    /// A quarter of the albedo of one scattering.
    pub quarter_albedo: T,
    /// 1/H(mu) is this plus the sum of weight / (place + mu).
    pub floor: T,
    /// Places and weights.
    pub terms: [[T; 2]; POINTS],
    /// Cosines of the map's directions.
    pub cosines: [T; 2],
    /// `quarter_albedo` times H of them: times H(mu)/(mu + cosine), what light of cosine mu sends there.
    pub toward: [T; 2],
    /// Factors of what the map holds, between its directions.
    pub between: [T; 2],
    /// What the map's numbers get of themselves by light that the boundary mirrors back through true contact: rows
    /// `[to][from]`.
    pub reentry_contact: [[T; 2]; 2],
    /// The same through the air gap.
    pub reentry_gap: [[T; 2]; 2],
}

impl Scatter<f64> {
    /// Of a diffuse reflectance; `contact` and `gap` reflect light of a cosine in the tissue.
    pub fn lambertian(albedo: f64, contact: impl Fn(f64) -> f64, gap: impl Fn(f64) -> f64) -> Self {
        let [reentry_contact, reentry_gap] = fresnel::lambertian_means(|cos| [contact(cos), gap(cos)]);
        Self::Lambertian(Lambertian { albedo, reentry_contact, reentry_gap })
    }

    /// Of a half space.
    pub fn half_space(tissue: &tissue::HalfSpace, contact: impl Fn(f64) -> f64, gap: impl Fn(f64) -> f64) -> Self {
        let [one, other] = MAP_COSINES;
        let h = MAP_COSINES.map(|mu| tissue.h(mu));
        let quarter_albedo = 0.25 * tissue.albedo;
        let mut found = HalfSpace {
            quarter_albedo,
            floor: tissue.floor,
            terms: tissue.terms,
            cosines: MAP_COSINES,
            toward: h.map(|h| quarter_albedo * h),
            between: [
                2.0 * one * (one + other) / (h[0] * (one - other)),
                2.0 * other * (one + other) / (h[1] * (other - one)),
            ],
            reentry_contact: [[0.0; 2]; 2],
            reentry_gap: [[0.0; 2]; 2],
        };
        let means = fresnel::lambertian_means(|cos| {
            let (from, to) = (found.between(cos), found.toward(cos));
            let (contact, gap) = (contact(cos), gap(cos));
            let pairs = [to[0] * from[0], to[0] * from[1], to[1] * from[0], to[1] * from[1]];
            [
                contact * pairs[0],
                contact * pairs[1],
                contact * pairs[2],
                contact * pairs[3],
                gap * pairs[0],
                gap * pairs[1],
                gap * pairs[2],
                gap * pairs[3],
            ]
        });
        found.reentry_contact = [[means[0], means[1]], [means[2], means[3]]];
        found.reentry_gap = [[means[4], means[5]], [means[6], means[7]]];
        Self::HalfSpace(found)
    }

    /// What the boundary mirrors back into the tissue of the map's two numbers, at a share of true contact: rows
    /// `[to][from]`.
    pub fn reentry(&self, share: f64) -> [[f64; 2]; 2] {
        let mix = |gap: f64, contact: f64| gap + share * (contact - gap);
        match self {
            Self::Lambertian(t) => {
                let back = mix(t.reentry_gap, t.reentry_contact);
                [[back, 0.0], [0.0, back]]
            }
            Self::HalfSpace(t) => {
                [0, 1].map(|to| [0, 1].map(|from| mix(t.reentry_gap[to][from], t.reentry_contact[to][from])))
            }
        }
    }
}

impl<T: Real> Scatter<T> {
    /// Whether it sends different light to different directions.
    pub fn is_half_space(&self) -> bool {
        matches!(self, Self::HalfSpace(_))
    }

    /// In another precision.
    pub fn cast<U: Real>(&self) -> Scatter<U> {
        let of = |v: T| U::of(v.wide());
        match self {
            Self::Lambertian(t) => Scatter::Lambertian(Lambertian {
                albedo: of(t.albedo),
                reentry_contact: of(t.reentry_contact),
                reentry_gap: of(t.reentry_gap),
            }),
            Self::HalfSpace(t) => Scatter::HalfSpace(HalfSpace {
                quarter_albedo: of(t.quarter_albedo),
                floor: of(t.floor),
                terms: t.terms.map(|term| term.map(of)),
                cosines: t.cosines.map(of),
                toward: t.toward.map(of),
                between: t.between.map(of),
                reentry_contact: t.reentry_contact.map(|row| row.map(of)),
                reentry_gap: t.reentry_gap.map(|row| row.map(of)),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(absorption: f64) -> (tissue::HalfSpace, HalfSpace<f64>) {
        let tissue = tissue::HalfSpace::new(1.0, absorption);
        let Scatter::HalfSpace(found) = Scatter::half_space(&tissue, |_| 1.0, |_| 0.0) else { panic!("a half space") };
        (tissue, found)
    }

    fn held(map: &HalfSpace<f64>, mu_i: f64, mu_o: f64) -> f64 {
        let (toward, between) = (map.toward(mu_i), map.between(mu_o));
        toward[0] * between[0] + toward[1] * between[1]
    }

    #[test]
    fn two_directions_tell_all_others_but_for_cauchys_remainder() {
        let (tissue, map) = open(0.01);
        for mu_i in [0.05, 0.3, 0.5, 0.7, 1.0] {
            for mu_o in [0.1, 0.3, 0.6, 0.9, 0.96, 1.0] {
                let part = |mu: f64, k: f64| (mu - k) / (mu + k);
                let off: f64 = MAP_COSINES.iter().map(|k| part(mu_i, *k) * part(mu_o, *k)).product();
                let exact = tissue.sent(mu_i, mu_o);
                assert!((held(&map, mu_i, mu_o) / exact - (1.0 - off)).abs() < 1e-12, "{mu_i} {mu_o}");
            }
        }
    }

    /// What the camera sees straight of guided light, of even radiance there.
    #[test]
    fn guided_light_that_the_camera_sees_is_held_to_5_parts_in_10000() {
        for absorption in [0.0, 0.01, 0.1, 1.0] {
            let (tissue, map) = open(absorption);
            for k in 0..=9 {
                let mu_o = 0.91 + 0.01 * f64::from(k);
                // From 45 degrees to grazing.
                let [exact, found] = fresnel::lambertian_means(|mu| {
                    let guided = f64::from(u8::from(mu < 0.7));
                    [guided * tissue.sent(mu, mu_o), guided * held(&map, mu, mu_o)]
                });
                assert!((found / exact - 1.0).abs() < 5e-4, "{absorption} {mu_o}: {found} {exact}");
            }
        }
    }

    /// A boundary that mirrors all: what leaves comes back as it left.
    #[test]
    fn what_is_mirrored_comes_again() {
        let (tissue, map) = open(0.1);
        let grid = |k: usize| (k as f64 + 0.5) / 2000.0;
        for (to, mu_l) in MAP_COSINES.into_iter().enumerate() {
            for mu_i in [0.3, 0.96] {
                // The map's light of mu_i, once more through the tissue, towards mu_l.
                let toward = map.toward(mu_i);
                let found: f64 = (0..2).map(|from| map.reentry_contact[to][from] * toward[from]).sum();
                let exact: f64 = (0..2000)
                    .map(|k| tissue.sent(mu_i, grid(k)) * tissue.sent(grid(k), mu_l) * 2.0 * grid(k) / 2000.0)
                    .sum();
                assert!((found / exact - 1.0).abs() < 1e-5, "{mu_i} to {mu_l}: {found} {exact}");
                assert!(map.reentry_gap[to] == [0.0; 2]);
            }
        }
    }
}
