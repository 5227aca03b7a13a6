//! Films of all backends against each other, by their variances.

use crate::adapter::require_gpu;
use crate::scenes::{Case, at_once, presets, variants};
use tirtouch::film::{BlockAccumulator, Comparison, Film, compare};
use tirtouch::scene::IntegratorChoice;
use tirtouch::trace::backend::CpuTracer;
use tirtouch::trace::batch::{Batch, Work};
use tirtouch::trace::cpu::Limits;
use tirtouch::trace::exitance::TouchedFace;
use tirtouch::trace::gpu::GpuTracer;
use tirtouch::trace::plan::Integrator;
use tirtouch::trace::render::REPLICATES;
use tirtouch::trace::symmetry::Symmetry;
use tirtouch::trace::{Backend, Kernel, Model, Plan};

/// Chance of a false alarm over all films together.
const LEVEL: f64 = 1e-3;

pub fn gpu(gpu: tirtouch::trace::gpu::Gpu, model: &Model<f64>) -> Backend {
    GpuTracer::on(gpu, model).unwrap().into()
}

pub fn f64_twin(model: &Model<f64>) -> Backend {
    Backend::Cpu64(Box::new(CpuTracer::new(model.clone())))
}

/// The twin in f64 whose photons go one way each.
fn whole_twin(model: &Model<f64>) -> Backend {
    Backend::Cpu64(Box::new(CpuTracer::new(model.clone()).with_limits(Limits::whole())))
}

/// A film of 16 replicates of `work` each; no pilot and no ledger, which `render` adds.
pub fn film(mut backend: Backend, model: &Model<f64>, integrator: Integrator, seed: u32, work: Work) -> Film {
    let [columns, rows] = model.camera.size;
    let mut sum = BlockAccumulator::new(columns, rows);
    let mut batch = Batch::new(model, &mut backend, integrator, seed);
    let maps = if integrator == Integrator::Map { smoothed_maps(&mut batch, work) } else { Vec::new() };
    for index in 0..REPLICATES {
        let replicate = match maps.get(index as usize) {
            Some(texels) => batch.mapped(index, work, texels, &mut |_| true),
            None => batch.replicate(index, work, &mut |_| true),
        };
        sum.add(&replicate.unwrap()).unwrap();
    }
    assert_eq!((batch.totals.lost(), batch.totals.fates.lost), (0, 0));
    Film { samples: work.spp * REPLICATES, ..sum.finish() }
}

/// The maps of all replicates, smoothed as `render` does.
fn smoothed_maps(batch: &mut Batch, work: Work) -> Vec<Vec<[f64; 4]>> {
    let face = TouchedFace::new(batch.model);
    let lights: Vec<_> = (0..REPLICATES).map(|k| batch.contact_light(k, work, &face, &mut |_| true).unwrap()).collect();
    let smoothing = face.choose(&lights);
    println!("{smoothing:?}");
    face.texels(&lights, smoothing)
}

/// The tests that failed, for a message.
pub fn failed(found: &Comparison) -> String {
    let failed: Vec<_> = found.tests.iter().filter(|t| !t.passed).collect();
    format!("ratio {:?}, {failed:?}", found.ratio)
}

fn against_f64(case: &Case, twin: &Case, integrator: Integrator, level: f64) -> Option<Comparison> {
    let adapter = require_gpu()?;
    let size = [48, 36];
    let work = Work { spp: 1, photons: 1 << 12 };
    // The reference splits no photon and takes no place for another's mirror image.
    let (model, reference) = (case.model(size), Model { symmetry: Symmetry::none(), ..twin.model(size) });
    let a = film(gpu(adapter, &model), &model, integrator, 1, work);
    let b = film(whole_twin(&reference), &reference, integrator, 2, work);
    Some(compare(&a, &b, level).unwrap())
}

/// Presets that the stored images hold, or that are dark: the golden test renders them in f32 against f64 as well.
const STORED: [&str; 5] = ["tsis-paper", "tsis-literature", "dent-cap", "rough", "absorbing"];

#[test]
fn gpu_films_agree_with_those_of_the_twin_in_f64() {
    let all = presets().into_iter().chain(variants());
    let cases: Vec<Case> = all.filter(|case| !STORED.contains(&case.name.as_str())).collect();
    let mut jobs: Vec<(&Case, Integrator)> = Vec::new();
    for case in &cases {
        let kernel = Kernel::of(&case.model([4, 3]));
        jobs.push((case, Plan::choose(IntegratorChoice::Auto, &kernel).unwrap().integrator));
        if Plan::choose(IntegratorChoice::Splat, &kernel).is_ok() {
            jobs.push((case, Integrator::Splat));
        }
    }
    let level = LEVEL / jobs.len() as f64;
    let found = at_once(&jobs, |(case, integrator)| against_f64(case, case, *integrator, level));
    for ((case, integrator), found) in jobs.iter().zip(found) {
        let Some(found) = found else { return };
        println!("{} by {}: ratio {:?}", case.name, integrator.name(), found.ratio);
        assert!(found.passed, "{} by {}: {}", case.name, integrator.name(), failed(&found));
    }
}

/// One LED of four is brighter, and its light is taken for that of the one that it faces.
#[test]
fn a_symmetry_that_there_is_none_is_found() {
    let mut case = Case::preset("contact-disc");
    let (work, size) = (Work { spp: 1, photons: 1 << 12 }, [48, 36]);
    let all = case.model(size).symmetry;
    case.loaded.scene.led[0].radiance_w_per_m2_sr = Some(1.5);
    let right = case.model(size);
    assert_eq!((all.order(), right.symmetry.order()), (4, 2));
    let reference = Model { symmetry: Symmetry::none(), ..right.clone() };
    let reference = film(f64_twin(&reference), &reference, Integrator::Map, 2, work);
    let wrong = Model { symmetry: all, ..right.clone() };
    for (model, same) in [(right, true), (wrong, false)] {
        let Some(adapter) = require_gpu() else { return };
        let found = compare(&film(gpu(adapter, &model), &model, Integrator::Map, 1, work), &reference, LEVEL).unwrap();
        assert_eq!(found.passed, same, "{}", failed(&found));
    }
}

#[test]
fn tissue_a_tenth_brighter_is_found() {
    let (mut brighter, case) = (Case::named("mirror-walls"), Case::named("mirror-walls"));
    if let Some(contact) = &mut brighter.loaded.scene.touch.contact {
        contact.tissue.diffuse_reflectance = Some(0.55);
    }
    for integrator in [Integrator::Map, Integrator::Splat] {
        let Some(found) = against_f64(&brighter, &case, integrator, LEVEL) else { return };
        assert!(!found.passed, "{}: {:?}", integrator.name(), found.ratio);
    }
}
