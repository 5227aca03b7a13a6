//! Streams of random numbers, and what a session keeps.
#![allow(clippy::unwrap_used)]

use super::{Order, PipelineError, Prepared, ReadAs, Session};
use crate::mechanics::press::Pressed;
use crate::progress::Stage;
use crate::scene::{IntegratorChoice, LoadedScene, Render, preset};
use crate::streams::{Sharing, Streams};
use crate::trace::{BackendChoice, Devices, Precision, Settings, TraceError};
use crate::vary::with;
use std::path::Path;
use std::sync::Arc;

fn session() -> Session {
    Session::from(Devices::cpu(Precision::F32))
}

/// A preset with few pixels and a coarse press.
fn coarse(name: &str) -> LoadedScene {
    let mut loaded = preset(name).unwrap();
    loaded.scene.camera.pixels = [48, 36];
    loaded.scene.render.map_texel_mm = 0.5;
    let press = loaded.scene.press.as_mut().unwrap();
    (press.resolution, press.estimate_error) = (0.5, false);
    loaded
}

fn prepared(session: &mut Session, loaded: LoadedScene) -> Prepared {
    let order = Order::of(&loaded.scene);
    session.prepare(loaded, &order, &mut |_| true).unwrap()
}

/// The same under another seed, few paths and photons.
fn reseeded(prepared: &Prepared, seed: u32, sharing: Sharing) -> Prepared {
    let settings = Settings { spp: 16, photons: Some(1 << 14), ..prepared.settings.clone() };
    let streams = Streams { seed, sharing, ..prepared.streams.clone() };
    Prepared::new(prepared.loaded.clone(), prepared.press.clone(), settings, streams).unwrap()
}

/// Noise of an image: the difference of those of two seeds.
fn noise(prepared: &Prepared, seeds: [u32; 2], sharing: Sharing) -> Vec<f64> {
    let image = |seed| session().shoot(&reseeded(prepared, seed, sharing), &mut |_| true).unwrap().outcome.film.mean;
    let [one, other] = seeds.map(image);
    one.iter().zip(&other).map(|(one, other)| f64::from(one - other)).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    product(a, b) / (product(a, a) * product(b, b)).sqrt()
}

/// With seeds counted on, a baseline had 0.9 of its noise in common with the next run, and loads 0.8 with one another.
#[test]
fn baselines_loads_and_runs_have_no_noise_in_common_unless_asked() {
    let mut session = session();
    let last = prepared(&mut session, coarse("phantom-size-8mm"));
    let baseline = session.baseline(&last, &mut |_| true).unwrap();
    let first = last.at_load(0).unwrap();
    let [image, without, load] = [&last, &baseline, &first].map(|one| noise(one, [1, 3], Sharing::Own));
    // Smoothing leaves some hundred independent patches in 1,728 pixels: four standard errors of a correlation of none.
    let none = 4.0 / 100f64.sqrt();
    let next = noise(&last, [2, 4], Sharing::Own);
    for (name, one, other) in [
        ("baseline and image", &without, &image),
        ("first load and image", &load, &image),
        ("baseline and the next seed's image", &without, &next),
    ] {
        let found = correlation(one, other);
        assert!(found.abs() < none, "{name}: {found}");
    }
    // Loads bend light apart, so that the same numbers leave less in common.
    let [image, without] = [&last, &baseline].map(|one| noise(one, [1, 3], Sharing::Common));
    let found = correlation(&without, &image);
    assert!(found > none, "baseline and image, common random numbers: {found}");
    let [one, other] = [&last, &first].map(|one| reseeded(one, 1, Sharing::Common).settings.seed);
    assert_eq!((one, other), (1, 1));
}

#[test]
fn each_seed_load_role_and_scene_has_a_stream_and_repeats_it() {
    let mut session = session();
    let last = prepared(&mut session, coarse("phantom-size-8mm"));
    let other = prepared(&mut session, coarse("phantom-size-2mm"));
    let loads = last.press.as_ref().unwrap().0.steps.len();
    let mut streams: Vec<u32> = (0..loads).map(|load| last.at_load(load).unwrap().settings.seed).collect();
    assert_eq!(streams.last(), Some(&last.settings.seed), "the last load is the image");
    // A scene that was changed in memory is another one.
    let mut warmer = coarse("phantom-size-8mm");
    warmer.scene.stack.layer[0].n = Some(1.411);
    let changed = prepared(&mut session, warmer);
    assert!(Arc::ptr_eq(&changed.press.as_ref().unwrap().0, &last.press.as_ref().unwrap().0));
    streams.push(changed.settings.seed);
    streams.extend([other.settings.seed, reseeded(&last, last.streams.seed + 1, Sharing::Own).settings.seed]);
    let again = reseeded(&last, last.streams.seed, Sharing::Own);
    assert_eq!((again.settings.seed, again.streams.sensor()), (last.settings.seed, last.streams.sensor()));
    let count = streams.len();
    streams.sort_unstable();
    streams.dedup();
    assert_eq!(streams.len(), count);
}

