//! GPU against CPU twin, path by path.
//!
//! Both trace the same paths from the same random numbers, and their event histories must agree. Where two differ, the
//! twin is run again in Monte Carlo arithmetic: the difference is explained when other roundings of the same path take
//! the GPU's branch. An index that is off by 0.005 is not explained so.

use crate::adapter::require_gpu;
use crate::rounding::{Rounded, reseed};
use crate::scenes::{Case, presets, variants};
use rayon::prelude::*;
use tirtouch::scene::Walls;
use tirtouch::trace::Model;
use tirtouch::trace::backend::{CameraMode, PhotonMode};
use tirtouch::trace::cpu::camera::View;
use tirtouch::trace::cpu::{Event, Limits, Path};
use tirtouch::trace::gpu::GpuTracer;
use tirtouch::trace::model::Real;

/// 96 x 72 camera paths and as many photons a scene: 117,504 of each over 17 scenes.
const PIXELS: [u32; 2] = [96, 72];
const PATHS: u32 = PIXELS[0] * PIXELS[1];
const SEED: u32 = 20_260_807;
/// Words of one history on the GPU: the number of events, and the first of them.
const WORDS: usize = 64;
/// Runs of the twin with other roundings. A branch whose two sides lie within the rounding of both tracers is taken
/// either way in a few of ten; a chaotic path (a dent spreads rays) needs more.
const RUNS: u64 = 1024;
/// Share of the paths that may differ.
const DIFFERING: f64 = 1e-4;
/// Differences of a scene that are looked into; with more of them the share is too high anyway.
const LOOKED_INTO: usize = 16;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Camera,
    Photon,
}

/// A history as the GPU keeps it. Events after the end (the LED that a camera path found) follow uncounted.
fn row(events: &[Event]) -> [u32; WORDS] {
    let mut row = [0; WORDS];
    row[0] = events.iter().position(|e| e.code >= 1000).map_or(0, |end| end as u32 + 1);
    row[1..].iter_mut().zip(events).for_each(|(word, event)| *word = event.code);
    row
}

fn history<T: Real>(model: &Model<T>, kind: Kind, k: u32) -> Vec<Event> {
    let mut path = Path::new(model, Limits::default());
    path.events = Some(Vec::new());
    match kind {
        Kind::Camera => {
            path.camera_path(View { exitance: None, complement: false }, SEED, k, 0);
        }
        Kind::Photon => path.photon(SEED, k, 0),
    }
    path.events.unwrap_or_default()
}

fn gpu_rows(tracer: &mut GpuTracer, kind: Kind) -> Vec<[u32; WORDS]> {
    tracer.record_events(PATHS).unwrap();
    match kind {
        Kind::Camera => tracer.camera(CameraMode::Path, SEED, [0, PATHS], [0, 1]).unwrap(),
        Kind::Photon => tracer.photons(PhotonMode::Ledger, SEED, PATHS, [0, 1]).unwrap(),
    }
    let words = tracer.read_events().unwrap();
    words.chunks_exact(WORDS).map(|row| row.try_into().unwrap()).collect()
}

/// Whether other roundings take the other tracer's branch at the first difference, word `at`. Where only the number of
/// events differs (0), the branch lies beyond the words kept: there other roundings must change the number too.
fn explained(model: &Model<Rounded>, kind: Kind, k: u32, [own, other]: [&[u32; WORDS]; 2], at: usize) -> bool {
    (0..RUNS).any(|run| {
        reseed(u64::from(k) << 32 | run);
        let again = row(&history(model, kind, k));
        if at == 0 { again[1..] == own[1..] && again[0] != own[0] } else { again[1..=at] == other[1..=at] }
    })
}

#[derive(Default, Debug)]
struct Findings {
    paths: usize,
    events: usize,
    differing: usize,
    /// The first of them, and whether rounding explains each.
    differences: Vec<(String, bool)>,
}

impl Findings {
    fn unexplained(&self) -> usize {
        self.differences.iter().filter(|(_, explained)| !explained).count()
    }

    fn add(&mut self, other: Self) {
        self.paths += other.paths;
        self.events += other.events;
        self.differing += other.differing;
        self.differences.extend(other.differences);
    }

    fn share(&self) -> f64 {
        self.differing as f64 / self.paths as f64
    }
}

