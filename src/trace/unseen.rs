//! What a render may have missed where it found no light.
//!
//! A sum of nothing has no spread, yet few paths prove little. Of N independent paths of which none found light, at
//! most 3/N find it in 95 % of such cases (e^-3 = 0.05: the rule of three), each at most the brightest light there is.
//! That is the brightest LED in a dark image, and in a lit one the largest single find: variance over mean of a pixel
//! is a find over the number of its paths. The variance stated for a pixel without light is that of a normal error
//! whose 95 % interval ends there.
//!
//! Over a whole image the same three finds bound all dark pixels together, not each of them: their sum is known much
//! better.
//!
//! Exactly dark is what geometry forbids: pixels that look past the stack; and all of an image of flat, smooth,
//! untouched layers whose LEDs send only light with s = n sin(theta) beyond that of the camera's rays. Between such
//! layers no path changes its s.

use super::kernel::{Kernel, ShapePiece};
use super::leds::Led;
use super::model::{Camera, Model};
use super::plan::Integrator;
use crate::film::Film;
use std::f64::consts::PI;

/// Largest expected number of finds of which none is seen in 5 % of all cases.
const NONE_SEEN: f64 = 3.0;
/// Most that rises in tissue over what enters it: what the boundary mirrors back rises again, 1 / (1 - R) with a
/// diffuse internal reflectance R of at most 0.6 up to an index of 1.5.
const RISEN: f64 = 2.5;
/// Half of a normal 95 % interval, standard deviations.
const NORMAL_95: f64 = 1.96;

/// Light that may be where none was found, radiances in W/(m^2 sr).
#[derive(Debug, Clone, PartialEq)]
pub struct Unseen {
    /// Why no light can reach the camera, where that is known.
    pub known_dark: Option<&'static str>,
    /// Of an image in which no path found light: what its mean is below with 95 % confidence.
    pub mean_below: Option<f64>,
    /// Variance of a pixel without light, unless it looks past the stack.
    pub pixel_variance: f64,
    /// Bound on the sum of all pixels without light.
    sum_below: f64,
    /// Pixels that look past the stack.
    beside: Vec<bool>,
}

/// What was traced.
#[derive(Debug, Clone, Copy)]
pub(super) struct Traced {
    pub integrator: Integrator,
    /// Camera paths a pixel.
    pub spp: u64,
    /// Photons of the image, without those of a ledger traced on its own.
    pub photons: u64,
}

impl Unseen {
    /// Bounds what a film may lack.
    pub(super) fn of(model: &Model<f64>, film: &Film, traced: Traced) -> Self {
        let beside = beside(&model.camera, model.half_size);
        let pixels = film.mean.len().max(1) as f64;
        let known_dark = known_dark(model);
        let brightest = brightest(model);
        let finds = NONE_SEEN / traced.spp.max(1) as f64;
        let dark = film.mean.iter().all(|&mean| mean == 0.0);
        let missed = || finds * brightest / pixels + missed_by_photons(model, traced, pixels);
        let mean_below = dark.then(|| if known_dark.is_some() { 0.0 } else { missed() });
        let (pixel, sum) = match (mean_below, known_dark) {
            (_, Some(_)) => (0.0, 0.0),
            (Some(mean), None) => {
                (finds * brightest + pixels * missed_by_photons(model, traced, pixels), mean * pixels)
            }
            (None, None) => {
                let find = film.mean.iter().zip(&film.variance).filter(|(mean, _)| **mean > 0.0);
                let find = find.map(|(&mean, &variance)| f64::from(variance) / f64::from(mean)).fold(0.0, f64::max);
                (NONE_SEEN * find, NONE_SEEN * find)
            }
        };
        let pixel_variance = (pixel.min(brightest) / NORMAL_95).powi(2);
        Self { known_dark, mean_below, pixel_variance, sum_below: sum.min(pixels * brightest), beside }
    }

    /// Variances of a film's pixels, with what stands for a pixel in which no path found light.
    pub fn variances(&self, film: &Film) -> Vec<f32> {
        let pixels = film.mean.iter().zip(&film.variance).zip(&self.beside);
        let stated = |((&mean, &variance), &beside): ((&f32, &f32), &bool)| match mean == 0.0 && !beside {
            true => variance.max(self.pixel_variance as f32),
            false => variance,
        };
        pixels.map(stated).collect()
    }

