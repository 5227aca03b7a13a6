//! Replicates: independent estimates of the whole image, traced in chunks of well under a second.

use super::backend::Backend;
use super::cpu::{UNIT, book, camera::FILM_UNIT, photons::DEPOSIT_UNIT};
use super::error::TraceError;
use super::exitance::{ContactLight, Smoothing, TouchedFace};
use super::kernel::Kernel;
use super::model::Model;
use super::modes::{CameraMode, Fates, PhotonMode};
use super::pcg::pcg3d;
use super::plan::Integrator;
use super::unfold::direct_light;
use crate::film::Ledger;
use crate::progress::{Observer, Stage};
use std::collections::HashMap;
use std::time::Instant;

/// Threads that share the photons of a replicate.
const THREADS: u32 = 1 << 14;
/// Most photons of one thread in one chunk: the shader's ledger counts 2^20 units each in 32 signed bits.
const THREAD_PHOTONS: u32 = 1024;
/// Aim for one chunk, seconds: a desktop stays usable and a stop is answered.
const CHUNK_SECONDS: f64 = 0.15;

/// Most pixels of one chunk: a dispatch holds 65,535 workgroups.
const MOST_PIXELS: u32 = 1 << 21;

/// Work of one replicate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Work {
    /// Camera paths per pixel.
    pub spp: u32,
    /// Photons (rounded up to whole threads).
    pub photons: u64,
}

/// Sums over replicates beside the image.
#[derive(Debug, Clone, Copy, Default)]
pub struct Totals {
    /// Camera paths.
    pub paths: u64,
    /// Photons.
    pub photons: u64,
    /// Segments of both that were traced: those of photons that were kept are not among them.
    pub segments: u64,
    /// What became of the camera paths.
    pub fates: Fates,
    /// Ledger of the photons, in its units.
    pub tally: [i64; book::SLOTS],
    /// Where the time went.
    pub times: Times,
}

/// Where the time of tracing went, seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Times {
    /// Photons.
    pub photons: f64,
    /// What is done to their map: choice of the smoothing, smoothing, spread in the tissue.
    pub map: f64,
    /// Camera paths.
    pub camera: f64,
    /// Photons of the ledger, where the integrator sends none of its own or not all.
    pub ledger: f64,
}

impl Times {
    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            photons: self.photons + other.photons,
            map: self.map + other.map,
            camera: self.camera + other.camera,
            ledger: self.ledger + other.ledger,
        }
    }
}

impl Totals {
    /// The ledger as shares of the emitted power.
    pub fn ledger(&self) -> Ledger {
        let sent = self.tally[book::EMITTED].max(1) as f64;
        let share = |slot: usize| self.tally[slot] as f64 / sent;
        let parts =
            [book::ABSORBED, book::TOP, book::BOTTOM, book::SIDES, book::DETECTED, book::TERMINATED, book::ROULETTE];
        let found: i64 = parts.iter().map(|&slot| self.tally[slot]).sum();
        Ledger {
            emitted: share(book::EMITTED),
            absorbed: share(book::ABSORBED),
            escaped_top: share(book::TOP),
            escaped_bottom: share(book::BOTTOM),
            escaped_sides: share(book::SIDES),
            detected: share(book::DETECTED),
            terminated: share(book::TERMINATED),
            roulette: share(book::ROULETTE),
            residual: (self.tally[book::EMITTED] - found) as f64 / sent,
        }
    }

    /// Lost photons.
    pub fn lost(&self) -> u64 {
        self.tally[book::LOST].max(0) as u64
    }

    /// Share of the camera paths' weight that the cap on interactions cut off.
    pub fn paths_cut_off(&self) -> f64 {
        self.fates.cut_off as f64 / UNIT / self.paths.max(1) as f64
    }
}

/// Adapts the size of chunks to the machine.
#[derive(Debug, Clone, Copy)]
pub struct Pacer {
    camera: f64,
    photons: f64,
}

impl Default for Pacer {
    fn default() -> Self {
        Self { camera: 65_536.0, photons: 65_536.0 }
    }
}

fn adapt(pace: &mut f64, done: u64, seconds: f64) {
    let aim = done as f64 * CHUNK_SECONDS / seconds.max(1e-4);
    *pace = aim.clamp(*pace * 0.5, *pace * 4.0).clamp(4096.0, 1e9);
}

