//! Pressure frames and their features.

mod input;
mod page;
mod pictures;
mod source;
mod tissue;

pub use input::{Input, InputError};
pub use pictures::Pictures;
pub use source::{Computed, Source, setup_of};

use super::PageError;
use super::facts::{columns, figure};
use crate::estimate::tissue::Tissue;
use crate::figure::Figure;
use crate::mechanics::frames::{Features, Frame, Frames, features_csv, frames_csv};
use crate::output::OutputFolder;
use serde_json::{Value, json};

/// Frames with what was read off them.
pub struct Reading {
    /// The frames, and where they come from.
    pub source: Source,
    /// Features of each.
    pub features: Vec<Features>,
    /// Half width of the window, mm; absent: the whole contact.
    pub window_mm: Option<f64>,
    /// Pressure up to which a place counts as not in contact, kPa.
    pub noise_kpa: f64,
    /// Which frame is shown by itself.
    pub shown: usize,
    /// What they say of the tissue, where that was asked.
    pub tissue: Option<Tissue>,
    /// The frames with noise that it was sought in, where noise was added.
    pub noisy: Option<Frames>,
}

impl Reading {
    fn frame(&self) -> &Frame {
        &self.source.frames.as_slice()[self.shown]
    }

    /// What the shown frame's eccentricity compares with.
    fn reference(&self) -> &Frame {
        match &self.source.computed {
            Some(computed) => &computed.scanned.without.as_slice()[self.shown],
            None => self.source.frames.farthest(),
        }
    }

    fn window_text(&self) -> String {
        match self.window_mm {
            Some(half) => format!("{} mm on each side of the indenter's centre", figure(half)),
            None => "the whole contact".to_owned(),
        }
    }

    /// What a user would want to know before trusting the features.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let cut = self.source.frames.as_slice().iter().filter(|frame| is_cut(frame, self.noise_kpa)).count();
        if cut > 0 {
            let above = if self.noise_kpa > 0.0 { "above the noise" } else { "not 0" };
            notes.push(format!("{cut} frames end within the contact: the pressure there is {above}"));
        }
        let without = self.features.iter().filter(|f| f.peak_kpa.value().is_none()).count();
        if without > 0 {
            notes.push(format!("{without} frames have no peak; features.csv says why"));
        }
        notes
    }

    /// Writes tables, pictures and the report.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &OutputFolder, pictures: &Pictures) -> Result<(), PageError> {
        folder.write("frames.csv", &frames_csv(&self.source.frames))?;
        folder.write("features.csv", &features_csv(&self.features))?;
        if let Some(computed) = &self.source.computed {
            folder.write("frames_without_inclusion.csv", &frames_csv(&computed.scanned.without))?;
            folder.write_bytes("deformed.vtu", &computed.vtu()?)?;
        }
        if let Some(noisy) = &self.noisy {
            folder.write("frames_noisy.csv", &frames_csv(noisy))?;
        }
        for (name, svg) in pictures.files() {
            folder.write(name, svg)?;
        }
        Ok(folder.write("report.html", &page::report(self, pictures).to_html())?)
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let source = &self.source;
        let positions: Vec<f64> = source.frames.as_slice().iter().map(|frame| frame.position_mm).collect();
        json!({
            "scene": source.name,
            "inputs": source.inputs,
            "source": if source.computed.is_some() { "computed" } else { "measured" },
            "reference": source.reference_name(),
            "positions_mm": positions,
            "places": self.frame().x_mm.len(),
            "window_mm": self.window_mm,
            "shown_mm": self.frame().position_mm,
            "features": self.features,
            "truth": source.truth,
            "mechanics": match &source.computed {
                Some(computed) => computed.json(),
                None => json!({"undefined": "the frames are measured"}),
            },
            "tissue": match &self.tissue {
                Some(tissue) => json!(tissue),
                None => json!({"undefined": "what the tissue is like was not asked"}),
            },
            "notes": self.notes(),
        })
    }

    /// For people.
    pub fn text(&self, out: &str) -> String {
        let row = |name: &str, value: String| (name.to_owned(), value);
        let f = &self.features[self.shown];
        let frames = self.source.frames.as_slice();
        let mut rows = vec![
            row("frames", format!("{}, {} places each", frames.len(), self.frame().x_mm.len())),
            row("window", self.window_text()),
            row("reference", self.source.reference_name().to_owned()),
        ];
        if let Some(computed) = &self.source.computed {
            rows.extend(computed.facts());
        }
        rows.extend([
            row("shown frame", format!("indenter at {} mm", figure(f.position_mm))),
            row("peak", said(&f.peak_kpa, "kPa")),
            row("base", said(&f.base_kpa, "kPa")),
            row("width", said(&f.fwhm_mm, "mm at half of the peak")),
            row("eccentricity", said(&rounded(&f.eccentricity), "")),
            row("over all", self.ranges()),
        ]);
        rows.extend(self.tissue.iter().flat_map(|tissue| tissue::rows(tissue, &self.source)));
        rows.extend([row("folder", out.to_owned()), row("report", format!("{out}/report.html"))]);
        format!("{}\n{}", self.source.name, columns(&rows))
    }

    /// Least and greatest of each feature.
    fn ranges(&self) -> String {
        type Pick = fn(&Features) -> &Figure;
        let picks: [(&str, Pick, &str); 4] = [
            ("peak", |f| &f.peak_kpa, " kPa"),
            ("base", |f| &f.base_kpa, " kPa"),
            ("width", |f| &f.fwhm_mm, " mm"),
            ("eccentricity", |f| &f.eccentricity, ""),
        ];
        let range = |(name, pick, unit): &(&str, Pick, &str)| {
            let mut values: Vec<f64> = self.features.iter().filter_map(|f| pick(f).value()).collect();
            values.sort_by(f64::total_cmp);
            let (low, high) = (values.first()?, values.last()?);
            Some(format!("{name} {} to {}{unit}", figure(*low), figure(*high)))
        };
        picks.iter().filter_map(range).collect::<Vec<_>>().join(", ")
    }
}

/// Whether a frame has more pressure than noise at one of its ends.
fn is_cut(frame: &Frame, noise_kpa: f64) -> bool {
    [frame.pressure_kpa.first(), frame.pressure_kpa.last()].into_iter().flatten().any(|p| *p > noise_kpa)
}

/// To a thousandth: an eccentricity of rounding alone is 0.
fn rounded(feature: &Figure) -> Figure {
    feature.value().map_or_else(|| feature.clone(), |value| Figure::known((1e3 * value).round() * 1e-3 + 0.0))
}

/// A feature in words.
fn said(feature: &Figure, unit: &str) -> String {
    match (feature.value(), feature.reason()) {
        (Some(value), _) => format!("{} {unit}", figure(value)),
        (None, reason) => format!("undefined: {}", reason.unwrap_or_default()),
    }
}