/// Histories of the twin against those of another tracer, and the reasons where they differ.
fn judge(twin: &Model<f64>, kind: Kind, rows: &[[u32; WORDS]]) -> Findings {
    let (exact, rounded) = (twin.cast::<f32>(), twin.cast::<Rounded>());
    let histories: Vec<_> = (0..PATHS).into_par_iter().map(|k| history(&exact, kind, k)).collect();
    let pairs = (0..).zip(histories.iter().zip(rows));
    let differing: Vec<_> = pairs.filter(|(_, (events, other))| row(events) != **other).collect();
    let reason = |(path, (events, other)): &(u32, (&Vec<Event>, &[u32; WORDS]))| {
        let own = row(events);
        let at = (1..WORDS).find(|&at| own[at] != other[at]).unwrap_or(0);
        let margin = at.checked_sub(1).and_then(|k| events.get(k)).map_or(f64::NAN, |e| e.margin);
        let what = format!("{kind:?} {path}, event {at}: {} and {}, margin {margin:.1e}", own[at], other[at]);
        (what, explained(&rounded, kind, *path, [&own, other], at))
    };
    Findings {
        paths: histories.len(),
        events: histories.iter().map(Vec::len).sum(),
        differing: differing.len(),
        differences: differing.par_iter().take(LOOKED_INTO).map(reason).collect(),
    }
}

/// Histories of a GPU's model against those of a twin's.
fn compare(tracer: &mut GpuTracer, twin: &Model<f64>) -> Findings {
    let mut findings = Findings::default();
    for kind in [Kind::Camera, Kind::Photon] {
        findings.add(judge(twin, kind, &gpu_rows(tracer, kind)));
    }
    findings
}

/// Histories of the twin in f64 against its own in f32.
fn compare_f64(model: &Model<f64>) -> Findings {
    let mut findings = Findings::default();
    for kind in [Kind::Camera, Kind::Photon] {
        let rows: Vec<_> = (0..PATHS).into_par_iter().map(|k| row(&history(model, kind, k))).collect();
        findings.add(judge(model, kind, &rows));
    }
    findings
}

/// All scenes, by whatever traces them: few paths may differ, and each by rounding.
fn few_differ_and_by_rounding(mut trace: impl FnMut(&Model<f64>) -> Option<Findings>) {
    let mut all = Findings::default();
    for case in presets().iter().chain(&variants()) {
        let Some(found) = trace(&case.model(PIXELS)) else { return };
        println!("{}: {} events, {} differ: {:?}", case.name, found.events, found.differing, found.differences);
        assert_eq!(found.unexplained(), 0, "{}: rounding does not explain {:?}", case.name, found.differences);
        all.add(found);
    }
    println!("{} paths, {} events, {:.1e} of the paths differ", all.paths, all.events, all.share());
    assert!(all.share() <= DIFFERING, "{:.1e} of the paths differ", all.share());
}

#[test]
fn gpu_and_twin_take_the_same_branches() {
    few_differ_and_by_rounding(|model| Some(compare(&mut GpuTracer::on(require_gpu()?, model).unwrap(), model)));
}

#[test]
fn f32_and_f64_twins_part_only_where_other_roundings_do() {
    few_differ_and_by_rounding(|model| Some(compare_f64(model)));
}

#[test]
fn where_rays_are_chaotic_rounding_explains_every_difference() {
    let mut case = Case::preset("dent-cap");
    case.loaded.scene.stack.walls = Walls::Mirror { reflectance: 0.97 };
    let model = case.model(PIXELS);
    // A dent between mirrors doubles the distance of two rays at every few bounces: about one path in a hundred parts.
    let found = compare_f64(&model);
    println!("f64: {} differ, {:?}", found.differing, found.differences);
    assert!(found.differing > 30, "{}", found.differing);
    assert_eq!(found.unexplained(), 0, "{:?}", found.differences);
    let Some(gpu) = require_gpu() else { return };
    let found = compare(&mut GpuTracer::on(gpu, &model).unwrap(), &model);
    println!("gpu: {} differ, {:?}", found.differing, found.differences);
    assert_eq!(found.unexplained(), 0, "{:?}", found.differences);
}

#[test]
fn an_index_off_by_0_005_is_a_difference_that_rounding_does_not_explain() {
    let Some(gpu) = require_gpu() else { return };
    let case = Case::preset("flat-bonded");
    let mut faulty = Case::preset("flat-bonded");
    faulty.loaded.scene.stack.layer[2].n = Some(1.395);
    let mut tracer = GpuTracer::on(gpu, &faulty.model(PIXELS)).unwrap();
    let found = compare(&mut tracer, &case.model(PIXELS));
    assert!(found.share() > DIFFERING, "{:.1e}", found.share());
    assert!(found.unexplained() > 0, "{:?}", found.differences);
}
