//! The map of light that photons leave at the touched face, and its smoothing.
//!
//! Gathered is, for true contact and for the air gap apart, the flux that would enter the tissue if contact were full;
//! the share of contact is applied where the map is read, so that sharp edges of contact stay sharp. Where tissue is a
//! half space (docs/PHYSICS.md, 6), it is instead what the light that enters sends towards two directions, from which
//! `scatter.rs` tells all others.
//!
//! A texel of a few photons is noisy; the light on the face is smooth. So each map is smoothed by a kernel whose bias
//! is small against its noise, both measured on the maps of the replicates, as they are seen: once the light has spread
//! in the tissue, which takes most of the noise and none of the bias (docs/decisions/smoothing.md).

use super::cpu::photons::DEPOSIT_UNIT;
use super::cpu::{Limits, Path};
use super::model::{Model, Tissue};
use super::scatter::Scatter;
use super::smooth::Smoother;
use super::spread::Spread;
use super::symmetry::Part;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::OnceLock;

/// Pairs of widths of the boxes on trial, texels.
const WIDTHS: [[usize; 2]; 6] = [[1, 3], [3, 7], [5, 11], [7, 15], [9, 19], [13, 27]];
/// Groups of replicates that the measure of the bias tells apart.
const GROUPS: usize = 8;
/// Largest square of the added bias, with the error of its measure, over the variance of the narrower. A box of w
/// texels has the variance (w^2 - 1)/12, to which a bias of second order goes: the narrower's is then at most 0.52 of
/// its own noise for all pairs, and at most 0.1 where the bias is of fourth order.
const MOST_ADDED: f64 = 3.0;
/// The same where light spreads in the tissue: its noise goes on from texel to texel, so smoothing gains little, and a
/// block of them is as noisy as one. The bias is then at most 0.3 of the noise.
const MOST_ADDED_TO_SPREAD: f64 = 1.0;
/// Width of the boxes over which a texel's noise is measured.
const ABOUT: usize = 13;
/// Least noise that counts in a texel, as a share of the median of the noisy ones.
const LEAST_NOISE: f64 = 0.1;

/// Light per area that meets the touched face in a replicate, in film units: what would enter the tissue through true
/// contact, and through the gap; or, where it is a half space, what it sends towards the map's two directions.
#[derive(Debug, Clone)]
pub struct ContactLight {
    /// Of photons.
    light: [Vec<f64>; 2],
    /// What was found without.
    direct: Option<[Vec<f64>; 2]>,
}

/// The touched face, cut into texels.
pub struct TouchedFace {
    /// Power of the LEDs over that of a unit of deposit.
    unit: f64,
    /// Area under tissue of each texel, mm^2.
    area: Vec<f64>,
    /// What of the face tells the rest.
    part: Part,
    /// Areas of its texels.
    part_area: Vec<f64>,
    /// That of a whole texel.
    texel_area: f64,
    /// Whether each of the maps is read: some of the face is in true contact, and some not.
    seen: [bool; 2],
    after: After,
    /// Whether its maps are smoothed.
    smoothed: bool,
}

/// What becomes of the light that enters.
enum After {
    /// The reader of the map tells it, where tissue is Lambertian and light leaves where it entered.
    Read,
    /// It spreads sideways in Lambertian tissue: with the mean share of true contact of each texel.
    Spread { spread: Spread, share: Vec<f64> },
    /// The same in tissue as a half space.
    SpreadHalfSpace(Spread),
    /// Tissue is a half space and light leaves where it entered: with what the boundary mirrors back at each texel.
    HalfSpace(Vec<[[f64; 2]; 2]>),
}

