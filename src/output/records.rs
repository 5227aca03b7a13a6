//! A folder that keeps one record for each item, each written whole or not at all, so that a stopped run can go on.

use super::leftovers::leftovers;
use super::order::{ITEMS, ORDER, PARTIAL, await_order, damaged, difference, is_bare, strange};
use super::whole::{passing_file, unwritable, write_by};
use super::worker::{self, Worker};
use super::{Claim, Claimed, OutputError, Remedy};
use crate::film::{Film, RADIANCE_UNIT};
use crate::image_io::{ImageError, Provenance, read_radiance, write_radiance};
use crate::scene::sha256;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The file whose lock says who writes the tables.
const TURN: &str = "tables.json";
/// What stands before the SHA-256 of a record, and before the record.
const SEAL: &str = "\"sha256\":\"";
const RECORD: &str = "\",\"record\":";

/// The folder.
pub struct Records {
    folder: PathBuf,
    hold: Hold,
}

/// Who else may write it.
enum Hold {
    /// Nobody.
    Alone(#[allow(dead_code)] Claim),
    /// Other workers, each of which claims what it computes.
    Shared(Worker),
    /// It is only read.
    Read,
}

/// What is kept of an item.
#[derive(Debug, Clone, PartialEq)]
pub enum Item<T> {
    /// It.
    There(T),
    /// Nothing.
    Missing,
    /// Something that cannot be read: it is as good as missing.
    Damaged,
}

impl Records {
    /// Opens a folder for an order of a scene.
    ///
    /// # Errors
    /// When another run writes it, it exists and is neither to be replaced nor gone on with, holds another order or
    /// anything that was not written here, or cannot be written.
    pub fn open(folder: &Path, order: &Value, force: bool, resume: bool) -> Result<Self, OutputError> {
        let refused = |why: &str, remedy| Err(OutputError::refused(folder, why, remedy));
        let records = Self { folder: folder.into(), hold: Hold::Alone(Claim::take(folder)?) };
        let old: Option<Value> = records.read_json(ORDER);
        match (folder.symlink_metadata().is_ok(), old) {
            (false, _) if resume => return refused("is not there to go on with", Remedy::Mend),
            (false, _) => {}
            (true, Some(old)) if resume => {
                if old != *order {
                    let why = format!("holds the records of another scene or order: {}", difference(&old, order));
                    return refused(&why, Remedy::Elsewhere);
                }
            }
            (true, old) if force && (old.is_some() || records.is_damaged()) => {
                if let Some(strange) = strange(folder) {
                    let why = format!("holds {}, which tirtouch did not write; it is not replaced", strange.display());
                    return refused(&why, Remedy::Elsewhere);
                }
                std::fs::remove_dir_all(folder)
                    .map_err(|error| OutputError::failed(folder, format!("cannot be replaced: {error}")))?;
            }
            (true, Some(_)) => return refused("exists", Remedy::GoOn),
            (true, None) if records.is_damaged() => return Err(damaged(folder, Remedy::Replace)),
            // A run that was killed before it came to its order.
            (true, None) if is_bare(folder) => {}
            (true, None) => return refused("exists and holds no records", Remedy::Elsewhere),
        }
        std::fs::create_dir_all(folder.join(ITEMS)).map_err(|error| {
            OutputError::refused(folder, format!("no folder can be made there: {error}"), Remedy::Mend)
        })?;
        leftovers().keep(format!("what was done is in {}", folder.display()));
        records.keep(ORDER, order)?;
        Ok(records)
    }

    /// Enters a folder as one worker of several. One that is not there yet is made; one that is there is entered where
    /// `resume` asks for it, or replaced by `force` where no other worker is in it.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn join(folder: &Path, order: &Value, force: bool, resume: bool) -> Result<Self, OutputError> {
        if !(resume && folder.join(ITEMS).join(ORDER).is_file()) {
            if force && worker::alive(folder) > 0 {
                return Err(OutputError::refused(folder, "other workers are in it", Remedy::Elsewhere));
            }
            // Alone while it is made; of several workers that come at once, one makes it.
            match Self::open(folder, order, force, false) {
                Ok(made) => drop(made),
                Err(error) if resume => await_order(folder).ok_or(error)?,
                Err(error) => return Err(error),
            }
        }
        let shared = Self { folder: folder.into(), hold: Hold::Shared(Worker::new(folder)?) };
        let old: Value = shared.read_json(ORDER).ok_or_else(|| damaged(folder, Remedy::Replace))?;
        if old != *order {
            let why = format!("holds the records of another order: {}", difference(&old, order));
            return Err(OutputError::refused(folder, why, Remedy::Elsewhere));
        }
        leftovers().keep(format!("what was done is in {}", folder.display()));
        Ok(shared)
    }

