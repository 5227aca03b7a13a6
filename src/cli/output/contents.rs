//! What a finished folder says of itself, and by what this program knows it again.
//!
//! `scene.toml` is the scene as it was read, `result.json` what `--json` prints, with the command line. `SHA256SUMS`
//! lists all files, for `sha256sum -c` and for `--force`: a folder is replaced only while it holds those files and
//! nothing else.

use crate::cli::Failure;
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The scene as read.
pub(in crate::cli) const SCENE: &str = "scene.toml";
/// What `--json` prints.
pub(in crate::cli) const RESULT: &str = "result.json";
/// The list of all other files.
const SUMS: &str = "SHA256SUMS";
/// Its first line: `sha256sum` takes it for a comment.
const HEADING: &str = "# Files of a folder of tirtouch, which replaces it only while it holds these and no others.";
/// Files that viewers of folders leave behind.
const LITTER: [&str; 3] = [".DS_Store", "Thumbs.db", "desktop.ini"];

/// A result with what every command adds: where it is, what made it, and how it was asked for.
pub(in crate::cli) fn described(mut result: Value, out: Option<&Path>) -> Value {
    result["out"] = json!(out.map(|out| out.display().to_string()));
    result["version"] = json!(env!("CARGO_PKG_VERSION"));
    result["command"] = json!(command());
    result
}

/// The command line, the program's name first.
fn command() -> Vec<String> {
    std::env::args_os().map(|argument| argument.to_string_lossy().into_owned()).collect()
}

/// The same in one line, for people.
pub(in crate::cli) fn command_line() -> String {
    command().join(" ")
}

/// The command line without what changes no light (folder and talk) and without the program's own place: equal renders
/// then have equal headers.
pub(in crate::cli) fn command_of_light() -> String {
    let mut said = vec!["tirtouch".to_owned()];
    let mut arguments = command().into_iter().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "-o" | "--out" => drop(arguments.next()),
            "--force" | "--quiet" | "--json" => {}
            out if out.starts_with("-o") || out.starts_with("--out=") => {}
            _ => said.push(argument),
        }
    }
    said.join(" ")
}

fn hash(file: &Path) -> std::io::Result<String> {
    Ok(Sha256::digest(std::fs::read(file)?).iter().map(|byte| format!("{byte:02x}")).collect())
}

/// The list of a folder's files.
pub(super) fn sums(folder: &Path) -> std::io::Result<(&'static str, String)> {
    let mut lines = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        lines.insert(entry.file_name().to_string_lossy().into_owned(), hash(&entry.path())?);
    }
    let lines: String = lines.iter().map(|(name, hash)| format!("{hash}  {name}\n")).collect();
    Ok((SUMS, format!("{HEADING}\n{lines}")))
}

/// Whether this program wrote a folder (or it is empty), and all that it holds.
///
/// # Errors
/// When it holds anything else, with what that is.
pub(in crate::cli) fn check_own(folder: &Path) -> Result<(), Failure> {
    let shown = folder.display();
    let refused = |why: String| {
        Failure::input(format!("{shown}: {why}; it is not replaced: `--out` names another folder")).in_file(folder)
    };
    let unreadable = |error: std::io::Error| refused(format!("cannot be read: {error}"));
    let sums = std::fs::read_to_string(folder.join(SUMS)).unwrap_or_default();
    let listed: BTreeMap<&str, &str> = match sums.split_once('\n') {
        Some((HEADING, lines)) => {
            lines.lines().filter_map(|line| line.split_once("  ").map(|(hash, name)| (name, hash))).collect()
        }
        _ => BTreeMap::new(),
    };
    let entries = std::fs::read_dir(folder).map_err(unreadable)?;
    let mut paths: Vec<PathBuf> =
        entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>().map_err(unreadable)?;
    paths.sort();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if (name == SUMS && !listed.is_empty()) || LITTER.contains(&name.as_str()) {
            continue;
        }
        match listed.get(name.as_str()) {
            None if listed.is_empty() => return Err(refused(format!("holds {name} and is no folder of tirtouch"))),
            None => return Err(refused(format!("holds {name}, which tirtouch did not write"))),
            Some(hash) if !path.is_file() || self::hash(&path).map_err(unreadable)? != **hash => {
                return Err(refused(format!("{name} was changed since tirtouch wrote it")));
            }
            Some(_) => {}
        }
    }
    Ok(())
}