/// A press does not see indices, LEDs or the camera; all that it sees makes it another.
#[test]
fn a_scene_takes_the_press_of_another_where_nothing_that_presses_differs() {
    type Change = fn(&mut LoadedScene);
    let changes: [(&str, bool, Change); 6] = [
        ("index", true, |l| l.scene.stack.layer[0].n = Some(1.42)),
        ("camera", true, |l| l.scene.camera.distance_mm += 1.0),
        ("modulus", false, |l| {
            l.scene.phantom.as_mut().unwrap().inclusion[0].material =
                crate::scene::Elastic::NeoHookean { youngs_kpa: 121.0, poisson: 0.5, relaxation: Vec::new() };
        }),
        ("depths", false, |l| l.scene.press.as_mut().unwrap().depths_mm = Some(vec![1.0, 1.5])),
        ("thickness", false, |l| l.scene.stack.layer[0].thickness_mm += 0.01),
        ("estimate", false, |l| l.scene.press.as_mut().unwrap().estimate_error = true),
    ];
    let mut loaded = coarse("phantom-size-8mm");
    loaded.scene.press.as_mut().unwrap().depths_mm = Some(vec![1.0]);
    for (what, same, change) in changes {
        let mut session = session();
        let first = prepared(&mut session, loaded.clone()).press.unwrap().0;
        let mut other = loaded.clone();
        change(&mut other);
        let second = prepared(&mut session, other).press.unwrap().0;
        assert_eq!(Arc::ptr_eq(&first, &second), same, "{what}");
    }
}

/// What a session did before must not show in what it does now.
#[test]
fn an_image_is_the_same_to_the_bit_whatever_its_session_did_before() {
    let shot = |session: &mut Session, loaded: LoadedScene| {
        let ready = reseeded(&prepared(session, loaded), 5, Sharing::Own);
        session.shoot(&ready, &mut |_| true).unwrap().outcome.film
    };
    let wanted = || coarse("phantom-size-8mm");
    let fresh = shot(&mut session(), wanted());
    let mut used = session();
    let other = shot(&mut used, coarse("phantom-size-14mm"));
    let warm = shot(&mut used, wanted());
    assert_eq!((&warm.mean, &warm.variance), (&fresh.mean, &fresh.variance));
    assert_ne!(other.mean, fresh.mean);
}

/// A press that started from another is none for who asks for one by itself.
#[test]
fn a_press_from_another_is_kept_apart() {
    let mut session = session();
    prepared(&mut session, coarse("phantom-size-14mm"));
    let press = |session: &mut Session, near: bool| {
        let loaded = coarse("phantom-size-8mm");
        let order = Order { near, ..Order::of(&loaded.scene) };
        session.press(&loaded, &order, &mut |_| true).unwrap()
    };
    let near = press(&mut session, true);
    let alone = press(&mut session, false);
    assert!(!Arc::ptr_eq(&near, &alone));
    assert!(near.iterations < alone.iterations, "{} and {}", near.iterations, alone.iterations);
    let force = |pressed: &Pressed| pressed.steps.last().unwrap().force_n;
    assert!((force(&near) / force(&alone) - 1.0).abs() < 2e-3, "{} and {}", force(&near), force(&alone));
    assert!(Arc::ptr_eq(&alone, &press(&mut session, false)));
}

#[test]
fn what_has_no_light_or_no_press_is_told() {
    let mut session = session();
    let flat = prepared(&mut session, preset("flat-bonded").unwrap());
    assert!(matches!(session.baseline(&flat, &mut |_| true), Err(PipelineError::NoBaseline)));
    let mut ball = coarse("phantom-size-8mm");
    ball.scene.press.as_mut().unwrap().indenter = Some(crate::scene::Indenter::Round { radius_mm: 5.0 });
    let order = Order::of(&ball.scene);
    assert!(matches!(session.prepare(ball, &order, &mut |_| true), Err(PipelineError::NoLight)));
    let wanted = coarse("phantom-size-8mm");
    let order = Order::of(&wanted.scene);
    assert!(matches!(session.prepare(wanted.clone(), &order, &mut |_| false), Err(PipelineError::Press(_))));
    let ready = session.prepare(wanted, &order, &mut |_| true).unwrap();
    assert!(matches!(ready.at_load(99), Err(PipelineError::NoLoad { load: 99, .. })));
    assert!(matches!(Devices::open(BackendChoice::Gpu, Precision::F64), Err(TraceError::Unsuited(_))));
}

