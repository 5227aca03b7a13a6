//! How often does `compare` call two images of the same light different?
//!
//!     cargo run --release --example false_alarms -- FOLDER [small|full] [PAIRS] [CASE] [SPP]
//!
//! For each case (a scene and a method), PAIRS disjoint pairs of seeds are rendered, at 96 x 72 pixels or at the
//! scene's own, with 16 camera paths a pixel unless SPP says otherwise, and compared as a file has them. Prints a row
//! a case: red pairs at each level with their 95 % interval (Clopper and Pearson 1934), then all cases together. The
//! last two columns plant faults of the size that the comparison says it would see in 90 of 100 cases: in one cell of
//! median noise among the pixels, and in the whole image. FOLDER keeps the replicates of each seed (0.4 MB at 96 x 72
//! pixels, 7 MB at 384 x 288): what is there is not rendered again. CASE picks cases by a part of their name.

mod faults;
mod films;

use anyhow::{Context as _, Result};
use faults::{planted_pixel, planted_whole};
use films::{Case, Films};
use statrs::distribution::{Beta, ContinuousCDF};
use std::path::PathBuf;
use tirtouch::film::compare;
use tirtouch::trace::Integrator;

/// Photons of a render of few camera paths, as `render` has them.
const PHOTONS: u64 = 1 << 20;
/// In the pressed phantom, where they stay between clear walls for long.
const FEW_PHOTONS: u64 = 1 << 17;

const CASES: [(&str, Integrator, u64); 11] = [
    ("flat-bonded", Integrator::Path, PHOTONS),
    ("dent-cap", Integrator::Path, PHOTONS),
    ("tsis-dent", Integrator::Path, PHOTONS),
    ("contact-disc", Integrator::Path, PHOTONS),
    ("contact-disc", Integrator::Splat, PHOTONS),
    ("contact-disc", Integrator::Map, PHOTONS),
    ("press-hertz", Integrator::Path, PHOTONS),
    ("press-hertz", Integrator::Splat, PHOTONS),
    ("press-hertz", Integrator::Map, PHOTONS),
    ("phantom-size-8mm", Integrator::Path, FEW_PHOTONS),
    ("phantom-size-8mm", Integrator::Map, FEW_PHOTONS),
];
const LEVELS: [f64; 3] = [0.05, 0.01, 0.001];
const SMALL: [u32; 2] = [96, 72];

/// Red pairs at each level, planted faults found and planted at the first level, pairs.
#[derive(Debug, Clone, Copy, Default)]
struct Count {
    red: [u32; LEVELS.len()],
    found: [u32; 2],
    planted: [u32; 2],
    pairs: u32,
}

fn main() -> Result<()> {
    let mut words = std::env::args().skip(1);
    let folder: PathBuf = words.next().context("usage: false_alarms FOLDER [small|full] [PAIRS] [CASE] [SPP]")?.into();
    let size = words.next().is_none_or(|word| word != "full").then_some(SMALL);
    let pairs: u32 = words.next().map_or(Ok(100), |word| word.parse())?;
    let filter = words.next().unwrap_or_default();
    let spp: u32 = words.next().map_or(Ok(16), |word| word.parse())?;
    println!(
        "| case | pairs | red at 0.05 | at 0.01 | at 0.001 | pixel found | whole found |\n|---|---|---|---|---|---|---|"
    );
    let mut all = Count::default();
    for (scene, integrator, photons) in CASES {
        let case = Case { scene, integrator, photons, size };
        if case.name().contains(&filter) {
            let count = study(&Films::of(&case, 2 * pairs, spp, &folder)?, pairs)?;
            println!("{}", row(&case.name(), &count));
            all = all.and(&count);
        }
    }
    println!("{}", row("all", &all));
    Ok(())
}

fn study(films: &Films, pairs: u32) -> Result<Count> {
    let mut count = Count { pairs, ..Count::default() };
    for pair in 0..pairs as usize {
        let (a, b) = (films.film(2 * pair)?, films.film(2 * pair + 1)?);
        for (red, level) in count.red.iter_mut().zip(LEVELS) {
            *red += u32::from(!compare(&a, &b, level)?.passed);
        }
        let tests = compare(&a, &b, LEVELS[0])?.tests;
        let faults = [planted_pixel(&b, &tests[0]), planted_whole(&b, &tests[4])];
        for (k, fault) in faults.into_iter().enumerate() {
            if let Some(faulty) = fault {
                count.planted[k] += 1;
                let level = compare(&a, &faulty, LEVELS[0])?.tests[[0, 4][k]];
                count.found[k] += u32::from(!level.passed);
            }
        }
    }
    Ok(count)
}

impl Count {
    fn and(&self, other: &Self) -> Self {
        let sum = |a: &[u32; 2], b: &[u32; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            red: [0, 1, 2].map(|k| self.red[k] + other.red[k]),
            found: sum(&self.found, &other.found),
            planted: sum(&self.planted, &other.planted),
            pairs: self.pairs + other.pairs,
        }
    }
}

fn row(name: &str, count: &Count) -> String {
    let red = count.red.map(|red| {
        let [low, high] = interval(red, count.pairs);
        format!("{red} ({:.1} to {:.1} %)", 100.0 * low, 100.0 * high)
    });
    let found = [0, 1].map(|k| match count.planted[k] {
        0 => "-".to_owned(),
        planted => format!("{} of {planted}", count.found[k]),
    });
    format!("| {name} | {} | {} | {} |", count.pairs, red.join(" | "), found.join(" | "))
}

/// The 95 % interval of a share (Clopper and Pearson 1934).
fn interval(found: u32, tried: u32) -> [f64; 2] {
    let quantile = |a: f64, b: f64, p: f64, end: f64| Beta::new(a, b).map_or(end, |beta| beta.inverse_cdf(p));
    let (k, n) = (f64::from(found), f64::from(tried));
    [quantile(k, n - k + 1.0, 0.025, 0.0), quantile(k + 1.0, n - k, 0.975, 1.0)]
}
