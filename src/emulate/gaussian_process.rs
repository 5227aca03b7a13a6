//! Gaussian processes with a trend: a smooth function of several variables, from noisy values at some points.
//!
//! ```text
//! y(x) = h(x)' beta + f(x) + noise,   cov f(x), f(x') = a^2 exp(-r^2 / 2),   r^2 = sum_i ((x_i - x'_i) / l_i)^2
//! ```
//!
//! h holds all monomials up to the second degree, beta is not known beforehand (universal kriging; Rasmussen and
//! Williams 2006, section 2.7). The lengths l_i, the amplitude a and the noise are those of the greatest restricted
//! likelihood (Patterson and Thompson, Biometrika 58(3), 1971), found by its average information matrix (Gilmour,
//! Thompson and Cullis, Biometrics 51(4), 1995), which takes no more than products with vectors. With
//! P = C^-1 - C^-1 H (H' C^-1 H)^-1 H' C^-1 and C the covariance of the values:
//!
//! ```text
//! -log L = (log |C| + log |H' C^-1 H| + y' P y) / 2,   slope_i = (tr(P C_i) - y' P C_i P y) / 2,
//! average information_ij = y' P C_i P C_j P y / 2
//! ```
//!
//! Leaving out one point changes the prediction there by (P y)_k / P_kk (Dubrule, Mathematical Geology 15(6), 1983).

use super::trend;
use super::weighted_points::{Gauss, WeightedPoints};
use faer::linalg::solvers::{DenseSolveCore as _, Llt, Solve as _};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// Bounds of the logarithms of lengths, in units of half the width of the points' box; of the amplitude and of the
/// noise, in units of the values' spread.
const LENGTH: [f64; 2] = [-0.7, 4.0];
const AMPLITUDE: [f64; 2] = [-7.0, 4.0];
const NOISE: [f64; 2] = [-12.0, 0.5];
/// Where the search starts.
const START: [f64; 3] = [0.9, -0.7, -2.0];
/// What is known of the logarithm of a length beforehand: a mean and a standard deviation. Noise would else pass for a
/// function that changes from point to point.
const KNOWN_LENGTH: [f64; 2] = [0.9, 0.5];
/// Most steps of the search, and the rise of the log-likelihood at which it ends.
const MOST_STEPS: usize = 60;
const LEAST_RISE: f64 = 1e-4;
/// Values for each term of the trend, at least.
const VALUES_A_TERM: f64 = 1.5;

/// Why there is no process.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Too few values for the trend.
    #[error("{points} points are too few for {variables} variables: at least {least}")]
    Few {
        /// Points given.
        points: usize,
        /// Variables.
        variables: usize,
        /// Points needed.
        least: usize,
    },
    /// Points and values that do not fit together, or are not finite.
    #[error("points and values must be finite, as many of the one as of the other, all points of as many variables")]
    Shape,
    /// Points that do not tell the terms of the trend apart.
    #[error("the points do not tell the variables apart: two of them move together, or one does not move")]
    Degenerate,
}

/// A function known by its values at some points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GaussianProcess {
    /// Low and high end of each variable over the points.
    bounds: Vec<[f64; 2]>,
    /// The points, each variable from -1 to 1.
    points: Vec<Vec<f64>>,
    /// Logarithms of lengths, amplitude and noise.
    logs: Vec<f64>,
    /// Mean and spread of the values.
    scale: [f64; 2],
    /// Coefficients of the trend.
    beta: Vec<f64>,
    /// Of the covariance with each point.
    weights: Vec<f64>,
}

/// A value that is predicted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// The value.
    pub value: f64,
    /// Its variance, without the noise of a new value.
    pub variance: f64,
}

