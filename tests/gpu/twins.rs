//! GPU against CPU twin, path by path.
//!
//! Both trace the same paths from the same random numbers, and their event histories must agree: of every kind of
//! camera path and photon that a scene allows. So must the light that photons leave, cell by cell. Where two histories
//! differ, the twin is run again in Monte Carlo arithmetic: the difference is explained when other roundings of the
//! same path take the GPU's branch. An index that is off by 0.005 is not explained so.

use crate::adapter::require_gpu;
use crate::films::gpu;
use crate::rounding::{Rounded, reseed};
use crate::scenes::{Case, at_once, presets, variants};
use rayon::prelude::*;
use std::sync::atomic::AtomicU64;
use tirtouch::scene::{IntegratorChoice, Walls};
use tirtouch::trace::constants::{EVENT_END, EVENTS};
use tirtouch::trace::cpu::camera::View;
use tirtouch::trace::cpu::photons::Deposits;
use tirtouch::trace::cpu::{Event, Limits, Path};
use tirtouch::trace::gpu::assemble::{Entry, source};
use tirtouch::trace::gpu::{Gpu, GpuTracer};
use tirtouch::trace::model::Real;
use tirtouch::trace::modes::{CameraMode, PhotonMode};
use tirtouch::trace::{Backend, Kernel, Model, Plan};

/// 64 x 48 paths of each kind a scene.
const PIXELS: [u32; 2] = [64, 48];
const PATHS: u32 = PIXELS[0] * PIXELS[1];
const SEED: u32 = 20_260_807;
/// Words of one history on the GPU: the number of events, and the first of them.
const WORDS: usize = EVENTS as usize;
/// Runs of the twin with other roundings. A branch whose two sides lie within the rounding of both tracers is taken
/// either way in a few of ten; a chaotic path (a dent spreads rays) needs more.
const RUNS: u64 = 1024;
/// Share of the paths that may differ.
const DIFFERING: f64 = 1e-4;
/// Share of the light that photons may leave in other cells: a photon in a thousand within rounding of a border, or on
/// another way after a branch that rounding decides.
const LIGHT: f64 = 2e-3;
/// Differences of a scene that are looked into; with more of them the share is too high anyway.
const LOOKED_INTO: usize = 16;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Camera(CameraMode),
    Photon(PhotonMode),
}

/// The kinds of paths that a scene's methods send.
fn kinds(model: &Model<f64>) -> Vec<Kind> {
    let kernel = Kernel::of(model);
    let methods = [IntegratorChoice::Path, IntegratorChoice::Map, IntegratorChoice::Splat];
    let allowed = methods.into_iter().filter_map(|asked| Plan::choose(asked, &kernel).ok());
    allowed
        .flat_map(|plan| [Kind::Camera(plan.integrator.modes().0), Kind::Photon(plan.integrator.modes().1)])
        .collect()
}

/// A history as the GPU keeps it. Events after the end (the LED that a camera path found) follow uncounted.
fn row(events: &[Event]) -> [u32; WORDS] {
    let mut row = [0; WORDS];
    row[0] = events.iter().rposition(|e| e.code >= EVENT_END).map_or(0, |end| end as u32 + 1);
    row[1..].iter_mut().zip(events).for_each(|(word, event)| *word = event.code);
    row
}

/// A path of the twin: what happens to it, and what it leaves in `cells`.
fn history<T: Real>(model: &Model<T>, kind: Kind, k: u32, cells: &[AtomicU64]) -> Vec<Event> {
    let mut path = Path::new(model, Limits::default());
    path.events = Some(Vec::new());
    match kind {
        Kind::Camera(mode) => {
            // Which way a path goes does not depend on what the map holds.
            let texels = vec![[T::zero(); 4]; model.map_size[0] * model.map_size[1]];
            let exitance = (mode == CameraMode::Mapped).then_some(texels.as_slice());
            path.camera_path(View { exitance, complement: mode == CameraMode::Complement }, SEED, k, 0);
            path.events.unwrap_or_default()
        }
        Kind::Photon(mode) => {
            let deposits = Deposits { cells, splatted: mode == PhotonMode::Splat };
            path.deposits = (mode != PhotonMode::Ledger).then_some(&deposits);
            path.photon(SEED, k, 0);
            path.events.take().unwrap_or_default()
        }
    }
}