/// Pixels from `pixel` on and samples of each that a pace of paths allows; `left` samples are still to take. Several
/// samples only of the whole image, which is begun anew only where the last chunk ended it.
fn chunk(pace: u64, pixels: u32, pixel: u32, left: u32) -> [u32; 2] {
    let samples = if pixel == 0 && pixels <= MOST_PIXELS { pace / u64::from(pixels) } else { 1 };
    let count = pace.clamp(1, u64::from(MOST_PIXELS)).min(u64::from(pixels - pixel));
    [count as u32, samples.clamp(1, u64::from(left)) as u32]
}

/// Everything that one replicate needs.
pub struct Batch<'a> {
    /// The scene.
    pub model: &'a Model<f64>,
    /// The backend with the scene loaded.
    pub backend: &'a mut Backend,
    /// How light is found.
    pub integrator: Integrator,
    /// Seed of the render.
    pub seed: u32,
    /// Paces chunks.
    pub pacer: Pacer,
    /// Sums over the replicates so far.
    pub totals: Totals,
    /// What the photons of a map have left, by replicate, where more of them may follow.
    kept: Option<HashMap<u32, Sent>>,
}

/// Photons of a replicate that were sent, `each` by every thread, and what they left.
#[derive(Clone)]
struct Sent {
    threads: u32,
    each: u32,
    tally: [i64; book::SLOTS],
    deposits: Vec<u64>,
}

impl Sent {
    /// The same with those that followed. A sum that is full stays full.
    fn and(mut self, more: &Self) -> Self {
        self.tally.iter_mut().zip(more.tally).for_each(|(sum, v)| *sum += v);
        self.deposits.iter_mut().zip(&more.deposits).for_each(|(sum, v)| *sum = sum.saturating_add(*v));
        Self { each: more.each, ..self }
    }
}

impl<'a> Batch<'a> {
    /// Nothing computed yet; `backend` holds the model.
    pub fn new(model: &'a Model<f64>, backend: &'a mut Backend, integrator: Integrator, seed: u32) -> Self {
        let (pacer, totals) = (Pacer::default(), Totals::default());
        Self { model, backend, integrator, seed, pacer, totals, kept: None }
    }

    /// Keeps what the photons of a map leave, from now on: the same replicate with more photons then sends those alone
    /// that it lacks, with the sums of all.
    #[must_use]
    pub fn keeping(self) -> Self {
        Self { kept: Some(HashMap::new()), ..self }
    }

    /// Keeps no more than what the first so many replicates left.
    pub fn keep_first(&mut self, replicates: u32) {
        if let Some(kept) = &mut self.kept {
            kept.retain(|index, _| *index < replicates);
        }
    }

    /// Computes replicate `index`: radiance in W/(m^2 sr), row-major.
    ///
    /// # Errors
    /// What the backend says; `Overflow` where sums of light are full, `Stopped` where `observe` says so.
    pub fn replicate(&mut self, index: u32, work: Work, observe: &mut Observer) -> Result<Vec<f64>, TraceError> {
        match self.integrator {
            Integrator::Path => self.camera(CameraMode::Path, index, work.spp, observe),
            Integrator::Map => {
                let face = TouchedFace::new(self.model);
                let light = self.contact_light(index, work, &face, observe)?;
                let texels = face.texels(&[light], Smoothing::default()).pop().unwrap_or_default();
                self.mapped(index, work, &texels, observe)
            }
            Integrator::Splat => {
                let (deposits, sent) = self.photons(PhotonMode::Splat, index, work.photons, observe)?;
                let mut image = self.camera(CameraMode::Complement, index, work.spp, observe)?;
                let each = self.model.power * self.model.unit_radiance / sent / DEPOSIT_UNIT;
                image.iter_mut().zip(deposits).for_each(|(v, d)| *v += d as f64 * each);
                Ok(image)
            }
        }
    }

