//! The least-squares fit.

use super::noise::{KINDS, Noise, Seen};
use super::told::{Told, middle, variance};
use super::unknowns::{DEPTH, MODULUS, MeshOf, NAMES, RADIUS, STRENGTH, Scanner, THICKNESS, WORDS, contrast};
use super::{Correlation, Fitted, Question, Tissue, TissueError, Value};
use crate::mechanics::frames::Frames;
use crate::progress::Stage;
use faer::linalg::solvers::{Llt, Solve as _};
use faer::{Mat, Side};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Tissues among which the fit starts.
const STARTS: u32 = 16;
/// Least strength at which it starts.
const LEAST_STRENGTH: f64 = 0.25;
/// Step of finite differences, in the coordinates.
const STEP: f64 = 0.01;
/// Longest step in a coordinate.
const FARTHEST: f64 = 0.3;
/// Most Gauss-Newton steps, and tries of one with more damping: with slopes that followed, and with new ones.
const MOST_STEPS: usize = 40;
const TRIES: [usize; 2] = [2, 5];
/// A step that makes the cost smaller by less than this ends the search on the coarse mesh.
const GAIN: f64 = 0.5;
/// What a feature costs that the measured frames have and the tissue's have not; most of them, as a share.
const MISSING: f64 = 9.0;
const MOST_MISSING: f64 = 0.1;
/// A step that is shorter than this, in standard deviations, ends the search.
const SHORT: f64 = 0.3;
/// How often a fine scan puts the coarse ones right.
const CORRECTIONS: usize = 12;
/// Error of the coarse mesh before it is known, as a share of each feature's size.
const COARSE_ERROR: f64 = 0.005;
/// Error of a feature on the fine mesh as a share of what that mesh put right, there and at the median of its kind; and
/// the share that all of a kind have in common.
const FINE_ERROR: f64 = 1.0;
const SHARED: f64 = 1.0;
/// Least size of a feature's error, kPa or mm.
const LEAST_ERROR: f64 = 1e-6;
/// Least chi square by degree of freedom at which the fit fails: something in the scene is not as in the frames.
const FAILS: f64 = 3.0;

/// A tissue, with its features.
#[derive(Clone)]
struct Place {
    point: Vec<f64>,
    /// As scanned, with the guessed modulus.
    frames: Frames,
    features: Vec<f64>,
    /// Sum of squares of the whitened residual.
    cost: f64,
}

struct Fit<'a> {
    scanner: Scanner<'a>,
    measured: &'a Frames,
    seen: Seen,
    positions_mm: Vec<f64>,
    ranges: Vec<[f64; 2]>,
    /// What a fine mesh adds to features of the coarse one.
    correction: Vec<f64>,
    /// Cholesky factor of the features' covariance.
    covariance: Llt<f64>,
    scans: AtomicUsize,
    /// Scans that are expected.
    expected: usize,
    observe: &'a (dyn Fn(Stage) -> bool + Sync),
}

