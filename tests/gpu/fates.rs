//! Camera paths that a surface loses or the cap cuts off are counted, and an image without their light is refused.

use crate::adapter::require_gpu;
use crate::scenes::Case;
use tirtouch::scene::Tissue;
use tirtouch::trace::backend::CpuTracer;
use tirtouch::trace::batch::{Batch, Totals, Work};
use tirtouch::trace::cpu::{Limits, book};
use tirtouch::trace::gpu::GpuTracer;
use tirtouch::trace::gpu::assemble::{Entry, source};
use tirtouch::trace::model::Real;
use tirtouch::trace::modes::PhotonMode;
use tirtouch::trace::render::accepted;
use tirtouch::trace::{Backend, Integrator, Model, TraceError};

const PIXELS: [u32; 2] = [24, 18];
const WORK: Work = Work { spp: 8, photons: 1 << 14 };

fn twin<T: Real>(model: &Model<f64>, limits: Limits) -> Box<CpuTracer<T>> {
    Box::new(CpuTracer::new(model.cast()).with_limits(limits))
}

/// The GPU, where there is one, and the twin in both precisions.
fn backends(model: &Model<f64>, limits: Limits) -> impl Iterator<Item = Backend> {
    let gpu = require_gpu().map(|gpu| GpuTracer::on(gpu, model).unwrap().with_limits(limits).into());
    gpu.into_iter().chain([Backend::Cpu32(twin(model, limits)), Backend::Cpu64(twin(model, limits))])
}

/// Camera paths alone of a scene by an integrator. Its photons are taken out of the sums: they have their own counts.
fn camera_paths(model: &Model<f64>, integrator: Integrator, backend: &mut Backend) -> Totals {
    let mut batch = Batch::new(model, backend, integrator, 1);
    batch.replicate(0, WORK, &mut |_| true).unwrap();
    Totals { photons: 0, tally: [0; _], ..batch.totals }
}

#[test]
fn an_image_whose_camera_paths_got_lost_is_refused() {
    // Two steps of the search on a height field are too few for most rays.
    let lossy = Limits { search_steps: 2, ..Limits::default() };
    for (name, integrator) in
        [("gaussian-dent", Integrator::Path), ("height-map", Integrator::Path), ("dent-contact", Integrator::Map)]
    {
        let model = Case::named(name).model(PIXELS);
        for mut backend in backends(&model, lossy) {
            let totals = camera_paths(&model, integrator, &mut backend);
            let lost = totals.fates.lost;
            println!("{name}, {}: {lost} of {} camera paths lost", backend.name(), totals.paths);
            assert!(lost > totals.paths / 100 && lost < totals.paths, "{name}, {}: {lost}", backend.name());
            let found = accepted(&totals);
            assert!(
                matches!(found, Err(TraceError::Lost { what: "camera paths", lost: l, .. }) if l == lost),
                "{found:?}"
            );
        }
    }
}

#[test]
fn an_image_whose_camera_paths_were_cut_off_is_refused() {
    let short = Limits { event_cap: 4, ..Limits::default() };
    for (name, integrator) in
        [("flat-bonded", Integrator::Path), ("contact-disc", Integrator::Map), ("contact-disc", Integrator::Splat)]
    {
        let model = Case::named(name).model(PIXELS);
        let mut shares = Vec::new();
        for mut backend in backends(&model, short) {
            let totals = camera_paths(&model, integrator, &mut backend);
            let share = totals.paths_cut_off();
            println!("{name} by {}, {}: {share:.4} of the weight cut off", integrator.name(), backend.name());
            assert!((1e-3..1.0).contains(&share), "{name} by {}, {}: {share}", integrator.name(), backend.name());
            let found = accepted(&totals);
            assert!(matches!(found, Err(TraceError::Truncated { share: s, .. }) if s == share), "{found:?}");
            shares.push(share);
        }
        // The same paths by three tracers: a few of 3,456 may part by rounding, and weights round to 2^-20.
        assert!(shares.iter().all(|s| (s / shares[0] - 1.0).abs() < 2e-3), "{name}: {shares:?}");
    }
}

