//! `frames`: pressure frames of a scanned indenter and their features.

mod page;
mod pictures;
mod source;

use super::command;
use super::facts::{columns, figure};
use super::flags::{finite, not_negative, positive};
use super::{Failure, Outcome, Talk, note, print};
use crate::figure::Figure;
use crate::mechanics::frames::{Features, Frame, features_csv, frames_csv};
use crate::output::OutputFolder;
use clap::Args;
use pictures::Pictures;
use serde_json::{Value, json};
use source::{Computed, Source};
use std::path::PathBuf;

/// Pressure frames of an indenter scanned over tissue, computed from a scan scene or measured, and their features.
#[derive(Debug, Args)]
pub(super) struct FramesCommand {
    /// Scan scene file, or preset:NAME for one that comes with the program.
    #[arg(required_unless_present = "measured", conflicts_with = "measured")]
    scene: Option<PathBuf>,
    /// Measured frames in place of a scene: CSV of position_mm,x_mm,pressure_kpa.
    #[arg(long, value_name = "CSV")]
    measured: Option<PathBuf>,
    /// Half width of the window of the parabola about the indenter's centre, mm [default: the scene's, or the contact].
    #[arg(long, value_name = "W", value_parser = positive, allow_negative_numbers = true)]
    window_mm: Option<f64>,
    /// Pressure up to which a place counts as not in contact, kPa: the noise of measured frames.
    #[arg(long, value_name = "P", default_value = "0", value_parser = not_negative, allow_negative_numbers = true)]
    noise_kpa: f64,
    /// Position of the frame that is shown by itself, mm; the nearest is taken.
    #[arg(long, value_name = "X", default_value = "0", value_parser = finite, allow_negative_numbers = true)]
    show_mm: f64,
    /// Folder to write, in whole or not at all [default: out/NAME].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the folder, if this program wrote all that it holds.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    talk: Talk,
}

/// Frames with what was read off them.
struct Reading {
    source: Source,
    features: Vec<Features>,
    /// Half width of the window, mm; absent: the whole contact.
    window_mm: Option<f64>,
    /// Pressure up to which a place counts as not in contact, kPa.
    noise_kpa: f64,
    /// Which frame is shown by itself.
    shown: usize,
}

impl FramesCommand {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let input = source::read(self.scene.as_deref(), self.measured.as_deref())?;
        let place = self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(input.name()));
        let folder = OutputFolder::create(&place, self.force)?;
        let window_mm = self.window_mm.or(input.window_mm());
        let source = input.frames(self.show_mm, self.talk.quiet)?;
        let features = source.features(window_mm, self.noise_kpa)?;
        let shown = source.nearest(self.show_mm);
        let reading = Reading { source, features, window_mm, noise_kpa: self.noise_kpa, shown };
        if !self.talk.quiet {
            reading.notes().iter().for_each(|line| note(line));
        }
        let pictures = Pictures::draw(&reading)?;
        reading.write(&folder, &pictures)?;
        let done = command::commit(folder, reading.source.scene_text.as_deref(), reading.json())?;
        match self.talk.json {
            true => print(&done.json)?,
            false => print(&reading.text(&done.out))?,
        }
        Ok(Outcome::Done)
    }
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
    fn notes(&self) -> Vec<String> {
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

    fn write(&self, folder: &OutputFolder, pictures: &Pictures) -> Result<(), Failure> {
        folder.write("frames.csv", &frames_csv(&self.source.frames))?;
        folder.write("features.csv", &features_csv(&self.features))?;
        if let Some(computed) = &self.source.computed {
            folder.write("frames_without_inclusion.csv", &frames_csv(&computed.scanned.without))?;
            folder.write("deformed.vtu", &computed.vtu()?)?;
        }
        for (name, svg) in pictures.files() {
            folder.write(name, svg)?;
        }
        Ok(folder.write("report.html", &page::report(self, pictures).to_html())?)
    }

    fn json(&self) -> Value {
        let source = &self.source;
        let positions: Vec<f64> = source.frames.as_slice().iter().map(|frame| frame.position_mm).collect();
        json!({
            "scene": source.name,
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
            "notes": self.notes(),
        })
    }

    fn text(&self, out: &str) -> String {
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
            row("folder", out.to_owned()),
            row("report", format!("{out}/report.html")),
        ]);
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
