//! Trouble with the device: lost in the middle, or asked for more than it has.

use crate::adapter::require_gpu;
use crate::films::gpu;
use crate::scenes::Case;
use std::sync::Arc;
use tirtouch::trace::backend::{BackendChoice, Precision};
use tirtouch::trace::batch::{Batch, Totals, Work};
use tirtouch::trace::gpu::{Gpu, GpuTracer};
use tirtouch::trace::plan::Integrator;
use tirtouch::trace::{Backend, Devices, Model, Settings, TraceError, render};

/// Resident memory of this process, bytes; none where the system does not say.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| 1024 * kib)
}

#[test]
fn a_device_lost_in_the_middle_of_a_render_is_an_error() {
    for integrator in [Integrator::Path, Integrator::Map, Integrator::Splat] {
        let Some(adapter) = require_gpu() else { return };
        let model = Case::preset("contact-disc").model([32, 24]);
        let device = adapter.device.clone();
        let mut backend = gpu(adapter, &model);
        let mut batch = Batch::new(&model, &mut backend, integrator, 1);
        let mut chunks = 0;
        let found = batch.replicate(0, Work { spp: 1 << 20, photons: 1 << 16 }, &mut |_| {
            chunks += 1;
            if chunks == 2 {
                device.destroy();
            }
            true
        });
        assert!(matches!(found, Err(TraceError::DeviceLost(_))), "{}: {found:?}", integrator.name());
        assert_eq!(chunks, 2, "{}: it went on after the loss", integrator.name());
        // And it stays lost.
        let again = batch.replicate(1, Work { spp: 1, photons: 1 << 14 }, &mut |_| true);
        assert!(matches!(again, Err(TraceError::DeviceLost(_))), "{again:?}");
    }
}

#[test]
fn what_is_prepared_is_all_that_a_replicate_needs_on_one_device_and_on_two() {
    fn kernels(backend: &Backend) -> [usize; 2] {
        match backend {
            Backend::Gpu { camera, photons } => [camera.kernels(), photons.as_ref().map_or(0, |p| p.kernels())],
            _ => [0, 0],
        }
    }
    for integrator in [Integrator::Path, Integrator::Map, Integrator::Splat] {
        let Some(adapter) = require_gpu() else { return };
        let model = Case::preset("contact-disc").model([32, 24]);
        let both = Devices::open(BackendChoice::Gpu, Precision::F32).unwrap().load(&model).unwrap();
        let films = [(gpu(adapter, &model), [2, 0]), (both, [1, 1])].map(|(mut backend, expected)| {
            backend.prepare(integrator).unwrap();
            assert_eq!(kernels(&backend), expected, "{}", integrator.name());
            let mut batch = Batch::new(&model, &mut backend, integrator, 1);
            let film = batch.replicate(0, Work { spp: 2, photons: 1 << 16 }, &mut |_| true).unwrap();
            if integrator == Integrator::Path {
                batch.ledger(1 << 16, &mut |_| true).unwrap();
            }
            assert_eq!(kernels(&backend), expected, "{}: built in the middle of a render", integrator.name());
            film
        });
        assert!(films[0].iter().any(|&v| v > 0.0));
        assert_eq!(films[0], films[1], "{}: one device and two", integrator.name());
    }
}

#[test]
fn photons_that_follow_kept_ones_make_the_image_of_all_of_them() {
    for preset in ["contact-disc", "press-hertz"] {
        let Some(adapter) = require_gpu() else { return };
        let model = Case::preset(preset).model([32, 24]);
        let mut backend = gpu(adapter, &model);
        let few = Work { spp: 2, photons: 1 << 16 };
        let many = Work { photons: 5 << 16, ..few };
        let traced = |batch: &mut Batch, work: Work| {
            batch.totals = Totals::default();
            (batch.replicate(3, work, &mut |_| true).unwrap(), batch.totals)
        };
        let (all, whole) = traced(&mut Batch::new(&model, &mut backend, Integrator::Map, 1), many);
        let mut batch = Batch::new(&model, &mut backend, Integrator::Map, 1).keeping();
        let (first, part) = traced(&mut batch, few);
        let (kept, rest) = traced(&mut batch, many);
        assert!(first != all && kept == all, "{preset}");
        assert_eq!((rest.photons, rest.ledger(), rest.fates), (whole.photons, whole.ledger(), whole.fates), "{preset}");
        // Camera paths are traced each time, photons once.
        assert_eq!(part.segments + rest.segments, whole.segments + part.fates.segments, "{preset}");
        // Fewer are not a part of what is kept.
        assert_eq!(traced(&mut batch, few).0, first, "{preset}");
    }
}

