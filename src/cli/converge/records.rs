//! A folder that keeps one record for each item, each written whole or not at all, so that a stopped run can go on.

use crate::cli::output::{Claim, RESULT, SCENE};
use crate::cli::{Failure, cancel};
use crate::film::{Film, RADIANCE_UNIT};
use crate::image_io::{Provenance, read_radiance, write_radiance};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Where the records are, and what they belong to.
const ITEMS: &str = "items";
const ORDER: &str = "order.json";
/// An image that is being written.
const PARTIAL: &str = "partial";

/// The folder.
pub(super) struct Records {
    folder: PathBuf,
    _claim: Claim,
}

impl Records {
    /// Opens a folder for an order of a scene.
    ///
    /// # Errors
    /// When another run writes it, it exists and is neither to be replaced nor gone on with, holds another order or
    /// anything that was not written here, or cannot be written.
    pub fn open(folder: &Path, order: &Value, force: bool, resume: bool) -> Result<Self, Failure> {
        let shown = folder.display();
        let input = |message: String| Failure::input(message).in_file(folder);
        let records = Self { folder: folder.into(), _claim: Claim::take(folder)? };
        let old: Option<Value> = records.read_json(ORDER);
        match (folder.symlink_metadata().is_ok(), old) {
            (false, _) if resume => return Err(input(format!("{shown}: is not there to go on with"))),
            (false, _) => {}
            (true, Some(old)) if resume => {
                if old != *order {
                    return Err(input(format!(
                        "{shown}: holds the rungs of another scene or other flags; `--out` names another folder"
                    )));
                }
            }
            (true, Some(_)) if force => {
                if let Some(strange) = strange(folder) {
                    return Err(input(format!(
                        "{shown}: holds {}, which tirtouch did not write; it is not replaced: `--out` names another",
                        strange.display()
                    )));
                }
                std::fs::remove_dir_all(folder)
                    .map_err(|error| Failure::failed(format!("{shown}: cannot be replaced: {error}")))?;
            }
            (true, Some(_)) => {
                let message = format!(
                    "{shown}: exists; `--resume` goes on with it, `--force` replaces it, `--out` names another"
                );
                return Err(input(message));
            }
            (true, None) => return Err(input(format!("{shown}: exists and holds no ladders; `--out` names another"))),
        }
        std::fs::create_dir_all(folder.join(ITEMS))
            .map_err(|error| input(format!("{shown}: no folder can be made there: {error}")))?;
        cancel::ending().keep(format!("what was done is in {shown}: go on with --resume"));
        records.keep(ORDER, order)?;
        Ok(records)
    }

    fn item(&self, name: &str) -> PathBuf {
        self.folder.join(ITEMS).join(name)
    }

    fn read_json<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        serde_json::from_slice(&std::fs::read(self.item(name)).ok()?).ok()
    }

    fn keep<T: Serialize>(&self, name: &str, value: &T) -> Result<(), Failure> {
        let text = serde_json::to_string(value).map_err(|error| Failure::failed(format!("{name}: {error}")))?;
        self.write_at(&self.item(name), text.as_bytes())
    }

    /// The item `name`: as it was kept, or made now and kept.
    pub fn item_or<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        make: impl FnOnce() -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let name = format!("{name}.json");
        if let Some(kept) = self.read_json(&name) {
            return Ok(kept);
        }
        let made = make()?;
        self.keep(&name, &made)?;
        Ok(made)
    }

    /// A film, kept as an EXR.
    pub fn film_or(&self, name: &str, make: impl FnOnce() -> Result<Film, Failure>) -> Result<Film, Failure> {
        let path = self.item(&format!("{name}.exr"));
        if let Ok((film, _)) = read_radiance(&path) {
            return Ok(film);
        }
        let film = make()?;
        let partial = path.with_extension(PARTIAL);
        let provenance =
            Provenance { unit: RADIANCE_UNIT.into(), replicates: film.replicates, ..Provenance::default() };
        let _whole = cancel::ending();
        write_radiance(&partial, &film, &provenance)?;
        std::fs::rename(&partial, &path).map_err(|error| unwritable(&path, &error))?;
        Ok(film)
    }

    /// Writes a file of the folder, whole or not at all.
    pub fn write(&self, name: &str, text: &str) -> Result<(), Failure> {
        self.write_at(&self.folder.join(name), text.as_bytes())
    }

    fn write_at(&self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        let _whole = cancel::ending();
        let write = || {
            let mut file = tempfile::NamedTempFile::new_in(&self.folder)?;
            file.write_all(bytes)?;
            file.as_file().sync_all()?;
            file.persist(path).map_err(|error| error.error)
        };
        write().map(|_| ()).map_err(|error| unwritable(path, &error))
    }
}