    /// Root-mean-square standard error over all pixels of a film.
    pub fn absolute_error(&self, film: &Film) -> f64 {
        let found: f64 = film.variance.iter().map(|&variance| f64::from(variance)).sum();
        let dark =
            film.mean.iter().zip(&self.beside).filter(|(mean, beside)| **mean == 0.0 && !**beside).count() as f64;
        // All that is missed may be in few pixels: as bright as one of them may be, in as many as that takes.
        let pixel = NORMAL_95 * self.pixel_variance.sqrt();
        let missed = if dark > 0.0 { pixel * self.sum_below.min(dark * pixel) / NORMAL_95.powi(2) } else { 0.0 };
        ((found + missed) / film.variance.len().max(1) as f64).sqrt()
    }
}

/// Largest radiance that the camera may see.
fn brightest(model: &Model<f64>) -> f64 {
    let n_0 = model.surround_n;
    let medium = |led: &Led<f64>| if led.air { n_0 } else { lowest_index(model) };
    let seen = |led: &Led<f64>| led.radiance * (n_0 / medium(led)).powi(2);
    model.unit_radiance * model.leds.iter().map(seen).fold(0.0, f64::max).max(1.0)
}

fn lowest_index(model: &Model<f64>) -> f64 {
    model.layers[1..model.layers.len() - 1].iter().map(|layer| layer.n).fold(f64::INFINITY, f64::min)
}

/// Mean radiance of tissue that no photon found lit: the flux that enters is at most 3 of so many photons, and rises
/// about as Lambert has it, seen by the whole image.
fn missed_by_photons(model: &Model<f64>, traced: Traced, pixels: f64) -> f64 {
    let Some(tissue) = model.tissue.as_ref().filter(|_| traced.integrator != Integrator::Path) else {
        return 0.0;
    };
    let flux = model.power * model.unit_radiance * model.aimed_share * NONE_SEEN / traced.photons.max(1) as f64;
    let n_0 = model.surround_n;
    let depth = |k: usize| (model.faces[k].z - model.faces[k - 1].z) * n_0 / model.layers[k].n;
    let distance = model.camera.distance + (1..model.faces.len()).map(depth).sum::<f64>();
    let area = pixels * (model.camera.pixel_tan * distance).powi(2);
    RISEN * flux * (n_0 / tissue.n).powi(2) / (PI * area)
}

/// Pixels whose rays pass the lowest face's outline, whatever the point of the lens.
fn beside(camera: &Camera<f64>, half_size: [f64; 2]) -> Vec<bool> {
    let blur = match camera.lens_radius > 0.0 && camera.focus > 0.0 {
        true => camera.lens_radius * (1.0 - camera.distance / camera.focus).abs(),
        false => 0.0,
    };
    let [columns, rows] = camera.size;
    // Nearest a pixel comes to the axis, along one side of the image; a thousandth less, for rounding.
    let out = |k: u32, count: u32, half: f64| {
        let from = f64::from(k) - 0.5 * f64::from(count);
        let nearest = if from >= 0.0 { from } else { (-from - 1.0).max(0.0) };
        nearest * camera.pixel_tan * camera.distance * 0.999 - blur >= half
    };
    let across: Vec<bool> = (0..columns).map(|k| out(k, columns, half_size[0])).collect();
    let down = (0..rows).map(|k| out(k, rows, half_size[1]));
    down.flat_map(|below| across.iter().map(move |aside| below || *aside).collect::<Vec<_>>()).collect()
}

/// Why no light can reach the camera.
fn known_dark(model: &Model<f64>) -> Option<&'static str> {
    let kernel = Kernel::of(model);
    if kernel.shape != ShapePiece::Plane || kernel.rough || kernel.touched {
        return None;
    }
    let camera = &model.camera;
    let [columns, rows] = camera.size.map(f64::from);
    let mut steepest = 0.5 * columns.hypot(rows) * camera.pixel_tan;
    if kernel.lens {
        steepest += camera.lens_radius / camera.focus;
    }
    let seen = model.surround_n * steepest / steepest.hypot(1.0);
    // A millionth for rounding: rays of f32 change their s by less.
    let guided = model.leds.iter().all(|led| least_s(model, led) > seen * (1.0 + 1e-6));
    guided.then_some("flat, smooth layers that nothing touches guide all light of the LEDs past what the camera sees")
}