/// However often it is asked, one "no" ends a press, also while a coarser mesh leads it.
#[test]
fn a_press_stops_when_it_is_told_once() {
    let mut loaded = coarse("phantom-size-8mm");
    loaded.scene.press.as_mut().unwrap().estimate_error = true;
    let order = Order::of(&loaded.scene);
    let mut all = 0;
    let whole = session().press(&loaded, &order, &mut |_| {
        all += 1;
        true
    });
    assert!(whole.is_ok() && all > 3, "{all}");
    for at in [1, all / 4, all / 2, 3 * all / 4] {
        let mut asked = 0;
        let stopped = session().press(&loaded, &order, &mut |_| {
            asked += 1;
            asked != at
        });
        assert!(matches!(stopped, Err(PipelineError::Press(_))), "{at} of {all}");
        assert_eq!(asked, at);
    }
}

/// Without smoothing a map is as noisy as its photons; with it, quieter, of the same light.
#[test]
fn a_map_may_be_left_unsmoothed() {
    let render = |map_smoothing| {
        let mut loaded = coarse("phantom-size-8mm");
        let render = loaded.scene.render.clone();
        loaded.scene.render = Render { integrator: IntegratorChoice::Map, map_texel_mm: 0.25, map_smoothing, ..render };
        let mut session = session();
        let prepared = reseeded(&prepared(&mut session, loaded), 1, Sharing::Own);
        session.shoot(&prepared, &mut |_| true).unwrap().outcome
    };
    let (raw, smooth) = (render(false), render(true));
    assert_eq!(raw.smoothing.unwrap().widths, [1, 1]);
    assert!(smooth.smoothing.unwrap().widths.iter().any(|width| *width > 1));
    let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
    let [noisy, quiet] = [&raw, &smooth].map(|outcome| sum(&outcome.film.variance));
    assert!(noisy > 2.0 * quiet, "{noisy:e} {quiet:e}");
    let [one, other] = [&raw, &smooth].map(|outcome| sum(&outcome.film.mean));
    assert!((one / other - 1.0).abs() < 0.02, "{one} {other}");
}

/// Without inclusions the same material follows the same way: all loads before, and how long each was held.
#[test]
fn a_phantom_that_relaxes_has_a_baseline_of_its_own_way() {
    let material =
        "{ law = \"neo_hookean\", youngs_kpa = 5.0, poisson = 0.49, relaxation = [{ share = 0.5, time_s = 2 }] }";
    let sets = [
        format!("phantom.material={material}"),
        format!("phantom.inclusion[0].material={material}"),
        "press.depths_mm=[1, 2]".into(),
        "press.rate_mm_per_s=5".into(),
        "press.hold_s=2".into(),
        "press.resolution=0.25".into(),
    ];
    let sets: Vec<_> = sets.iter().map(|set| set.parse().unwrap()).collect();
    let loaded = with(coarse("phantom-size-8mm"), Path::new("relaxing.toml"), &sets).unwrap();
    let mut session = session();
    let last = prepared(&mut session, loaded);
    for load in 0..2 {
        let at = last.at_load(load).unwrap();
        let baseline = session.baseline(&at, &mut |_| true).unwrap();
        let force = |prepared: &Prepared| prepared.pressed().unwrap().1.force_n;
        assert!((force(&baseline) / force(&at) - 1.0).abs() < 1e-6, "load {load}: {} {}", force(&baseline), force(&at));
    }
}

/// From a scene to its reading no stage is come back to.
#[test]
fn a_scene_visits_each_stage_once_and_in_order() {
    let mut loaded = coarse("phantom-size-8mm");
    loaded.scene.press.as_mut().unwrap().estimate_error = true;
    let (mut session, mut stages) = (session(), Vec::new());
    let order = Order {
        settings: Settings { spp: 16, photons: Some(1 << 14), ..Settings::of(&loaded.scene.render) },
        ..Order::of(&loaded.scene)
    };
    let mut observe = |stage: Stage| {
        stages.push(stage.what.to_owned());
        true
    };
    let prepared = session.prepare(loaded, &order, &mut observe).unwrap();
    let shot = session.shoot(&prepared, &mut observe).unwrap();
    assert!(shot.read(&ReadAs::default()).is_ok());
    stages.dedup();
    let mut once = stages.clone();
    once.sort();
    once.dedup();
    assert_eq!(once.len(), stages.len(), "{stages:?}");
    let place = |what: &str| stages.iter().position(|stage| stage == what).unwrap();
    assert!(place("pressing") < place("photons") && place("photons") < place("camera paths"), "{stages:?}");
}