/// Something in a folder of records, or in its items, of a kind that is never written there.
fn strange(folder: &Path) -> Option<PathBuf> {
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let named = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let is_ours = |path: &PathBuf| {
        let name = named(path);
        let figures = name.starts_with("converge") && (name.ends_with(".csv") || name.ends_with(".svg"));
        match path.is_dir() {
            true => name == ITEMS,
            // `.tmp...` is what a killed run was writing.
            false => figures || name == SCENE || name == RESULT || name.starts_with(".tmp"),
        }
    };
    let is_item = |path: &PathBuf| {
        let kind = path.extension().and_then(|kind| kind.to_str());
        path.is_file() && matches!(kind, Some("json" | "exr" | PARTIAL))
    };
    let items = folder.join(ITEMS);
    entries(folder).find(|path| !is_ours(path)).or_else(|| entries(&items).find(|path| !is_item(path)))
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::failed(format!("{}: cannot be written: {error}", path.display())).in_file(path)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn items_are_made_once_and_kept() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("ladders");
        let order = json!({"seed": 1});
        let records = Records::open(&folder, &order, false, false).unwrap();
        assert_eq!(records.item_or("a", || Ok(7)).unwrap(), 7);
        assert_eq!(records.item_or("a", || Err(Failure::failed("made twice"))), Ok(7));
        assert!(records.item_or::<u32>("b", || Err(Failure::cancelled())).is_err());
        drop(records);
        let again = Records::open(&folder, &order, false, true).unwrap();
        assert_eq!(again.item_or("a", || Ok(8)).unwrap(), 7);
        assert_eq!(again.item_or("b", || Ok(9)).unwrap(), 9);
    }

    #[test]
    fn another_order_an_existing_folder_and_a_strange_one_are_refused() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("ladders");
        assert_eq!(Records::open(&folder, &json!(1), false, true).err().unwrap().code(), 2);
        Records::open(&folder, &json!(1), false, false).unwrap();
        assert_eq!(Records::open(&folder, &json!(1), false, false).err().unwrap().code(), 2);
        assert_eq!(Records::open(&folder, &json!(2), false, true).err().unwrap().code(), 2);
        Records::open(&folder, &json!(2), true, false).unwrap();
        for strange in ["notes.txt", "items/notes.txt"] {
            std::fs::write(folder.join(strange), "mine").unwrap();
            let refused = Records::open(&folder, &json!(2), true, false).err().unwrap();
            assert!(refused.code() == 2 && refused.message().contains("notes.txt"), "{}", refused.message());
            std::fs::remove_file(folder.join(strange)).unwrap();
        }
        let records = Records::open(&folder, &json!(2), true, false).unwrap();
        let second = Records::open(&folder, &json!(2), false, true).err().unwrap();
        assert!(second.code() == 2 && second.message().contains("another run"), "{}", second.message());
        drop(records);
        std::fs::create_dir(place.path().join("mine")).unwrap();
        assert_eq!(Records::open(&place.path().join("mine"), &json!(1), true, false).err().unwrap().code(), 2);
    }
}
