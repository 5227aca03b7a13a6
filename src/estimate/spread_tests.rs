//! Coverage on made-up light: replicates whose pixels move together, seen by a camera with noise.

use super::*;
use crate::camera::{expose, noise::PixelRandom};
use crate::estimate::{PaperEstimate, measure};
use crate::film::{BlockAccumulator, Film};
use crate::scene::{Camera, Scene, preset};

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;
const REPLICATES: u32 = 16;
const SEEDS: u32 = 300;

fn scene() -> Scene {
    let mut scene = preset("phantom-size-8mm").unwrap().scene;
    scene.camera.pixels = [WIDTH, HEIGHT];
    scene
}

/// Radiance that the camera reads as one grey level.
fn grey_level(scene: &Scene) -> f64 {
    let film = |radiance| Film { width: WIDTH, height: HEIGHT, mean: vec![radiance; 3072], ..Film::default() };
    let [dark, lit] =
        [0.0, 1.0].map(|radiance| Exposed::new(&film(radiance), &scene.camera, 532.0).unwrap().signal(1560).mean);
    1.0 / (lit - dark)
}

/// A film of a spot of `peak` grey levels. Each replicate has 8 % of noise in its brightness, 6 grey levels of noise in
/// waves of 8 to 25 pixels and 4 of each pixel's own.
fn film(peak: f64, seed: u32, grey: f64, together: bool) -> Film {
    let mut sum = BlockAccumulator::new(WIDTH, HEIGHT);
    let mut replicates: Vec<Vec<f64>> = Vec::new();
    for replicate in 0..REPLICATES {
        let mut random = PixelRandom::new(seed, replicate);
        let brightness = 1.0 + 0.08 * random.normal();
        let waves: [[f64; 4]; 6] = std::array::from_fn(|_| {
            [random.normal() * 0.2, random.normal() * 0.2, 6.3 * random.uniform(), random.normal()]
        });
        // The sine of a sum, from sines and cosines along columns and rows.
        let along = |count: u32, slope: usize, phase: f64| -> Vec<[(f64, f64); 6]> {
            let angles = |i: u32| -> [f64; 6] {
                std::array::from_fn(|k| waves[k][slope] * (f64::from(i) + 0.5) + phase * waves[k][2])
            };
            (0..count).map(|i| angles(i).map(f64::sin_cos)).collect()
        };
        let (columns, rows) = (along(WIDTH, 0, 0.0), along(HEIGHT, 1, 1.0));
        let pixel = |i: u32| {
            let (column, row) = (i % WIDTH, i / WIDTH);
            let (x, y) = (f64::from(column) + 0.5, f64::from(row) + 0.5);
            let sines = columns[column as usize].iter().zip(&rows[row as usize]);
            let spot = peak * (-((x - 30.3).powi(2) + (y - 24.8).powi(2)) / (2.0 * 9.0f64.powi(2))).exp();
            let waves: f64 = (waves.iter().zip(sines))
                .map(|(wave, ((sin_x, cos_x), (sin_y, cos_y)))| wave[3] * (sin_x * cos_y + cos_x * sin_y))
                .sum();
            let own = PixelRandom::new(seed ^ 0x5000_0000, i * REPLICATES + replicate).normal();
            // Sixteen times brighter than all noise: no radiance falls below 0.
            grey * (60.0 + spot * brightness + 6.0 * waves / 3f64.sqrt() + 4.0 * own)
        };
        replicates.push((0..WIDTH * HEIGHT).map(pixel).map(|radiance| radiance.max(0.0)).collect());
    }
    for replicate in 0..REPLICATES {
        let pick = |i: usize| match together {
            true => replicates[replicate as usize][i],
            // Each pixel takes another replicate: the same mean and variance, no correlation left.
            false => replicates[((u64::from(replicate) + mixed(i)) % u64::from(REPLICATES)) as usize][i],
        };
        sum.add(&(0..(WIDTH * HEIGHT) as usize).map(pick).collect::<Vec<_>>()).unwrap();
    }
    sum.finish()
}

fn mixed(i: usize) -> u64 {
    (PixelRandom::new(77, i as u32).uniform() * 16.0) as u64
}

fn read(film: &Film, reference: Option<&Film>, camera: &Camera, seed: u32, threshold: f64) -> PaperEstimate {
    let shot = |film, seed| GreyImage::from_frame(&expose(film, camera, 532.0, seed).unwrap()).unwrap();
    let exposed = |film| Exposed::new(film, camera, 532.0).unwrap();
    let (image, frame) = (shot(film, 2 * seed), exposed(film));
    match reference {
        None => measure(&image, &frame, Subtracted::Nothing, threshold),
        Some(film) => {
            let image = image.minus(&shot(film, 2 * seed + 1)).unwrap();
            measure(&image, &frame, Subtracted::Frame(&exposed(film)), threshold)
        }
    }
}

