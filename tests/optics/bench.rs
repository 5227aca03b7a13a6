//! The optical bench: sensors put together from presets, light sent through them, and the statistics of what arrives.

use rayon::prelude::*;
use tirtouch::pipeline::{Order, Session};
use tirtouch::scene::{self, Layer, LoadedScene};
use tirtouch::trace::cpu::vec3::{V3, v3};
use tirtouch::trace::cpu::{Limits, Path};
use tirtouch::trace::model::Real;
use tirtouch::trace::{Backend, BackendChoice, Devices, Model, Precision, TraceError};

/// A preset.
pub fn sensor(preset: &str) -> LoadedScene {
    scene::preset(preset).unwrap()
}

/// A flat stack of layers given as thickness (mm) and index, touch side first, with black walls and bonded LEDs.
pub fn stack(layers: &[[f64; 2]]) -> LoadedScene {
    let mut loaded = sensor("flat-bonded");
    let pattern = loaded.scene.stack.layer[0].clone();
    let layer = |&[thickness_mm, n]: &[f64; 2]| Layer { thickness_mm, n: Some(n), ..pattern.clone() };
    loaded.scene.stack.layer = layers.iter().map(layer).collect();
    loaded
}

/// What the tracers see of a scene.
pub fn model(loaded: &LoadedScene) -> Model<f64> {
    let mut loaded = loaded.clone();
    if let Some(press) = &mut loaded.scene.press {
        press.estimate_error = false;
    }
    let order = Order::of(&loaded.scene);
    Session::from(Devices::cpu(Precision::F32)).prepare(loaded, &order, &mut |_| true).unwrap().model
}

/// The GPU where there is one (a missing one is a failure under TIRTOUCH_REQUIRE_GPU), and the twin in f32.
pub fn backends(model: &Model<f64>) -> Vec<Backend> {
    let open = |choice| Devices::open(choice, Precision::F32)?.load(model);
    let gpu = match open(BackendChoice::Gpu) {
        Ok(gpu) => Some(gpu),
        Err(TraceError::NoAdapter) if std::env::var_os("TIRTOUCH_REQUIRE_GPU").is_none() => None,
        Err(e) => panic!("{e}"),
    };
    gpu.into_iter().chain([open(BackendChoice::Cpu).unwrap()]).collect()
}

/// The GPU, or the twin where there is none.
pub fn fastest(model: &Model<f64>) -> Backend {
    backends(model).swap_remove(0)
}

/// The same choice, for renders.
pub fn devices() -> Devices {
    let choice = match std::env::var_os("TIRTOUCH_REQUIRE_GPU") {
        Some(_) => BackendChoice::Gpu,
        None => BackendChoice::Auto,
    };
    Devices::open(choice, Precision::F32).unwrap()
}

/// A path of unlimited length at a point, with an optical momentum.
pub fn path<T: Real>(model: &Model<T>, layer: usize, o: [f64; 3], p: [f64; 3]) -> Path<'_, T> {
    let mut path = Path::new(model, Limits::ENDLESS);
    put(&mut path, layer, o, p);
    path
}

/// Puts a path somewhere else, with full weight.
pub fn put<T: Real>(path: &mut Path<T>, layer: usize, o: [f64; 3], p: [f64; 3]) {
    let vector = |a: [f64; 3]| -> V3<T> { v3(T::of(a[0]), T::of(a[1]), T::of(a[2])) };
    path.layer = layer;
    path.o = vector(o);
    path.p = vector(p);
    path.weight = T::one();
    path.bounces = 0;
}

