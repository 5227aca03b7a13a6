//! What a frame is reduced to.

use super::eccentricity::eccentricity;
use super::{Frame, Frames, FramesError, Parabola};
use crate::figure::Figure;
use serde::Serialize;
use std::ops::RangeInclusive;

/// How features are taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Half width of the window of the fit about the indenter's centre, mm; absent: the whole contact. Within the
    /// window only the contact is fitted.
    pub window_mm: Option<f64>,
    /// The contact reaches from the first to the last place with more pressure than this, kPa: 0 for a computed frame,
    /// the noise for a measured one.
    pub contact_above_kpa: f64,
    /// The eccentricity is 0 where a frame differs from its reference by at most this share: more than a solver leaves
    /// (1e-8), less than an inclusion that is felt (1e-3).
    pub vanishing_share: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { window_mm: None, contact_above_kpa: 0.0, vanishing_share: 1e-6 }
    }
}

/// What the eccentricity compares with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reference<'a> {
    /// The frame farthest from position 0, as in the paper.
    Farthest,
    /// The frames at the same positions and places without the inclusion.
    Without(&'a Frames),
}

/// The features of one frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Features {
    /// Position of the frame, mm.
    pub position_mm: f64,
    /// Peak of the parabola, kPa.
    pub peak_kpa: Figure,
    /// Raw pressure at the ends of the window, kPa.
    pub base_kpa: Figure,
    /// Place of the parabola's peak, mm.
    pub center_mm: Figure,
    /// Full width of the parabola at half of its peak, mm; it may reach beyond the window.
    pub fwhm_mm: Figure,
    /// Asymmetry of what the inclusion adds, from -1 to 1.
    pub eccentricity: Figure,
    /// The parabola, where there are samples enough.
    pub parabola: Option<Parabola>,
}

/// The features of every frame.
///
/// # Errors
/// Where the reference has not the positions and places of the frames.
pub fn features(frames: &Frames, reference: Reference, settings: &Settings) -> Result<Vec<Features>, FramesError> {
    let references: Vec<&Frame> = match reference {
        Reference::Farthest => vec![frames.farthest(); frames.as_slice().len()],
        Reference::Without(others) => others.as_slice().iter().collect(),
    };
    let matches = |(frame, other): (&Frame, &&Frame)| {
        let in_place = matches!(reference, Reference::Farthest) || frame.position_mm == other.position_mm;
        in_place && frame.x_mm == other.x_mm
    };
    let matching = frames.as_slice().iter().zip(&references).take_while(|pair| matches(*pair)).count();
    if matching < frames.as_slice().len() || references.len() != matching {
        return Err(FramesError { frame: matching, rule: "the reference must have its position and its places" });
    }
    Ok(frames.as_slice().iter().zip(references).map(|(frame, other)| of_frame(frame, other, settings)).collect())
}

/// The features of one frame; `reference` has its places.
pub(crate) fn of_frame(frame: &Frame, reference: &Frame, settings: &Settings) -> Features {
    let touches = |p: &f64| *p > settings.contact_above_kpa;
    let contact = frame.pressure_kpa.iter().position(touches).zip(frame.pressure_kpa.iter().rposition(touches));
    let (base_kpa, parabola) = match contact {
        Some((first, last)) => fit(frame, first..=last, settings.window_mm.unwrap_or(f64::INFINITY)),
        None => (Figure::undefined("there is no contact"), None),
    };
    let [peak_kpa, center_mm, fwhm_mm] = match (&parabola, base_kpa.value()) {
        (Some(parabola), Some(_)) => vertex(parabola),
        (None, Some(_)) => [(); 3].map(|()| Figure::undefined("fewer than three places of contact lie in the window")),
        (_, None) => [(); 3].map(|()| base_kpa.clone()),
    };
    let share = settings.vanishing_share;
    let eccentricity = eccentricity(&frame.x_mm, &frame.pressure_kpa, &reference.pressure_kpa, share);
    Features { position_mm: frame.position_mm, peak_kpa, base_kpa, center_mm, fwhm_mm, eccentricity, parabola }
}

/// Base and parabola over the part of the contact within `half` of the centre.
fn fit(frame: &Frame, contact: RangeInclusive<usize>, half: f64) -> (Figure, Option<Parabola>) {
    let base = 0.5 * (edge(frame, &contact, -half) + edge(frame, &contact, half));
    // A hair of slack: a place at the window's end belongs to it whatever rounding did to either.
    let inside = |i: &usize| frame.x_mm[*i].abs() <= half * (1.0 + 1e-12);
    let kept: Vec<usize> = contact.filter(inside).collect();
    let pick = |values: &[f64]| kept.iter().map(|&i| values[i]).collect::<Vec<_>>();
    (Figure::known(base), Parabola::fit(&pick(&frame.x_mm), &pick(&frame.pressure_kpa)))
}

/// The raw pressure at the window's end `at` (infinite: the frame's own end), linear between places; 0 beyond the
/// contact.
fn edge(frame: &Frame, contact: &RangeInclusive<usize>, at: f64) -> f64 {
    let (x, p) = (&frame.x_mm, &frame.pressure_kpa);
    let end = x.len() - 1;
    // Where the window takes in the frame's end, a free edge carries nothing, and a contact that is cut off what is
    // there.
    if at <= x[0] {
        return if *contact.start() == 0 { p[0] } else { 0.0 };
    }
    if at >= x[end] {
        return if *contact.end() == end { p[end] } else { 0.0 };
    }
    let right = x.partition_point(|&place| place < at).clamp(1, end);
    if right < *contact.start() || right > contact.end() + 1 {
        return 0.0;
    }
    let share = (at - x[right - 1]) / (x[right] - x[right - 1]);
    p[right - 1] + share * (p[right] - p[right - 1])
}

/// Peak, its place and its width, from the parabola's vertex.
fn vertex(parabola: &Parabola) -> [Figure; 3] {
    let [from, to] = parabola.window_mm;
    let center = parabola.center_mm();
    if !parabola.has_peak() {
        return [(); 3].map(|()| Figure::undefined("the fitted parabola has no peak"));
    }
    if !(from..=to).contains(&center) {
        return [(); 3].map(|()| Figure::undefined("the fitted parabola peaks outside its window"));
    }
    let peak = parabola.at(center);
    let fwhm = if peak > 0.0 {
        Figure::known((2.0 * peak / -parabola.coefficients[2]).sqrt())
    } else {
        Figure::undefined("the fitted parabola's peak is not positive")
    };
    [Figure::known(peak), Figure::known(center), fwhm]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