/// Histories of a GPU's paths, and what they leave.
fn gpu_rows(gpu: &mut Backend, model: &Model<f64>, kind: Kind) -> (Vec<[u32; WORDS]>, Vec<u64>) {
    let mut deposits = Vec::new();
    keep_events(gpu);
    match kind {
        Kind::Camera(mode) => {
            gpu.set_exitance(&vec![[0.0; 4]; model.map_size[0] * model.map_size[1]]).unwrap();
            gpu.camera(mode, SEED, [0, PATHS], [0, 1]).unwrap();
        }
        Kind::Photon(mode) => {
            gpu.clear_photons(mode).unwrap();
            gpu.photons(mode, SEED, PATHS, [0, 1]).unwrap();
            deposits = gpu.read_photons(mode).unwrap().1;
        }
    }
    let words = tracer(gpu).read_events().unwrap();
    (words.chunks_exact(WORDS).map(|row| row.try_into().unwrap()).collect(), deposits)
}

fn tracer(gpu: &mut Backend) -> &mut GpuTracer {
    match gpu {
        Backend::Gpu { camera, .. } => camera,
        _ => panic!("{}", gpu.name()),
    }
}

/// Histories are kept from here on, in a buffer without traces of earlier ones.
fn keep_events(gpu: &mut Backend) {
    tracer(gpu).record_events(PATHS).unwrap();
}

/// Whether other roundings take the other tracer's branch at the first difference, word `at`. Where only the number of
/// events differs (0), the branch lies beyond the words kept: there other roundings must change the number too.
fn explained(model: &Model<Rounded>, kind: Kind, k: u32, [own, other]: [&[u32; WORDS]; 2], at: usize) -> bool {
    (0..RUNS).any(|run| {
        reseed(u64::from(k) << 32 | run);
        let again = row(&history(model, kind, k, &[]));
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
    /// Largest difference of the light left by any kind of photons, as a share of it.
    light: f64,
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
        self.light = self.light.max(other.light);
    }

    fn share(&self) -> f64 {
        self.differing as f64 / self.paths as f64
    }
}

/// Histories of the twin against those of another tracer, and the reasons where they differ.
fn judge(twin: &Model<f64>, kind: Kind, rows: &[[u32; WORDS]], deposits: &[u64]) -> Findings {
    let (exact, rounded) = (twin.cast::<f32>(), twin.cast::<Rounded>());
    let cells: Vec<AtomicU64> = deposits.iter().map(|_| AtomicU64::new(0)).collect();
    let histories: Vec<_> = (0..PATHS).into_par_iter().map(|k| history(&exact, kind, k, &cells)).collect();
    let (mut off, mut all) = (0, 0);
    for (cell, other) in cells.into_iter().map(AtomicU64::into_inner).zip(deposits) {
        (off, all) = (off + cell.abs_diff(*other), all + cell);
    }
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
        light: off as f64 / all.max(1) as f64,
    }
}

/// Histories of a GPU's model against those of a twin's.
fn compare(gpu: &mut Backend, model: &Model<f64>, twin: &Model<f64>) -> Findings {
    let mut findings = Findings::default();
    for kind in kinds(twin) {
        let (rows, deposits) = gpu_rows(gpu, model, kind);
        findings.add(judge(twin, kind, &rows, &deposits));
    }
    findings
}

/// Histories of the twin in f64 against its own in f32.
fn compare_f64(model: &Model<f64>) -> Findings {
    let mut findings = Findings::default();
    for kind in kinds(model) {
        let rows: Vec<_> = (0..PATHS).into_par_iter().map(|k| row(&history(model, kind, k, &[]))).collect();
        findings.add(judge(model, kind, &rows, &[]));
    }
    findings
}

/// All scenes, by whatever traces them: few paths may differ, and each by rounding.
fn few_differ_and_by_rounding(trace: impl Fn(&Model<f64>) -> Option<Findings> + Sync) {
    let cases: Vec<Case> = presets().into_iter().chain(variants()).collect();
    let findings = at_once(&cases, |case| (case.name.clone(), trace(&case.model(PIXELS))));
    let mut all = Findings::default();
    for (name, found) in findings {
        let Some(found) = found else { return };
        println!(
            "{name}: {} paths, {} events, {} differ: {:?}; light {:.1e}",
            found.paths, found.events, found.differing, found.differences, found.light
        );
        assert!(found.light <= LIGHT, "{name}: {:.1e} of the light", found.light);
        assert_eq!(found.unexplained(), 0, "{name}: rounding does not explain {:?}", found.differences);
        all.add(found);
    }
    println!("{} paths, {} events, {:.1e} of the paths differ", all.paths, all.events, all.share());
    assert!(all.share() <= DIFFERING, "{:.1e} of the paths differ", all.share());
}

