//! Twin of `tissue_lambertian.wgsl` and `tissue_half_space.wgsl`: what tissue does with light of the cosines that it
//! comes and leaves at, within the tissue.

use super::touch::Boundary;
use super::{Path, book};
use crate::trace::model::{Real, Tissue};
use crate::trace::scatter::{HalfSpace, Scatter};

impl<T: Real> HalfSpace<T> {
    fn h(&self, mu: T) -> T {
        let terms = self.terms.iter().fold(T::zero(), |sum, [place, weight]| sum + *weight / (*place + mu));
        T::one() / (self.floor + terms)
    }

    /// What light of this cosine sends towards both directions of the map.
    pub(in crate::trace) fn toward(&self, mu: T) -> [T; 2] {
        let h = self.h(mu);
        [0, 1].map(|k| self.toward[k] * h / (mu + self.cosines[k]))
    }

    /// Parts of both directions of the map in what leaves at this cosine.
    pub(in crate::trace) fn between(&self, mu: T) -> [T; 2] {
        let [one, other] = self.cosines;
        let scale = self.h(mu) / ((mu + one) * (mu + other));
        [self.between[0] * scale * (mu - other), self.between[1] * scale * (mu - one)]
    }
}

impl<T: Real> Tissue<T> {
    /// Cosine in the tissue of light that has a = n cos in the guide.
    pub fn cosine(&self, a: T) -> T {
        (self.dn_sq + a * a).max(T::zero()).sqrt() / self.n
    }

    /// Share of light that leaves again.
    pub(super) fn returned(&self, mu: T) -> T {
        match &self.scatter {
            Scatter::Lambertian(t) => t.albedo,
            Scatter::HalfSpace(t) => T::one() - t.floor * t.h(mu),
        }
    }

    /// Radiance that leaves at `mu_o` over that of a white Lambertian face.
    pub(super) fn sent(&self, mu_i: T, mu_o: T) -> T {
        match &self.scatter {
            Scatter::Lambertian(t) => t.albedo,
            Scatter::HalfSpace(t) => t.quarter_albedo * t.h(mu_i) * t.h(mu_o) / (mu_i + mu_o),
        }
    }

    /// What a photon leaves in the map, of its weight.
    pub(super) fn map_shares(&self, r: &Boundary<T>, mu: T) -> [T; 2] {
        let one = T::one();
        match &self.scatter {
            Scatter::Lambertian(_) => [one - r.contact, one - r.gap],
            Scatter::HalfSpace(t) => t.toward(mu).map(|toward| (one - r.mixed) * toward),
        }
    }
}

impl<T: Real> Path<'_, T> {
    /// What light that has a = n cos in the guide sends towards both directions of the map, in tissue as a half space.
    pub(in crate::trace) fn toward_map(&self, a: T) -> [T; 2] {
        match self.tissue().map(|tissue| (tissue, &tissue.scatter)) {
            Some((tissue, Scatter::HalfSpace(t))) => t.toward(tissue.cosine(a)),
            _ => [T::zero(); 2],
        }
    }

    /// The weight of a path that survived and leaves by Lambert's law. It is 1 in the mean, so it is booked as
    /// roulette's.
    pub(super) fn weigh(&mut self, tissue: &Tissue<T>, mu_i: T, mu_o: T) {
        if tissue.scatter.is_half_space() {
            let before = self.weight;
            self.weight = before * tissue.sent(mu_i, mu_o) / tissue.returned(mu_i);
            self.book(book::ROULETTE, before, self.weight);
        }
    }

    /// Exitance towards the cosine `mu_o`, times pi as a radiance, from the map's two numbers.
    pub(super) fn exitance_toward(&self, tissue: &Tissue<T>, x: T, y: T, map: [T; 2], mu_o: T) -> T {
        match &tissue.scatter {
            Scatter::Lambertian(_) if self.kernel.spreading => map[0],
            Scatter::Lambertian(t) => {
                let share = self.contact_share(x, y);
                let mix = |a: T, b: T| a * (T::one() - share) + b * share;
                let reentry = mix(t.reentry_gap, t.reentry_contact);
                t.albedo * mix(map[1], map[0]) / (T::one() - t.albedo * reentry)
            }
            Scatter::HalfSpace(t) => {
                let between = t.between(mu_o);
                (between[0] * map[0] + between[1] * map[1]).max(T::zero())
            }
        }
    }
}