pub(super) fn fit<'a>(
    measured: &'a Frames,
    question: &'a Question<'a>,
    observe: &'a (dyn Fn(Stage) -> bool + Sync),
) -> Result<Tissue, TissueError> {
    let scanner = Scanner::new(measured, question)?;
    let noise = Noise::of(measured, question.noise_kpa).ok_or(TissueError::NoNoise)?;
    let seen = Seen::of(measured, noise, &scanner.settings())?;
    let unknowns = scanner.unknowns();
    if seen.used.len() <= 2 * unknowns {
        return Err(TissueError::TooFew { features: seen.used.len(), needed: 2 * unknowns + 1 });
    }
    let sizes = typical_by_kind(&seen, &seen.values);
    let errors: Vec<f64> = seen.used.iter().map(|place| COARSE_ERROR * sizes[place % KINDS]).collect();
    let covariance = with_mesh(&seen, &errors, [0.0; KINDS])?;
    let mut fit = Fit {
        ranges: scanner.ranges(),
        correction: vec![0.0; seen.used.len()],
        measured,
        positions_mm: measured.as_slice().iter().map(|frame| frame.position_mm).collect(),
        scanner,
        seen,
        covariance,
        scans: AtomicUsize::new(0),
        expected: STARTS as usize + 6 * unknowns + 6,
        observe,
    };
    let mut here = fit.start()?;
    let mut slopes = fit.descend(&mut here)?;
    if question.by_force {
        fit.hold_forces(&here, noise)?;
    }
    let mut settled = false;
    for _ in 0..CORRECTIONS {
        fit.put_right(&mut here)?;
        slopes = fit.slopes(&here)?;
        // On the coarse mesh features jump from tissue to tissue: the step is the slopes' own.
        let mut step = fit.step(&slopes, &here, 0.0).ok_or(TissueError::NotFinite)?;
        settled = fit.is_short(&slopes, &step);
        if settled {
            // What is said of the fit is that of the fine mesh before this step.
            here.point = fit.inside(moved(&here.point, &step));
            break;
        }
        here = loop {
            match fit.at(fit.inside(moved(&here.point, &step)))? {
                Ok(place) => break place,
                Err(why) if fit.is_short(&slopes, &step) => return Err(TissueError::Unpressed(why)),
                Err(_) => step.iter_mut().for_each(|d| *d *= 0.5),
            }
        };
    }
    Ok(fit.tissue(&here, &slopes, settled, question, noise))
}

/// A point after a step.
fn moved(point: &[f64], step: &[f64]) -> Vec<f64> {
    point.iter().zip(step).map(|(x, d)| x + d).collect()
}