#[test]
fn gpu_and_twin_take_the_same_branches() {
    few_differ_and_by_rounding(|model| Some(compare(&mut gpu(require_gpu()?, model), model, model)));
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
    let Some(adapter) = require_gpu() else { return };
    let found = compare(&mut gpu(adapter, &model), &model, &model);
    println!("gpu: {} differ, {:?}", found.differing, found.differences);
    assert_eq!(found.unexplained(), 0, "{:?}", found.differences);
}

#[test]
fn an_index_off_by_0_005_is_a_difference_that_rounding_does_not_explain() {
    let Some(adapter) = require_gpu() else { return };
    let case = Case::preset("flat-bonded");
    let mut faulty = Case::preset("flat-bonded");
    faulty.loaded.scene.stack.layer[2].n = Some(1.395);
    let faulty = faulty.model(PIXELS);
    let found = compare(&mut gpu(adapter, &faulty), &faulty, &case.model(PIXELS));
    assert!(found.share() > DIFFERING, "{:.1e}", found.share());
    assert!(found.unexplained() > 0, "{:?}", found.differences);
}

/// Whether the kernel of a kind of paths reads this text; which of its branches are taken is up to its constants.
fn reads(model: &Model<f64>, kind: Kind, text: &str) -> bool {
    let entry = match kind {
        Kind::Camera(mode) => Entry::Camera(mode),
        Kind::Photon(mode) => Entry::Photons(mode),
    };
    source(&model.cast(), entry, true).0.contains(text)
}

/// Whether any kind of paths shows that the kernels read `wrong` in place of `right`. The others' kernels are not
/// changed, and are compared above.
fn shows(adapter: Gpu, model: &Model<f64>, right: &'static str, wrong: &'static str) -> bool {
    let edit = move |_, text: String| text.replace(right, wrong);
    let mut faulty = GpuTracer::with_source(adapter, model, Box::new(edit)).unwrap().into();
    let changed: Vec<Kind> = kinds(model).into_iter().filter(|kind| reads(model, *kind, right)).collect();
    assert!(!changed.is_empty(), "no kernel reads `{right}`");
    changed.into_iter().any(|kind| {
        let (rows, deposits) = gpu_rows(&mut faulty, model, kind);
        let found = judge(model, kind, &rows, &deposits);
        println!("`{wrong}`, {kind:?}: {} differ, light {:.1e}", found.differing, found.light);
        found.unexplained() > 0 || found.light > LIGHT
    })
}

/// Faults that no history shows but that of the kind it is planted in: each turns the light red, or the branches.
#[test]
fn faults_in_what_maps_and_splats_do_are_found() {
    let faults = [
        ("contact-disc", "path.turns >= UNFOLDED", "path.turns >= 0u"),
        ("contact-disc", "&& path.turns == 0u)", "&& path.turns == 1u)"),
        ("contact-disc", "beyond > 0.0 && (along >= 0.0 ||", "beyond > 1.0 && (along >= 0.0 ||"),
        ("mirror-walls", "slope += d * layer_n_sq(k) / (c * c * c);", "slope += d * layer_n_sq(k) / (c * c);"),
        ("pressed", "select(r, max(r, REFLECTED), MAPPED)", "select(r, max(r, 0.3), MAPPED)"),
        ("mesh-contact", "select(mesh_facet, mesh_normal,", "select(mesh_normal, mesh_facet,"),
    ];
    let seen = at_once(&faults, |&(name, right, wrong)| {
        Some((name, wrong, shows(require_gpu()?, &Case::named(name).model(PIXELS), right, wrong)))
    });
    let missed: Vec<_> = seen.into_iter().flatten().filter(|(_, _, seen)| !seen).collect();
    assert!(missed.is_empty(), "{missed:?}");
}
