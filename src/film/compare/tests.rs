//! Synthetic films: normal noise on a known image, some of it shared between neighbours.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::film::BlockAccumulator;

const REPLICATES: u32 = 16;

/// Normal deviates from a counter hash (splitmix64, Box-Muller).
pub(in crate::film) struct Noise(pub u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// A film of counted light: each replicate of a pixel a Poisson number of mean `count` (Knuth's product of uniforms).
fn counted(seed: u64, size: [u32; 2], count: f64) -> Film {
    let mut noise = Noise(seed);
    let mut sums = BlockAccumulator::new(size[0], size[1]);
    for _ in 0..REPLICATES {
        let mut pixel = || {
            let (mut events, mut product) = (0.0, noise.uniform());
            while product > (-count).exp() {
                events += 1.0;
                product *= noise.uniform();
            }
            events
        };
        let image: Vec<f64> = (0..size[0] * size[1]).map(|_| pixel()).collect();
        sums.add(&image).unwrap();
    }
    sums.finish()
}

/// A film of `truth` with relative noise of its pixels `error`; squares of `patch` pixels share their noise.
fn film(seed: u64, size: [u32; 2], error: f64, patch: u32, truth: impl Fn(u32, u32) -> f64) -> Film {
    let [width, height] = size;
    let mut noise = Noise(seed.wrapping_mul(0x1234_5678_9abc_def1));
    let mut sums = BlockAccumulator::new(width, height);
    let scale = error * f64::from(REPLICATES).sqrt();
    for _ in 0..REPLICATES {
        let columns = width.div_ceil(patch);
        let shared: Vec<f64> = (0..columns * height.div_ceil(patch)).map(|_| noise.normal()).collect();
        let pixel = |index: u32| {
            let (x, y) = (index % width, index / width);
            let z = shared[(y / patch * columns + x / patch) as usize];
            truth(x, y) * (1.0 + scale * z)
        };
        let image: Vec<f64> = (0..width * height).map(pixel).collect();
        sums.add(&image).unwrap();
    }
    sums.finish()
}

fn blob(x: u32, y: u32) -> f64 {
    let r2 = (f64::from(x) - 40.0).powi(2) + (f64::from(y) - 30.0).powi(2);
    2.0 * (-r2 / 800.0).exp() + 0.1
}

#[test]
fn equal_light_with_other_noise_fails_no_oftener_than_the_level() {
    let level = 0.1;
    let fails = |seed: u64| {
        let [a, b] = [2 * seed, 2 * seed + 1].map(|seed| film(seed, [32, 32], 0.05, 1, blob));
        !compare(&a, &b, level).unwrap().passed
    };
    let failures = (0..200).filter(|&seed| fails(seed)).count();
    // Binomial: 20 expected, standard deviation 4.2; 33 is three of them above.
    assert!(failures <= 33, "{failures} of 200 equal pairs failed at level {level}");
    assert!(failures >= 1, "a test that never fails at level {level} has no power");
}

#[test]
fn a_hundredth_more_light_on_a_patch_is_found_in_noise_three_times_as_large() {
    let patch = |x: u32, y: u32| (20..60).contains(&x) && (30..70).contains(&y);
    let bright = |x, y| if patch(x, y) { 1.01 } else { 1.0 };
    let a = film(1, [128, 96], 0.03, 1, |_, _| 1.0);
    let faulty = film(2, [128, 96], 0.03, 1, bright);
    let sound = film(2, [128, 96], 0.03, 1, |_, _| 1.0);
    let result = compare(&a, &faulty, 1e-3).unwrap();
    // A pixel sees 0.24 standard errors, a block of 16 inside the patch 3.8, one of 64 5.9.
    assert!(result.tests[0].passed, "pixels alone cannot see it: {result:?}");
    assert!(!result.passed, "{result:?}");
    assert!(compare(&a, &sound, 1e-3).unwrap().passed);
}

#[test]
fn noise_shared_by_neighbours_gives_no_alarm() {
    let level = 0.1;
    let plain = |film: &Film| Film { blocks: Vec::new(), correlation: Vec::new(), ..film.clone() };
    let mut failures = [0; 2];
    for seed in 0..100 {
        let [a, b] = [2 * seed, 2 * seed + 1].map(|seed| film(seed, [64, 48], 0.05, 5, blob));
        let pairs = [(a.clone(), b.clone()), (plain(&a), plain(&b))];
        for (count, (a, b)) in failures.iter_mut().zip(&pairs) {
            *count += usize::from(!compare(a, b, level).unwrap().passed);
        }
    }
    // Binomial: 10 expected, standard deviation 3; 19 is three of them above.
    assert!(failures[0] <= 19, "replicate blocks: {failures:?}");
    // The fault this guards against: pixels taken as independent. Blocks of 16 then err by a factor of about 5.
    assert!(failures[1] >= 90, "taken as independent nearly all should fail: {failures:?}");
}

#[test]
fn dark_films_agree_and_light_against_dark_does_not() {
    let dark = film(1, [32, 32], 0.05, 1, |_, _| 0.0);
    let lit = film(2, [32, 32], 0.05, 1, |_, _| 1.0);
    let both = compare(&dark, &dark, 1e-3).unwrap();
    assert!(both.passed);
    assert_eq!(both.tests.iter().map(|test| test.cells).sum::<usize>(), 0);
    assert_eq!(both.ratio, None);
    assert!(!compare(&dark, &lit, 1e-3).unwrap().passed);
    assert!(!compare(&lit, &dark, 1e-3).unwrap().passed);
}

#[test]
fn a_dark_hole_in_one_film_is_found() {
    let hole = |x: u32, y: u32| {
        if (8..12).contains(&x) && (8..12).contains(&y) { 0.0 } else { 1.0 }
    };
    let whole = film(1, [64, 64], 0.05, 1, |_, _| 1.0);
    let holed = film(2, [64, 64], 0.05, 1, hole);
    assert!(!compare(&whole, &holed, 1e-3).unwrap().passed);
}

#[test]
fn sparse_light_is_judged_in_blocks_only() {
    // A block of 16 has a relative error of 3/16, so 28 contributions; one of 64 has 455.
    let sparse = |seed| film(seed, [128, 128], 3.0, 1, |_, _| 1.0);
    let result = compare(&sparse(1), &sparse(2), 1e-3).unwrap();
    assert_eq!(result.tests[0].cells, 0);
    assert_eq!(result.tests[2].cells, 0);
    assert!(result.tests[3].cells == 4 && result.tests[4].cells == 1);
    assert!(result.passed);
}

/// A film of few heavy contributions has neighbourhoods without any: they say nothing against a film of many light
/// ones.
#[test]
fn light_too_sparse_for_a_neighbourhood_is_no_hole() {
    let (size, count) = ([96, 96], 5e-4);
    for seed in 0..10 {
        let sparse = counted(seed, size, count);
        let smooth = film(seed + 100, size, 0.01, 1, |_, _| count);
        assert!(compare(&smooth, &sparse, 1e-3).unwrap().passed, "{seed}");
        assert!(compare(&sparse, &smooth, 1e-3).unwrap().passed, "{seed}");
        let brighter = film(seed + 200, size, 0.01, 1, |_, _| 2.5 * count);
        assert!(!compare(&sparse, &brighter, 1e-3).unwrap().passed, "{seed}");
    }
}

#[test]
fn cells_near_the_least_light_are_not_chosen_by_their_own_noise() {
    // 16 replicates of 7.5: 120 contributions a pixel.
    let [a, b] = [1, 2].map(|seed| counted(seed, [64, 64], 7.5));
    let pixels = compare(&a, &b, 1e-3).unwrap().tests[0];
    // Standard deviation of the mean of 4096 squares: sqrt(2/4096) = 0.022; a choice by own variance gives 1.15.
    assert!(pixels.cells > 3500, "{pixels:?}");
    assert!((pixels.mean_square - 1.0).abs() < 0.09, "{pixels:?}");
}

#[test]
fn a_noisy_film_below_the_least_light_is_not_judged_where_it_happens_to_be_bright() {
    // 90 contributions a pixel against a film of 200 times less variance: chosen by the plain mean of both, the cells
    // above 100 were all too bright (their squares averaged 4.2).
    let size = [96, 72];
    let noisy = counted(5, size, 90.0 / f64::from(REPLICATES));
    let fine = film(6, size, 0.0075, 1, |_, _| 90.0 / f64::from(REPLICATES));
    let comparison = compare(&noisy, &fine, 1e-3).unwrap();
    assert!(comparison.passed);
    assert_eq!(comparison.tests[0].cells, 0);
}

#[test]
fn films_without_noise_agree_to_rounding_and_no_further() {
    let exact =
        |value: f32| Film { width: 8, height: 8, mean: vec![value; 64], variance: vec![0.0; 64], ..Film::default() };
    assert!(compare(&exact(1.0), &exact(1.000_003), 1e-3).unwrap().passed);
    assert!(!compare(&exact(1.0), &exact(1.000_1), 1e-3).unwrap().passed);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let good = film(1, [8, 8], 0.1, 1, |_, _| 1.0);
    let other_size = film(1, [8, 9], 0.1, 1, |_, _| 1.0);
    assert!(matches!(compare(&good, &other_size, 1e-3), Err(CompareError::Size { .. })));
    assert!(matches!(compare(&good, &good, 0.0), Err(CompareError::Level(_))));
    let mut single = good.clone();
    single.replicates = 1;
    assert!(matches!(compare(&good, &single, 1e-3), Err(CompareError::OneReplicate { .. })));
    let mut broken = good.clone();
    broken.mean[3] = f32::NAN;
    assert!(matches!(compare(&broken, &good, 1e-3), Err(CompareError::Value { index: 3, .. })));
    let mut short = good.clone();
    short.variance.pop();
    assert!(matches!(compare(&short, &good, 1e-3), Err(CompareError::Shape { .. })));
}

#[test]
fn the_ratio_and_its_interval_hold_the_truth() {
    let a = film(1, [32, 32], 0.1, 1, |_, _| 1.0);
    let b = film(2, [32, 32], 0.1, 1, |_, _| 1.5);
    let ratio = compare(&a, &b, 1e-3).unwrap().ratio.unwrap();
    // Both means err by 0.1/32 relative: the ratio by 1.5 * 0.0044 = 0.0066, its half interval is about twice that.
    assert!(ratio.low < 1.5 && 1.5 < ratio.high, "{ratio:?}");
    assert!((0.008..0.022).contains(&(ratio.high - ratio.value)), "{ratio:?}");
}

/// Bright pixels with noise of their own (LEDs), and a dim disc, ten times as many, whose noise is common.
fn bright_and_dim(seed: u64) -> Film {
    let mut noise = Noise(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let mut sums = BlockAccumulator::new(48, 32);
    for _ in 0..REPLICATES {
        let common = noise.normal();
        let mut pixel = |k: u32| match k % 48 {
            0..4 => 1000.0 * (1.0 + 0.2 * noise.normal()),
            4..44 => 1.0 + 0.01 * common + 0.003 * noise.normal(),
            _ => 0.0,
        };
        sums.add(&(0..48 * 32).map(&mut pixel).collect::<Vec<_>>()).unwrap();
    }
    sums.finish()
}

#[test]
fn dim_cells_that_move_together_beside_bright_ones_that_do_not_give_no_alarm() {
    let level = 0.05;
    let blind = |film: &Film| Film { correlation: Vec::new(), ..film.clone() };
    let mut failures = [0; 2];
    for seed in 0..100 {
        let [a, b] = [2 * seed, 2 * seed + 1].map(bright_and_dim);
        let pairs = [(a.clone(), b.clone()), (blind(&a), blind(&b))];
        for (count, (a, b)) in failures.iter_mut().zip(&pairs) {
            *count += u32::from(!compare(a, b, level).unwrap().passed);
        }
    }
    // Binomial: 5 expected, standard deviation 2.2; 11 is three of them above.
    assert!(failures[0] <= 11, "{failures:?}");
    // The fault this guards against: cells taken to be independent.
    assert!(failures[1] >= 15, "cells taken as independent: {failures:?}");
}

#[test]
fn a_change_as_large_as_said_is_seen_in_nine_of_ten_cases() {
    let (mut pixel, mut whole) = (0, 0);
    for seed in 0..100 {
        let [a, b] = [2 * seed, 2 * seed + 1].map(|seed| film(seed, [32, 32], 0.05, 1, |_, _| 1.0));
        let tests = compare(&a, &b, 0.05).unwrap().tests;
        let change = |test: &LevelTest| 1.0 + test.smallest_change.unwrap() as f32;
        let mut fault = b.clone();
        fault.mean[tests[0].median_cell.unwrap()] *= change(&tests[0]);
        pixel += u32::from(!compare(&a, &fault, 0.05).unwrap().tests[0].passed);
        let mut fault = b.clone();
        fault.blocks[3].mean[0] *= change(&tests[4]);
        whole += u32::from(!compare(&a, &fault, 0.05).unwrap().tests[4].passed);
    }
    // Binomial: 90 expected, standard deviation 3. The sum of squares and chance alarms add a little.
    assert!((81..=100).contains(&pixel) && (81..=99).contains(&whole), "{pixel} and {whole} of 100");
}