impl GaussianProcess {
    /// Fits values at points, each point a number for every variable.
    ///
    /// # Errors
    /// [`FitError`]: too few points, points that do not tell the variables apart.
    pub fn fit(points: &[Vec<f64>], values: &[f64]) -> Result<Self, FitError> {
        let variables = points.first().map_or(0, Vec::len);
        let finite = points.iter().flatten().chain(values).all(|v| v.is_finite());
        if points.len() != values.len() || !finite || points.iter().any(|point| point.len() != variables) {
            return Err(FitError::Shape);
        }
        let least = (VALUES_A_TERM * trend::terms(variables) as f64).ceil() as usize + 1;
        if points.len() < least {
            return Err(FitError::Few { points: points.len(), variables, least });
        }
        let along = |i: usize| points.iter().map(move |point| point[i]);
        let bounds: Vec<[f64; 2]> = (0..variables)
            .map(|i| [along(i).fold(f64::INFINITY, f64::min), along(i).fold(f64::NEG_INFINITY, f64::max)])
            .collect();
        if bounds.iter().any(|[low, high]| high <= low) {
            return Err(FitError::Degenerate);
        }
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let spread = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        let spread = if spread > 0.0 { spread } else { 1.0 };
        let mut process = Self {
            bounds,
            points: Vec::new(),
            logs: Vec::new(),
            scale: [mean, spread],
            beta: Vec::new(),
            weights: Vec::new(),
        };
        process.points = points.iter().map(|point| process.placed(point)).collect();
        let values: Vec<f64> = values.iter().map(|v| (v - mean) / spread).collect();
        let known = Known::new(&process.points, values);
        let solved = known.most_likely()?;
        process.logs = solved.logs.clone();
        (process.beta, process.weights) = (solved.beta.clone(), solved.projected.clone());
        Ok(process)
    }

    /// A place within the box of the points, each variable from -1 to 1.
    fn placed(&self, place: &[f64]) -> Vec<f64> {
        let along = |(x, [low, high]): (&f64, &[f64; 2])| 2.0 * (x - low) / (high - low) - 1.0;
        place.iter().zip(&self.bounds).map(along).collect()
    }

    /// The value at a place.
    pub fn value(&self, place: &[f64]) -> f64 {
        let place = self.placed(place);
        let (amplitude, lengths) = (self.amplitude(), self.lengths());
        let near: f64 = self.points.iter().zip(&self.weights).map(|(p, w)| w * correlation(p, &place, &lengths)).sum();
        let trend: f64 = trend::monomials(&place).iter().zip(&self.beta).map(|(h, b)| h * b).sum();
        self.scale[0] + self.scale[1] * (trend + amplitude * amplitude * near)
    }

    /// What tells many values, faster.
    pub fn evaluator(&self) -> Evaluator<'_> {
        let (square, lengths) = (self.amplitude().powi(2), self.lengths());
        let scaled = |point: &Vec<f64>| point.iter().zip(&lengths).map(|(x, length)| x / length).collect::<Vec<f64>>();
        let weighted = self.points.iter().zip(&self.weights).map(|(point, weight)| (scaled(point), square * weight));
        Evaluator { process: self, points: WeightedPoints::new(self.bounds.len(), weighted), lengths }
    }

    /// What remains to be known of the values: residuals of each, left out, and their variances, noise included.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub fn left_out(&self, values: &[f64]) -> Result<Vec<Predicted>, FitError> {
        let [mean, spread] = self.scale;
        let known = Known::new(&self.points, values.iter().map(|v| (v - mean) / spread).collect());
        let solved = known.solve(&self.logs).ok_or(FitError::Degenerate)?;
        let one = |k: usize| {
            let own = solved.projection[(k, k)];
            Predicted { value: spread * solved.projected[k] / own, variance: spread * spread / own }
        };
        Ok((0..values.len()).map(one).collect())
    }

    /// What tells variances; it takes a factorisation.
    ///
    /// # Errors
    /// `Degenerate` where the covariance cannot be factorised.
    pub fn variances(&self) -> Result<Variances<'_>, FitError> {
        let known = Known::new(&self.points, vec![0.0; self.points.len()]);
        let solved = known.solve(&self.logs).ok_or(FitError::Degenerate)?;
        Ok(Variances { process: self, factor: solved.factor, shared: solved.shared, trend: solved.trend })
    }

    /// Whether all its parts are there, for so many variables.
    pub fn is_whole(&self, variables: usize) -> bool {
        let finite = |numbers: &[f64]| numbers.iter().all(|v| v.is_finite());
        let counts = [self.bounds.len(), self.logs.len(), self.beta.len(), self.weights.len()];
        counts == [variables, variables + 2, trend::terms(variables), self.points.len()]
            && !self.points.is_empty()
            && self.points.iter().all(|point| point.len() == variables && finite(point))
            && self.bounds.iter().all(|[low, high]| finite(&[*low, *high]) && low < high)
            && self
                .logs
                .iter()
                .enumerate()
                .all(|(k, log)| (bounds(k, variables)[0]..=bounds(k, variables)[1]).contains(log))
            && [&self.beta, &self.weights].iter().all(|numbers| finite(numbers))
            && finite(&self.scale)
    }

    /// Standard deviation of the noise of a value.
    pub fn noise(&self) -> f64 {
        self.scale[1] * self.logs.last().map_or(0.0, |log| log.exp())
    }

    fn amplitude(&self) -> f64 {
        self.logs.get(self.bounds.len()).map_or(0.0, |log| log.exp())
    }

    /// Lengths of the variables, in units of half the width of the box.
    pub fn lengths(&self) -> Vec<f64> {
        self.logs.iter().take(self.bounds.len()).map(|log| log.exp()).collect()
    }
}

