//! The report of a run.

use super::PageError;
use super::explore::explore;
use super::facts::{columns, facts, figure, ledger, mean_radiance, said, scene_rows, version};
use super::press::{press_rows, press_section};
use super::press_files::{PressPictures, write_press};
use super::regimes::layers;
use super::regimes::regimes;
use super::shot::{CameraPictures, Pictures};
use super::truth::{truth_rows, truth_table};
use crate::estimate::{Detected, Estimates, GreyImage, Value};
use crate::output::OutputFolder;
use crate::pipeline::{EarlierFrame, NO_MECHANICS, Reading, Shot, Truth};
use crate::report::{Item, Report, Section, Table};

/// What a report tells.
pub struct Run<'a> {
    /// The image.
    pub shot: &'a Shot<'a>,
    /// What was read from it.
    pub figures: &'a Reading,
    /// Name of what was subtracted first, if anything.
    pub reference: Option<&'a str>,
    /// What the phantom holds.
    pub truth: &'a Truth,
    /// Depth, mm, and frame of each load, in order.
    pub frames: &'a [(f64, GreyImage)],
    /// What is said of those before the last.
    pub earlier: &'a [EarlierFrame],
    /// The command that asked for it.
    pub command: String,
    /// The same without what changes no light.
    pub command_of_light: String,
}

/// Writes radiance, camera image, press, pictures and the report; says how long the files of the light took, seconds.
///
/// # Errors
/// A view that total reflection hides, a file that cannot be written.
pub fn write(run: &Run, folder: &OutputFolder) -> Result<f64, PageError> {
    let shot = run.shot;
    let light = shot.write_pictured(folder, &run.command_of_light)?;
    let seen = shot.camera_pictures(run.figures, run.reference)?;
    folder.write("camera_false_color.svg", &seen.false_color)?;
    folder.write("camera_relief.svg", &seen.relief)?;
    let scene = shot.prepared.scene();
    let lift_mm = scene.stack.height_mm();
    let press = shot.prepared.pressed().map(|(pressed, _)| write_press(&scene.name, pressed, lift_mm, folder));
    let drawn = Drawn { light, seen, press: press.transpose()? };
    folder.write("report.html", &report(run, &drawn)?.to_html())?;
    Ok(drawn.light.files_seconds)
}

/// The pictures of a run.
struct Drawn {
    light: Pictures,
    seen: CameraPictures,
    press: Option<PressPictures>,
}

fn report(run: &Run, drawn: &Drawn) -> Result<Report, PageError> {
    let Run { shot, figures, reference, truth, .. } = *run;
    let scene = shot.prepared.scene();
    let explore = Item::Explore(Box::new(explore(shot, run.frames, run.earlier)?));
    let explore = Section { title: String::new(), items: vec![explore] };
    let mut sections = vec![explore, camera(shot, reference, &drawn.seen), estimates(figures, reference, truth)];
    if let (Some((pressed, _)), Some(pictures)) = (shot.prepared.pressed(), &drawn.press) {
        sections.push(press_section(pressed, pictures));
    }
    sections.extend([light(shot, &drawn.light), stack(shot)]);
    Ok(Report {
        title: format!("tirtouch: {}", scene.name),
        summary: summary(shot, figures),
        facts: cards(shot),
        sections,
        provenance: provenance(shot, &run.command),
    })
}

fn summary(shot: &Shot, figures: &Reading) -> String {
    let lit = match &figures.paper.diameter_mm {
        Value::Known { value, .. } => format!("The lit area is {} mm across.", figure(*value)),
        Value::Undefined { reason } => format!("The diameter of the lit area is undefined: {reason}."),
    };
    format!("{} {lit}", shot.prepared.scene().description)
}

/// The figures in few words; the text below says more.
fn cards(shot: &Shot) -> Vec<(String, String)> {
    let outcome = &shot.outcome;
    let card = |name: &str, value: String| (name.to_owned(), value);
    let error = match outcome.relative_error {
        Some(error) => format!("{} %", figure(100.0 * error)),
        None => "undefined: dark".to_owned(),
    };
    vec![
        card("backend", outcome.backend.to_owned()),
        card("integrator", outcome.plan.integrator.name().to_owned()),
        card("tracing time", format!("{} s", figure(outcome.seconds))),
        card("paths a pixel", outcome.spp.to_string()),
        card("photons", figure(outcome.photons as f64)),
        card("error of a lit pixel", error),
        card("brightest grey level", format!("{} of {}", shot.frame.max_grey(), shot.frame.top_grey())),
    ]
}

fn camera(shot: &Shot, reference: Option<&str>, seen: &CameraPictures) -> Section {
    let sensor = &shot.prepared.scene().camera.sensor;
    let exposure = format!(
        "Grey levels of camera.png: {} ms at f/{}, full well {} electrons, {} bits.",
        figure(sensor.exposure_ms),
        figure(sensor.f_number),
        figure(sensor.full_well_e),
        sensor.bit_depth
    );
    let frame = reference.map_or_else(String::new, |name| {
        format!(" The pictures show that frame less {name}, which is what was measured.")
    });
    let caption =
        format!("{exposure}{frame} The line runs around the pixels above the threshold; the cross is their centroid.");
    let items = vec![
        Item::picture(&seen.false_color, "the measured frame in false colour", caption),
        Item::picture(&seen.relief, "relief of the grey levels", "The same grey levels as height."),
    ];
    Section { title: "What the camera sees".into(), items }
}

