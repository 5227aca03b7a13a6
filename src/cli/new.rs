//! `new`: a scene file to begin with.

use super::{Failure, Outcome, Talk};
use crate::output::{must_be_free, write_new, write_whole};
use crate::scene::begin::{self, BEGINNINGS, Beginning, PHANTOM};
use crate::scene::{self, LoadedScene};
use crate::vary::{self, Set};
use crate::view::Knob;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
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
    #[arg(long, value_parser = kinds())]
    kind: Option<String>,
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

impl New {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let name = self.name.strip_suffix(".toml").unwrap_or(&self.name);
        begin::check_name(name).map_err(|why| Failure::usage(format!("`{name}`: {why}")))?;
        let file = self.out.join(format!("{name}.toml"));
        must_be_free(&file)?;
        let asks = !self.yes && !self.talk.json && std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
        let beginning = match self.kind.as_deref().and_then(Beginning::of) {
            Some(beginning) => beginning,
            None if asks => ask_kind()?,
            None => &PHANTOM,
        };
        let mut loaded = scene::preset(beginning.preset)?;
        let is_set = |key: &str| self.set.iter().any(|set| set.key.to_string() == key);
        for (key, question) in beginning.questions.iter().filter(|(key, _)| asks && !is_set(key)) {
            loaded = ask(loaded, &file, key, question)?;
        }
        let text = beginning.text(&vary::with(loaded, &file, &self.set)?, name, SCHEMA);
        // What is written can be read.
        scene::parse(&text, &file)?;
        let schema = self.out.join(SCHEMA);
        if !schema.exists() {
            write_whole(&schema, &format!("{:#}\n", scene::schema()))?;
        }
        write_new(&file, &text)?;
        self.talk.tell(
            json!({"file": file.display().to_string()}),
            format!("{0}: try `tirtouch run {0}` or `tirtouch view {0}`", file.display()),
        )
    }
}

fn kinds() -> PossibleValuesParser {
    BEGINNINGS.iter().map(|one| PossibleValue::new(one.kind).help(one.holds)).into()
}

fn ask_kind() -> Result<&'static Beginning, Failure> {
    loop {
        for (k, Beginning { kind, holds, .. }) in BEGINNINGS.iter().enumerate() {
            tell(&format!("  {}  {kind}: {holds}\n", k + 1));
        }
        let Some(answer) = answer("what does the scene hold? [4]")? else { return Ok(&PHANTOM) };
        let numbered = answer.parse().ok().and_then(|k: usize| BEGINNINGS.get(k.checked_sub(1)?)).copied();
        if let Some(beginning) = numbered.or_else(|| Beginning::of(&answer.to_lowercase())) {
            return Ok(beginning);
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
    Ok(Some(line.trim().to_owned()).filter(|line| !line.is_empty()))
}

fn tell(text: &str) {
    let mut out = std::io::stderr().lock();
    let _ = write!(out, "{text}").and_then(|()| out.flush());
}