    /// The records of a folder, to be read, and their order.
    ///
    /// # Errors
    /// When the folder holds none.
    pub fn read(folder: &Path) -> Result<(Self, Value), OutputError> {
        let records = Self { folder: folder.into(), hold: Hold::Read };
        match records.read_json(ORDER) {
            Some(order) => Ok((records, order)),
            None if records.is_damaged() => Err(damaged(folder, Remedy::Mend)),
            None => Err(OutputError::refused(folder, "holds no records", Remedy::Mend)),
        }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Other workers that are in it.
    pub fn workers(&self) -> usize {
        worker::alive(&self.folder).saturating_sub(usize::from(matches!(self.hold, Hold::Shared(_))))
    }

    /// Claims an item for this worker; alone, all are its own.
    ///
    /// # Errors
    /// When no claim can be written.
    pub fn claim(&self, name: &str) -> Result<Claimed, OutputError> {
        match &self.hold {
            Hold::Shared(worker) => worker.claim(name),
            Hold::Alone(_) | Hold::Read => Ok(Claimed::Ours),
        }
    }

    /// Lets go of an item that was claimed.
    pub fn let_go(&self, name: &str) {
        if let Hold::Shared(worker) = &self.hold {
            worker.let_go(name);
        }
    }

    /// What is kept of an item.
    pub fn item<T: DeserializeOwned>(&self, name: &str) -> Item<T> {
        let name = format!("{name}.json");
        match std::fs::read(self.place(&name)) {
            Ok(bytes) => unsealed(&name, &bytes).map_or(Item::Damaged, Item::There),
            Err(_) => Item::Missing,
        }
    }

    /// Keeps an item.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn keep_item<T: Serialize>(&self, name: &str, value: &T) -> Result<(), OutputError> {
        self.keep(&format!("{name}.json"), value)
    }

    /// Takes back what is kept of an item, if it is there.
    ///
    /// # Errors
    /// When it cannot be removed.
    pub fn forget_item(&self, name: &str) -> Result<(), OutputError> {
        let path = self.place(&format!("{name}.json"));
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(unwritable(&path, &error)),
            _ => Ok(()),
        }
    }

    /// Whether the order is there but cannot be read.
    fn is_damaged(&self) -> bool {
        self.place(ORDER).is_file() && self.read_json::<Value>(ORDER).is_none()
    }

    fn place(&self, name: &str) -> PathBuf {
        self.folder.join(ITEMS).join(name)
    }

    fn read_json<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        unsealed(name, &std::fs::read(self.place(name)).ok()?)
    }

    fn keep<T: Serialize>(&self, name: &str, value: &T) -> Result<(), OutputError> {
        let text =
            serde_json::to_string(value).map_err(|error| OutputError::failed(&self.place(name), error.to_string()))?;
        self.write_at(&self.place(name), sealed(name, &text).as_bytes())
    }

    /// The item `name`: as it was kept, or made now and kept.
    ///
    /// # Errors
    /// That of making it, or when it cannot be written.
    pub fn item_or<T: Serialize + DeserializeOwned, E: From<OutputError>>(
        &self,
        name: &str,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let name = format!("{name}.json");
        if let Some(kept) = self.read_json(&name) {
            return Ok(kept);
        }
        let made = make()?;
        self.keep(&name, &made)?;
        Ok(made)
    }

    /// A film, kept as an EXR.
    ///
    /// # Errors
    /// That of making it, or when it cannot be written.
    pub fn film_or<E: From<OutputError>>(&self, name: &str, make: impl FnOnce() -> Result<Film, E>) -> Result<Film, E> {
        let path = self.place(&format!("{name}.exr"));
        if let Ok((film, _)) = read_radiance(&path) {
            return Ok(film);
        }
        let film = make()?;
        let partial = path.with_extension(PARTIAL);
        let provenance =
            Provenance { unit: RADIANCE_UNIT.into(), replicates: film.replicates, ..Provenance::default() };
        let _whole = leftovers();
        write_radiance(&partial, &film, &provenance).map_err(|error| OutputError::of_image(error, &path))?;
        std::fs::rename(&partial, &path).map_err(|error| unwritable(&path, &error))?;
        Ok(film)
    }

    /// Writes a file of the folder, whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, name: &str, text: &str) -> Result<(), OutputError> {
        self.write_bytes(name, text.as_bytes())
    }

    /// The same of bytes; `name` may lie in a folder of this one, which is made.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write_bytes(&self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        let path = self.folder.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(|error| unwritable(parent, &error))?;
        }
        self.write_at(&path, bytes)
    }

    /// The same, written by `write` to a place that it is given.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write_with(
        &self,
        name: &str,
        write: impl FnOnce(&Path) -> Result<(), ImageError>,
    ) -> Result<(), OutputError> {
        let path = self.folder.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(|error| unwritable(parent, &error))?;
        }
        let _whole = leftovers();
        let made = passing_file(&self.folder).map_err(|error| unwritable(&path, &error))?;
        write(made.path()).map_err(|error| OutputError::of_image(error, &path))?;
        // It may have put another file in this one's place.
        std::fs::File::open(made.path()).and_then(|file| file.sync_all()).map_err(|error| unwritable(&path, &error))?;
        made.persist(&path).map(|_| ()).map_err(|error| unwritable(&path, &error.error))
    }

    /// Whether a file of the folder is there.
    pub fn has(&self, name: &str) -> bool {
        self.folder.join(name).is_file()
    }

    /// Does what reads the records and writes files of them, while no other worker does the same: what is read last is
    /// written last. Where a file system has no locks, all do it at once.
    ///
    /// # Errors
    /// Those of the work.
    pub fn in_turn<T>(&self, work: impl FnOnce() -> T) -> T {
        let turn = std::fs::File::options().create(true).append(true).open(self.place(TURN)).ok();
        let _held = turn.as_ref().map(std::fs::File::lock);
        work()
    }

    fn write_at(&self, path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
        write_by(&self.folder, path, bytes)
    }
}

