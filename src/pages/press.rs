//! What a report says of a press.

use super::PageError;
use super::facts::{figure, load_name, scene_rows, version};
use super::press_files::{PressPictures, write_press};
use super::truth::truth_table;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::press::{Pressed, PressureError, Rounding, SensorBody};
use crate::output::OutputFolder;
use crate::pipeline::{PressSummary, Truth, method_name, setting};
use crate::report::{Item, Report, Section, Table};
use crate::scene::LoadedScene;
use serde_json::{Value, json};

/// Writes a press: its contact, shape, pictures and report; what is said of it for programs. `stopped` says why it
/// reached no more.
///
/// # Errors
/// What cannot be drawn or written.
pub fn write(
    (loaded, pressed): (&LoadedScene, &Pressed),
    truth: &Truth,
    stopped: Option<&str>,
    command: String,
    folder: &OutputFolder,
) -> Result<Value, PageError> {
    let name = &loaded.scene.name;
    let pictures = write_press(name, pressed, loaded.scene.stack.height_mm(), folder)?;
    if let Some(why) = stopped {
        folder.write("STOPPED.txt", &format!("{why}\nThe files hold the loads before that.\n"))?;
    }
    let page = press_report(loaded, pressed, truth, &pictures, stopped, command);
    folder.write("report.html", &page.to_html())?;
    Ok(json!({"scene": name, "inputs": loaded.inputs(), "truth": truth, "mechanics": PressSummary::of(pressed)}))
}

fn press_report(
    loaded: &LoadedScene,
    pressed: &Pressed,
    truth: &Truth,
    pictures: &PressPictures,
    stopped: Option<&str>,
    command: String,
) -> Report {
    let scene = &loaded.scene;
    let mut section = press_section(pressed, pictures);
    if let Some(why) = stopped {
        section.items.insert(0, Item::Warning(format!("The press stopped early: {why}.")));
    }
    section.items.extend(truth_table(truth));
    let pair = |name: &str, value: String| (name.to_owned(), value);
    let mut facts =
        vec![pair("unknowns", pressed.unknowns.to_string()), pair("iterations", pressed.iterations.to_string())];
    facts.push(pair("seconds", figure(pressed.seconds)));
    if let Some(step) = pressed.steps.last() {
        facts.push(pair("force", format!("{} N", figure(step.force_n))));
        facts.push(pair("peak pressure", format!("{} kPa", figure(step.peak_pressure_kpa))));
    }
    Report {
        title: format!("tirtouch: {}", scene.name),
        summary: scene.description.clone(),
        facts,
        sections: vec![section],
        provenance: scene_rows(&scene.name, &loaded.sha256, &loaded.inputs())
            .into_iter()
            .chain([version(), pair("command", command)])
            .collect(),
    }
}

/// The press as a section of a report.
pub fn press_section(pressed: &Pressed, pictures: &PressPictures) -> Section {
    let mut items = Vec::new();
    if let Some(mesh) = &pictures.mesh {
        let caption = "Section through the axis after the press, coloured by mean compressive stress.";
        items.push(Item::picture(mesh, "deformed mesh with pressure in colour", caption));
    }
    let caption = "Pressure on the touched face. The peak is judged within 0.8 of its radius, under an indenter \
                   over all of it.";
    items.push(Item::picture(&pictures.pressure, "contact pressure", caption));
    let percent = |share: Option<f64>| {
        share.and_then(PressureError::resolved).map_or("-".to_owned(), |share| figure(100.0 * share))
    };
    let is_solid = pressed.setup.kinematics == Kinematics::ThreeDimensional;
    let at = if is_solid { "at x, y (mm)" } else { "at (mm)" };
    let place = |[x, y]: [f64; 2]| if is_solid { format!("{x:.2}, {y:.2}") } else { format!("{x:.2}") };
    let rows = pressed.steps.iter().map(|step| {
        vec![
            load_name(step),
            format!("{:.4}", step.force_n),
            percent(step.error.map(|error| error.force)),
            format!("{:.4}", step.peak_pressure_kpa),
            percent(step.error.and_then(|error| error.peak)),
            step.peak_at_mm.map_or("-".to_owned(), place),
            percent(step.error.map(|error| error.rms)),
        ]
    });
    let columns = ["load", "force (N)", "± (%)", "peak pressure (kPa)", "± (%)", at, "all pressures, rms ± (%)"];
    items.push(Item::Table(Table {
        caption: "Presses; errors are estimated from a second, coarser mesh".into(),
        columns: columns.map(str::to_owned).to_vec(),
        rows: rows.collect(),
    }));
    let facts = press_rows(pressed);
    items.extend(facts.first().map(|(_, text)| Item::Text(format!("Solver: {text}."))));
    Section { title: "Press".into(), items }
}

/// A press in words.
pub fn press_rows(pressed: &Pressed) -> Vec<(String, String)> {
    let percent = |share: f64| figure(100.0 * share);
    let part = match pressed.setup.sensor {
        SensorBody::Indenter(_) => "",
        _ => " over 0.8 of the face",
    };
    let row = |name: &str, value: String| (name.to_owned(), value);
    let mut rows = vec![row(
        "mechanics",
        format!(
            "{}, {} unknowns, {} iterations, {} s and {} s for the error; {} of {} MiB",
            setting(&pressed.setup),
            pressed.unknowns,
            pressed.iterations,
            figure(pressed.seconds),
            figure(pressed.error_seconds),
            method_name(pressed.method),
            figure(pressed.factor_mib)
        ),
    )];
    rows.extend(pressed.steps.iter().map(|step| {
        let error = match step.error {
            Some(error) => {
                let sharp = |rounding: Rounding| {
                    format!(
                        "; a sharp edge changes them by up to {} and {} %",
                        percent(rounding.rms),
                        percent(rounding.force)
                    )
                };
                let sharp = error.rounding.map_or(String::new(), sharp);
                let told = |what: &str, share: f64| match PressureError::resolved(share) {
                    Some(share) => format!("{what} within {} %", percent(share)),
                    None => format!("{what} not resolved"),
                };
                let pressure = told("pressure (rms)", error.rms);
                let peak = error.peak.map_or(String::new(), |peak| told(", its peak", peak));
                format!(" ({pressure}{peak}, {}{sharp})", told("force", error.force))
            }
            None => String::new(),
        };
        let peak = figure(step.peak_pressure_kpa);
        let force = format!("{} N, peak pressure{part} {peak} kPa{error}", figure(step.force_n));
        row(&load_name(step), force)
    }));
    rows
}