impl After {
    fn of(model: &Model<f64>, tissue: &Tissue<f64>, share: Vec<f64>, area: &[f64], size: [f64; 2]) -> Self {
        let reentry = share.iter().map(|&share| tissue.scatter.reentry(share));
        let covered = reentry.clone().zip(area).map(|(reentry, area)| {
            let part = area / (size[0] * size[1]);
            reentry.map(|row| row.map(|v| v * part))
        });
        let columns = model.map_size[0];
        match (&tissue.scatter, tissue.spread_d > 0.0) {
            (Scatter::Lambertian(_), false) => Self::Read,
            (Scatter::Lambertian(t), true) => {
                let spread = Spread::new(columns, size, tissue.spread_d, t.albedo, covered.collect());
                Self::Spread { spread, share }
            }
            (Scatter::HalfSpace(_), true) => {
                Self::SpreadHalfSpace(Spread::new(columns, size, tissue.spread_d, 1.0, covered.collect()))
            }
            (Scatter::HalfSpace(_), false) => Self::HalfSpace(reentry.collect()),
        }
    }
}

/// The sum of what returns any number of times: (1 - M)^-1 v.
fn all_returns([[a, b], [c, d]]: [[f64; 2]; 2], [v, w]: [f64; 2]) -> [f64; 2] {
    let determinant = (1.0 - a) * (1.0 - d) - b * c;
    [((1.0 - d) * v + b * w) / determinant, (c * v + (1.0 - a) * w) / determinant]
}

/// How the maps of a render are smoothed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smoothing {
    /// Width of the boxes for each of the two maps, texels; 1: not smoothed.
    pub widths: [usize; 2],
    /// Root-mean-square bias of each over its root-mean-square light, as measured; 0 where it is not told from noise.
    pub bias: [f64; 2],
}

impl Default for Smoothing {
    fn default() -> Self {
        Self { widths: [1, 1], bias: [0.0; 2] }
    }
}

impl TouchedFace {
    /// Cuts the touched face of a model into the texels of its map.
    pub fn new(model: &Model<f64>) -> Self {
        let part = model.symmetry.part(model.map_size);
        let size = [0, 1].map(|axis| 2.0 * model.half_size[axis] / model.map_size[axis] as f64);
        let low = |cell: [usize; 2]| [0, 1].map(|axis| cell[axis] as f64 * size[axis] - model.half_size[axis]);
        let texel_area = size[0] * size[1];
        let part_area: Vec<f64> = part.cells().map(|cell| texel_area * tissue_share(model, low(cell), size)).collect();
        let area = part.unfolded(&part_area);
        let after = model.tissue.as_ref().map_or(After::Read, |tissue| {
            let share: Vec<f64> = part.cells().map(|cell| contact_share(model, low(cell), size)).collect();
            After::of(model, tissue, part.unfolded(&share), &area, size)
        });
        let uniform = model.tissue.as_ref().filter(|tissue| tissue.grid.is_empty()).map(|tissue| tissue.share);
        let both = model.tissue.as_ref().is_some_and(|tissue| tissue.scatter.is_half_space());
        let seen = [both || uniform != Some(0.0), both || uniform != Some(1.0)];
        let smoothed = model.map_smoothing;
        Self { unit: model.power / DEPOSIT_UNIT, area, part, part_area, texel_area, seen, after, smoothed }
    }

    /// Turns deposits of `sent` photons into light per area, beside light found without photons: the mean over what the
    /// model stays the same under.
    pub fn light(&self, deposits: &[u64], sent: f64, direct: Option<[Vec<f64>; 2]>) -> ContactLight {
        let each = self.unit / sent;
        let light = [0, 1].map(|which| {
            let fluxes = deposits.iter().skip(which).step_by(2);
            let light = fluxes.zip(&self.area).map(|(&flux, &a)| if a > 0.0 { flux as f64 * each / a } else { 0.0 });
            self.part.folded(&light.collect::<Vec<_>>())
        });
        ContactLight { light, direct: direct.map(|maps| maps.map(|map| self.part.folded(&map))) }
    }

