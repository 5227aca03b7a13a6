//! What a folder of records is of, and what it may hold: an order that another run finds, and nothing strange.

use super::worker::{CLAIMS, WORKERS};
use super::{OutputError, RESULT, Remedy, SCENE};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Where the records are, and what they belong to.
pub(super) const ITEMS: &str = "items";
pub(super) const ORDER: &str = "order.json";
/// Folders of images.
const SPLITS: [&str; 2] = ["train", "test"];
/// Files beside the records.
const TABLES: [&str; 10] = [
    SCENE,
    RESULT,
    "sweep.toml",
    "points.csv",
    "points.parquet",
    "times.csv",
    "sensitivity.csv",
    "report.html",
    "README.md",
    "job.sh",
];
/// An image that is being written.
pub(super) const PARTIAL: &str = "partial";

pub(super) fn damaged(folder: &Path, remedy: Remedy) -> OutputError {
    let why = format!("{ITEMS}/{ORDER} in it is damaged, so that nothing tells what its records are of");
    OutputError::refused(folder, why, remedy)
}

/// Whether a folder holds nothing but an empty folder of items, and what a killed run was writing.
pub(super) fn is_bare(folder: &Path) -> bool {
    let names = |folder: &Path| -> Vec<PathBuf> {
        std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.file_name().into()).collect()
    };
    let is_left = |name: &PathBuf| name == Path::new(ITEMS) || name.to_string_lossy().starts_with(".tmp");
    let all = names(folder);
    !all.is_empty() && all.iter().all(is_left) && names(&folder.join(ITEMS)).is_empty()
}

/// Waits until another worker has made a folder: some seconds.
pub(super) fn await_order(folder: &Path) -> Option<()> {
    (0..100).find_map(|_| {
        let made = folder.join(ITEMS).join(ORDER).is_file();
        if !made {
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
        made.then_some(())
    })
}

/// Something in a folder of records, or in its items, of a kind that is never written there.
pub(super) fn strange(folder: &Path) -> Option<PathBuf> {
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let named = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let is_ours = |path: &PathBuf| {
        let name = named(path);
        let between = |start: &str, end: &str| name.strip_prefix(start)?.strip_suffix(end).map(str::to_owned);
        let figures = name == "converge.csv" || between("converge_", ".svg").is_some();
        let job = between("job-", ".log").is_some_and(|task| task.bytes().all(|byte| byte.is_ascii_digit()));
        // What a killed run was writing has six letters and digits.
        let writing = between(".tmp", "").is_some_and(|end| end.len() == 6 && end.chars().all(char::is_alphanumeric));
        match path.is_dir() {
            true => [ITEMS, CLAIMS, WORKERS, SPLITS[0], SPLITS[1]].contains(&name.as_str()),
            false => figures || job || writing || TABLES.contains(&name.as_str()),
        }
    };
    let is_item = |path: &PathBuf| {
        let kind = path.extension().and_then(|kind| kind.to_str());
        path.is_file() && matches!(kind, Some("json" | "exr" | PARTIAL))
    };
    // Images of points begin with their row.
    let is_image = |path: &PathBuf| {
        let name = named(path);
        let of_row = name.bytes().take(7).filter(u8::is_ascii_digit).count() == 7;
        let image = [".png", ".exr", ".npy"].iter().any(|kind| name.ends_with(kind));
        path.is_file() && (name == "metadata.csv" || of_row && image)
    };
    let is_folder = |path: &PathBuf| path.is_dir();
    let marks = || [CLAIMS, WORKERS].iter().flat_map(|of| entries(&folder.join(of))).find(is_folder);
    let items = folder.join(ITEMS);
    let images = || SPLITS.iter().flat_map(|split| entries(&folder.join(split))).find(|path| !is_image(path));
    entries(folder)
        .find(|path| !is_ours(path))
        .or_else(|| entries(&items).find(|path| !is_item(path)))
        .or_else(images)
        .or_else(marks)
}

/// Where two orders differ first, in words.
pub(super) fn difference(old: &Value, new: &Value) -> String {
    fn walk(at: &str, old: &Value, new: &Value) -> Option<String> {
        let shown = |value: &Value| match value {
            Value::String(text) => format!("{:?}", text.chars().take(60).collect::<String>()),
            other => other.to_string().chars().take(60).collect(),
        };
        match (old, new) {
            (old, new) if old == new => None,
            (Value::Object(a), Value::Object(b)) => {
                let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
                let none = Value::Null;
                let one = |key: &String| {
                    let at = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
                    walk(&at, a.get(key).unwrap_or(&none), b.get(key).unwrap_or(&none))
                };
                keys.into_iter().find_map(one)
            }
            (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
                a.iter().zip(b).enumerate().find_map(|(k, (old, new))| walk(&format!("{at}[{k}]"), old, new))
            }
            // Texts of files: the first line that differs.
            (Value::String(a), Value::String(b)) if a.contains('\n') && b.contains('\n') => {
                let (mut old, mut new) = (a.lines(), b.lines());
                (1..).find_map(|line| match (old.next(), new.next()) {
                    (a, b) if a == b && a.is_some() => None,
                    (a, b) => {
                        let said = |text: Option<&str>| text.map_or("nothing".to_owned(), |text| format!("{text:?}"));
                        Some(format!("line {line} of {at} is {} there and {} here", said(a), said(b)))
                    }
                })
            }
            (old, new) => Some(format!("{at} is {} there and {} here", shown(old), shown(new))),
        }
    }
    walk("", old, new).unwrap_or_default()
}
