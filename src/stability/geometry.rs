//! Rays that graze, that run through corners and edges, and that LEDs send: none may get lost.

use super::row::{Part, Row, Subject};
use super::scenes::{hard_scenes, layers};
use super::tracer::{Finish, Start, Tracer};
use super::watch::{Seen, direction};
use super::{Context, StabilityError, creeping};
use crate::scene::{Walls, preset, validate};
use crate::trace::batch::{Batch, Totals};
use crate::trace::cpu::{End, Limits, Path, book};
use crate::trace::render::accepted;
use crate::trace::{Integrator, Model, TraceError};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Steps that a hard ray is followed for.
const STEPS: u32 = 256;

/// Rays at 89.9 to 90 degrees, through edges and corners, and along height fields, in every hard scene.
pub fn hard_rays(context: &Context, tracer: &Tracer) -> Result<Vec<Row>, StabilityError> {
    let families = [
        "grazing rays, 89.9 to 90 degrees",
        "rays through edges and corners",
        "rays along height fields, 0.1 to 1e-7 rad",
    ];
    // Rays, those lost and those astray; and scenes that have such rays.
    let mut counts = [[0; 4]; 3];
    for scene in &hard_scenes(context.quick)? {
        let single = scene.model.cast();
        let starts = [grazing(&single), corners(&single), creeping::starts(&scene.model)];
        let finishes = tracer.follow(&scene.model, &starts.concat())?;
        let mut rest = finishes.as_slice();
        for (count, starts) in counts.iter_mut().zip(&starts) {
            let (these, others) = rest.split_at(starts.len());
            let found = [
                these.len(),
                these.iter().filter(|f| f.end == End::Lost as u32).count(),
                these.iter().filter(|f| is_astray(&scene.model, f)).count(),
                usize::from(!these.is_empty()),
            ];
            count.iter_mut().zip(found).for_each(|(sum, n)| *sum += n);
            rest = others;
        }
    }
    let mut rows = Vec::new();
    for (what, [rays, lost, astray, scenes]) in families.into_iter().zip(counts) {
        let subject = Subject::new(Part::Light, format!("{what}, {scenes} scenes"), tracer.name());
        rows.push(subject.none(
            format!("rays lost, of {rays}"),
            lost as f64,
            "a ray in a layer meets one of its faces",
        ));
        let quantity = format!("rays outside, with a wrong momentum or none, of {rays}");
        rows.push(subject.none(quantity, astray as f64, "beyond the rounding of f32"));
    }
    Ok(rows)
}

/// Whether a ray is outside the footprint, or its momentum is not its layer's index.
fn is_astray(model: &Model<f64>, f: &Finish) -> bool {
    if !f.o.iter().chain(&f.p).chain([&f.weight]).all(|v| v.is_finite()) {
        return true;
    }
    let outside = (f.o[0].abs() - model.half_size[0]).max(f.o[1].abs() - model.half_size[1]);
    let index = model.layers.get(f.layer).map_or(f64::NAN, |layer| layer.n);
    let momentum = (f.p.iter().map(|p| p * p).sum::<f64>().sqrt() / index - 1.0).abs();
    let under_way = f.end == End::GoesOn as u32;
    outside > Seen::OUTSIDE_MM || under_way && (momentum.is_nan() || momentum > Seen::MOMENTUM)
}

/// Height of an interface above a point.
fn height(model: &Model<f32>, i: usize, [x, y]: [f64; 2]) -> f64 {
    let face = model.faces[i];
    let mut path = Path::new(model, Limits::default());
    f64::from(if face.share == 0.0 { face.z } else { path.surface_height(i, x as f32, y as f32) })
}

fn inside(model: &Model<f32>, layer: usize, o: [f64; 3], d: [f64; 3]) -> Start {
    let n = model.layers[layer].n;
    Start { o: o.map(|v| v as f32), p: d.map(|v| v as f32 * n), layer, steps: STEPS }
}