    /// What camera paths read, for each replicate: light times area beside the area, for true contact and for the gap;
    /// the exitance in place of the first, where light spreads; the exitance towards the map's two directions, where
    /// tissue is a half space.
    pub fn texels(&self, maps: &[ContactLight], smoothing: Smoothing) -> Vec<Vec<[f64; 4]>> {
        let smoothers = smoothing
            .widths
            .map(|width| Smoother::new(&self.part_area, self.part.size()[0], self.part.mirrored, width));
        let smooth = |map: &ContactLight| {
            [0, 1].map(|which| {
                let mut light = smoothers[which].smooth(&map.light[which]);
                if let Some(direct) = &map.direct {
                    light.iter_mut().zip(&direct[which]).for_each(|(v, direct)| *v += direct);
                }
                // The kernel has a negative rim.
                light.iter_mut().for_each(|v| *v = v.max(0.0));
                self.part.unfolded(&light)
            })
        };
        let texels = |[one, other]: [Vec<f64>; 2]| -> Vec<[f64; 4]> {
            one.iter().zip(&other).zip(&self.area).map(|((one, other), &a)| [one * a, a, other * a, a]).collect()
        };
        match &self.after {
            After::Read => maps.par_iter().map(|map| texels(smooth(map))).collect(),
            After::HalfSpace(reentry) => {
                let all = |[mut one, mut other]: [Vec<f64>; 2]| {
                    for ((one, other), reentry) in one.iter_mut().zip(&mut other).zip(reentry) {
                        [*one, *other] = all_returns(*reentry, [*one, *other]);
                    }
                    [one, other]
                };
                maps.par_iter().map(|map| texels(all(smooth(map)))).collect()
            }
            After::SpreadHalfSpace(spread) => {
                maps.par_iter().map(|map| texels(self.spread(spread, &smooth(map)))).collect()
            }
            After::Spread { spread, share } => {
                let mixed = |map: &ContactLight| -> Vec<f64> {
                    let [contact, gap] = smooth(map);
                    contact.iter().zip(&gap).zip(share).map(|((c, g), share)| g + share * (c - g)).collect()
                };
                // Two replicates at once.
                let pair = |pair: &[ContactLight]| -> Vec<Vec<[f64; 4]>> {
                    let light: Vec<Vec<f64>> = pair.iter().map(mixed).collect();
                    let (Some(first), Some(last)) = (light.first(), light.last()) else { return Vec::new() };
                    let spread = self.spread(spread, &[first.clone(), last.clone()]);
                    let nothing = || vec![0.0; self.area.len()];
                    spread.into_iter().take(pair.len()).map(|exitance| texels([exitance, nothing()])).collect()
                };
                maps.par_chunks(2).flat_map_iter(pair).collect()
            }
        }
    }

    /// Exitance from two maps of light per area of tissue, per area of the texels. Where there is none, rounding may
    /// leave less than nothing.
    fn spread(&self, spread: &Spread, light: &[Vec<f64>; 2]) -> [Vec<f64>; 2] {
        let flux = [0, 1].map(|k| light[k].iter().zip(&self.area).map(|(v, area)| v * area).collect::<Vec<_>>());
        spread
            .exitance([&flux[0], &flux[1]])
            .map(|flux| flux.iter().map(|flux| flux.max(0.0) / self.texel_area).collect())
    }

    fn most_added(&self) -> f64 {
        match self.after {
            After::Read | After::HalfSpace(_) => MOST_ADDED,
            After::Spread { .. } | After::SpreadHalfSpace(_) => MOST_ADDED_TO_SPREAD,
        }
    }

    /// One or two maps of light, of their part, as they are seen where light spreads in the tissue: without what the
    /// boundary mirrors back, which spreads further yet.
    fn spread_out(&self, which: usize, maps: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let (spread, share) = match &self.after {
            After::Read | After::HalfSpace(_) => return maps.to_vec(),
            After::Spread { spread, share } => (spread, Some(share)),
            After::SpreadHalfSpace(spread) => (spread, None),
        };
        let flux = |light: &Vec<f64>| -> Vec<f64> {
            let mut flux = self.part.unfolded(light);
            flux.iter_mut().zip(&self.area).for_each(|(v, area)| *v *= area);
            if let Some(share) = share {
                let of = |share: f64| if which == 0 { share } else { 1.0 - share };
                flux.iter_mut().zip(share).for_each(|(v, share)| *v *= of(*share));
            }
            flux
        };
        let fluxes: Vec<Vec<f64>> = maps.iter().map(flux).collect();
        let (Some(first), Some(last)) = (fluxes.first(), fluxes.last()) else { return Vec::new() };
        spread.first_term([first, last]).iter().take(maps.len()).map(|light| self.part.folded(light)).collect()
    }