/// A process made ready to be asked for many values.
#[derive(Debug, Clone)]
pub struct Evaluator<'a> {
    process: &'a GaussianProcess,
    lengths: Vec<f64>,
    /// Points in units of the lengths.
    points: WeightedPoints,
}

impl Evaluator<'_> {
    /// [`GaussianProcess::value`] but for rounding.
    pub fn value(&self, place: &[f64]) -> f64 {
        let process = self.process;
        let mut place = process.placed(place);
        let trend = trend::sum(&place, &process.beta);
        place.iter_mut().zip(&self.lengths).for_each(|(x, length)| *x /= length);
        process.scale[0] + process.scale[1] * (trend + self.points.sum(&place, Gauss))
    }
}

/// Variances of the predictions of one process.
pub struct Variances<'a> {
    process: &'a GaussianProcess,
    /// Of C.
    factor: Llt<f64>,
    /// C^-1 H.
    shared: Mat<f64>,
    /// (H' C^-1 H)^-1.
    trend: Mat<f64>,
}

/// Slopes of a function along every variable, as a process knows them.
#[derive(Debug, Clone, PartialEq)]
pub struct Slopes {
    /// The slopes.
    pub values: Vec<f64>,
    /// Their covariance.
    pub covariance: Mat<f64>,
}

impl Variances<'_> {
    /// Slopes at a place. The covariance of slopes f_i, f_j is a^2 / l_i^2 where i = j, else 0; that of f_i with the
    /// value at a point p is a^2 exp(-r^2 / 2) (p_i - x_i) / l_i^2 (Rasmussen and Williams 2006, section 9.4).
    pub fn slopes(&self, place: &[f64]) -> Slopes {
        let process = self.process;
        let place = process.placed(place);
        let (square, lengths) = (process.amplitude().powi(2), process.lengths());
        let (n, d) = (process.points.len(), place.len());
        let near: Vec<f64> = process.points.iter().map(|p| square * correlation(p, &place, &lengths)).collect();
        let with = Mat::from_fn(n, d, |k, i| near[k] * (process.points[k][i] - place[i]) / lengths[i].powi(2));
        let monomials = trend::slopes(&place);
        let of_trend = Mat::from_fn(monomials.len(), d, |k, i| monomials[k][i]);
        let mut known = with.clone();
        solve_lower_triangular_in_place(self.factor.L(), known.as_mut(), Par::Seq);
        let known = known.transpose() * &known;
        let beyond = &of_trend - self.shared.transpose() * &with;
        let trend = beyond.transpose() * &self.trend * &beyond;
        let unit = |i: usize| process.scale[1] * 2.0 / (process.bounds[i][1] - process.bounds[i][0]);
        let value = |i: usize| {
            let near: f64 = (0..n).map(|k| process.weights[k] * with[(k, i)]).sum();
            let trend: f64 = (0..monomials.len()).map(|k| process.beta[k] * of_trend[(k, i)]).sum();
            unit(i) * (near + trend)
        };
        let covariance = Mat::from_fn(d, d, |i, j| {
            let own = if i == j { square / lengths[i].powi(2) } else { 0.0 };
            unit(i) * unit(j) * (own - known[(i, j)] + trend[(i, j)])
        });
        Slopes { values: (0..d).map(value).collect(), covariance }
    }

    /// Variance of the predicted value at a place, without the noise of a new one.
    pub fn at(&self, place: &[f64]) -> f64 {
        let process = self.process;
        let place = process.placed(place);
        let (square, lengths) = (process.amplitude().powi(2), process.lengths());
        let n = process.points.len();
        let near = Mat::from_fn(n, 1, |k, _| square * correlation(&process.points[k], &place, &lengths));
        let monomials = trend::monomials(&place);
        // By the factor: the inverse loses digits where the noise is small, and all of them where it is very small.
        let mut known = near.clone();
        solve_lower_triangular_in_place(self.factor.L(), known.as_mut(), Par::Seq);
        let known = known.transpose() * &known;
        let beyond = Mat::from_fn(monomials.len(), 1, |k, _| monomials[k]) - self.shared.transpose() * &near;
        let trend = beyond.transpose() * &self.trend * &beyond;
        process.scale[1].powi(2) * (square - known[(0, 0)] + trend[(0, 0)]).max(n as f64 * f64::EPSILON * square)
    }
}

