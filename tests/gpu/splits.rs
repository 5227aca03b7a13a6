//! The same seed gives the same bits, however the work is cut into chunks.

use crate::adapter::require_gpu;
use crate::films::{f64_twin, gpu};
use crate::scenes::Case;
use tirtouch::trace::backend::CpuTracer;
use tirtouch::trace::gpu::GpuTracer;
use tirtouch::trace::gpu::tracer::{Portion, SourceEdit};
use tirtouch::trace::modes::{CameraMode, Fates, PhotonMode};
use tirtouch::trace::{Backend, Model};

const SIZE: [u32; 2] = [24, 18];
const PIXELS: u32 = SIZE[0] * SIZE[1];
/// Pixels and samples of each chunk: all at once, and cut both ways in a mixed order.
const WHOLE: &[[[u32; 2]; 2]] = &[[[0, PIXELS], [0, 8]]];
const CUT: &[[[u32; 2]; 2]] =
    &[[[100, PIXELS - 100], [3, 5]], [[0, 100], [0, 1]], [[0, 100], [1, 7]], [[100, PIXELS - 100], [0, 3]]];

fn camera(backend: &mut Backend, seed: u32, chunks: &[[[u32; 2]; 2]]) -> (Vec<u64>, Fates) {
    backend.clear_film().unwrap();
    for &[pixels, samples] in chunks {
        backend.camera(CameraMode::Path, seed, pixels, samples).unwrap();
    }
    backend.read_film().unwrap()
}

fn photons(backend: &mut Backend, mode: PhotonMode, seed: u32, chunks: &[[u32; 2]]) -> (Vec<i64>, Vec<u64>) {
    backend.clear_photons(mode).unwrap();
    for &samples in chunks {
        backend.photons(mode, seed, 512, samples).unwrap();
    }
    let (tally, deposits) = backend.read_photons(mode).unwrap();
    (tally.to_vec(), deposits)
}

fn splits_change_nothing(mut backend: Backend, deformed: bool) {
    let backend = &mut backend;
    let whole = camera(backend, 5, WHOLE);
    assert!(whole.0.iter().any(|&v| v > 0), "{}: no light", backend.name());
    assert_ne!(camera(backend, 6, WHOLE), whole, "{}: another seed gave the same film", backend.name());
    assert_eq!(camera(backend, 5, CUT), whole, "{}: camera paths", backend.name());
    let splat = (!deformed).then_some(PhotonMode::Splat);
    for mode in [PhotonMode::Ledger, PhotonMode::Map].into_iter().chain(splat) {
        let whole = photons(backend, mode, 5, &[[0, 6]]);
        assert_ne!(photons(backend, mode, 6, &[[0, 6]]), whole);
        assert_eq!(photons(backend, mode, 5, &[[4, 2], [0, 1], [1, 3]]), whole, "{} {mode:?}", backend.name());
    }
}

fn scenes() -> Vec<(Model<f64>, bool)> {
    vec![(Case::named("contact-disc").model(SIZE), false), (Case::named("dent-contact").model(SIZE), true)]
}

#[test]
fn the_twin_gives_the_same_bits_however_the_work_is_cut() {
    for (model, deformed) in scenes() {
        splits_change_nothing(Backend::Cpu32(Box::new(CpuTracer::new(model.cast()))), deformed);
        splits_change_nothing(f64_twin(&model), deformed);
    }
}

#[test]
fn the_gpu_gives_the_same_bits_however_the_work_is_cut() {
    for (model, deformed) in scenes() {
        let Some(adapter) = require_gpu() else { return };
        splits_change_nothing(gpu(adapter, &model), deformed);
    }
}

/// Photons of a thread spread over five rows of threads, two and then one at a time: what a real GPU does.
#[test]
fn photons_are_the_same_however_many_threads_share_them() {
    let model = &scenes()[1].0;
    let spread = |edit: SourceEdit| -> Option<Backend> {
        let tracer = GpuTracer::with_source(require_gpu()?, model, edit).unwrap();
        Some(tracer.in_portions(Portion { paths: 2, threads: 5 * 512 + 100 }).into())
    };
    let Some(adapter) = require_gpu() else { return };
    let whole = photons(&mut gpu(adapter, model), PhotonMode::Map, 5, &[[0, 23]]);
    let Some(mut same) = spread(Box::new(|_, text| text)) else { return };
    assert_eq!(photons(&mut same, PhotonMode::Map, 5, &[[0, 23]]), whole);
    // All rows take the photons of the first.
    let taken = "run.first_sample + id.x / run.threads * run.samples";
    let Some(mut wrong) = spread(Box::new(move |_, text| {
        assert!(text.contains(taken));
        text.replace(taken, "run.first_sample")
    })) else {
        return;
    };
    assert_ne!(photons(&mut wrong, PhotonMode::Map, 5, &[[0, 23]]), whole);
}
