//! A guard that looks at a path of the twin between any two steps of its walk.

use super::creeping;
use super::tracer::Start;
use crate::trace::Model;
use crate::trace::cpu::vec3::{V3, v3};
use crate::trace::cpu::{End, Limits, Path};
use crate::trace::model::Real;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Photons of a round, and as many camera paths, shared among the threads.
const ROUND: u32 = 4096;

/// What was seen, worst values first.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Seen {
    /// Paths followed.
    pub paths: u64,
    /// Steps of their walks.
    pub segments: u64,
    /// Paths whose next surface was not found.
    pub lost: u64,
    /// Paths cut off by the cap on interactions.
    pub cut_off: u64,
    /// Paths that moved less than a nanometre in [`Seen::STUCK`] steps one after the other.
    pub stuck: u64,
    /// Paths with a number that is not finite.
    pub not_finite: u64,
    /// Furthest beyond the footprint, mm.
    pub outside_mm: f64,
    /// Furthest beyond the interfaces of the path's layer, mm.
    pub wrong_layer_mm: f64,
    /// Largest |p| / n - 1.
    pub momentum: f64,
}

impl Seen {
    /// Steps without moving after which a path counts as stuck. A rim between two faces takes a handful.
    pub const STUCK: u32 = 256;

    /// What both saw.
    pub fn merge(self, b: Self) -> Self {
        Self {
            paths: self.paths + b.paths,
            segments: self.segments + b.segments,
            lost: self.lost + b.lost,
            cut_off: self.cut_off + b.cut_off,
            stuck: self.stuck + b.stuck,
            not_finite: self.not_finite + b.not_finite,
            outside_mm: self.outside_mm.max(b.outside_mm),
            wrong_layer_mm: self.wrong_layer_mm.max(b.wrong_layer_mm),
            momentum: self.momentum.max(b.momentum),
        }
    }

    /// Furthest that a path may be beyond the footprint, mm: positions reach 20 mm, where an ulp of f32 is 2e-6 mm.
    pub const OUTSIDE_MM: f64 = 1e-5;
    /// Furthest that a path may be beyond its layer, mm: a hit adds its distance's rounding, a height field the last
    /// Newton step (1e-6 in units of the momentum) and a cap the cancellation in its quadratic (some ulps of 100 mm^2
    /// over a radius of 10 mm).
    pub const WRONG_LAYER_MM: f64 = 3e-5;
    /// The same of a ray along a height field: along a concave face each bounce takes it out by the rounding of a
    /// height, 1e-6 mm, which the search adds to the gap so that it gets on.
    pub const CREEPING_MM: f64 = Self::WRONG_LAYER_MM + 1e-6 * creeping::STEPS as f64;
    /// Largest |p| / n - 1: it is rounded some tens of times a bounce.
    pub const MOMENTUM: f64 = 1e-5;

