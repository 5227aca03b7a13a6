//! `new`: a scene file to begin with.

use super::{Failure, Outcome, Talk};
use crate::output::write_whole;
use crate::scene::{self, LoadedScene};
use crate::vary::{self, Set};
use crate::view::Knob;
use clap::{Args, ValueEnum};
use serde_json::json;
use std::io::{BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// The schema that editors take, beside the scene.
const SCHEMA: &str = "tirtouch.schema.json";

/// Write a commented scene file to begin with, and the schema by which an editor knows its keys.
///
/// On a terminal it asks for what no flag says.
#[derive(Debug, Args)]
pub(super) struct New {
    /// Name of the scene; the file is NAME.toml, whether or not that is said.
    name: String,
    /// What the scene holds.
    #[arg(long, value_enum)]
    kind: Option<SceneKind>,
    /// Set a key of the scene, as in `stack.layer[0].n=1.42`; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Set>,
    /// Folder to write to [default: this one].
    #[arg(short, long, value_name = "DIR", default_value = ".", hide_default_value = true)]
    out: PathBuf,
    /// Ask nothing.
    #[arg(long)]
    yes: bool,
    #[command(flatten)]
    talk: Talk,
}

/// What a scene holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SceneKind {
    /// A sensor that nothing touches.
    Sensor,
    /// A sensor with a dent of a given shape.
    Dent,
    /// A sensor that tissue touches in a disc.
    Contact,
    /// A phantom with an inclusion, pressed on the sensor.
    Phantom,
}

/// A key that is asked for, and the question.
type Question = (&'static str, &'static str);

impl SceneKind {
    /// The scene that it begins with, and what is asked.
    fn start(self) -> (&'static str, &'static [Question]) {
        const INDEX: Question = ("stack.layer[0].n", "index of refraction of the touched layer");
        match self {
            Self::Sensor => ("flat-bonded", &[INDEX]),
            Self::Dent => ("dent-cap", &[INDEX, ("touch.shape.depth_mm", "depth of the dent, mm")]),
            Self::Contact => ("contact-disc", &[INDEX, ("touch.contact.pressure.radius_mm", "radius of the disc, mm")]),
            Self::Phantom => (
                "phantom-size-8mm",
                &[
                    ("phantom.inclusion[0].shape.diameter_mm", "diameter of the inclusion, mm"),
                    ("phantom.inclusion[0].depth_mm", "its depth, from the touched face to its top, mm"),
                    ("phantom.inclusion[0].material.youngs_kpa", "its Young's modulus, kPa"),
                    ("phantom.material.youngs_kpa", "Young's modulus of the tissue around it, kPa"),
                    INDEX,
                ],
            ),
        }
    }
}

impl New {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let name = self.name.strip_suffix(".toml").unwrap_or(&self.name);
        let plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
        if name.is_empty() || name.starts_with(['.', '-']) || !name.chars().all(plain) {
            let message = format!("`{name}`: a name has letters, digits, - _ and . and begins with neither - nor .");
            return Err(Failure::usage(message));
        }
        let file = self.out.join(format!("{name}.toml"));
        if file.symlink_metadata().is_ok() {
            return Err(is_there(&file));
        }
        let asks = !self.yes && !self.talk.json && std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
        let kind = match self.kind {
            Some(kind) => kind,
            None if asks => ask_kind()?,
            None => SceneKind::Phantom,
        };
        let (preset, questions) = kind.start();
        let mut loaded = scene::preset(preset)?;
        if asks {
            for (key, question) in
                questions.iter().filter(|(key, _)| !self.set.iter().any(|set| set.key.to_string() == *key))
            {
                loaded = ask(loaded, &file, key, question)?;
            }
        }
        let loaded = vary::with(loaded, &file, &self.set)?;
        let text = renamed(&loaded, name, preset);
        // What is written can be read.
        scene::parse(&text, &file)?;
        let schema = self.out.join(SCHEMA);
        if !schema.exists() {
            write_whole(&schema, &format!("{:#}\n", scene::schema()))?;
        }
        write_anew(&file, &text)?;
        self.talk.tell(
            json!({"file": file.display().to_string()}),
            format!("{0}: try `tirtouch run {0}` or `tirtouch view {0}`", file.display()),
        )
    }
}

fn is_there(file: &Path) -> Failure {
    Failure::usage(format!("{}: is there already", file.display())).in_file(file)
}