#[test]
fn an_image_to_an_asked_error_is_that_of_its_samples_at_once() {
    if require_gpu().is_none() {
        return;
    }
    let case = Case::preset("press-hertz");
    let model = case.model([128, 96]);
    let devices = Devices::open(BackendChoice::Gpu, Precision::F32).unwrap();
    let own = Settings { seed: 3, spp: 16, photons: Some(1 << 19), ..Settings::of(&case.loaded.scene.render) };
    let least = render(&devices, &model, &own, &mut |_| true).unwrap();
    let target = 0.6 * least.relative_error.unwrap();
    let asked = Settings { target_error: Some(target), ..own.clone() };
    let found = render(&devices, &model, &asked, &mut |_| true).unwrap();
    assert!(found.relative_error.unwrap() <= target && found.photons > 2 * least.photons);
    // Of 47 samples there are 24 replicates of two, 48 in all.
    let spp = u32::try_from(found.spp).unwrap();
    let at_once = [spp, spp - 1].map(|spp| {
        let samples = Settings { spp, photons: Some(found.photons), ..own.clone() };
        render(&devices, &model, &samples, &mut |_| true).unwrap()
    });
    let same = at_once.iter().find(|outcome| outcome.film.replicates == found.film.replicates).unwrap();
    assert_eq!(same.film.mean, found.film.mean);
    assert_eq!((same.film.variance.clone(), same.ledger), (found.film.variance.clone(), found.ledger));
    // Attempts share photons: all of the last one's segments and the camera paths of those before.
    let traced = found.segments - same.segments;
    assert!(traced < least.segments, "{} for {} and {}", found.segments, same.segments, least.segments);
}

#[test]
fn a_film_larger_than_the_device_allows_is_refused_before_anything_is_allocated() {
    let Some(adapter) = require_gpu() else { return };
    let model = Case::preset("contact-disc").model([65_535, 65_535]);
    let before = resident();
    match GpuTracer::on(adapter, &model).map(|_| ()) {
        Err(TraceError::Memory { what, needed, allowed }) => {
            assert_eq!((what, needed), ("film", 16 * 65_535 * 65_535));
            assert!(needed > allowed);
        }
        other => panic!("{other:?}"),
    }
    if let (Some(before), Some(after)) = (before, resident()) {
        // The other buffers of this scene are some kilobytes; other tests run beside this one.
        assert!(after.saturating_sub(before) < 1 << 30, "{before} -> {after}");
    }
}

#[test]
fn a_map_larger_than_the_device_allows_is_refused() {
    let Some(adapter) = require_gpu() else { return };
    let mut model = Case::preset("contact-disc").model([8, 6]);
    model.map_size = [65_535, 65_535];
    let mut backend = gpu(adapter, &model);
    let found = backend.clear_photons(tirtouch::trace::modes::PhotonMode::Map);
    assert!(matches!(found, Err(TraceError::Memory { what: "photon deposits", .. })), "{found:?}");
}

/// What a device keeps of one scene (its kernels) must not show in the next.
#[test]
fn a_scene_after_another_of_its_make_takes_its_kernels_and_nothing_else() {
    let Some(adapter) = require_gpu() else { return };
    let adapter = Arc::new(adapter);
    let [first, second] = [1.0, 1.2].map(|factor| {
        let mut case = Case::preset("contact-disc");
        case.loaded.scene.stack.layer[0].thickness_mm *= factor;
        case.model([32, 24])
    });
    let film = |gpu: Arc<Gpu>, model: &Model<f64>| {
        let mut backend = GpuTracer::on(gpu, model).unwrap().into();
        let mut batch = Batch::new(model, &mut backend, Integrator::Map, 1);
        batch.replicate(0, Work { spp: 2, photons: 1 << 16 }, &mut |_| true).unwrap()
    };
    let before = film(adapter.clone(), &first);
    let kernels = adapter.kernels();
    let warm = film(adapter.clone(), &second);
    assert_eq!(adapter.kernels(), kernels);
    let Some(fresh) = require_gpu() else { return };
    assert_eq!(warm, film(Arc::new(fresh), &second));
    assert_ne!(warm, before);
    assert_eq!(before, film(adapter, &first));
}
