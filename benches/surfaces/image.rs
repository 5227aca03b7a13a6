//! Speed and image error, in alternating rounds.

use super::candidates::{Candidate, Dent};
use super::statistics::{Estimate, Replicates, block_means};
use anyhow::Result;
use std::time::Instant;
use tirtouch::trace::cpu::camera::FILM_UNIT;
use tirtouch::trace::modes::CameraMode;
use tirtouch::trace::{Backend, BackendChoice, Devices, Precision};

/// Paths per pixel in one round.
pub const SPP: u32 = 8;
/// Edge of the compared blocks, pixels: a few, because a dent shows sharp images of the LEDs.
const EDGE: u32 = 4;
/// Paths per pixel of the reference in the time budgets.
const BUDGETS: [f64; 3] = [64.0, 1024.0, 16384.0];

/// Speed and image error of one surface.
pub struct ImageError {
    /// Median of the rounds.
    pub paths_per_second: f64,
    /// Median over the rounds of the reference's time over this one's.
    pub speed_ratio: f64,
    /// Root-mean-square bias of lit blocks over their mean.
    pub bias: Estimate,
    /// Relative bias of the whole image's mean.
    pub mean_bias: Estimate,
    /// Error of lit blocks over their mean, noise and bias together, within the time budgets.
    pub total: [f64; 3],
}

/// What a dent's surfaces do, the reference's line first.
pub struct Images {
    /// Name of the adapter.
    pub adapter: String,
    /// One line per surface.
    pub rows: Vec<ImageError>,
}

#[derive(Default)]
struct Traced {
    seconds: Vec<f64>,
    blocks: Replicates,
    whole: Replicates,
}

/// Traces all surfaces in turn, each round with one seed for all.
pub fn errors(dent: &Dent, candidates: &[Candidate], rounds: u32) -> Result<Images> {
    let mut backends = Vec::new();
    for candidate in candidates {
        let mut backend = Devices::open(BackendChoice::Auto, Precision::F32)?.load(&candidate.model)?;
        // Compiles the kernel.
        backend.camera(CameraMode::Path, 0, [0, 64], [0, 1])?;
        backends.push(backend);
    }
    let adapter = backends.first().map_or_else(String::new, Backend::adapter);
    let mut traced: Vec<Traced> = candidates.iter().map(|_| Traced::default()).collect();
    for round in 0..rounds as usize {
        eprintln!("{}: round {} of {rounds}", dent.name, round + 1);
        for k in 0..candidates.len() {
            // Each round starts elsewhere, so that no surface always follows the same one.
            let at = (k + round) % candidates.len();
            trace(&mut backends[at], &candidates[at], round as u32 + 1, &mut traced[at])?;
        }
    }
    let rows = traced.iter().zip(candidates).map(|(t, c)| row(t, &traced[0], c)).collect();
    Ok(Images { adapter, rows })
}

fn pixels(candidate: &Candidate) -> u32 {
    candidate.model.camera.size[0] * candidate.model.camera.size[1]
}

fn trace(backend: &mut Backend, candidate: &Candidate, seed: u32, traced: &mut Traced) -> Result<()> {
    backend.clear_film()?;
    let start = Instant::now();
    for sample in (0..SPP).step_by(2) {
        backend.camera(CameraMode::Path, seed, [0, pixels(candidate)], [sample, 2])?;
    }
    traced.seconds.push(start.elapsed().as_secs_f64());
    let (sums, _) = backend.read_film()?;
    let image: Vec<f64> = sums.iter().map(|&s| s as f64 / FILM_UNIT / f64::from(SPP)).collect();
    traced.blocks.rounds.push(block_means(&image, candidate.model.camera.size, EDGE));
    traced.whole.rounds.push(vec![image.iter().sum::<f64>() / image.len() as f64]);
    Ok(())
}

fn row(traced: &Traced, reference: &Traced, candidate: &Candidate) -> ImageError {
    let lit = reference.blocks.lit();
    let ratios: Vec<f64> = reference.seconds.iter().zip(&traced.seconds).map(|(r, t)| r / t).collect();
    let speed_ratio = median(&ratios);
    let bias = traced.blocks.rms_bias(&reference.blocks, &lit);
    let noise = traced.blocks.noise(&lit);
    let total = BUDGETS.map(|spp| {
        let variance = noise * noise * f64::from(SPP) / (spp * speed_ratio);
        (variance + bias.value.max(0.0).powi(2)).sqrt()
    });
    ImageError {
        paths_per_second: f64::from(pixels(candidate)) * f64::from(SPP) / median(&traced.seconds),
        speed_ratio,
        bias,
        mean_bias: traced.whole.relative_bias(&reference.whole, 0),
        total,
    }
}

/// The middle value.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}
