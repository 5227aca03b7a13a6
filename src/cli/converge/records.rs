//! A folder that keeps one record for each item, each written whole or not at all, so that a stopped run can go on.

use crate::cli::Failure;
use crate::film::Film;
use crate::image_io::{Provenance, read_radiance, write_radiance};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Where the records are, and what they belong to.
const ITEMS: &str = "items";
const ORDER: &str = "order.json";

/// The folder.
pub(super) struct Records {
    folder: PathBuf,
}

impl Records {
    /// Opens a folder for an order.
    ///
    /// # Errors
    /// When it exists and is neither to be replaced nor gone on with, holds another order, or cannot be written.
    pub fn open(folder: &Path, order: &Value, force: bool, resume: bool) -> Result<Self, Failure> {
        let shown = folder.display();
        let input = |message: String| Failure::input(message).in_file(folder);
        let records = Self { folder: folder.into() };
        let old: Option<Value> = records.read_json(ORDER);
        match (folder.symlink_metadata().is_ok(), old) {
            (false, _) if resume => return Err(input(format!("{shown}: is not there to go on with"))),
            (false, _) => {}
            (true, Some(old)) if resume => {
                return match old == *order {
                    true => Ok(records),
                    false => Err(input(format!(
                        "{shown}: holds the rungs of another scene or other flags; `--out` names another folder"
                    ))),
                };
            }
            (true, Some(_)) if force => {
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
        let partial = path.with_extension("partial");
        let provenance = Provenance { unit: "W/(m^2 sr)".into(), replicates: film.replicates, ..Provenance::default() };
        write_radiance(&partial, &film, &provenance)?;
        std::fs::rename(&partial, &path).map_err(|error| unwritable(&path, &error))?;
        Ok(film)
    }

    /// Writes a file of the folder, whole or not at all.
    pub fn write(&self, name: &str, text: &str) -> Result<(), Failure> {
        self.write_at(&self.folder.join(name), text.as_bytes())
    }

    fn write_at(&self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        let write = || {
            let mut file = tempfile::NamedTempFile::new_in(&self.folder)?;
            file.write_all(bytes)?;
            file.as_file().sync_all()?;
            file.persist(path).map_err(|error| error.error)
        };
        write().map(|_| ()).map_err(|error| unwritable(path, &error))
    }
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
        std::fs::create_dir(place.path().join("mine")).unwrap();
        assert_eq!(Records::open(&place.path().join("mine"), &json!(1), true, false).err().unwrap().code(), 2);
    }
}