    /// Light that the photons of replicate `index` leave at the touched face.
    ///
    /// # Errors
    /// As [`Self::replicate`].
    pub fn contact_light(
        &mut self,
        index: u32,
        work: Work,
        face: &TouchedFace,
        observe: &mut Observer,
    ) -> Result<ContactLight, TraceError> {
        let (deposits, sent) = self.photons(PhotonMode::Map, index, work.photons, observe)?;
        let (model, unfolded) = (self.model, Kernel::of(self.model).unfolded);
        let shift = pcg3d([self.seed, index, 2]).map(|v| f64::from(v) / 4_294_967_296.0);
        Ok(self.at_map(|| {
            let direct = (unfolded > 0).then(|| direct_light(model, unfolded, [shift[0], shift[1]]));
            face.light(&deposits, sent, direct)
        }))
    }

    /// Replicate `index` of the image, from a map: radiance in W/(m^2 sr), row-major.
    ///
    /// # Errors
    /// As [`Self::replicate`].
    pub fn mapped(
        &mut self,
        index: u32,
        work: Work,
        texels: &[[f64; 4]],
        observe: &mut Observer,
    ) -> Result<Vec<f64>, TraceError> {
        self.backend.set_exitance(texels)?;
        self.camera(CameraMode::Mapped, index, work.spp, observe)
    }

    /// Does something to maps, and books its time.
    pub fn at_map<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let done = work();
        self.totals.times.map += start.elapsed().as_secs_f64();
        done
    }

    /// Sends photons for the ledger alone.
    ///
    /// # Errors
    /// As [`Self::replicate`].
    pub fn ledger(&mut self, photons: u64, observe: &mut Observer) -> Result<(), TraceError> {
        self.photons(PhotonMode::Ledger, u32::MAX, photons, observe).map(|_| ())
    }

    fn camera(
        &mut self,
        mode: CameraMode,
        index: u32,
        spp: u32,
        observe: &mut Observer,
    ) -> Result<Vec<f64>, TraceError> {
        let begun = Instant::now();
        let pixels = self.model.camera.size[0] * self.model.camera.size[1];
        let seed = stream(self.seed, index, 0);
        self.backend.clear_film()?;
        let total = f64::from(pixels) * f64::from(spp);
        let (mut sample, mut pixel) = (0, 0);
        while sample < spp {
            let [count, samples] = chunk(self.pacer.camera as u64, pixels, pixel, spp - sample);
            let start = Instant::now();
            self.backend.camera(mode, seed, [pixel, count], [sample, samples])?;
            adapt(&mut self.pacer.camera, u64::from(count) * u64::from(samples), start.elapsed().as_secs_f64());
            pixel += count;
            if pixel >= pixels {
                pixel = 0;
                sample += samples;
            }
            let done = (f64::from(sample) * f64::from(pixels) + f64::from(pixel)) / total;
            if !observe(Stage { done, what: "camera paths" }) {
                return Err(TraceError::Stopped);
            }
        }
        let (sums, fates) = self.backend.read_film()?;
        held("pixels", &sums)?;
        self.totals.paths += u64::from(pixels) * u64::from(spp);
        self.totals.segments += fates.segments;
        self.totals.fates = self.totals.fates.and(fates);
        self.totals.times.camera += begun.elapsed().as_secs_f64();
        let unit = self.model.unit_radiance * self.model.surround_n * self.model.surround_n;
        let each = unit / f64::from(spp) / FILM_UNIT;
        Ok(sums.into_iter().map(|s| s as f64 * each).collect())
    }

    /// Returns the deposits in their units, and the photons that they stand for.
    fn photons(
        &mut self,
        mode: PhotonMode,
        index: u32,
        photons: u64,
        observe: &mut Observer,
    ) -> Result<(Vec<u64>, f64), TraceError> {
        let begun = Instant::now();
        let threads = photons.clamp(1, u64::from(THREADS)) as u32;
        let each = photons.div_ceil(u64::from(threads)).min(u64::from(u32::MAX)) as u32;
        let seed = stream(self.seed, index, 1);
        let before = self.kept.as_mut().filter(|_| mode == PhotonMode::Map).and_then(|kept| kept.remove(&index));
        let before = before.filter(|sent| sent.threads == threads && sent.each <= each);
        self.backend.clear_photons(mode)?;
        let mut sample = before.as_ref().map_or(0, |sent| sent.each);
        while sample < each {
            let pace = (self.pacer.photons as u64 / u64::from(threads)).max(1);
            let samples = pace.min(u64::from(THREAD_PHOTONS)).min(u64::from(each - sample)) as u32;
            let start = Instant::now();
            self.backend.photons(mode, seed, threads, [sample, samples])?;
            adapt(&mut self.pacer.photons, u64::from(threads) * u64::from(samples), start.elapsed().as_secs_f64());
            sample += samples;
            if !observe(Stage { done: f64::from(sample) / f64::from(each), what: "photons" }) {
                return Err(TraceError::Stopped);
            }
        }
        let (tally, deposits) = self.backend.read_photons(mode)?;
        self.totals.segments += tally[book::SEGMENTS].max(0) as u64;
        let sent = Sent { threads, each, tally, deposits };
        let sent = match before {
            Some(before) => before.and(&sent),
            None => sent,
        };
        if let (PhotonMode::Map, Some(kept)) = (mode, &mut self.kept) {
            kept.insert(index, sent.clone());
        }
        let Sent { tally, deposits, .. } = sent;
        held(if mode == PhotonMode::Splat { "pixels" } else { "cells of the map" }, &deposits)?;
        let sent = u64::from(threads) * u64::from(each);
        let emitted = tally[book::EMITTED] as f64 / UNIT;
        if emitted != sent as f64 {
            return Err(TraceError::CutShort { finished: emitted as u64, sent });
        }
        self.totals.photons += sent;
        self.totals.times.photons += begun.elapsed().as_secs_f64();
        if mode != PhotonMode::Ledger && Kernel::of(self.model).aimed {
            // They are not followed to their ends.
            self.totals.tally[book::LOST] += tally[book::LOST];
            return Ok((deposits, sent as f64 / self.model.aimed_share));
        }
        self.totals.tally.iter_mut().zip(tally).for_each(|(sum, v)| *sum += v);
        Ok((deposits, sent as f64))
    }
}