/// Rays by 0.1 degrees from the horizontal down to nothing: in each layer's middle, and along its lower face.
pub fn grazing(model: &Model<f32>) -> Vec<Start> {
    let at = [-14.0, 9.0];
    let mut starts = Vec::new();
    for layer in 1..model.faces.len() {
        let (low, high) = (height(model, layer - 1, at), height(model, layer, at));
        for step in 0..=40u32 {
            let off = if step == 40 { 0.0 } else { 0.1f64.to_radians() * 10f64.powf(-f64::from(step) / 4.0) };
            let turn = 0.1 + 0.37 * f64::from(step);
            let mut add =
                |z: f64, angle: f64| starts.push(inside(model, layer, [at[0], at[1], z], direction(angle, turn)));
            add(0.5 * (low + high), FRAC_PI_2 - off);
            add(0.5 * (low + high), FRAC_PI_2 + off);
            add(low, FRAC_PI_2 - off);
        }
    }
    starts
}

/// Rays from the middle of each layer through its upper corners and the edges of two walls, along the axis, and from a
/// corner inwards.
pub fn corners(model: &Model<f32>) -> Vec<Start> {
    let [half_x, half_y] = model.half_size.map(f64::from);
    let mut starts = Vec::new();
    for step in 0..64u32 {
        let turn = FRAC_PI_4 + f64::from(step % 4) * 0.25 * TAU;
        let layer = 1 + step as usize % (model.faces.len() - 1);
        let [middle, corner] =
            [[0.0, 0.0], [half_x, half_y]].map(|at| [layer - 1, layer].map(|i| height(model, i, at)));
        let z = 0.5 * (middle[0] + middle[1]);
        let to_corner = f64::atan2(half_x.hypot(half_y), corner[1] - z);
        let through = [to_corner, FRAC_PI_2, 0.0, PI];
        starts.extend(through.map(|angle| inside(model, layer, [0.0, 0.0, z], direction(angle, turn))));
        let (x, y) = (half_x * turn.cos().signum(), half_y * turn.sin().signum());
        starts.push(inside(model, layer, [x, y, corner[0]], direction(1.2, turn + 0.5 * TAU)));
    }
    starts
}

/// Photons of the LEDs in every hard scene: the ledger closes, none is lost.
pub fn ledgers(context: &Context, tracer: &Tracer) -> Result<Vec<Row>, StabilityError> {
    let photons = if context.quick { 1 << 14 } else { 1 << 20 };
    let scenes = hard_scenes(context.quick)?;
    let (mut lost, mut residual, mut cut) = (0.0f64, 0.0f64, 0.0f64);
    for scene in &scenes {
        let mut backend = tracer.open(&scene.model)?;
        let mut batch = Batch::new(&scene.model, &mut backend, Integrator::Path, 7);
        batch.ledger(photons, &mut |_| true)?;
        let ledger = batch.totals.ledger();
        lost = lost.max(batch.totals.lost() as f64 / batch.totals.photons.max(1) as f64);
        residual = residual.max(ledger.residual.abs());
        cut = cut.max(ledger.terminated);
    }
    let subject = Subject::new(Part::Light, format!("flux ledger, worst of {} scenes", scenes.len()), tracer.name());
    let sent = "emitted = absorbed + escaped + detected + terminated";
    Ok(vec![
        subject.absolute("share of photons lost", [lost, 0.0], "must not happen", 1e-6, "what a render accepts"),
        subject.absolute("residual, share of the power", [residual, 0.0], sent, 1e-6, "fixed point of 2^-20 a booking"),
        subject.absolute("share cut off", [cut, 0.0], "must not happen", 1e-4, "what a render accepts"),
    ])
}