#[test]
fn no_camera_path_of_an_accepted_image_is_lost_or_cut_off() {
    for (name, integrator) in [("gaussian-dent", Integrator::Path), ("mirror-walls", Integrator::Map)] {
        let model = Case::named(name).model(PIXELS);
        for mut backend in backends(&model, Limits::default()) {
            let totals = camera_paths(&model, integrator, &mut backend);
            assert_eq!((totals.fates.lost, totals.fates.cut_off), (0, 0), "{name}, {}", backend.name());
            assert!(totals.fates.segments > totals.paths && accepted(&totals).is_ok());
        }
    }
}

/// Clear walls hold light that goes like a cube's diagonal. It comes out of them, if it is let: a share of roulette at
/// each interaction makes what is left thousands of times heavier.
#[test]
fn photons_that_walls_hold_for_long_stay_as_heavy_as_they_were() {
    let model = pressed_on_lambertian_tissue();
    let played = |limits: Limits| {
        let mut backend = Backend::Cpu32(twin(&model, limits));
        let mut batch = Batch::new(&model, &mut backend, Integrator::Map, 1);
        batch.ledger(1 << 19, &mut |_| true).unwrap();
        batch.totals.tally[book::ROULETTE]
    };
    // What splits photons is booked as roulette's too.
    let early = Limits { roulette_start: 256, ..Limits::whole() };
    let found = [early, Limits::whole()].map(played);
    assert!(found[0] != 0 && found[1] == 0, "{found:?}");
}

/// Tissue that sends back by Lambert's law weighs nothing: what is booked as roulette's is roulette's and splitting's.
fn pressed_on_lambertian_tissue() -> Model<f64> {
    let mut case = Case::named("pressed");
    let tissue = &mut case.loaded.scene.touch.contact.as_mut().unwrap().tissue;
    *tissue =
        Tissue { reduced_scattering_per_mm: None, absorption_per_mm: None, diffuse_reflectance: Some(0.8), ..*tissue };
    case.model(PIXELS)
}

/// What splitting takes is nothing on average. It is something where a part keeps the weight of the whole.
#[test]
fn parts_of_a_photon_weigh_together_what_it_did() {
    let model = pressed_on_lambertian_tissue();
    // Mean over its standard error, of groups of photons.
    let taken = |right: &'static str, wrong: &'static str| {
        assert!(source(&model.cast(), Entry::Photons(PhotonMode::Ledger), false).0.contains(right));
        let edit = move |_, text: String| text.replace(right, wrong);
        let mut backend: Backend = GpuTracer::with_source(require_gpu()?, &model, Box::new(edit)).unwrap().into();
        let group = |seed| {
            let mut batch = Batch::new(&model, &mut backend, Integrator::Map, seed);
            batch.ledger(1 << 13, &mut |_| true).unwrap();
            batch.totals.tally[book::ROULETTE] as f64
        };
        let groups: Vec<f64> = (0..32).map(group).collect();
        let (n, mean) = (groups.len() as f64, groups.iter().sum::<f64>() / groups.len() as f64);
        let variance = groups.iter().map(|taken| (taken - mean).powi(2)).sum::<f64>() / (n - 1.0);
        Some(mean / (variance / n).sqrt())
    };
    let (mirrored, entered) = ("path.weight = r * before;", "path.weight = max(entered, ENTERED);");
    let Some(sound) = taken(mirrored, mirrored) else { return };
    assert!(sound.abs() < 4.0, "{sound}");
    for part in [mirrored, entered] {
        let faulty = taken(part, "path.weight = before;").unwrap();
        assert!(faulty.abs() > 20.0, "{part} {faulty}");
    }
}