    /// What is wrong with what was seen; empty where every path kept its place. Lost paths are the caller's to judge:
    /// they are counted.
    pub fn faults(&self) -> Vec<&'static str> {
        let faults = [
            (self.not_finite > 0, "a number that is not finite"),
            (self.stuck > 0, "a path that is stuck"),
            (self.cut_off > 0, "a path that was cut off"),
            (self.outside_mm > Self::OUTSIDE_MM, "a path outside the footprint"),
            (self.wrong_layer_mm > Self::WRONG_LAYER_MM, "a path outside its layer"),
            (self.momentum > Self::MOMENTUM, "a momentum that is not the index"),
        ];
        faults.into_iter().filter(|(is, _)| *is).map(|(_, what)| what).collect()
    }

    /// Looks at a path.
    pub fn look<T: Real>(&mut self, path: &mut Path<T>) {
        let [x, y, z] = [path.o.x, path.o.y, path.o.z].map(T::wide);
        let p = path.p.dot(path.p).wide().sqrt();
        if ![x, y, z, p, path.weight.wide()].iter().all(|v| v.is_finite()) {
            self.not_finite += 1;
            return;
        }
        let half = path.model.half_size.map(T::wide);
        self.outside_mm = self.outside_mm.max(x.abs() - half[0]).max(y.abs() - half[1]);
        self.momentum = self.momentum.max((p / path.model.layers[path.layer].n.wide() - 1.0).abs());
        let (layer, faces) = (path.layer, path.model.faces.len());
        let mut height = |i: usize| {
            let face = path.model.faces[i];
            let (x, y) = (path.o.x, path.o.y);
            if face.share == T::zero() { face.z.wide() } else { path.surface_height(i, x, y).wide() }
        };
        let below = if layer > 0 { height(layer - 1) - z } else { 0.0 };
        let above = if layer < faces { z - height(layer) } else { 0.0 };
        self.wrong_layer_mm = self.wrong_layer_mm.max(below).max(above);
    }

    /// Follows a path that is under way to its end.
    pub fn follow<T: Real>(&mut self, path: &mut Path<T>, end: End) {
        self.follow_for(path, end, u64::MAX);
    }

    /// The same for so many steps at most.
    fn follow_for<T: Real>(&mut self, path: &mut Path<T>, mut end: End, steps: u64) {
        self.paths += 1;
        let last = self.segments.saturating_add(steps);
        let before = self.not_finite;
        let mut still = 0;
        while end == End::GoesOn && self.segments < last {
            let from = path.o;
            end = path.step();
            self.segments += 1;
            if end == End::Touch {
                self.look(path);
                end = path.photon_touch();
            }
            if end == End::GoesOn {
                self.look(path);
            }
            let moved = path.o - from;
            still = if moved.dot(moved).wide() < 1e-12 { still + 1 } else { 0 };
            if still == Self::STUCK {
                self.stuck += 1;
                return;
            }
            if self.not_finite > before {
                return;
            }
        }
        self.lost += u64::from(end == End::Lost);
        self.cut_off += u64::from(end == End::Cap);
    }

    /// Follows the rays along a scene's height fields, in f32.
    pub fn along(model: &Model<f64>) -> Self {
        let single = model.cast::<f32>();
        let follow = |(k, start): (usize, &Start)| {
            let mut path = Path::new(&single, Limits::default());
            path.start_random(1, k as u32, 0);
            start.put(&mut path);
            let mut seen = Self::default();
            seen.follow_for(&mut path, End::GoesOn, start.steps.into());
            seen
        };
        creeping::starts(model).par_iter().enumerate().map(follow).reduce(Self::default, Self::merge)
    }

    /// Follows photons and camera paths of a scene until they have made so many segments.
    pub fn of_scene(model: &Model<f32>, segments: u64) -> Self {
        let [half_x, half_y] = model.half_size.map(Real::wide);
        let mut all = Self::default();
        for round in 0.. {
            let seen = (0..ROUND).into_par_iter().map(|k| {
                let mut seen = Self::default();
                seen.photon(model, round, k);
                // A camera path: any point of the lowest face, any direction up.
                let mut draws = Path::new(model, Limits::default());
                draws.start_random(!round, k, 0);
                let [x, y, z, turn] = std::array::from_fn(|_| draws.draw().wide());
                let at = [(2.0 * x - 1.0) * half_x, (2.0 * y - 1.0) * half_y];
                seen.camera_ray(model, round.wrapping_mul(ROUND).wrapping_add(k), at, direction(z.acos(), TAU * turn));
                seen
            });
            all = all.merge(seen.reduce(Self::default, Self::merge));
            if all.segments >= segments {
                break;
            }
        }
        all
    }

    /// Follows a photon from an LED.
    pub fn photon<T: Real>(&mut self, model: &Model<T>, seed: u32, k: u32) {
        let mut path = Path::new(model, Limits::whole());
        path.start_random(seed, k, 0);
        let end = path.launch();
        self.follow(&mut path, end);
    }

    /// Follows a ray that comes in from below at (x, y) with direction d, as a camera path does.
    pub fn camera_ray<T: Real>(&mut self, model: &Model<T>, k: u32, [x, y]: [f64; 2], d: [f64; 3]) {
        let mut path = Path::new(model, Limits::default());
        path.start_random(0x0ca3e4a, k, 0);
        path.o.x = T::of(x);
        path.o.y = T::of(y);
        let n = model.surround_n.wide();
        path.p = v3(T::of(n * d[0]), T::of(n * d[1]), T::of(n * d[2]));
        if path.meet(0, V3::up(), T::one()) {
            path.layer = 1;
            self.follow(&mut path, End::GoesOn);
        }
    }
}

/// The unit vector at `angle` from the z axis and azimuth `turn`, radians.
pub fn direction(angle: f64, turn: f64) -> [f64; 3] {
    [angle.sin() * turn.cos(), angle.sin() * turn.sin(), angle.cos()]
}