/// Bounds of the k-th logarithm where there are so many variables.
fn bounds(k: usize, variables: usize) -> [f64; 2] {
    match k.cmp(&variables) {
        Ordering::Less => LENGTH,
        Ordering::Equal => AMPLITUDE,
        Ordering::Greater => NOISE,
    }
}

fn off_length(log: f64) -> f64 {
    (log - KNOWN_LENGTH[0]) / KNOWN_LENGTH[1]
}

fn correlation(a: &[f64], b: &[f64], lengths: &[f64]) -> f64 {
    let square: f64 = a.iter().zip(b).zip(lengths).map(|((a, b), l)| ((a - b) / l).powi(2)).sum();
    (-0.5 * square).exp()
}

/// Values at points from -1 to 1.
struct Known<'a> {
    points: &'a [Vec<f64>],
    values: Vec<f64>,
    trend: Mat<f64>,
}

/// What follows of the values where lengths, amplitude and noise are given.
struct Solved {
    logs: Vec<f64>,
    /// Minus the logarithm of the restricted likelihood, but for a constant.
    unlikely: f64,
    factor: Llt<f64>,
    shared: Mat<f64>,
    trend: Mat<f64>,
    projection: Mat<f64>,
    /// P y.
    projected: Vec<f64>,
    beta: Vec<f64>,
    /// a^2 times the correlations.
    covariance: Mat<f64>,
}

impl<'a> Known<'a> {
    fn new(points: &'a [Vec<f64>], values: Vec<f64>) -> Self {
        let rows: Vec<Vec<f64>> = points.iter().map(|point| trend::monomials(point)).collect();
        let terms = rows.first().map_or(0, Vec::len);
        Self { points, values, trend: Mat::from_fn(points.len(), terms, |k, j| rows[k][j]) }
    }

    fn variables(&self) -> usize {
        self.points.first().map_or(0, Vec::len)
    }

    /// None where a matrix is not positive definite.
    fn solve(&self, logs: &[f64]) -> Option<Solved> {
        let (n, d) = (self.points.len(), self.variables());
        let lengths: Vec<f64> = logs[..d].iter().map(|log| log.exp()).collect();
        let (square, noise) = ((2.0 * logs[d]).exp(), (2.0 * logs[d + 1]).exp());
        let scaled: Vec<Vec<f64>> =
            self.points.iter().map(|point| point.iter().zip(&lengths).map(|(x, l)| x / l).collect()).collect();
        let unit = vec![1.0; d];
        let mut covariance = Mat::<f64>::zeros(n, n);
        for i in 0..n {
            for j in 0..=i {
                let one = square * correlation(&scaled[i], &scaled[j], &unit);
                (covariance[(i, j)], covariance[(j, i)]) = (one, one);
            }
        }
        let whole = Mat::from_fn(n, n, |i, j| covariance[(i, j)] + if i == j { noise } else { 0.0 });
        let factor = Llt::new(whole.as_ref(), Side::Lower).ok()?;
        let inverse = factor.inverse();
        let shared = factor.solve(&self.trend);
        let normal = self.trend.transpose() * &shared;
        let of_trend = Llt::new(normal.as_ref(), Side::Lower).ok()?;
        let log_determinant = |factor: &Llt<f64>, n: usize| (0..n).map(|k| factor.L()[(k, k)].ln()).sum::<f64>();
        let logs_of_determinants = log_determinant(&factor, n) + log_determinant(&of_trend, normal.nrows());
        let trend = of_trend.inverse();
        let projection = &inverse - &shared * (&trend * shared.transpose());
        let values = Mat::from_fn(n, 1, |k, _| self.values[k]);
        let beta = of_trend.solve(shared.transpose() * &values);
        let projected = &projection * &values;
        let fit: f64 = (0..n).map(|k| self.values[k] * projected[(k, 0)]).sum();
        let beforehand: f64 = logs.iter().take(d).map(|log| 0.5 * off_length(*log).powi(2)).sum();
        let unlikely = logs_of_determinants + 0.5 * fit + beforehand;
        let column = |of: &Mat<f64>| (0..of.nrows()).map(|k| of[(k, 0)]).collect::<Vec<_>>();
        unlikely.is_finite().then(|| Solved {
            logs: logs.to_vec(),
            unlikely,
            factor,
            shared,
            trend,
            projection,
            projected: column(&projected),
            beta: column(&beta),
            covariance,
        })
    }

