//! Logistic regression on one covariate with Firth's penalty.
//!
//! Maximised is log L + log |I| / 2, I the information matrix (Firth 1993): its maximum is finite where plain
//! likelihood runs off to infinity because the covariate separates the outcomes, and less biased elsewhere. Its
//! gradient is that of augmented data: each outcome once, and its leverage h, half as a success and half as a failure
//! (Heinze & Schemper 2002). Steps are those of iteratively reweighted least squares on them, halved until they go up.
//!
//! Where outcomes are all but separated there are several hills, and a climb from a rate of one half everywhere, as of
//! R's logistf, may end on a lower one. Climbs start at the highest of many places instead.

/// Most steps of a climb; ten to thirty are usual.
const MOST_STEPS: usize = 500;
/// Step in the logit at which a climb has arrived.
const ARRIVED: f64 = 1e-9;
/// Most middles of a rise, between neighbouring covariates, from which climbs may start.
const MOST_MIDDLES: usize = 32;
/// Fall of the log likelihood that is none.
const ROUNDING: f64 = 1e-12;

/// Outcomes against a covariate that is of the order of 1.
pub(super) struct Outcomes(pub(super) Vec<(f64, bool)>);

/// A place on the hill.
pub(super) struct Place {
    /// Intercept and slope.
    pub(super) beta: [f64; 2],
    /// Penalised log likelihood.
    pub(super) height: f64,
    /// Its gradient.
    score: [f64; 2],
    /// The information of the augmented data: intercept, both, slope.
    information: [f64; 3],
}

impl Place {
    /// The step of least squares: along a direction, or free.
    fn step(&self, along: Option<[f64; 2]>) -> [f64; 2] {
        let ([s, t], [a, b, c]) = (self.score, self.information);
        match along {
            Some([d, e]) => {
                let length = (s * d + t * e) / (a * d * d + 2.0 * b * d * e + c * e * e);
                [length * d, length * e]
            }
            None => [(c * s - b * t) / (a * c - b * b), (a * t - b * s) / (a * c - b * b)],
        }
    }
}

impl Outcomes {
    /// What is at a place.
    fn at(&self, beta: [f64; 2]) -> Place {
        let logits = || self.0.iter().map(|(z, _)| beta[0] + beta[1] * z);
        // Of the rarer outcome to the other: exact where the latter's rate is 1 to the last bit.
        let odds: Vec<f64> = logits().map(|logit| (-logit.abs()).exp()).collect();
        let weights: Vec<f64> = odds.iter().map(|odds| odds / (1.0 + odds).powi(2)).collect();
        let weighted = || self.0.iter().map(|(z, _)| *z).zip(&weights);
        // |I| about the mean: from its entries it would lose its digits.
        let total: f64 = weights.iter().sum();
        let mean = weighted().map(|(z, w)| w * z).sum::<f64>() / total;
        let spread: f64 = weighted().map(|(z, w)| w * (z - mean).powi(2)).sum();
        let (mut height, mut score, mut information) = (0.5 * (total * spread).ln(), [0.0; 2], [0.0; 3]);
        for ((&(z, is_detected), logit), (odds, w)) in self.0.iter().zip(logits()).zip(odds.iter().zip(&weights)) {
            let p = if logit > 0.0 { 1.0 } else { *odds } / (1.0 + odds);
            let leverage = w * (1.0 / total + (z - mean).powi(2) / spread);
            let residual = f64::from(is_detected) - p + leverage * (0.5 - p);
            score = [score[0] + residual, score[1] + residual * z];
            let [a, b, c] = information;
            let w = w * (1.0 + leverage);
            information = [a + w, b + w * z, c + w * z * z];
            height += if is_detected { logit } else { -logit }.min(0.0) - odds.ln_1p();
        }
        Place { beta, height, score, information }
    }

    /// The highest place from a start, along a direction or free; `None` where it is not found.
    pub(super) fn climb(&self, start: [f64; 2], along: Option<[f64; 2]>) -> Option<Place> {
        let mut place = self.at(start);
        for _ in 0..MOST_STEPS {
            let [d, e] = place.step(along);
            let longest = self.0.iter().map(|(z, _)| (d + e * z).abs()).fold(0.0, f64::max);
            let mut share = 1.0;
            loop {
                // Not so for what is not finite.
                let is_far = share * longest > ARRIVED;
                if !is_far {
                    return place.height.is_finite().then_some(place);
                }
                let next = self.at([place.beta[0] + share * d, place.beta[1] + share * e]);
                if next.height >= place.height - ROUNDING {
                    place = next;
                    break;
                }
                share *= 0.5;
            }
        }
        None
    }

    /// The highest place of all, `None` where it is not found.
    pub(super) fn summit(&self) -> Option<Place> {
        let mut sorted: Vec<f64> = self.0.iter().map(|(z, _)| *z).collect();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup();
        let thin = sorted.len().div_ceil(MOST_MIDDLES);
        let middles = sorted.windows(2).step_by(thin).map(|pair| pair.iter().sum::<f64>() / 2.0);
        let start = highest(middles.flat_map(|z| rises(z, 0.0)).map(|line| self.at(line)))?.beta;
        highest([[0.0; 2], start].into_iter().filter_map(|start| self.climb(start, None)))
    }

    /// The highest place of a rising rate whose logit is `logit` at the covariate `z`.
    pub(super) fn summit_through(&self, z: f64, logit: f64) -> Option<Place> {
        let lines: Vec<Place> = rises(z, logit).map(|line| self.at(line)).collect();
        let height = |k: usize| lines.get(k).map_or(f64::NEG_INFINITY, |line| line.height.max(f64::NEG_INFINITY));
        let is_peak = |k: usize| height(k) >= height(k.wrapping_sub(1)) && height(k) >= height(k + 1);
        let peaks = lines.iter().enumerate().filter(|(k, _)| is_peak(*k));
        highest(peaks.filter_map(|(_, peak)| self.climb(peak.beta, Some([-z, 1.0]))))
    }
}

/// The highest of places, of those that have a height.
fn highest(places: impl Iterator<Item = Place>) -> Option<Place> {
    places.filter(|place| place.height.is_finite()).max_by(|a, b| a.height.total_cmp(&b.height))
}

/// Lines through a point, as intercept and slope, from those that rise over 1e-4 of the span of the covariates to those
/// that rise over all of it, with the point; each rises 1.4 times as steeply as the next.
fn rises(z: f64, logit: f64) -> impl Iterator<Item = [f64; 2]> {
    let slopes = (0..).map(|k| 16_384.0 * f64::from(-k).exp2().sqrt());
    slopes.take_while(move |slope| slope * (1.0 + z.abs()) > 0.25).map(move |slope| [logit - slope * z, slope])
}