/// A record with the SHA-256 of its name and its text: a bit that flipped in a figure, or another item's record, is
/// still good JSON.
fn sealed(name: &str, text: &str) -> String {
    format!("{{{SEAL}{}{RECORD}{text}}}\n", sha256(format!("{name}\n{text}").as_bytes()))
}

/// What such a text holds; none where it is not as it was written.
fn unsealed<T: DeserializeOwned>(name: &str, bytes: &[u8]) -> Option<T> {
    let text = std::str::from_utf8(bytes).ok()?.strip_prefix('{')?.strip_prefix(SEAL)?.strip_suffix("}\n")?;
    let (seal, text) = text.split_once(RECORD)?;
    (seal == sha256(format!("{name}\n{text}").as_bytes())).then(|| serde_json::from_str(text).ok())?
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use serde_json::json;

    fn is_refused(opened: &Result<Records, OutputError>) -> bool {
        matches!(opened, Err(OutputError::Refused { .. }))
    }

    #[test]
    fn items_are_made_once_and_kept() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("ladders");
        let order = json!({"seed": 1});
        let records = Records::open(&folder, &order, false, false).unwrap();
        assert_eq!(records.item_or("a", || Ok::<_, OutputError>(7)).unwrap(), 7);
        let kept: Result<i32, _> = records.item_or("a", || Err(OutputError::Stopped));
        assert_eq!(kept.unwrap(), 7, "it is not made twice");
        assert!(records.item_or::<u32, _>("b", || Err(OutputError::Stopped)).is_err());
        drop(records);
        let again = Records::open(&folder, &order, false, true).unwrap();
        assert_eq!(again.item_or("a", || Ok::<_, OutputError>(8)).unwrap(), 7);
        assert_eq!(again.item_or("b", || Ok::<_, OutputError>(9)).unwrap(), 9);
    }

    #[test]
    fn what_is_not_as_it_was_written_is_damaged() {
        let place = tempfile::tempdir().unwrap();
        let records = Records::open(&place.path().join("kept"), &json!(1), false, false).unwrap();
        let value = json!({"figure": 0.1234, "reason": "\",\"record\":"});
        records.keep_item("a", &value).unwrap();
        records.keep_item("b", &json!({"figure": 2})).unwrap();
        assert_eq!(records.item("a"), Item::There(value));
        let path = |name: &str| records.place(&format!("{name}.json"));
        let body = std::fs::read(path("a")).unwrap();
        for at in 0..body.len() {
            let mut other = body.clone();
            other[at] ^= 1;
            std::fs::write(path("a"), other).unwrap();
            assert_eq!(records.item::<Value>("a"), Item::Damaged, "{at}");
            std::fs::write(path("a"), &body[..at]).unwrap();
            assert_eq!(records.item::<Value>("a"), Item::Damaged, "cut at {at}");
        }
        std::fs::copy(path("b"), path("a")).unwrap();
        assert_eq!(records.item::<Value>("a"), Item::Damaged, "another item's");
        assert_eq!(records.item::<Value>("c"), Item::Missing);
    }

    #[test]
    fn another_order_an_existing_folder_and_a_strange_one_are_refused() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("ladders");
        assert!(is_refused(&Records::open(&folder, &json!(1), false, true)));
        Records::open(&folder, &json!(1), false, false).unwrap();
        assert!(is_refused(&Records::open(&folder, &json!(1), false, false)));
        assert!(is_refused(&Records::open(&folder, &json!(2), false, true)));
        Records::open(&folder, &json!(2), true, false).unwrap();
        for (strange, said) in [
            ("notes.txt", "notes.txt"),
            ("items/notes.txt", "items/notes.txt"),
            ("job-notes.txt", "job-notes.txt"),
            ("converge-mine.csv", "converge-mine.csv"),
            (".tmp-notes", ".tmp-notes"),
            ("train/0000001.note", "0000001.note"),
            ("claims/mine/thesis.tex", "claims/mine"),
        ] {
            let strange = folder.join(strange);
            std::fs::create_dir_all(strange.parent().unwrap()).unwrap();
            std::fs::write(&strange, "mine").unwrap();
            let refused = Records::open(&folder, &json!(2), true, false);
            assert!(is_refused(&refused) && refused.err().unwrap().to_string().contains(said), "{said}");
            std::fs::remove_file(strange).unwrap();
        }
        std::fs::remove_dir(folder.join("claims/mine")).unwrap();
        ["job-12.log", ".tmpAb12Cd", "converge_camera paths.svg", "train/0000001.png"].iter().for_each(|ours| {
            std::fs::write(folder.join(ours), "ours").unwrap();
        });
        let records = Records::open(&folder, &json!(2), true, false).unwrap();
        let second = Records::open(&folder, &json!(2), false, true);
        assert!(is_refused(&second) && second.err().unwrap().to_string().contains("another run"));
        drop(records);
        // Of records whose order is damaged nobody knows what they are of.
        std::fs::write(folder.join(ITEMS).join(ORDER), "{").unwrap();
        for found in [Records::open(&folder, &json!(2), false, true), Records::join(&folder, &json!(2), false, true)] {
            assert!(is_refused(&found) && found.err().unwrap().to_string().contains("is damaged"));
        }
        assert!(Records::read(&folder).err().unwrap().to_string().contains("is damaged"));
        Records::open(&folder, &json!(2), true, false).unwrap();
        std::fs::create_dir(place.path().join("mine")).unwrap();
        assert!(is_refused(&Records::open(&place.path().join("mine"), &json!(1), true, false)));
        // What a run leaves that was killed before its order was there.
        std::fs::create_dir(place.path().join("mine/items")).unwrap();
        std::fs::write(place.path().join("mine/.tmpx"), "").unwrap();
        Records::open(&place.path().join("mine"), &json!(1), false, false).unwrap();
    }

    #[test]
    fn tables_are_written_one_after_the_other() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("shared");
        let (inside, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    let records = Records::join(&folder, &json!(1), false, true).unwrap();
                    for _ in 0..5 {
                        records.in_turn(|| {
                            most.fetch_max(1 + inside.fetch_add(1, Ordering::SeqCst), Ordering::SeqCst);
                            std::thread::yield_now();
                            inside.fetch_sub(1, Ordering::SeqCst);
                        });
                    }
                });
            }
        });
        assert_eq!(most.load(Ordering::SeqCst), 1);
    }

    #[test]
    fn workers_that_come_at_once_share_a_new_folder() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("shared");
        let made: Vec<usize> = std::thread::scope(|scope| {
            let work = || {
                let records = Records::join(&folder, &json!(1), false, true).unwrap();
                let one = |item: usize| {
                    let name = item.to_string();
                    let free = records.item::<usize>(&name) == Item::Missing;
                    let ours = free && records.claim(&name).unwrap() == Claimed::Ours;
                    if ours && records.item::<usize>(&name) == Item::Missing {
                        records.keep_item(&name, &item).unwrap();
                    }
                    records.let_go(&name);
                    records.item::<usize>(&name)
                };
                (0..20).filter(|&item| one(item) == Item::There(item)).count()
            };
            let workers: Vec<_> = (0..4).map(|_| scope.spawn(work)).collect();
            workers.into_iter().map(|worker| worker.join().unwrap()).collect()
        });
        assert!(made.iter().all(|&made| made > 0), "{made:?}");
        assert!(is_refused(&Records::join(&folder, &json!(2), false, true)));
        let (records, order) = Records::read(&folder).unwrap();
        assert_eq!((order, records.workers()), (json!(1), 0));
        assert!((0..20).all(|item| records.item::<usize>(&item.to_string()) == Item::There(item)));
    }
}