/// Runs `trial` on `n` paths in parallel and sums what it returns, as many numbers as wanted.
pub fn sums<const K: usize, T: Real>(
    model: &Model<T>,
    seed: u32,
    n: u64,
    trial: impl Fn(&mut Path<T>) -> [f64; K] + Sync,
) -> [f64; K] {
    let threads = 64u32;
    (0..threads)
        .into_par_iter()
        .map(|thread| {
            let mut path = path(model, 0, [0.0; 3], [0.0; 3]);
            let mut sum = [0.0; K];
            let each = n / u64::from(threads);
            for trial_of_thread in 0..each {
                path.start_random(seed, (u64::from(thread) * each + trial_of_thread) as u32, 0);
                let found = trial(&mut path);
                sum.iter_mut().zip(found).for_each(|(s, v)| *s += v);
            }
            sum
        })
        .reduce(|| [0.0; K], |a, b| std::array::from_fn(|k| a[k] + b[k]))
}

/// Counts the paths on which `trial` holds; `n` is a multiple of 64.
pub fn count<T: Real>(model: &Model<T>, seed: u32, n: u64, trial: impl Fn(&mut Path<T>) -> bool + Sync) -> Share {
    let [hits] = sums(model, seed, n, |path| [f64::from(u8::from(trial(path)))]);
    Share { hits, of: n as f64 }
}

/// A count of hits.
#[derive(Debug, Clone, Copy)]
pub struct Share {
    /// Hits.
    pub hits: f64,
    /// Trials.
    pub of: f64,
}

impl Share {
    /// Holds the share to a probability: within four standard errors, which must be good for so many digits of it.
    pub fn is(self, what: &str, expected: f64, digits: i32) {
        let four = 4.0 * (expected * (1.0 - expected) / self.of).sqrt();
        let half_unit = 0.5 * 10f64.powi(expected.log10().floor() as i32 + 1 - digits);
        let found = self.hits / self.of;
        println!("{what}: {found:.6} for {expected:.6}, 4 standard errors {four:.1e}");
        assert!(four <= half_unit, "{what}: 4 standard errors are {four:.1e}, half a unit {half_unit:.1e}");
        assert!((found - expected).abs() <= four, "{what}: {found} for {expected}, 4 standard errors {four:.1e}");
    }
}

/// Holds a number to another one.
pub fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    println!("{what}: {found:.9} for {expected:.9}, tolerance {tolerance:.1e}");
    assert!((found - expected).abs() <= tolerance, "{what}: {found} for {expected}, tolerance {tolerance:.1e}");
}

/// Four standard deviations of the normal distribution leave this probability outside, both sides together.
const OUTSIDE_FOUR: f64 = 6.334e-5;

/// Holds counts to expected counts by chi-square, at the probability of four standard deviations.
pub fn chi_square(what: &str, counts: &[f64], expected: &[f64]) {
    use statrs::distribution::{ChiSquared, ContinuousCDF};
    let chi2: f64 = counts.iter().zip(expected).map(|(c, e)| (c - e) * (c - e) / e).sum();
    let chance = ChiSquared::new(counts.len() as f64 - 1.0).unwrap().sf(chi2);
    println!("{what}: chi-square {chi2:.1} in {} cells, chance {chance:.1e}", counts.len());
    assert!(chance > OUTSIDE_FOUR, "{what}: chi-square {chi2} in {} cells", counts.len());
}

/// Holds values to a distribution by Kolmogorov and Smirnov, at the probability of four standard deviations.
pub fn kolmogorov(what: &str, mut values: Vec<f64>, cumulative: impl Fn(f64) -> f64) {
    values.sort_by(f64::total_cmp);
    let n = values.len() as f64;
    let gap = |(k, &v): (usize, &f64)| ((k as f64 + 0.5) / n - cumulative(v)).abs() + 0.5 / n;
    let largest = values.iter().enumerate().map(gap).fold(0.0, f64::max);
    // The chance that sqrt(n) D exceeds t is 2 exp(-2 t^2) to leading order.
    let limit = (-0.5 * (0.5 * OUTSIDE_FOUR).ln()).sqrt();
    println!("{what}: sqrt(n) D = {:.3}, limit {limit:.3}", n.sqrt() * largest);
    assert!(n.sqrt() * largest < limit, "{what}: sqrt(n) D = {}", n.sqrt() * largest);
}