/// How many intervals of M, d, column, row and h hold the mean of the figure over seeds.
fn held(all: &[PaperEstimate]) -> [usize; 5] {
    let figures = |paper: &PaperEstimate| {
        let [column, row] = [0, 1].map(|axis| paper.centroid_px.axis(axis));
        [paper.sum_grey.clone(), paper.diameter_px.clone(), column, row, paper.h_grey.clone()]
    };
    [0, 1, 2, 3, 4].map(|figure| {
        let known: Vec<[f64; 3]> = all
            .iter()
            .map(|paper| match figures(paper)[figure] {
                Value::Known { value, low, high } => [value, low, high],
                Value::Undefined { ref reason } => panic!("{reason}"),
            })
            .collect();
        let mean = known.iter().map(|known| known[0]).sum::<f64>() / known.len() as f64;
        known.iter().filter(|[_, low, high]| *low <= mean && mean <= *high).count()
    })
}

#[test]
fn intervals_hold_the_mean_over_seeds_in_95_percent_where_pixels_move_together() {
    let scene = scene();
    let grey = grey_level(&scene);
    let one = |seed| {
        let (with, without) = (film(60.0, 2 * seed, grey, true), film(0.0, 2 * seed + 1, grey, true));
        let raw = read(&with, None, &scene.camera, seed, 80.0);
        (raw, read(&with, Some(&without), &scene.camera, seed, 20.0))
    };
    let (raw, subtracted): (Vec<_>, Vec<_>) = (0..SEEDS).into_par_iter().map(one).unzip();
    for (what, all) in [("raw", raw), ("subtracted", subtracted)] {
        // 285 of 300 expected; four standard deviations are 15. An interval that always holds is too wide.
        let held = held(&all);
        assert!(held.iter().all(|held| (270..=299).contains(held)), "{what}: {held:?}");
    }
}

#[test]
fn pixels_taken_as_independent_would_be_caught() {
    // The fault: groups that do not know how pixels move together, as a variance a pixel does not.
    let independent = |subtracted: bool| {
        let scene = scene();
        let grey = grey_level(&scene);
        let ratio = |together| {
            let with = film(60.0, 1, grey, together);
            let without = film(0.0, 2, grey, together);
            let paper = read(&with, subtracted.then_some(&without), &scene.camera, 1, 20.0);
            match paper.sum_grey {
                Value::Known { low, high, .. } => high - low,
                Value::Undefined { reason } => panic!("{reason}"),
            }
        };
        ratio(true) / ratio(false)
    };
    assert!(independent(false) > 3.0 && independent(true) > 3.0, "{} {}", independent(false), independent(true));
}

#[test]
fn weights_of_a_place_go_from_a_centre_to_the_mean_of_all_places() {
    // w^2 + (1 - w)^2 by hand: 1 on a centre, 1/2 between two, 2/3 on average; the series is cut at 0.004.
    for (place, error, expected) in [(3.5, 0.0, 1.0), (4.0, 0.0, 0.5), (3.75, 0.0, 0.625), (3.5, 3.0, 2.0 / 3.0)] {
        assert!((bilinear_square(place, error) - expected).abs() < 0.005, "{place} {error}");
    }
}

/// Pixels that single paths light, by `rate` paths each: lit or not is a matter of one replicate.
fn sparse(rate: f64, seed: u32, grey: f64) -> Film {
    let mut sum = BlockAccumulator::new(WIDTH, HEIGHT);
    for replicate in 0..REPLICATES {
        let pixel = |i: u32| {
            let hits = PixelRandom::new(seed, i * REPLICATES + replicate).poisson(rate / f64::from(REPLICATES));
            30.0 * f64::from(REPLICATES) * grey * hits
        };
        sum.add(&(0..WIDTH * HEIGHT).map(pixel).collect::<Vec<_>>()).unwrap();
    }
    sum.finish()
}

#[test]
fn pixels_lit_by_single_paths_vary_as_their_number_does() {
    let scene = scene();
    let grey = grey_level(&scene);
    let films: Vec<Film> = (0..SEEDS).into_par_iter().map(|seed| sparse(0.1, 2 * seed, grey)).collect();
    let without = sparse(0.0, 1, grey);
    for subtracted in [false, true] {
        let all: Vec<[f64; 3]> = (0..SEEDS)
            .into_par_iter()
            .map(|seed| {
                match read(&films[seed as usize], subtracted.then_some(&without), &scene.camera, seed, 5.0).diameter_px
                {
                    Value::Known { value, low, high } => [value, low, high],
                    Value::Undefined { reason } => panic!("{reason}"),
                }
            })
            .collect();
        let mean = all.iter().map(|known| known[0]).sum::<f64>() / f64::from(SEEDS);
        let held = all.iter().filter(|[_, low, high]| *low <= mean && mean <= *high).count();
        // As above; the jackknife takes a pixel of two paths for certain and one of a single path for a whole one: p in
        // place of p (1 - p), 5 % in the spread.
        assert!((270..=299).contains(&held), "subtracted {subtracted}: {held}");
    }
}
