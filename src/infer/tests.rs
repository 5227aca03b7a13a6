use super::*;
use crate::camera::noise::PixelRandom;
use crate::emulate::Slopes;
use crate::estimate::Value;
use faer::linalg::solvers::{DenseSolveCore as _, Llt};
use faer::{Mat, Side};
use rayon::prelude::*;
use std::sync::LazyLock;

const LENGTH: usize = 600;
const CASES: u32 = 40;

fn unknowns() -> Vec<Unknown> {
    let one = |name: &str, prior| Unknown { name: name.into(), prior, followed: Followed::Coordinate };
    vec![
        one("size", Prior::LogUniform { low: 4.0, high: 14.0 }),
        one("depth", Prior::Uniform { low: 2.0, high: 11.0 }),
        one("brightness", Prior::Uniform { low: -0.3, high: 0.3 }),
    ]
}

/// A bump whose width and height follow size and depth, in two frames.
fn light(place: &[f64]) -> Vec<f64> {
    let (size, depth, brightness) = (place[0].exp(), place[1], place[2]);
    let height = 0.4 * (size / (depth + 0.5 * size)).powi(2);
    let width = 0.6 * (depth + 0.5 * size);
    let at = |i: usize| {
        let r = 15.0 * (i % 300) as f64 / 300.0;
        let deep = if i < 300 { 0.6 } else { 1.0 };
        brightness * deep + (1.0 + height * deep * (-(r / width).powi(2)).exp()).ln()
    };
    (0..LENGTH).map(at).collect()
}

/// Noise that neighbours share, and the camera's.
fn noisy(light: Vec<f64>, shared: f64, own: f64, random: &mut PixelRandom) -> Vec<f64> {
    let knots: Vec<f64> = (0..=LENGTH / 20).map(|_| shared * random.normal()).collect();
    let at = |(i, v): (usize, f64)| {
        let (k, u) = (i / 20, (i % 20) as f64 / 20.0);
        v + knots[k] * (1.0 - u) + knots[k + 1] * u
    };
    let smooth: Vec<f64> = light.into_iter().enumerate().map(at).collect();
    smooth.into_iter().map(|v| v + own * random.normal()).collect()
}

fn drawn(random: &mut PixelRandom) -> Vec<f64> {
    let along = |unknown: &Unknown, u: f64| {
        let [low, high] = unknown.prior.bounds();
        low + (high - low) * u
    };
    unknowns().iter().map(|unknown| along(unknown, random.uniform())).collect()
}

/// Learnt from points whose first unknown is told wrong by so much.
fn learnt(shift: f64) -> Learnt {
    let mut random = PixelRandom::new(7, 0);
    let points: Vec<Vec<f64>> = (0..150).map(|_| drawn(&mut random)).collect();
    let vectors: Vec<Vec<f64>> = points.iter().map(|p| noisy(light(p), 0.01, 0.002, &mut random)).collect();
    let told: Vec<Vec<f64>> = points.iter().map(|p| vec![p[0] + shift, p[1], p[2]]).collect();
    Learnt::from(unknowns(), &told, &vectors, vec![100.0; LENGTH], (0..LENGTH).collect()).unwrap()
}

/// Learnt from points as they are.
static LEARNT: LazyLock<Learnt> = LazyLock::new(|| learnt(0.0));

/// What follows the unknowns beside the frames.
fn number(place: &[f64]) -> f64 {
    place[0] + 0.1 * place[1]
}