/// Refuses sums that are full: light is missing from them.
fn held(what: &'static str, sums: &[u64]) -> Result<(), TraceError> {
    let full = sums.iter().filter(|sum| **sum >> 32 == u64::from(u32::MAX)).count();
    if full == 0 { Ok(()) } else { Err(TraceError::Overflow { what, full, of: sums.len() }) }
}

/// Seed of a replicate's stream.
fn stream(seed: u32, replicate: u32, which: u32) -> u32 {
    pcg3d([seed, replicate, which])[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_that_is_full_stays_full_with_what_follows() {
        let sent = |each: u32, deposits: &[u64]| {
            let (mut tally, deposits) = ([0; book::SLOTS], deposits.to_vec());
            tally[book::EMITTED] = i64::from(each);
            Sent { threads: 4, each, tally, deposits }
        };
        let all = sent(2, &[7, u64::MAX - 1, u64::MAX]).and(&sent(5, &[5, 9, 0]));
        assert_eq!((all.each, all.tally[book::EMITTED]), (5, 7));
        assert_eq!(all.deposits, [12, u64::MAX, u64::MAX]);
        assert!(held("pixels", &all.deposits).is_err() && held("pixels", &all.deposits[..1]).is_ok());
    }

    #[test]
    fn chunks_cover_each_pixel_and_sample_once_however_the_pace_changes() {
        for pixels in [1, 7, 1000, MOST_PIXELS + 5] {
            for paces in [[1, 3], [500, 2 * u64::from(pixels)], [u64::from(pixels) - 1, 5 * u64::from(pixels)]] {
                let (spp, mut sample, mut pixel, mut traced) = (4, 0, 0, 0);
                let mut turn = paces.into_iter().cycle().map(|pace| pace.max(u64::from(pixels) / 9));
                while sample < spp {
                    let [count, samples] = chunk(turn.next().unwrap(), pixels, pixel, spp - sample);
                    assert!((1..=MOST_PIXELS).contains(&count) && pixel + count <= pixels, "{count} from {pixel}");
                    assert!(samples == 1 || (pixel == 0 && count == pixels), "{count} x {samples} from {pixel}");
                    traced += u64::from(count) * u64::from(samples);
                    pixel += count;
                    if pixel == pixels {
                        (pixel, sample) = (0, sample + samples);
                    }
                }
                assert_eq!(traced, u64::from(pixels) * u64::from(spp), "{pixels} pixels, {paces:?}");
                assert_eq!(sample, spp);
            }
        }
    }
}