    /// Chooses the smoothing from the maps of independent replicates.
    pub fn choose(&self, maps: &[ContactLight]) -> Smoothing {
        let groups = GROUPS.min(maps.len());
        if groups < 3 || !self.smoothed {
            return Smoothing::default();
        }
        let smoothers = Smoothers::new(&self.part_area, self.part.size()[0], self.part.mirrored);
        let choose = |which: usize| {
            if !self.seen[which] {
                return (1, 0.0);
            }
            let group = |k: usize| mean(maps.iter().skip(k).step_by(groups).map(|map| map.light[which].as_slice()));
            let parts: Vec<Vec<f64>> = (0..groups).map(group).collect();
            let (width, bias) = width(&parts, &smoothers, self.most_added(), |pair| self.spread_out(which, pair));
            // What was found without photons is not smoothed, but is light too.
            let direct = mean(maps.iter().filter_map(|map| map.direct.as_ref()).map(|direct| direct[which].as_slice()));
            let mut light = mean(parts.iter().map(Vec::as_slice));
            light.iter_mut().zip(&direct).for_each(|(v, direct)| *v += direct);
            let light = self.spread_out(which, &[light]).concat();
            let square: f64 = light.iter().zip(&self.part_area).map(|(v, area)| v * v * area).sum();
            (width, if bias > 0.0 { bias / square.sqrt() } else { 0.0 })
        };
        let (contact, gap) = rayon::join(|| choose(0), || choose(1));
        Smoothing { widths: [contact.0, gap.0], bias: [contact.1, gap.1] }
    }
}

/// Smoothers of one face by the width of their boxes, each made when it is first asked for.
struct Smoothers<'a> {
    area: &'a [f64],
    columns: usize,
    mirrored: [bool; 2],
    by_width: Vec<(usize, OnceLock<Smoother>)>,
}

impl<'a> Smoothers<'a> {
    fn new(area: &'a [f64], columns: usize, mirrored: [bool; 2]) -> Self {
        let by_width = WIDTHS.iter().flatten().map(|&width| (width, OnceLock::new())).collect();
        Self { area, columns, mirrored, by_width }
    }

    /// Each of the parts smoothed by boxes of a width.
    fn smooth(&self, parts: &[Vec<f64>], width: usize) -> Vec<Vec<f64>> {
        let make = || Smoother::new(self.area, self.columns, self.mirrored, width);
        match self.by_width.iter().find(|(known, _)| *known == width) {
            Some((_, smoother)) => {
                let smoother = smoother.get_or_init(make);
                parts.par_iter().map(|part| smoother.smooth(part)).collect()
            }
            None => parts.par_iter().map(|part| make().smooth(part)).collect(),
        }
    }
}