/// A number beside the frames makes intervals shorter, and they still hold; one that is wrong shows in the misfit.
#[test]
fn a_number_beside_the_frames_tells_more_and_a_wrong_one_shows() {
    const ERROR: f64 = 0.01;
    let mut learnt = LEARNT.clone();
    let mut random = PixelRandom::new(17, 0);
    let points: Vec<Vec<f64>> = (0..150).map(|_| drawn(&mut random)).collect();
    let numbers: Vec<Vec<f64>> = points.iter().map(|place| vec![number(place)]).collect();
    let scores = learnt.scored.processes.len();
    learnt.scored = learnt.scored.clone().and(&points, &numbers).unwrap();
    assert!(learnt.scored.is_whole(scores + 1) && !learnt.scored.is_whole(scores));
    let case = |case: u32| {
        let mut random = PixelRandom::new(19, case);
        let place = drawn(&mut random);
        let values = noisy(light(&place), 0.03, 0.002, &mut random).into_iter().map(Some).collect();
        let told = learnt.told(&Seen { values, variances: vec![0.002f64.powi(2); LENGTH] }).unwrap();
        let measured = number(&place) + ERROR * random.normal();
        let with = |off: f64| told.clone().and(scores, measured + off, ERROR.powi(2));
        let posterior = |told: &Told| learnt.scored.posterior(told, case).unwrap();
        let [alone, both, wrong] = [told.clone(), with(0.0), with(0.5)].map(|told| posterior(&told));
        let ends = |of: &Posterior, k: usize| {
            [0.025, 0.975].map(|share| unknowns()[k].prior.coordinate(of.quantile(k, share)))
        };
        let held = (0..3).filter(|&k| (ends(&both, k)[0]..=ends(&both, k)[1]).contains(&place[k])).count();
        let width = |of: &Posterior| ends(of, 0)[1] - ends(of, 0)[0];
        (held, width(&both) / width(&alone), wrong.misfit / both.misfit.max(1.0))
    };
    let all: Vec<(usize, f64, f64)> = (0..CASES).into_par_iter().map(case).collect();
    let held: usize = all.iter().map(|one| one.0).sum();
    let middle = |of: &dyn Fn(&(usize, f64, f64)) -> f64| {
        let mut values: Vec<f64> = all.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (shorter, worse) = (middle(&|one| one.1), middle(&|one| one.2));
    // 95 of 100 expected; four standard deviations of 120 are 10.
    assert!(held >= 104 && shorter < 0.8 && worse > 2.0, "{held} of 120, {shorter}, {worse}");
}

/// How many intervals, with their half widths times `stretch`, hold the truth of each unknown; and the noise's factor.
fn held(learnt: &Learnt, shared: f64, stretch: f64) -> ([u32; 3], f64) {
    let case = |case: u32| {
        let mut random = PixelRandom::new(11, case);
        let place = drawn(&mut random);
        let values = noisy(light(&place), shared, 0.002, &mut random).into_iter().map(Some).collect();
        let told = learnt.told(&Seen { values, variances: vec![0.002f64.powi(2); LENGTH] }).unwrap();
        let posterior = learnt.scored.posterior(&told, case).unwrap();
        let held = [0, 1, 2].map(|k| {
            let prior = unknowns()[k].prior;
            let at = |share: f64| prior.coordinate(posterior.quantile(k, share));
            let middle = at(0.5);
            let [low, high] = [0.025, 0.975].map(|share| middle + stretch * (at(share) - middle));
            u32::from(low <= place[k] && place[k] <= high)
        });
        (held, told.noise_factor)
    };
    let all: Vec<([u32; 3], f64)> = (0..CASES).into_par_iter().map(case).collect();
    let held = [0, 1, 2].map(|k| all.iter().map(|(held, _)| held[k]).sum());
    (held, all.iter().map(|(_, factor)| factor / f64::from(CASES)).sum())
}

/// 95 of 100 expected; four standard deviations of 40 cases are 5.5.
#[test]
fn intervals_hold_the_truth_whatever_the_noise_of_the_light() {
    let learnt = &*LEARNT;
    for (shared, variance) in [(0.01, 1.0), (0.003, 0.09), (0.03, 9.0)] {
        let (held, factor) = held(learnt, shared, 1.0);
        assert!(held.iter().all(|held| *held >= 32), "{shared}: {held:?} of {CASES}");
        // The camera's noise is known; what is learnt of the light's, of 150 images, is good to a third.
        assert!((0.7 * variance..1.4 * variance + 0.1).contains(&factor), "{shared}: {factor}");
    }
}

/// An image that is its own mirror image has twice the variance along what follows the unknowns, of the same in each
/// half: told where mirror images are known, and nowhere else.
#[test]
fn noise_that_mirror_images_share_is_told() {
    const HALF: usize = LENGTH;
    let both = |light: &[f64], noise: [&[f64]; 2]| -> Vec<f64> {
        noise.into_iter().flat_map(|noise| light.iter().zip(noise).map(|(v, n)| v + n).collect::<Vec<_>>()).collect()
    };
    let mut random = PixelRandom::new(23, 0);
    let mut noise = || noisy(vec![0.0; HALF], 0.01, 0.002, &mut random);
    let mut places = PixelRandom::new(24, 0);
    let points: Vec<Vec<f64>> = (0..60).map(|_| drawn(&mut places)).collect();
    let vectors: Vec<Vec<f64>> = points.iter().map(|place| both(&light(place), [&noise(), &noise()])).collect();
    let mut factors = |alike: &dyn Fn(usize) -> usize| {
        let kinds = (0..2 * HALF).map(alike).collect();
        let learnt = Learnt::from(unknowns(), &points, &vectors, vec![100.0; 2 * HALF], kinds).unwrap();
        let factor = |values: Vec<f64>| {
            let values = values.into_iter().map(Some).collect();
            learnt.told(&Seen { values, variances: vec![0.0; 2 * HALF] }).unwrap().noise_factor
        };
        let mut sums = [0.0; 2];
        for _ in 0..20 {
            let (light, one, other) = (light(&drawn(&mut places)), noise(), noise());
            sums[0] += factor(both(&light, [&one, &other])) / 20.0;
            sums[1] += factor(both(&light, [&one, &one])) / 20.0;
        }
        sums
    };
    let [plain, mirrored] = factors(&|i| i % HALF);
    assert!((0.7..1.4).contains(&plain) && (1.4..2.8).contains(&mirrored), "{plain} {mirrored}");
    let [plain, mirrored] = factors(&|i| i);
    assert!((0.7..1.4).contains(&plain) && mirrored < 1.4, "{plain} {mirrored}");
}

/// Directions lean to the noise of what was learnt: frames that were not have scores as large as is predicted all the
/// same, and not as those of the former are.
#[test]
fn predicted_scores_are_those_of_other_frames() {
    const NOISE: f64 = 0.15;
    let mut random = PixelRandom::new(29, 0);
    let points: Vec<Vec<f64>> = (0..80).map(|_| drawn(&mut random)).collect();
    let vectors: Vec<Vec<f64>> = points.iter().map(|place| noisy(light(place), 0.0, NOISE, &mut random)).collect();
    let learnt = Learnt::from(unknowns(), &points, &vectors, vec![1.0 / NOISE; LENGTH], (0..LENGTH).collect()).unwrap();
    let weakest = learnt.own.len() - 1;
    let (mut products, mut squares) = (0.0, 0.0);
    for _ in 0..400 {
        let place = drawn(&mut random);
        let values = light(&place).into_iter().map(Some).collect();
        let told = learnt.told(&Seen { values, variances: vec![0.0; LENGTH] }).unwrap();
        let predicted = learnt.scored.at(&place)[weakest];
        products += told.scores[weakest] * predicted;
        squares += told.scores[weakest].powi(2);
    }
    // What is predicted over what is there, and over what there would be were the own noise left in.
    let (slope, own) = (products / squares, learnt.own[weakest]);
    let off = |slope: f64| (slope - 1.0).abs();
    assert!(own > 0.1 && off(slope) < 0.5 * off(slope / (1.0 - own)), "{slope}, own {own}");
}

/// Noise of more dimensions than components hold is stronger along scores, which are smooth, than across them: told as
/// strong as it is, and not as it is on the mean over all directions.
#[test]
fn noise_of_the_scores_is_that_of_their_own_directions() {
    const REACH: usize = 6;
    let mut random = PixelRandom::new(41, 0);
    let mut noise = || -> Vec<f64> {
        let own: Vec<f64> = (0..LENGTH + REACH).map(|_| 0.05 * random.normal()).collect();
        (0..LENGTH).map(|i| own[i..i + REACH].iter().sum::<f64>() / REACH as f64).collect()
    };
    let mut places = PixelRandom::new(43, 0);
    let points: Vec<Vec<f64>> = (0..150).map(|_| drawn(&mut places)).collect();
    let vectors: Vec<Vec<f64>> =
        points.iter().map(|place| light(place).iter().zip(noise()).map(|(v, n)| v + n).collect()).collect();
    let learnt = Learnt::from(unknowns(), &points, &vectors, vec![100.0; LENGTH], (0..LENGTH).collect()).unwrap();
    let values: Vec<Option<f64>> = light(&drawn(&mut places)).iter().zip(noise()).map(|(v, n)| Some(v + n)).collect();
    let told = learnt.told(&Seen { values, variances: vec![0.0; LENGTH] }).unwrap();
    let seeds = 400;
    let (mut along, mut all) = (vec![0.0; learnt.directions.len()], 0.0);
    for _ in 0..seeds {
        let noise: Vec<f64> = noise().into_iter().map(|v| 100.0 * v).collect();
        all += noise.iter().map(|v| v * v).sum::<f64>() / (LENGTH * seeds) as f64;
        for (sum, direction) in along.iter_mut().zip(&learnt.directions) {
            let score: f64 = direction.iter().zip(&noise).map(|(d, v)| d * v).sum();
            *sum += score * score / f64::from(seeds as u32);
        }
    }
    for (k, truth) in along.into_iter().enumerate() {
        // The variance of 150 points' noise, less what predictions miss, is known to an eighth; so is the factor.
        let said = told.covariance[(k, k)];
        assert!(
            (0.6..1.6).contains(&(said / truth)) && all < 0.4 * truth,
            "{k}: {said} for {truth}, on the mean {all}"
        );
    }
}

/// Errors of predictions are as large as where points are left out, and go together as these do.
#[test]
fn errors_are_those_of_points_left_out() {
    let mut random = PixelRandom::new(37, 0);
    let points: Vec<Vec<f64>> = (0..40).map(|_| vec![random.uniform()]).collect();
    let numbers: Vec<Vec<f64>> = points
        .iter()
        .map(|x| {
            let shared = 0.1 * random.normal();
            vec![x[0] + shared + 0.05 * random.normal(), x[0] * x[0] + shared]
        })
        .collect();
    let empty = Scored { unknowns: vec![], processes: vec![], variances: vec![], left_out: vec![] };
    let mut scored = empty.and(&points, &numbers).unwrap();
    // The residuals' correlation is 0.1 / sqrt(0.1^2 + 0.05^2) = 0.89, good to a few hundredths.
    let together = scored.left_out[0][1] / (scored.left_out[0][0] * scored.left_out[1][1]).sqrt();
    assert!((together - 0.89).abs() < 0.1 && scored.left_out[0][1] == scored.left_out[1][0], "{together}");
    scored.left_out = vec![vec![2.0, 0.9], vec![0.9, 0.5]];
    let noises = [0, 1].map(|k: usize| scored.processes[k].noise().powi(2));
    let found = scored.errors(&[1, 0], &[0.01, 0.02]);
    // Twice as large in all as the process says, its noise apart; never less than it says.
    let wanted = [0.01, 2.0 * (0.02 + noises[0]) - noises[0]];
    assert!((found[(0, 0)] / wanted[0] - 1.0).abs() < 1e-12 && (found[(1, 1)] / wanted[1] - 1.0).abs() < 1e-12);
    assert!((found[(0, 1)] / (0.9 * (wanted[0] * wanted[1]).sqrt()) - 1.0).abs() < 1e-12);
    assert_eq!(found[(0, 1)], found[(1, 0)]);
}

/// Wrong labels and intervals of a third of the width must show.
#[test]
fn faults_show_in_the_coverage() {
    let (short, _) = held(&LEARNT, 0.01, 0.33);
    assert!(short.iter().all(|held| *held < 29), "{short:?}");
    let (wrong, _) = held(&learnt(0.3), 0.003, 1.0);
    assert!(wrong[0] < 27, "{wrong:?}");
}

#[test]
fn frames_without_enough_elements_tell_nothing() {
    let learnt = &*LEARNT;
    let few = 10 * learnt.directions.len() - 1;
    let values = (0..LENGTH).map(|i| (i < few).then_some(0.0)).collect();
    assert_eq!(learnt.told(&Seen { values, variances: vec![0.0; LENGTH] }), None);
}

/// The bound by slopes that are known: of the light itself, as the scores see it.
fn true_bound(learnt: &Learnt, place: &[f64], told: &Told, stretch: f64) -> Vec<f64> {
    let score = |place: &[f64]| -> Vec<f64> {
        let weighted: Vec<f64> = light(place).iter().zip(&learnt.weights).map(|(v, weight)| v * weight).collect();
        learnt.directions.iter().map(|one| one.iter().zip(&weighted).map(|(d, v)| d * v).sum()).collect()
    };
    let slope = |i: usize| -> Vec<f64> {
        let moved = |step: f64| {
            score(&place.iter().enumerate().map(|(k, x)| x + if k == i { step } else { 0.0 }).collect::<Vec<_>>())
        };
        moved(1e-4).iter().zip(moved(-1e-4)).map(|(high, low)| stretch * (high - low) / 2e-4).collect()
    };
    let slopes = [slope(0), slope(1), slope(2)];
    let slopes = Mat::from_fn(learnt.directions.len(), 3, |k, i| slopes[i][k]);
    let inverse = |of: &Mat<f64>| Llt::new(of.as_ref(), Side::Lower).unwrap().inverse();
    let mut information = slopes.transpose() * (inverse(&told.covariance) * &slopes);
    // The brightness is integrated away: uniform from -0.3 to 0.3.
    information[(2, 2)] += 12.0 / 0.36;
    let least = inverse(&information);
    (0..3).map(|i| least[(i, i)].sqrt()).collect()
}

/// Bounds hold those by the light's own slopes, and slopes half as steep show.
#[test]
fn bounds_hold_what_the_lights_own_slopes_say() {
    let learnt = &*LEARNT;
    let variances = learnt.scored.variances_of_scores().unwrap();
    let case = |case: u32| {
        let mut random = PixelRandom::new(13, case);
        let place = drawn(&mut random);
        let values = learnt.vector(&learnt.scored.at(&place)).into_iter().map(Some).collect();
        let told = learnt.told(&Seen { values, variances: vec![0.002f64.powi(2); LENGTH] }).unwrap();
        let slopes: Vec<Slopes> = variances.iter().map(|one| learnt.scored.slopes(one, &place)).collect();
        let bounds = learnt.scored.bound(&slopes, &told.covariance, &[false, false, true]).unwrap();
        let held = |stretch: f64| {
            let held =
                bounds.iter().zip(true_bound(learnt, &place, &told, stretch)).take(2).filter(|(bound, truth)| {
                    let Value::Known { low, high, .. } = bound else { return false };
                    (*low..=*high).contains(truth)
                });
            held.count()
        };
        [held(1.0), held(0.5)]
    };
    let all: Vec<[usize; 2]> = (0..CASES).into_par_iter().map(case).collect();
    let held = [0, 1].map(|k| all.iter().map(|held| held[k]).sum::<usize>());
    // Of 80.
    assert!(held[0] >= 64 && held[1] < 40, "{held:?}");
}

/// Draws of 0 to 1: of those within 0.4 to 0.6 a quarter is below 0.45.
#[test]
fn ranks_are_those_among_what_truths_are_drawn_from() {
    let draws = (0..1000).map(|k| vec![f64::from(k) / 1000.0, f64::from(k % 10)]).collect();
    let posterior = Posterior { draws, misfit: 0.0, scores: vec![], worth: 1000.0 };
    let below = |ranges: &[Option<[f64; 2]>]| posterior.below(0, 0.45, ranges);
    assert_eq!(below(&[None, None]), Some(0.45));
    assert!((below(&[Some([0.4, 0.6]), None]).unwrap() - 0.25).abs() < 0.002);
    // The other one's range takes draws away, and says nothing of this one.
    assert!((below(&[None, Some([2.0, 5.0])]).unwrap() - 0.45).abs() < 0.002);
    assert_eq!(below(&[Some([2.0, 3.0]), None]), None);
}

/// Frames that are another phantom's are told, and none of those that are in their places.
#[test]
fn frames_that_do_not_go_with_the_others_are_told() {
    let mut random = PixelRandom::new(7, 0);
    let points: Vec<Vec<f64>> = (0..150).map(|_| drawn(&mut random)).collect();
    let mut vectors: Vec<Vec<f64>> = points.iter().map(|p| noisy(light(p), 0.01, 0.002, &mut random)).collect();
    let most = |off: &[f64]| off.iter().copied().fold(0.0, f64::max);
    // These are what it was learnt from.
    let clean = LEARNT.left_out(&vectors).unwrap();
    assert!(most(&clean) < 5.0, "{clean:?}");
    vectors[7] = vectors[8].clone();
    let learnt = Learnt::from(unknowns(), &points, &vectors, vec![100.0; LENGTH], (0..LENGTH).collect()).unwrap();
    let faulty = learnt.left_out(&vectors).unwrap();
    assert!(faulty[7] > 5.0 && faulty[7] == most(&faulty), "{faulty:?}");
}