    /// Slope of the unlikelihood and average information.
    fn slopes(&self, solved: &Solved) -> (Vec<f64>, Mat<f64>) {
        let (n, d) = (self.points.len(), self.variables());
        let lengths: Vec<f64> = solved.logs[..d].iter().map(|log| log.exp()).collect();
        let noise = (2.0 * solved.logs[d + 1]).exp();
        let y = &solved.projected;
        // C_i P y, and tr(P C_i), each pair of points looked at once.
        let mut moved = Mat::<f64>::zeros(n, d + 2);
        let mut trace = vec![0.0; d + 2];
        let mut apart = vec![0.0; d];
        for i in 0..n {
            for j in 0..i {
                let covariance = solved.covariance[(i, j)];
                let twice = 2.0 * solved.projection[(i, j)] * covariance;
                for k in 0..d {
                    apart[k] = ((self.points[i][k] - self.points[j][k]) / lengths[k]).powi(2);
                }
                for k in 0..d {
                    trace[k] += twice * apart[k];
                    moved[(i, k)] += covariance * apart[k] * y[j];
                    moved[(j, k)] += covariance * apart[k] * y[i];
                }
                trace[d] += 2.0 * twice;
                moved[(i, d)] += 2.0 * covariance * y[j];
                moved[(j, d)] += 2.0 * covariance * y[i];
            }
            let own = solved.projection[(i, i)];
            trace[d] += 2.0 * own * solved.covariance[(i, i)];
            trace[d + 1] += 2.0 * own * noise;
            moved[(i, d)] += 2.0 * solved.covariance[(i, i)] * y[i];
            moved[(i, d + 1)] = 2.0 * noise * y[i];
        }
        let through = |k: usize| (0..n).map(|i| y[i] * moved[(i, k)]).sum::<f64>();
        let mut slope: Vec<f64> = (0..d + 2).map(|k| 0.5 * (trace[k] - through(k))).collect();
        let mut information = moved.transpose() * (&solved.projection * &moved) * faer::Scale(0.5);
        for (k, log) in solved.logs.iter().take(d).enumerate() {
            slope[k] += off_length(*log) / KNOWN_LENGTH[1];
            information[(k, k)] += KNOWN_LENGTH[1].powi(-2);
        }
        (slope, information)
    }

    /// Lengths, amplitude and noise of the greatest restricted likelihood, by damped steps within their bounds.
    fn most_likely(&self) -> Result<Solved, FitError> {
        let d = self.variables();
        let start: Vec<f64> = (0..d + 2).map(|k| START[(k + 1).saturating_sub(d)]).collect();
        let mut best = self.solve(&start).ok_or(FitError::Degenerate)?;
        let mut damping = 1e-2;
        for _ in 0..MOST_STEPS {
            let (slope, information) = self.slopes(&best);
            // What lies at a bound and would leave stays there.
            let held = |k: usize| {
                let [low, high] = bounds(k, d);
                (best.logs[k] <= low && slope[k] > 0.0) || (best.logs[k] >= high && slope[k] < 0.0)
            };
            let mut rise = 0.0;
            while damping < 1e8 {
                let normal = Mat::from_fn(d + 2, d + 2, |i, j| match (held(i) || held(j), i == j) {
                    (true, true) => 1.0,
                    (true, false) => 0.0,
                    (false, true) => information[(i, i)] * (1.0 + damping) + 1e-3 * (1.0 + damping),
                    (false, false) => information[(i, j)],
                });
                let right = Mat::from_fn(d + 2, 1, |k, _| if held(k) { 0.0 } else { -slope[k] });
                let tried = Llt::new(normal.as_ref(), Side::Lower).ok().and_then(|factor| {
                    let step = factor.solve(&right);
                    let longest = (0..d + 2).map(|k| step[(k, 0)].abs()).fold(0.0, f64::max);
                    let shorter = (1.5 / longest.max(1e-300)).min(1.0);
                    let logs: Vec<f64> = (0..d + 2)
                        .map(|k| (best.logs[k] + shorter * step[(k, 0)]).clamp(bounds(k, d)[0], bounds(k, d)[1]))
                        .collect();
                    self.solve(&logs)
                });
                match tried {
                    Some(tried) if tried.unlikely < best.unlikely => {
                        rise = best.unlikely - tried.unlikely;
                        best = tried;
                        damping = (0.2 * damping).max(1e-6);
                        break;
                    }
                    _ => damping *= 5.0,
                }
            }
            if rise < LEAST_RISE {
                break;
            }
        }
        Ok(best)
    }
}

#[cfg(test)]
#[path = "gaussian_process_tests.rs"]
mod tests;