/// Smallest s = n sin(theta) of light that an LED sends into the stack. The vertical part of its momentum is at most
/// that at the cut-off; behind a clear wall it stays what it was in the surround, and the rest of n grows sideways.
fn least_s(model: &Model<f64>, led: &Led<f64>) -> f64 {
    let n = lowest_index(model);
    let sin_sq = 1.0 - led.cos_cutoff * led.cos_cutoff;
    let medium = if led.air { model.surround_n } else { n };
    (n * n - medium * medium * sin_sq).max(0.0).sqrt()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::film::BlockAccumulator;
    use crate::scene::{LoadedScene, Mount, Walls, preset};
    use crate::trace::Backend;
    use crate::trace::backend::CpuTracer;
    use crate::trace::batch::{Batch, Work};

    fn model(loaded: &LoadedScene) -> Model<f64> {
        let shape = crate::surface::surface(loaded).unwrap();
        Model::new(loaded, &shape, crate::surface::contact_map(loaded).unwrap()).unwrap()
    }

    fn seen_by(name: &str, pixels: [u32; 2]) -> LoadedScene {
        let mut loaded = preset(name).unwrap();
        loaded.scene.camera.pixels = pixels;
        loaded
    }

    /// A film of camera paths alone: `spp` a pixel in each of 16 replicates.
    fn traced(model: &Model<f64>, seed: u32, spp: u32) -> (Film, Unseen) {
        let mut backend = Backend::Cpu32(Box::new(CpuTracer::new(model.cast())));
        let integrator = Integrator::Path;
        let mut batch = Batch::new(model, &mut backend, integrator, seed);
        let mut sum = BlockAccumulator::new(model.camera.size[0], model.camera.size[1]);
        for index in 0..16 {
            let image = batch.replicate(index, Work { spp, photons: 1 }, &mut |_| true).unwrap();
            sum.add(&image).unwrap();
        }
        let film = sum.finish();
        let unseen = Unseen::of(model, &film, Traced { integrator, spp: 16 * u64::from(spp), photons: 0 });
        (film, unseen)
    }

    /// Dark pixels of a lit film: what is stated covers what a long render finds there, in at least 95 % of all of
    /// them, and 0 does not. The bound of the whole holds for all of them together.
    #[test]
    fn light_that_was_missed_lies_within_what_is_stated() {
        let model = model(&seen_by("contact-disc", [8, 6]));
        let truth = traced(&model, 1000, 1024).0.mean;
        let (mut dark, mut beyond, mut dim, mut far) = (0.0, 0.0, 0.0, 0.0);
        let seeds = 200;
        for seed in 0..seeds {
            let (film, unseen) = traced(&model, seed, 2);
            let stated = unseen.variances(&film);
            let pixels = film.mean.iter().zip(&truth).zip(&stated);
            for ((_, &truth), &variance) in pixels.filter(|((mean, truth), _)| **mean == 0.0 && **truth > 0.0) {
                dark += 1.0;
                beyond += f64::from(u8::from(truth > 1.96 * variance.sqrt()));
                dim += f64::from(u8::from(variance > 0.0));
            }
            // Within three standard errors, all pixels together: three finds in one pixel are the worst case.
            let square = film.mean.iter().zip(&truth).map(|(m, t)| f64::from(m - t).powi(2)).sum::<f64>();
            far += f64::from(u8::from((square / 48.0).sqrt() > 3.0 * unseen.absolute_error(&film)));
        }
        println!(
            "{dark} dark pixels, {beyond} beyond what is stated; {far} of {seeds} images farther than three errors"
        );
        // 16 contributions make 5 % of thousands of pixels a bound with some to spare.
        assert!(dark > 1000.0 && dim == dark, "{dark} {dim}");
        assert!(beyond <= 0.05 * dark, "{beyond} of {dark}");
        assert!(far <= 0.05 * f64::from(seeds), "{far}");
    }

    /// A dozen paths in the dark prove little: the mean and the error hold the true light, and fall with the number of
    /// paths.
    #[test]
    fn a_film_without_light_is_bounded_by_the_brightest_led() {
        let model = model(&seen_by("contact-disc", [2, 2]));
        let truth = traced(&model, 1000, 4096).0.mean;
        let mean = truth.iter().map(|&v| f64::from(v)).sum::<f64>() / 4.0;
        let dark: Vec<_> = (0..60).map(|seed| traced(&model, seed, 1)).filter(|(f, _)| f.mean == [0.0; 4]).collect();
        assert!(dark.len() > 2 && mean > 0.0, "{}", dark.len());
        for (film, unseen) in &dark {
            // Three finds of the LEDs' radiance among 64 paths.
            let below = 3.0 / 64.0 * model.unit_radiance;
            assert!((unseen.mean_below.unwrap() / below - 1.0).abs() < 1e-12 && below > mean);
            // All in one of four pixels, as a standard error.
            let error = unseen.absolute_error(film);
            assert!((error / (3.0 / 16.0 * model.unit_radiance / 1.96 / 2.0) - 1.0).abs() < 1e-6, "{error}");
            assert!(unseen.variances(film).iter().zip(&truth).all(|(v, t)| 1.96 * v.sqrt() > *t));
            assert_eq!(unseen.known_dark, None);
        }
        let (film, _) = &dark[0];
        let bound = |spp| {
            Unseen::of(&model, film, Traced { integrator: Integrator::Path, spp, photons: 0 }).absolute_error(film)
        };
        assert!((bound(64) / bound(1024) - 16.0).abs() < 1e-6);
        // No pixel is brighter than an LED, however few the paths: of one path a pixel, three finds in three of four
        // pixels.
        assert!((bound(1) * 1.96 / model.unit_radiance - 0.75f64.sqrt()).abs() < 1e-6, "{}", bound(1));
        // Where photons gather the light, theirs adds to what camera paths leave open: three of one photon are more
        // than there is.
        let map = |photons| {
            Unseen::of(&model, film, Traced { integrator: Integrator::Map, spp: 1 << 20, photons }).mean_below
        };
        let paths = 3.0 / f64::from(4 << 20) * model.unit_radiance;
        let by_photons = |photons| map(photons).unwrap() - paths;
        assert!((by_photons(1) / by_photons(1 << 10) / 1024.0 - 1.0).abs() < 1e-6 && by_photons(1) > mean);
    }

    #[test]
    fn darkness_is_known_where_all_light_is_guided_and_nowhere_else() {
        let flat = seen_by("tsis-paper", [8, 6]);
        let (film, unseen) = traced(&model(&flat), 1, 64);
        assert!(film.mean.iter().all(|&v| v == 0.0) && unseen.known_dark.is_some());
        assert_eq!((unseen.absolute_error(&film), unseen.variances(&film)), (0.0, vec![0.0; 48]));
        // Light of bonded LEDs, of a wide cone or of a dented or touched face may get out.
        let mut bonded = flat.clone();
        bonded.scene.stack.walls = Walls::Black;
        bonded.scene.led.iter_mut().for_each(|led| (led.mount, led.cutoff_half_angle_deg) = (Mount::Bonded, None));
        for loaded in [bonded, seen_by("tsis-dent", [8, 6]), seen_by("contact-disc", [8, 6])] {
            assert_eq!(known_dark(&model(&loaded)), None, "{}", loaded.scene.name);
        }
        // A lower index lets more out: 1.1 guides only what is steeper than 27 degrees, and the camera sees 30 to 36.
        let mut low = flat;
        low.scene.stack.layer.iter_mut().for_each(|layer| layer.n = Some(1.1));
        assert_eq!(known_dark(&model(&low)), None);
    }

    #[test]
    fn pixels_past_the_stack_are_dark_for_certain_and_the_others_are_not() {
        let mut loaded = seen_by("contact-disc", [24, 18]);
        loaded.scene.camera.view_angle_deg = 120.0;
        let model = model(&loaded);
        let (film, unseen) = traced(&model, 1, 64);
        let variances = unseen.variances(&film);
        let past = unseen.beside.iter().filter(|past| **past).count();
        assert!(past > 24 && past < 24 * 18 / 2 * 2, "{past}");
        for ((&past, &mean), &variance) in unseen.beside.iter().zip(&film.mean).zip(&variances) {
            assert!(if past { mean == 0.0 && variance == 0.0 } else { variance > 0.0 });
        }
        // Brighter LEDs do not light them: no path of theirs starts.
        let (corner, middle) = (0, 9 * 24 + 12);
        assert!(unseen.beside[corner] && !unseen.beside[middle]);
    }
}