/// Width of the boxes that `parts`, independent estimates of the light e, bear, and its bias: the root of its square's
/// integral over the face, 0 where that is below the error of its measure. Both are measured on what is `seen` of one or
/// two parts.
///
/// Bias and noise are compared texel by texel, each in units of the noise about it: a few strong photons, noisy where
/// they land, excuse no bias elsewhere. (With one measure of noise for the face they did: on `press-hertz` 4 of 200
/// renders took four times the width of the others, and differed from these by 8 of their standard errors about the
/// bump.)
///
/// T_d e - T_v e is what a width d of about 2 v adds to the bias of v. Its square is measured by products of different
/// parts, which have no noise in common, and is known to about the error of that measure. While both together are below
/// `most_added` times the variance of T_v, v is taken: its bias is 3 to 35 times smaller than what d adds. Nothing is
/// extrapolated below v: where d is so wide that its bias no longer grows as a power, that would promise too much.
fn width(
    parts: &[Vec<f64>],
    smoothers: &Smoothers,
    most_added: f64,
    seen: impl Fn(&[Vec<f64>]) -> Vec<Vec<f64>> + Sync,
) -> (usize, f64) {
    let (area, mut chosen) = (smoothers.area, (1, 0.0));
    let smoothed =
        |width| -> Vec<Vec<f64>> { smoothers.smooth(parts, width).par_chunks(2).flat_map_iter(&seen).collect() };
    let unsmoothed = smoothed(1);
    let Some(weights) = over_local_noise(&unsmoothed, smoothers) else {
        return chosen;
    };
    let mut known = HashMap::from([(1, unsmoothed)]);
    for [narrow, wide] in WIDTHS {
        for width in [narrow, wide] {
            known.entry(width).or_insert_with(|| smoothed(width));
        }
        let pairs = known[&wide].iter().zip(&known[&narrow]);
        let added: Vec<Vec<f64>> = pairs.map(|(w, n)| w.iter().zip(n).map(|(w, n)| w - n).collect()).collect();
        let (weighted, noise) = (Square::of(&added, &weights), Square::of(&known[&narrow], &weights).noise);
        if weighted.common.max(0.0) + weighted.error > most_added * noise {
            break;
        }
        let added = Square::of(&added, area);
        // The bias is of second order at least, and nothing where nothing is smoothed.
        let variance = |width: usize| (width * width - 1) as f64;
        let share = variance(narrow) / variance(wide);
        let told = if added.common > added.error { added.common.sqrt() } else { 0.0 };
        chosen = (narrow, told * share / (1.0 - share));
    }
    chosen
}

/// Areas over the variance that the parts show about each texel; none where they do not differ, or nothing is touched.
fn over_local_noise(parts: &[Vec<f64>], smoothers: &Smoothers) -> Option<Vec<f64>> {
    let area = smoothers.area;
    if area.iter().all(|&area| area <= 0.0) {
        return None;
    }
    let whole = mean(parts.iter().map(Vec::as_slice));
    let square = |k: usize| parts.iter().map(|part| (part[k] - whole[k]).powi(2)).sum::<f64>();
    let squares: Vec<f64> = (0..area.len()).map(square).collect();
    let about = Smoother::new(area, smoothers.columns, smoothers.mirrored, ABOUT).mean(&squares);
    let mut noisy: Vec<f64> = about.iter().copied().filter(|&v| v > 0.0).collect();
    noisy.sort_by(f64::total_cmp);
    let least = LEAST_NOISE * noisy.get(noisy.len() / 2)?;
    let over = |(v, area): (&f64, &f64)| if *area > 0.0 { area / v.max(least) } else { 0.0 };
    Some(about.iter().zip(area).map(over).collect())
}

/// Mean square over the face of what independent estimates show.
struct Square {
    /// Of what they have in common, without bias: may be negative.
    common: f64,
    /// Standard error of that, by the jackknife.
    error: f64,
    /// Of the noise in the mean of all.
    noise: f64,
}

impl Square {
    fn of(parts: &[Vec<f64>], area: &[f64]) -> Self {
        let n = parts.len() as f64;
        let whole = mean(parts.iter().map(Vec::as_slice));
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).zip(area).map(|((a, b), w)| a * b * w).sum::<f64>();
        let own: Vec<f64> = parts.iter().map(|part| product(part, part)).collect();
        let (owns, all) = (own.iter().sum::<f64>(), n * n * product(&whole, &whole));
        let without: Vec<f64> = parts
            .iter()
            .zip(&own)
            .map(|(part, own)| (all - 2.0 * n * product(part, &whole) + 2.0 * own - owns) / ((n - 1.0) * (n - 2.0)))
            .collect();
        let middle = without.iter().sum::<f64>() / n;
        let spread = without.iter().map(|c| (c - middle).powi(2)).sum::<f64>();
        Self {
            common: (all - owns) / (n * (n - 1.0)),
            error: (spread * (n - 1.0) / n).sqrt(),
            noise: (owns - all / n) / (n * (n - 1.0)),
        }
    }
}