impl Fit<'_> {
    fn keeps_on(&self) -> bool {
        let done = self.scans.load(Ordering::Relaxed) as f64 / self.expected as f64;
        (self.observe)(Stage { done: done.min(0.99), what: "fitting the tissue" })
    }

    /// Frames of a tissue; the reason where there is no such tissue.
    fn scan(&self, point: &[f64], mesh: MeshOf) -> Result<Result<Frames, String>, TissueError> {
        let scanned = self.scanner.scan(point, mesh, &|| self.keeps_on())?;
        self.scans.fetch_add(usize::from(scanned.is_ok()), Ordering::Relaxed);
        Ok(scanned)
    }

    /// Used features of frames with the modulus of a point; the reason where too many are missing.
    fn read(&self, frames: &Frames, point: &[f64]) -> Result<Result<Vec<f64>, String>, TissueError> {
        let picked = self.seen.pick(&self.scanner.features(frames, point)?);
        let missing = picked.iter().filter(|value| value.is_nan()).count() as f64;
        Ok(match missing > MOST_MISSING * picked.len() as f64 {
            true => Err("the frames have not the features of the measured ones".to_owned()),
            false => Ok(picked),
        })
    }

    /// Used features of a tissue.
    fn features(&self, point: &[f64], mesh: MeshOf) -> Result<Result<Vec<f64>, String>, TissueError> {
        match self.scan(point, mesh)? {
            Ok(frames) => self.read(&frames, point),
            Err(why) => Ok(Err(why)),
        }
    }

    /// Lets the noise of the forces that are held count.
    fn hold_forces(&mut self, here: &Place, noise: Noise) -> Result<(), TissueError> {
        let harder = self.scanner.pressed_harder(STEP);
        let scanned = harder.scan(&here.point, MeshOf::Coarse, &|| self.keeps_on())?;
        let frames = scanned.map_err(TissueError::Unpressed)?;
        self.scans.fetch_add(1, Ordering::Relaxed);
        let pressed = self.seen.pick(&harder.features(&frames, &here.point)?);
        let by_force = pressed.iter().zip(&here.features).map(|(more, less)| or_nothing((more - less) / STEP.ln_1p()));
        let by_force: Vec<f64> = by_force.collect();
        self.seen.hold_forces(self.measured, noise, &self.scanner.settings(), &by_force);
        Ok(())
    }

    fn whitened(&self, values: &[f64]) -> Mat<f64> {
        let mut right = Mat::from_fn(values.len(), 1, |k, _| values[k]);
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            self.covariance.L(),
            right.as_mut(),
            faer::Par::Seq,
        );
        right
    }

    /// What the tissue leaves of the measured features, whitened; nothing of those that it has not.
    fn residual(&self, features: &[f64]) -> Mat<f64> {
        let seen = self.seen.values.iter().zip(features).zip(&self.correction);
        self.whitened(&seen.map(|((y, f), d)| or_nothing(y - f - d)).collect::<Vec<_>>())
    }

    fn cost(&self, features: &[f64]) -> f64 {
        let missing = features.iter().filter(|value| value.is_nan()).count() as f64;
        self.residual(features).squared_norm_l2() + MISSING * missing
    }

    fn at(&self, point: Vec<f64>) -> Result<Result<Place, String>, TissueError> {
        match self.scan(&point, MeshOf::Coarse)? {
            Ok(frames) => self.place(point, frames),
            Err(why) => Ok(Err(why)),
        }
    }

    fn place(&self, point: Vec<f64>, frames: Frames) -> Result<Result<Place, String>, TissueError> {
        let read = self.read(&frames, &point)?;
        Ok(read.map(|features| {
            let cost = self.cost(&features) + self.penalty(&point);
            Place { point, frames, features, cost }
        }))
    }

    /// The best of some tissues, each with the modulus that suits it best.
    fn start(&self) -> Result<Place, TissueError> {
        let sample = |row: u32, k: usize| f64::from(sobol_burley::sample(row, k as u32, 0));
        let tried: Vec<Result<Place, String>> = (0..STARTS)
            .into_par_iter()
            .map(|row| {
                let within = |(k, [low, high]): (usize, &[f64; 2])| match k {
                    MODULUS => 0.5 * (low + high),
                    // Without contrast the radius has no slope.
                    STRENGTH => LEAST_STRENGTH + (high - LEAST_STRENGTH) * sample(row, k),
                    // The ends are where frames change least.
                    k => low + (high - low) * (0.15 + 0.7 * sample(row, k)),
                };
                let point: Vec<f64> = self.ranges.iter().enumerate().map(within).collect();
                if !self.scanner.is_scanned(MODULUS) {
                    return self.scaled(point);
                }
                let stiff = self.scanner.as_stiff(&point, &|| self.keeps_on())?;
                self.scans.fetch_add(1, Ordering::Relaxed);
                match stiff {
                    Ok(point) => self.at(self.inside(point)),
                    Err(why) => Ok(Err(why)),
                }
            })
            .collect::<Result<_, TissueError>>()?;
        let mut why = String::new();
        let mut best: Option<Place> = None;
        for place in tried {
            match place {
                Ok(place) if best.as_ref().is_none_or(|best| place.cost < best.cost) => best = Some(place),
                Ok(_) => {}
                Err(reason) => why = reason,
            }
        }
        best.ok_or(TissueError::NoStart(why))
    }

    /// A tissue with the modulus that makes its pressures those of the frames, by their sum.
    fn scaled(&self, mut point: Vec<f64>) -> Result<Result<Place, String>, TissueError> {
        let frames = match self.scan(&point, MeshOf::Coarse)? {
            Ok(frames) => frames,
            Err(why) => return Ok(Err(why)),
        };
        let factor = sum(self.measured) / (sum(&frames) * self.scanner.scale(&point));
        if !(factor > 0.0 && factor.is_finite()) {
            return Ok(Err("the frames have no pressure".to_owned()));
        }
        point[MODULUS] += factor.ln();
        self.place(self.inside(point), frames)
    }

    fn inside(&self, point: Vec<f64>) -> Vec<f64> {
        point.into_iter().zip(&self.ranges).map(|(x, [low, high])| x.clamp(*low, *high)).collect()
    }

    /// Derivatives of the features by the unknowns, whitened.
    fn slopes(&self, here: &Place) -> Result<Mat<f64>, TissueError> {
        let columns: Vec<Vec<f64>> = (0..here.point.len())
            .into_par_iter()
            .map(|k| {
                if !self.scanner.is_scanned(k) {
                    let mut point = here.point.clone();
                    point[k] += STEP;
                    let other = self.read(&here.frames, &point)?.map_err(TissueError::Unpressed)?;
                    return Ok(change(&other, &here.features, STEP));
                }
                let mut why = String::new();
                for step in [STEP, -STEP] {
                    let mut point = here.point.clone();
                    point[k] += step;
                    match self.features(&point, MeshOf::Neighbour(&here.point))? {
                        Ok(features) => {
                            return Ok(change(&features, &here.features, step));
                        }
                        Err(reason) => why = reason,
                    }
                }
                Err(TissueError::Unpressed(why))
            })
            .collect::<Result<_, TissueError>>()?;
        let mut slopes = Mat::zeros(self.seen.used.len(), columns.len());
        for (k, column) in columns.iter().enumerate() {
            slopes.col_mut(k).copy_from(self.whitened(column).col(0));
        }
        Ok(slopes)
    }

    /// Gauss-Newton steps with damping until they are short. The slopes follow the steps (Broyden), and are computed
    /// anew where a step fails by them.
    fn descend(&self, here: &mut Place) -> Result<Mat<f64>, TissueError> {
        let (mut slopes, mut fresh) = (self.slopes(here)?, true);
        let (mut damping, mut fails) = (0.0, 0);
        for _ in 0..MOST_STEPS {
            let step = self.step(&slopes, here, damping);
            if damping == 0.0 && step.as_ref().is_some_and(|step| self.is_short(&slopes, step)) {
                break;
            }
            let point = step.map(|step| self.inside(moved(&here.point, &step)));
            let tried = match point {
                Some(point) => self.at(point)?.ok(),
                None => None,
            };
            match tried.filter(|place| place.cost < here.cost) {
                Some(place) => {
                    let gain = here.cost - place.cost;
                    self.follow(&mut slopes, here, &place);
                    (*here, fresh, fails) = (place, false, 0);
                    damping *= 0.1;
                    if gain < GAIN {
                        break;
                    }
                }
                None if fails < TRIES[usize::from(fresh)] => {
                    fails += 1;
                    damping = f64::max(10.0 * damping, 1e-2);
                }
                None if fresh => break,
                None => {
                    (slopes, fresh, fails, damping) = (self.slopes(here)?, true, 0, 0.0);
                }
            }
        }
        Ok(slopes)
    }

    /// Slopes that agree with what a step changed.
    fn follow(&self, slopes: &mut Mat<f64>, from: &Place, to: &Place) {
        let way: Vec<f64> = to.point.iter().zip(&from.point).map(|(a, b)| a - b).collect();
        let square = way.iter().map(|d| d * d).sum::<f64>();
        if square > 0.0 {
            let step = Mat::from_fn(way.len(), 1, |k, _| way[k]);
            let change: Vec<f64> = to.features.iter().zip(&from.features).map(|(a, b)| or_nothing(a - b)).collect();
            let missed = self.whitened(&change) - &*slopes * &step;
            *slopes += missed * step.transpose() * faer::Scale(1.0 / square);
        }
    }

    /// The step of a damped linear fit, at most `FARTHEST` in any coordinate. Damping is a share of the squares of the
    /// slopes.
    fn step(&self, slopes: &Mat<f64>, here: &Place, damping: f64) -> Option<Vec<f64>> {
        let mut normal = self.normal(slopes, 1.0);
        (0..normal.nrows()).for_each(|k| normal[(k, k)] *= 1.0 + damping);
        let mut right = slopes.transpose() * self.residual(&here.features);
        for (k, range) in self.ranges.iter().enumerate() {
            right[(k, 0)] += (middle(range) - here.point[k]) / variance(range);
        }
        let step = Llt::new(normal.as_ref(), Side::Lower).ok()?.solve(&right);
        let longest = (0..step.nrows()).map(|k| step[(k, 0)].abs()).fold(0.0, f64::max);
        let shorter = (FARTHEST / longest).min(1.0);
        longest.is_finite().then(|| (0..step.nrows()).map(|k| shorter * step[(k, 0)]).collect())
    }

    /// What a point costs beforehand: as normal as its range is wide, which matters only where frames tell nothing.
    fn penalty(&self, point: &[f64]) -> f64 {
        self.ranges.iter().zip(point).map(|(range, x)| (x - middle(range)).powi(2) / variance(range)).sum()
    }

    /// The inverse of the unknowns' covariance, where that of the features is widened by a factor.
    fn normal(&self, slopes: &Mat<f64>, widened: f64) -> Mat<f64> {
        let mut normal = slopes.transpose() * slopes * faer::Scale(1.0 / widened);
        self.ranges.iter().enumerate().for_each(|(k, range)| normal[(k, k)] += 1.0 / variance(range));
        normal
    }

    /// Whether a step is short, in standard deviations.
    fn is_short(&self, slopes: &Mat<f64>, step: &[f64]) -> bool {
        (slopes * Mat::from_fn(step.len(), 1, |k, _| step[k])).norm_l2() < SHORT
    }

    /// Takes what a fine mesh adds at this tissue for what it adds nearby.
    fn put_right(&mut self, here: &mut Place) -> Result<(), TissueError> {
        let fine = self.features(&here.point, MeshOf::Fine)?.map_err(TissueError::Unpressed)?;
        self.correction = fine.iter().zip(&here.features).map(|(fine, coarse)| or_nothing(fine - coarse)).collect();
        let typical = typical_by_kind(&self.seen, &self.correction);
        let error = |(d, place): (&f64, &usize)| FINE_ERROR * (d.abs() + typical[place % KINDS]);
        let errors: Vec<f64> = self.correction.iter().zip(&self.seen.used).map(error).collect();
        self.covariance = with_mesh(&self.seen, &errors, typical.map(|size| SHARED * size))?;
        here.cost = self.cost(&here.features) + self.penalty(&here.point);
        Ok(())
    }

    /// What is said of the tissue.
    fn tissue(&self, here: &Place, slopes: &Mat<f64>, settled: bool, question: &Question, noise: Noise) -> Tissue {
        let missing = here.features.iter().filter(|value| value.is_nan()).count() as f64;
        let freedom = (self.seen.used.len() - here.point.len()) as f64 - missing;
        let chi = self.residual(&here.features).squared_norm_l2() / freedom.max(1.0);
        let told = Told::of(&here.point, &self.normal(slopes, chi.max(1.0)), &self.ranges, question.seed);
        let fails = self.fails(here, chi, settled);
        let value = |of: &dyn Fn(&[f64]) -> f64, unknowns: &[usize]| match (&fails, &told) {
            (Some(why), _) => Value::undefined(why),
            (None, None) => Value::undefined("the covariance of the estimates has no factor"),
            (None, Some(told)) => told.value(&here.point, of, unknowns, &self.ranges),
        };
        let modulus = |x: &[f64]| x[MODULUS].exp();
        Tissue {
            held: if question.by_force { "force" } else { "depth" },
            thickness_mm: value(&|x| x[THICKNESS].exp(), &[THICKNESS]),
            tissue_youngs_kpa: value(&modulus, &[MODULUS]),
            radius_mm: value(&|x| x[RADIUS].exp(), &[RADIUS]),
            // Of a weak inclusion frames tell a product of contrast and size, at some depth.
            inclusion_youngs_kpa: value(&|x| modulus(x) * contrast(x[STRENGTH]), &[STRENGTH, RADIUS, DEPTH, MODULUS]),
            contrast: value(&|x| contrast(x[STRENGTH]), &[STRENGTH, RADIUS, DEPTH]),
            depth_mm: question.free_depth.then(|| value(&|x| x[DEPTH].exp(), &[DEPTH])),
            correlation: Correlation {
                names: NAMES[..here.point.len()].to_vec(),
                rows: told.as_ref().map(Told::correlation).unwrap_or_default(),
            },
            noise,
            features: self.seen.used.len(),
            reduced_chi_square: chi,
            reference: "the frame farthest from position 0",
            scans: self.scans.load(Ordering::Relaxed),
            fitted: self.fitted(here),
        }
    }

    /// Why nothing is said of the tissue.
    fn fails(&self, here: &Place, chi: f64, settled: bool) -> Option<String> {
        if settled && chi <= FAILS {
            return None;
        }
        let at_end = |k: &usize| {
            let [low, high] = self.ranges[*k];
            let margin = 0.01 * (high - low);
            here.point[*k] < low + margin || here.point[*k] > high - margin
        };
        if let Some(k) = (0..here.point.len()).find(at_end) {
            return Some(format!(
                "nothing fits within the ranges: the {} goes to an end of its own; is the guess right, are the units?",
                WORDS[k]
            ));
        }
        Some(match settled {
            true => format!(
                "the frames are not those of such a tissue: the fit leaves {:.1} times what noise and mesh explain",
                chi.sqrt()
            ),
            false => "the fit did not settle".to_owned(),
        })
    }

    /// The features that were fitted, frame by frame.
    fn fitted(&self, here: &Place) -> Vec<Fitted> {
        let mut all = vec![[None; KINDS]; self.positions_mm.len()];
        for ((value, correction), place) in here.features.iter().zip(&self.correction).zip(&self.seen.used) {
            all[place / KINDS][place % KINDS] = Some(value + correction).filter(|value| value.is_finite());
        }
        let named = |(&position_mm, [peak_kpa, base_kpa, fwhm_mm, eccentricity]): (&f64, [Option<f64>; KINDS])| {
            Fitted { position_mm, peak_kpa, base_kpa, fwhm_mm, eccentricity }
        };
        self.positions_mm.iter().zip(all).map(named).collect()
    }
}