fn estimates(figures: &Reading, reference: Option<&str>, truth: &Truth) -> Section {
    let image = match reference {
        Some(name) => format!("the frame less {name}"),
        None => "the raw frame".to_owned(),
    };
    let mut items = vec![
        Item::Text(format!("Inclusion: {}.", found(&figures.estimates.detected))),
        Item::from_estimates(&figures.estimates),
        Item::Text(format!(
            "Figures of the image as the TSIS paper defines them, of {image}, with a threshold of {} grey levels. \
             Intervals say how well the image's figures are known, not how well the object's ({}): the lit area holds all \
             that glows, which is wider than what presses and grows with brightness.",
            figure(figures.threshold_grey),
            figures.paper.intervals
        )),
        Item::from_paper(&figures.paper),
    ];
    items.extend(truth_table(truth));
    items.extend(figures.paper.warnings.iter().cloned().map(Item::Warning));
    Section { title: "Estimates".into(), items }
}

fn light(shot: &Shot, pictures: &Pictures) -> Section {
    let caption = format!("Radiance at the camera, before lens and sensor. Mean {}.", mean_radiance(shot));
    Section {
        title: "Light".into(),
        items: vec![
            Item::picture(&pictures.radiance, "radiance in false colour", caption),
            Item::picture(
                &pictures.side,
                "the stack from the side with rays",
                "Rays from the LEDs at the left and right wall, traced through the stack. They are picked to show each fate; \
                 the table below has the true shares.",
            ),
            Item::Ledger(shot.outcome.ledger),
            Item::Text(format!("Integrator {}: {}.", shot.outcome.plan.integrator.name(), shot.outcome.plan.why)),
        ],
    }
}

fn stack(shot: &Shot) -> Section {
    let layers = layers(shot.prepared);
    let rows = layers.iter().map(|layer| {
        vec![
            layer.name.clone(),
            format!("{:.5}", layer.n),
            layer.thickness_mm.to_string(),
            format!("{:.3}", layer.acceptance_deg),
            layer.critical_text(),
        ]
    });
    let columns = ["layer", "n", "thickness (mm)", "acceptance angle (°)", "critical angle (°)"];
    let table = Table {
        caption: "Layers, touch side first".into(),
        columns: columns.map(str::to_owned).to_vec(),
        rows: rows.collect(),
    };
    let mut items = vec![Item::Table(table)];
    items.extend(regimes(shot.prepared, &layers).into_iter().map(|text| Item::Text(sentence(&text))));
    Section { title: "Stack".into(), items }
}

fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

fn provenance(shot: &Shot, command: &str) -> Vec<(String, String)> {
    let pair = |name: &str, value: String| (name.to_owned(), value);
    let loaded = &shot.prepared.loaded;
    let mut rows = scene_rows(&loaded.scene.name, &loaded.sha256, &loaded.inputs());
    rows.extend([
        pair("seed", shot.prepared.streams.seed.to_string()),
        pair("adapter", shot.outcome.adapter.clone()),
        version(),
        pair("command", command.to_owned()),
    ]);
    rows
}

/// What is said of the inclusion.
pub fn inclusion_rows(estimates: &Estimates) -> Vec<(String, String)> {
    let row = |name: &str, value: String| (name.to_owned(), value);
    vec![
        row("inclusion", found(&estimates.detected)),
        row("size", said(&estimates.size_mm, "mm")),
        row("depth", said(&estimates.depth_mm, "mm to its top")),
        row("modulus", said(&estimates.youngs_kpa, "kPa")),
    ]
}

/// Whether there is one, in words.
fn found(detected: &Detected) -> String {
    match detected {
        Detected::Known(true) => "there is one".into(),
        Detected::Known(false) => "none is told from noise".into(),
        Detected::Undefined { undefined } => format!("undefined: {undefined}"),
    }
}

/// A run in words; `out` is its folder.
pub fn text(shot: &Shot, figures: &Reading, truth: &Truth, out: &str) -> String {
    let (paper, estimates) = (&figures.paper, &figures.estimates);
    let row = |name: &str, value: String| (name.to_owned(), value);
    let mut rows = facts(shot);
    match shot.prepared.pressed() {
        Some((pressed, _)) => rows.extend(press_rows(pressed)),
        None => rows.push(row("mechanics", format!("none: {NO_MECHANICS}"))),
    }
    rows.extend([
        row("light", ledger(shot)),
        row(
            "lit area",
            format!(
                "{} (threshold {} grey levels)",
                said(&paper.diameter_px, "pixels across"),
                figure(figures.threshold_grey)
            ),
        ),
        row("its diameter", said(&paper.diameter_mm, "mm")),
        row("indicator h", said(&paper.h_grey, "grey levels")),
        row("sum M", said(&paper.sum_grey, "grey levels")),
    ]);
    rows.extend(inclusion_rows(estimates));
    rows.extend(truth_rows(truth));
    rows.extend(paper.warnings.iter().map(|warning| row("note", warning.clone())));
    rows.push(row("folder", out.to_owned()));
    rows.push(row("report", format!("{out}/report.html")));
    format!("{}\n{}", shot.prepared.scene().name, columns(&rows))
}
