//! What a finished folder says of itself, and by what this program knows it again.
//!
//! `scene.toml` is the scene as it was read, `result.json` what `--json` prints, with the command line. `SHA256SUMS`
//! lists all files, for `sha256sum -c` and for `--force`: a folder is replaced only while it holds those files and
//! nothing else.

use super::{OutputError, Remedy};
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// File of the scene as read.
pub const SCENE: &str = "scene.toml";
/// File of the result, as JSON.
pub const RESULT: &str = "result.json";
/// The list of all other files.
const SUMS: &str = "SHA256SUMS";
/// Its first line: `sha256sum` takes it for a comment.
const HEADING: &str = "# Files of a folder of tirtouch, which replaces it only while it holds these and no others.";
/// Files that viewers of folders leave behind.
const LITTER: [&str; 3] = [".DS_Store", "Thumbs.db", "desktop.ini"];

/// A result with where it is and what version made it.
pub fn described(mut result: Value, out: Option<&Path>) -> Value {
    result["out"] = json!(out.map(|out| out.display().to_string()));
    result["version"] = json!(env!("CARGO_PKG_VERSION"));
    result
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
pub(super) fn check_own(folder: &Path) -> Result<(), OutputError> {
    let refused = |why: String| OutputError::refused(folder, format!("{why}; it is not replaced"), Remedy::Elsewhere);
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