/// Slopes of features by finite differences.
fn change(to: &[f64], from: &[f64], step: f64) -> Vec<f64> {
    to.iter().zip(from).map(|(a, b)| or_nothing((a - b) / step)).collect()
}

/// Sum of all pressures.
fn sum(frames: &Frames) -> f64 {
    frames.as_slice().iter().flat_map(|frame| &frame.pressure_kpa).sum()
}

/// A number, or 0 where a feature is missing.
fn or_nothing(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value }
}

/// Median size of values of each kind of feature.
fn typical_by_kind(seen: &Seen, values: &[f64]) -> [f64; KINDS] {
    std::array::from_fn(|kind| {
        let of_kind = values.iter().zip(&seen.used).filter(|(_, place)| **place % KINDS == kind);
        let mut sizes: Vec<f64> = of_kind.map(|(value, _)| value.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        sizes.get(sizes.len() / 2).copied().unwrap_or(0.0).max(LEAST_ERROR)
    })
}

/// Covariance of noise and mesh, factorised: of the mesh each feature's own error, and one that a kind shares.
fn with_mesh(seen: &Seen, own: &[f64], shared: [f64; KINDS]) -> Result<Llt<f64>, TissueError> {
    let mut whole = seen.covariance.clone();
    for (i, a) in seen.used.iter().enumerate() {
        whole[(i, i)] += own[i].powi(2);
        for (j, _) in seen.used.iter().enumerate().filter(|(_, b)| *b % KINDS == a % KINDS) {
            whole[(i, j)] += shared[a % KINDS].powi(2);
        }
    }
    // All parts are squares and the second is above 0: only numbers that are not finite have no factor.
    Llt::new(whole.as_ref(), Side::Lower).map_err(|_| TissueError::NotFinite)
}
