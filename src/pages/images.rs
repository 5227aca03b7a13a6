//! Figures of images from anywhere.

use super::facts::{columns, figure, said as all_said, said_within};
use super::run::inclusion_rows;
use crate::calibrate::Inferred;
use crate::estimate::{
    Calibration, Estimates, GreyImage, PaperEstimate, Settings, Stiffness, Value, estimate, scattered, stiffness,
};
use crate::pipeline::{FrameFileError, less};
use serde_json::{Value as Json, json};
use std::path::{Path, PathBuf};

/// One image and its figures.
pub struct Measured {
    pub path: PathBuf,
    /// What was measured: as the file has it, or less a reference.
    pub image: GreyImage,
    /// As the file has it, where a reference was subtracted.
    raw: Option<GreyImage>,
    pub threshold_grey: f64,
    pub paper: PaperEstimate,
}

impl Measured {
    /// The figures of an image: as a file has it, or less a reference.
    ///
    /// # Errors
    /// A reference of other pixels or levels.
    pub fn of(
        (path, raw): (&Path, GreyImage),
        reference: Option<&(&Path, GreyImage)>,
        threshold_grey: f64,
        calibration: Option<&Calibration>,
    ) -> Result<Self, FrameFileError> {
        let (image, raw) = match reference {
            Some((file, reference)) => (less(&raw, reference, file)?, Some(raw)),
            None => (raw, None),
        };
        let mut paper = estimate(&image, &settings(threshold_grey, reference.is_some()));
        paper.warnings.extend(scattered(&image, threshold_grey));
        if let Some(calibration) = calibration {
            paper = paper.scaled(calibration.mm_per_pixel);
        }
        Ok(Self { path: path.into(), image, raw, threshold_grey, paper })
    }

    /// The image as its file has it.
    pub fn raw(&self) -> &GreyImage {
        self.raw.as_ref().unwrap_or(&self.image)
    }
}

/// How images are read. One less another is rounded twice.
fn settings(threshold_grey: f64, is_less: bool) -> Settings {
    let rounded = if is_less { std::f64::consts::SQRT_2 } else { 1.0 };
    Settings { threshold_grey, noise_grey: rounded * Settings::default().noise_grey }
}

/// What two images say about stiffness, or why they do not; `are_less`: a reference was subtracted from them.
pub fn relative_stiffness(
    measured: &[Measured],
    are_less: bool,
    calibration: Option<&Calibration>,
) -> Result<Stiffness, String> {
    match (measured, calibration) {
        ([first, second], _) if first.image.top_grey() != second.image.top_grey() => {
            Err("the images' grey levels end at different values, and so cannot be compared".into())
        }
        ([first, second], Some(calibration)) => {
            Ok(stiffness(&first.image, &second.image, &settings(first.threshold_grey, are_less), calibration))
        }
        ([_, _], None) => Err("no calibration gives force and pressure".into()),
        _ => Err(format!("it takes two images under different press, there are {}", measured.len())),
    }
}

/// All images and what two say of stiffness.
pub fn text(
    measured: &[Measured],
    relative: &Result<Stiffness, String>,
    (inclusion, inferred): (&Estimates, &Result<Inferred, String>),
) -> String {
    let row = |name: &str, value: String| (name.to_owned(), value);
    let mut text = String::new();
    for Measured { path, image, threshold_grey, paper, .. } in measured {
        let mut rows = vec![
            row("pixels", format!("{} x {}", image.width(), image.height())),
            row(
                "lit area",
                format!("{} (threshold {})", said(&paper.diameter_px, "pixels across"), figure(*threshold_grey)),
            ),
            row("", said(&paper.diameter_mm, "mm")),
            row("centroid", format!("column {}", said(&paper.centroid_px.axis(0), "px"))),
            row("", format!("row {}", said(&paper.centroid_px.axis(1), "px"))),
            row("indicator h", said(&paper.h_grey, "grey levels")),
            row("sum M", said(&paper.sum_grey, "grey levels")),
        ];
        rows.push(row("intervals", paper.intervals.to_owned()));
        rows.extend(paper.warnings.iter().map(|warning| row("note", warning.clone())));
        text.push_str(&format!("{}\n{}", path.display(), columns(&rows)));
    }
    let mut rows = match relative {
        Ok(stiffness) => vec![
            row("force", said(&stiffness.force_n, "N")),
            row("pressure", said(&stiffness.pressure_kpa, "kPa")),
            row("growth", said(&stiffness.deformation, "of the first diameter")),
            row("stiffness", said(&stiffness.relative_stiffness_kpa, "kPa, relative")),
        ],
        Err(reason) => vec![row("stiffness", format!("undefined: {reason}"))],
    };
    rows.extend(inclusion_rows(inclusion));
    if let Ok(inferred) = inferred {
        let others = inferred.unknowns.iter().filter(|one| !one.is_of_inclusion);
        rows.extend(others.map(|one| row(&one.name, all_said(&one.value, unit(&one.keys)))));
        let noise = format!("{} times that of the training images", figure(inferred.noise));
        rows.push(row("unexplained", noise));
    }
    text + &columns(&rows)
}

/// Unit of keys, by the ending of the first.
fn unit(keys: &[String]) -> &'static str {
    let key = keys.first().map_or("", String::as_str);
    let known = [("_kpa", "kPa"), ("_mm", "mm"), ("_mw", "mW"), ("_deg", "degrees"), ("_per_mm", "per mm")];
    known.into_iter().rfind(|(ending, _)| key.ends_with(ending)).map_or("", |(_, unit)| unit)
}

/// A figure with its interval, which holds no noise that a new image would show.
fn said(value: &Value, unit: &str) -> String {
    said_within(value, unit, "rounding and counting")
}

/// The same for programs.
pub fn json(
    measured: &[Measured],
    relative: &Result<Stiffness, String>,
    (inclusion, inferred): (&Estimates, &Result<Inferred, String>),
    reference: Option<&Path>,
) -> Json {
    let image = |one: &Measured| {
        let mut paper = json!(one.paper);
        paper["threshold_grey"] = json!(one.threshold_grey);
        json!({
            "image": one.path.display().to_string(),
            "pixels": [one.image.width(), one.image.height()],
            "paper": paper,
            "estimates": Estimates::without_model(),
        })
    };
    json!({
        "images": measured.iter().map(image).collect::<Vec<_>>(),
        "threshold_grey": common_threshold(measured),
        "reference": reference.map(|path| path.display().to_string()),
        "estimates": inclusion,
        "inferred": match inferred {
            Ok(inferred) => json!(inferred),
            Err(reason) => json!({"undefined": reason}),
        },
        "stiffness": match relative {
            Ok(stiffness) => json!(stiffness),
            Err(reason) => json!({"undefined": reason}),
        },
    })
}

/// The threshold where it is the same for all images, grey levels.
fn common_threshold(measured: &[Measured]) -> Json {
    match measured {
        [first, others @ ..] if others.iter().all(|one| one.threshold_grey == first.threshold_grey) => {
            json!(first.threshold_grey)
        }
        _ => json!({"undefined": "the images end at different grey levels; each has its own"}),
    }
}