/// Photons and camera rays of the twin, looked at between any two steps.
pub fn watched_paths(context: &Context) -> Result<Vec<Row>, StabilityError> {
    let segments = if context.quick { 20_000 } else { 2_000_000 };
    let scenes = hard_scenes(context.quick)?;
    let seen =
        scenes.iter().map(|scene| Seen::of_scene(&scene.model.cast(), segments)).fold(Seen::default(), Seen::merge);
    let along = scenes.iter().map(|scene| Seen::along(&scene.model)).fold(Seen::default(), Seen::merge);
    let layers = ["the hit's rounding and Newton's last step", "a height's rounding a bounce, and a hit's"];
    let mut rows = watched(
        seen,
        format!("{} segments in {} scenes", seen.segments, scenes.len()),
        (1e-6, "what a render accepts"),
        (Seen::WRONG_LAYER_MM, layers[0]),
    );
    let none = (0.0, "a ray in a layer meets one of its faces");
    rows.extend(watched(
        along,
        format!("{} rays along height fields", along.paths),
        none,
        (Seen::CREEPING_MM, layers[1]),
    ));
    Ok(rows)
}

/// What was seen of some paths, with what may be lost of them and how far they may be outside their layer, and why.
fn watched(seen: Seen, case: String, lost: (f64, &str), beyond: (f64, &str)) -> Vec<Row> {
    let subject = Subject::new(Part::Light, case, "cpu f32");
    let share = seen.lost as f64 / seen.paths.max(1) as f64;
    let bad = (seen.not_finite + seen.stuck + seen.cut_off) as f64;
    let (outside, layer) = ([seen.outside_mm, 0.0], [seen.wrong_layer_mm, 0.0]);
    vec![
        subject.absolute("share of paths lost", [share, 0.0], "must not happen", lost.0, lost.1),
        subject.none("paths stuck, cut off or without a number", bad, "looked at between any two steps"),
        subject.absolute("furthest outside, mm", outside, "inside", Seen::OUTSIDE_MM, "ulps of 20 mm"),
        subject.absolute("furthest outside its layer, mm", layer, "in its layer", beyond.0, beyond.1),
        subject.absolute("|p| / n - 1, worst", [seen.momentum, 0.0], "0", Seen::MOMENTUM, "tens of roundings a bounce"),
    ]
}

/// A cap on interactions cuts light off, and the ledger counts it. A layer without thickness is refused.
pub fn truncated_light(_: &Context) -> Result<Vec<Row>, StabilityError> {
    let mut loaded = preset("flat-bonded")?;
    loaded.scene.stack.walls = Walls::Mirror { reflectance: 1.0 };
    let model = super::scenes::model(&loaded)?.cast::<f32>();
    let mut path = Path::new(&model, Limits { event_cap: 8, ..Limits::ENDLESS });
    (0..1024).for_each(|k| path.photon(1, k, 0));
    let sent = path.tally[book::EMITTED] as f64;
    let fates =
        [book::ABSORBED, book::TOP, book::BOTTOM, book::SIDES, book::DETECTED, book::TERMINATED, book::ROULETTE];
    let found: i64 = fates.iter().map(|&fate| path.tally[fate]).sum();
    let cut = path.tally[book::TERMINATED] as f64 / sent;
    let totals = Totals { photons: 1024, tally: path.tally, ..Totals::default() };
    let refused = accepted(&totals).is_err_and(|e| matches!(e, TraceError::Truncated { share, .. } if share == cut));
    let subject = Subject::new(Part::Light, "light cut off after 8 interactions", "cpu f32");
    let mut flat = preset("flat-bonded")?.scene;
    layers(&mut flat, &[[2.0, 1.41], [0.0, 1.40], [5.0, 1.39]]);
    let thin = subject.case("a layer of 0 mm");
    Ok(vec![
        subject.absolute("ledger, share of what was sent", [found as f64 / sent, 1.0], "conservation", 1e-6, "counted"),
        subject.holds("cut-off light is booked", cut > 0.1, "never a silent cap"),
        subject.holds(
            "an image without that light is refused",
            refused,
            "1e-4 may be missing, and the error says how much",
        ),
        thin.holds("the scene is refused", validate(&flat).is_err(), "an interface has two sides"),
    ])
}