fn mean<'a>(lists: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
    let mut sum: Vec<f64> = Vec::new();
    let mut count = 0.0;
    for list in lists {
        sum.resize(list.len(), 0.0);
        sum.iter_mut().zip(list).for_each(|(sum, v)| *sum += v);
        count += 1.0;
    }
    sum.iter_mut().for_each(|v| *v /= count);
    sum
}

/// Mean share of true contact of a texel, over 4 x 4 points.
fn contact_share(model: &Model<f64>, low: [f64; 2], size: [f64; 2]) -> f64 {
    let path = Path::new(model, Limits::default());
    let at = |k: usize, axis: usize| low[axis] + (k as f64 + 0.5) / 4.0 * size[axis];
    (0..16).map(|k| path.contact_share(at(k % 4, 0), at(k / 4, 1))).sum::<f64>() / 16.0
}

/// Share of a texel that lies under tissue, by 16 x 16 points where the tissue's rim may cross it.
pub(super) fn tissue_share(model: &Model<f64>, low: [f64; 2], size: [f64; 2]) -> f64 {
    let Some(tissue) = &model.tissue else { return 0.0 };
    let Some(disc) = tissue.disc else { return 1.0 };
    let inside = |fx: f64, fy: f64| disc.holds(low[0] + fx * size[0], low[1] + fy * size[1]);
    let middle = [low[0] + 0.5 * size[0] - disc.center[0], low[1] + 0.5 * size[1] - disc.center[1]];
    let distance = (middle[0].hypot(middle[1]) - disc.radius_sq.sqrt()).abs();
    if distance > 0.5 * size[0].hypot(size[1]) {
        return f64::from(u8::from(inside(0.5, 0.5)));
    }
    let steps = 16;
    let at = |k: usize| (k as f64 + 0.5) / steps as f64;
    let hits = (0..steps * steps).filter(|k| inside(at(k % steps), at(k / steps))).count();
    hits as f64 / (steps * steps) as f64
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const COLUMNS: usize = 64;
    const WHOLE: [bool; 2] = [false; 2];

    /// Independent estimates of `light`, each of `photons` a texel on average (normal noise of Poisson's variance).
    fn parts(light: impl Fn(f64, f64) -> f64, photons: f64) -> Vec<Vec<f64>> {
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut uniform = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut normal = move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let at = |k: usize| light((k % COLUMNS) as f64 / COLUMNS as f64, (k / COLUMNS) as f64 / COLUMNS as f64);
        (0..GROUPS)
            .map(|_| (0..COLUMNS * COLUMNS).map(|k| at(k) + normal() * (at(k) / photons).sqrt()).collect())
            .collect()
    }

    /// Width and bias where light is seen as it came in.
    fn chosen(parts: &[Vec<f64>], area: &[f64]) -> (usize, f64) {
        width(parts, &Smoothers::new(area, COLUMNS, WHOLE), MOST_ADDED, <[_]>::to_vec)
    }

    fn error(found: &[f64], light: impl Fn(f64, f64) -> f64) -> f64 {
        let at = |k: usize| light((k % COLUMNS) as f64 / COLUMNS as f64, (k / COLUMNS) as f64 / COLUMNS as f64);
        let sum: f64 = found.iter().enumerate().map(|(k, v)| (v / at(k) - 1.0).powi(2)).sum();
        (sum / found.len() as f64).sqrt()
    }

    #[test]
    fn smooth_light_is_smoothed_widely_and_an_edge_is_not() {
        let area = vec![1.0; COLUMNS * COLUMNS];
        let bump = |x: f64, y: f64| 2.0 + (3.0 * x).sin() * (2.0 * y).cos();
        let noisy = parts(bump, 20.0);
        let (wide, bias) = chosen(&noisy, &area);
        let raw = error(&noisy[0], bump);
        let smooth = error(&Smoother::new(&area, COLUMNS, WHOLE, wide).smooth(&noisy[0]), bump);
        let light = COLUMNS as f64 * 2.0;
        assert!(wide >= 9 && bias < 0.01 * light, "{wide} {bias}");
        assert!(smooth < 0.11 * raw, "{smooth} {raw}");
        // The same noise about an edge: the kernel stays at the texel where photons abound.
        let edge = |x: f64, _: f64| if x < 0.5 { 1.0 } else { 2.0 };
        assert_eq!(chosen(&parts(edge, 2e4), &area).0, 1);
        let nothing = vec![0.0; COLUMNS * COLUMNS];
        assert_eq!(chosen(&parts(bump, 20.0), &nothing), (1, 0.0), "a face that nothing touches");
    }

    #[test]
    fn strong_photons_in_a_corner_do_not_widen_the_kernel() {
        let area = vec![1.0; COLUMNS * COLUMNS];
        let bump = |x: f64, y: f64| 1.0 + 4.0 * (-((x - 0.5).powi(2) + (y - 0.5).powi(2)) / 0.02).exp();
        let sound = parts(bump, 3.0);
        let (expected, _) = chosen(&sound, &area);
        assert!(expected > 1, "nothing is smoothed");
        for strong in [30.0, 300.0] {
            let mut struck = sound.clone();
            // In one of the parts, on 5 x 5 texels. With one measure of noise for the face: 9 and 13 texels in place of
            // 3.
            (0..25).for_each(|k| struck[3][(k / 5 + 2) * COLUMNS + k % 5 + 2] += strong);
            assert_eq!(chosen(&struck, &area).0, expected, "{strong}");
        }
    }

    /// What no spread of replicates shows: the chosen width's true bias, against the noise that it leaves, of light as
    /// it came in and of light that has spread, which bears less.
    #[test]
    fn the_chosen_bias_stays_below_half_of_the_noise() {
        let disc = |k: usize| ((k % COLUMNS) as f64 - 31.5).hypot((k / COLUMNS) as f64 - 31.5) < 31.0;
        let area: Vec<f64> = (0..COLUMNS * COLUMNS).map(|k| f64::from(u8::from(disc(k)))).collect();
        // Light from four sides with a ripple, as on a disc of contact.
        let light = |x: f64, y: f64| {
            let (u, v) = (2.0 * x - 1.0, 2.0 * y - 1.0);
            1.0 + 0.15 * (u * u + v * v) + 0.08 * (5.0 * u).cos() * (5.0 * v).cos()
        };
        let exact: Vec<f64> = (0..COLUMNS * COLUMNS)
            .map(|k| light((k % COLUMNS) as f64 / COLUMNS as f64, (k / COLUMNS) as f64 / COLUMNS as f64))
            .collect();
        let about = Smoother::new(&area, COLUMNS, WHOLE, 9);
        let spread = |parts: &[Vec<f64>]| parts.iter().map(|part| about.mean(part)).collect();
        type Seen<'a> = &'a (dyn Fn(&[Vec<f64>]) -> Vec<Vec<f64>> + Sync);
        let mut more_added = 0.0f64;
        for photons in [3.0, 10.0, 30.0] {
            let parts = parts(light, photons);
            // Bias over noise of a width.
            let share = |width: usize, seen: Seen| {
                let smoother = Smoother::new(&area, COLUMNS, WHOLE, width);
                let pair = seen(&[smoother.smooth(&exact), exact.clone()]);
                let square = |k: usize| area[k] * (pair[0][k] - pair[1][k]).powi(2);
                let smoothed = seen(&parts.iter().map(|part| smoother.smooth(part)).collect::<Vec<_>>());
                (0..area.len()).map(square).sum::<f64>().sqrt() / Square::of(&smoothed, &area).noise.sqrt()
            };
            let smoothers = Smoothers::new(&area, COLUMNS, WHOLE);
            for (most_added, seen) in [(MOST_ADDED, &<[_]>::to_vec as Seen), (MOST_ADDED_TO_SPREAD, &spread)] {
                let wide = width(&parts, &smoothers, most_added, seen).0;
                assert!(share(wide, seen) < 0.5, "{wide}: {}", share(wide, seen));
                assert!(share(39, seen) > 0.5, "the light has nothing that a wide kernel would lose");
            }
            more_added = more_added.max(share(width(&parts, &smoothers, MOST_ADDED, spread).0, &spread));
        }
        assert!(more_added > 0.5, "{more_added}");
    }
}