/// Writes a file whole, where none is: one that has come to be there since stays.
fn write_anew(file: &Path, text: &str) -> Result<(), Failure> {
    let failed = |error: std::io::Error| Failure::failed(format!("{}: {error}", file.display())).in_file(file);
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut partial =
        tempfile::Builder::new().prefix(".tirtouch").suffix(".partial").tempfile_in(folder).map_err(failed)?;
    partial.write_all(text.as_bytes()).and_then(|()| partial.as_file().sync_all()).map_err(failed)?;
    match partial.persist_noclobber(file) {
        Ok(_) => Ok(()),
        Err(error) if error.error.kind() == std::io::ErrorKind::AlreadyExists => Err(is_there(file)),
        Err(error) => Err(failed(error.error)),
    }
}

/// The scene's text under another name, without what its file said of where its numbers come from.
fn renamed(loaded: &LoadedScene, name: &str, preset: &str) -> String {
    let mut in_head = true;
    let body = loaded.text.lines().skip_while(|line| line.starts_with('#') || line.trim().is_empty());
    let body = body.filter(|line| {
        in_head &= !line.starts_with('[');
        !(in_head && ["name =", "description ="].iter().any(|key| line.starts_with(key)))
    });
    let body: String = body.flat_map(|line| [line, "\n"]).collect();
    format!(
        "#:schema {SCHEMA}\n\
         # Begun as preset:{preset}. Keys name their units; `tirtouch schema --markdown` explains each.\n\
         name = \"{name}\"\n\
         description = \"Begun as {preset}.\"\n\n{}",
        body.trim_start()
    )
}

fn ask_kind() -> Result<SceneKind, Failure> {
    let kinds = SceneKind::value_variants();
    loop {
        for (k, kind) in kinds.iter().enumerate() {
            let value = kind.to_possible_value();
            let (name, help) = value.as_ref().map_or(("", None), |value| (value.get_name(), value.get_help()));
            tell(&format!("  {}  {name}: {}\n", k + 1, help.map(ToString::to_string).unwrap_or_default()));
        }
        let Some(answer) = answer("what does the scene hold? [4]")? else { return Ok(SceneKind::Phantom) };
        let numbered = answer.parse().ok().and_then(|k: usize| kinds.get(k.checked_sub(1)?)).copied();
        if let Some(kind) = numbered.or_else(|| SceneKind::from_str(&answer, true).ok()) {
            return Ok(kind);
        }
    }
}

/// Asks for a key until the scene takes the answer.
fn ask(loaded: LoadedScene, file: &Path, key: &str, question: &str) -> Result<LoadedScene, Failure> {
    let knobs = Knob::of(&loaded, file, &[]).map_err(Failure::usage)?;
    let now = knobs.iter().find(|knob| knob.key == key).map_or_else(String::new, |knob| format!(" [{}]", knob.value));
    loop {
        let Some(answer) = answer(&format!("{question}{now}"))? else { return Ok(loaded) };
        let set = format!("{key}={answer}").parse::<Set>();
        let with = set.map_err(Failure::usage).and_then(|set| Ok(vary::with(loaded.clone(), file, &[set])?));
        match with {
            Ok(loaded) => return Ok(loaded),
            Err(failure) => tell(&format!("  {}\n", failure.message())),
        }
    }
}

/// One line of an answer; none where it is empty.
fn answer(question: &str) -> Result<Option<String>, Failure> {
    super::cancel::check()?;
    tell(&format!("{question}: "));
    let mut line = String::new();
    let read = std::io::stdin().lock().read_line(&mut line);
    super::cancel::check()?;
    let read = read.map_err(|error| Failure::failed(format!("standard input cannot be read: {error}")))?;
    if read == 0 {
        tell("\n");
    }
    let line = line.trim().to_owned();
    Ok((!line.is_empty()).then_some(line))
}

fn tell(text: &str) {
    let mut out = std::io::stderr().lock();
    let _ = write!(out, "{text}").and_then(|()| out.flush());
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_begins_with_a_scene_that_has_what_is_asked() {
        for kind in SceneKind::value_variants() {
            let (preset, questions) = kind.start();
            let loaded = scene::preset(preset).unwrap();
            let file = Path::new("mine.toml");
            let knobs = Knob::of(&loaded, file, &[]).unwrap();
            for (key, _) in questions {
                let knob = knobs.iter().find(|knob| knob.key == *key);
                assert!(knob.is_some(), "{kind:?}: {key}");
            }
            let begun = scene::parse(&renamed(&loaded, "mine", preset), file).unwrap().scene;
            let named = (begun.name.as_str(), begun.description.contains(preset));
            assert_eq!(named, ("mine", true));
            let (name, description) = (loaded.scene.name.clone(), loaded.scene.description.clone());
            assert_eq!(scene::Scene { name, description, ..begun }, loaded.scene, "{kind:?}");
        }
    }
}
