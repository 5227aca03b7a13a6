//! Several workers on one folder of records: who computes which item.
//!
//! A worker holds the lock of a file of its own for as long as it lives. It claims an item by making a file that names
//! it. A claim counts while its worker's file is locked: the system lets go of a lock when its program ends, however it
//! ends, so no claim outlives its worker. NFS passes locks on to its server, but some mounts keep them to their
//! machine, and some file systems have none. So a worker of another machine whose file is not locked, or of which
//! nothing is known, counts as alive for as long as it touches its file. For claims times are compared with each other,
//! by one clock, and not with this machine's. Two workers that take over a dead one's claim in the same moment both
//! compute the item: the records that they write are the same.

use super::OutputError;
use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, SystemTime};

/// Folders of claims and of workers.
pub(super) const CLAIMS: &str = "claims";
pub(super) const WORKERS: &str = "workers";
/// Time between two touches of a worker's file.
const TOUCH: Duration = Duration::from_secs(5);
/// Where locks do not tell: a worker that has not touched its file for so long is dead.
const DEAD: Duration = Duration::from_secs(60);

/// A worker of this program. Dropping it lets go of its claims.
pub(super) struct Worker {
    folder: PathBuf,
    name: String,
    file: PathBuf,
    /// Locked where there are locks.
    _held: File,
    /// Dropping it ends the thread that touches the file.
    _alive: Sender<()>,
}

/// What became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claimed {
    /// This worker has the item.
    Ours,
    /// Another one, which is alive, computes it.
    Taken,
}

/// Tells the workers of one process apart.
static COUNT: AtomicU32 = AtomicU32::new(0);

impl Worker {
    /// A new worker of a folder.
    pub fn new(folder: &Path) -> Result<Self, OutputError> {
        let failed = |error: std::io::Error| OutputError::failed(folder, format!("no worker can be entered: {error}"));
        let workers = folder.join(WORKERS);
        std::fs::create_dir_all(&workers).map_err(failed)?;
        std::fs::create_dir_all(folder.join(CLAIMS)).map_err(failed)?;
        let host = host();
        let (file, name, held) = loop {
            let name = format!("{host}-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
            let file = workers.join(&name);
            match File::options().write(true).create_new(true).open(&file) {
                Ok(held) => break (file, name, held),
                // A process of the same number has been here.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(failed(error)),
            }
        };
        // Waits for whoever looks whether it is locked. Without locks the touches tell.
        let _ = held.lock();
        let (alive, ended) = channel::<()>();
        let touched = file.clone();
        let touch = move || {
            while ended.recv_timeout(TOUCH) == Err(RecvTimeoutError::Timeout) {
                let _ = std::fs::write(&touched, "alive\n");
            }
        };
        std::thread::Builder::new().name("worker's touch".into()).spawn(touch).map_err(failed)?;
        let worker = Self { folder: folder.into(), name, file, _held: held, _alive: alive };
        worker.bury();
        Ok(worker)
    }

    /// Claims an item.
    pub fn claim(&self, item: &str) -> Result<Claimed, OutputError> {
        let path = self.folder.join(CLAIMS).join(item);
        let failed = |error: std::io::Error| OutputError::failed(&path, format!("cannot be claimed: {error}"));
        loop {
            match File::options().write(true).create_new(true).open(&path) {
                Ok(mut file) => {
                    file.write_all(self.name.as_bytes()).map_err(failed)?;
                    return Ok(Claimed::Ours);
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(failed(error)),
            }
            match owner_of(&path) {
                Ok(owner) if owner == self.name => return Ok(Claimed::Ours),
                Ok(owner) if self.is_alive(&owner, &path) => return Ok(Claimed::Taken),
                Ok(_) => match std::fs::remove_file(&path) {
                    Ok(()) => {}
                    Err(error) if error.kind() == ErrorKind::NotFound => {}
                    Err(error) => return Err(failed(error)),
                },
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => return Err(failed(error)),
            }
        }
    }

    /// Lets go of an item, if it is this worker's.
    pub fn let_go(&self, item: &str) {
        let path = self.folder.join(CLAIMS).join(item);
        if owner_of(&path).is_ok_and(|owner| owner == self.name) {
            let _ = std::fs::remove_file(path);
        }
    }

    /// Removes the files of workers that are long dead. One that is just coming has not locked its own yet.
    fn bury(&self) {
        for entry in std::fs::read_dir(self.folder.join(WORKERS)).into_iter().flatten().flatten() {
            let file = entry.path();
            if is_locked(&file) == Some(false) && !self.is_recent(&file) {
                let _ = std::fs::remove_file(file);
            }
        }
    }

    /// Whether the worker of a claim is alive. A claim that does not name one yet is as old as its file.
    fn is_alive(&self, owner: &str, claim: &Path) -> bool {
        if owner.is_empty() {
            return self.is_recent(claim);
        }
        let file = self.folder.join(WORKERS).join(owner);
        match is_locked(&file) {
            Some(true) => true,
            Some(false) if host_of(owner) == host_of(&self.name) => false,
            _ => self.is_recent(&file),
        }
    }

    /// Whether a file was touched about as late as this worker's own.
    fn is_recent(&self, file: &Path) -> bool {
        // Now, by the clock of the file system.
        let _ = std::fs::write(&self.file, "alive\n");
        let time = |path: &Path| path.metadata().and_then(|data| data.modified()).ok();
        match (time(file), time(&self.file)) {
            (Some(theirs), Some(ours)) => is_near(theirs, ours),
            _ => false,
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.file);
    }
}

/// Whom a claim names. What is no name of a worker names a dead one.
fn owner_of(claim: &Path) -> std::io::Result<String> {
    std::fs::read(claim).map(|name| String::from_utf8_lossy(&name).into_owned())
}

/// Whether a worker's file is locked; none where there are no locks to tell by.
fn is_locked(file: &Path) -> Option<bool> {
    match File::options().read(true).write(true).open(file) {
        Ok(file) => match file.try_lock() {
            Ok(()) => Some(false),
            Err(TryLockError::WouldBlock) => Some(true),
            Err(TryLockError::Error(_)) => None,
        },
        Err(error) if error.kind() == ErrorKind::NotFound => Some(false),
        Err(_) => None,
    }
}

/// How many workers of a folder are alive.
pub(super) fn alive(folder: &Path) -> usize {
    let (now, ours) = (SystemTime::now(), host());
    let recent = |file: &Path| file.metadata().and_then(|data| data.modified()).is_ok_and(|time| is_near(time, now));
    let lives = |file: &Path, name: &str| match is_locked(file) {
        Some(false) => host_of(name) != Some(&ours) && recent(file),
        Some(true) | None => true,
    };
    let entries = std::fs::read_dir(folder.join(WORKERS)).into_iter().flatten().flatten();
    entries.filter(|entry| lives(&entry.path(), &entry.file_name().to_string_lossy())).count()
}

/// Whether two times are less apart than a living worker's touches.
fn is_near(one: SystemTime, other: SystemTime) -> bool {
    one.duration_since(other).or_else(|_| other.duration_since(one)).is_ok_and(|apart| apart < DEAD)
}

/// The machine in a worker's name.
fn host_of(worker: &str) -> Option<&str> {
    worker.rsplitn(3, '-').nth(2)
}

/// This machine's name, as far as a file name can hold it. Machines of one job may differ at either end: it is not cut,
/// Linux has 64 characters at most.
fn host() -> String {
    let named =
        ["/proc/sys/kernel/hostname", "/etc/hostname"].iter().find_map(|file| std::fs::read_to_string(file).ok());
    let named = named.or_else(|| std::env::var("HOSTNAME").ok());
    let plain = |name: String| -> String {
        name.trim().chars().filter(|c| c.is_ascii_alphanumeric() || *c == '-').take(128).collect()
    };
    named.map(plain).filter(|name| !name.is_empty()).unwrap_or_else(|| "host".into())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Makes a file older than a worker that lives lets its own become.
    fn set_back(file: &Path) {
        let old = SystemTime::now() - 2 * DEAD;
        File::options().write(true).open(file).unwrap().set_modified(old).unwrap();
    }

    #[test]
    fn an_item_has_one_worker_at_a_time() {
        let place = tempfile::tempdir().unwrap();
        let [one, other] = [(); 2].map(|()| Worker::new(place.path()).unwrap());
        assert_eq!(one.claim("7").unwrap(), Claimed::Ours);
        assert_eq!(one.claim("7").unwrap(), Claimed::Ours);
        assert_eq!(other.claim("7").unwrap(), Claimed::Taken);
        assert_eq!(alive(place.path()), 2);
        one.let_go("7");
        assert_eq!(other.claim("7").unwrap(), Claimed::Ours);
        // Whoever ends without letting go is dead.
        drop(other);
        assert_eq!(alive(place.path()), 1);
        assert_eq!(one.claim("7").unwrap(), Claimed::Ours);
    }

    #[test]
    fn nobody_lets_go_of_what_another_has() {
        let place = tempfile::tempdir().unwrap();
        let [one, other] = [(); 2].map(|()| Worker::new(place.path()).unwrap());
        assert_eq!(one.claim("7").unwrap(), Claimed::Ours);
        other.let_go("7");
        assert_eq!(other.claim("7").unwrap(), Claimed::Taken);
    }

    #[test]
    fn files_of_dead_workers_are_removed_and_claims_that_name_nobody_fall() {
        let place = tempfile::tempdir().unwrap();
        let first = Worker::new(place.path()).unwrap();
        let [dead, coming] = ["host-1-0", "host-2-0"].map(|name| place.path().join(WORKERS).join(name));
        for file in [&dead, &coming] {
            std::fs::write(file, "").unwrap();
        }
        set_back(&dead);
        std::fs::write(place.path().join(CLAIMS).join("7"), [0xff, 0xfe]).unwrap();
        let second = Worker::new(place.path()).unwrap();
        assert!(!dead.exists() && coming.exists());
        assert_eq!(second.claim("7").unwrap(), Claimed::Ours);
        assert_eq!(first.claim("7").unwrap(), Claimed::Taken);
    }

    #[test]
    fn a_killed_workers_claim_falls() {
        let place = tempfile::tempdir().unwrap();
        let worker = Worker::new(place.path()).unwrap();
        // What `kill -9` leaves: a file that nobody has locked, and a claim; or a claim that was cut short.
        let dead = format!("{}-1-0", host());
        std::fs::write(place.path().join(WORKERS).join(&dead), "").unwrap();
        std::fs::write(place.path().join(CLAIMS).join("7"), &dead).unwrap();
        assert_eq!(worker.claim("7").unwrap(), Claimed::Ours);
        let cut = place.path().join(CLAIMS).join("8");
        std::fs::write(&cut, "").unwrap();
        assert_eq!(worker.claim("8").unwrap(), Claimed::Taken, "it may just be written");
        set_back(&cut);
        assert_eq!(worker.claim("8").unwrap(), Claimed::Ours);
        // A clock set back makes the future no sign of life.
        std::fs::write(&cut, "").unwrap();
        let ahead = SystemTime::now() + 2 * DEAD;
        File::options().write(true).open(&cut).unwrap().set_modified(ahead).unwrap();
        assert_eq!(worker.claim("8").unwrap(), Claimed::Ours);
    }

    /// Its lock may not have left its machine, so that the file looks as if nobody held it.
    #[test]
    fn a_worker_of_another_machine_lives_while_it_touches_its_file() {
        let place = tempfile::tempdir().unwrap();
        let worker = Worker::new(place.path()).unwrap();
        let theirs = format!("{}-too-1-0", host());
        let file = place.path().join(WORKERS).join(&theirs);
        std::fs::write(&file, "alive\n").unwrap();
        std::fs::write(place.path().join(CLAIMS).join("7"), &theirs).unwrap();
        assert_eq!(worker.claim("7").unwrap(), Claimed::Taken);
        assert_eq!(alive(place.path()), 2);
        set_back(&file);
        assert_eq!(worker.claim("7").unwrap(), Claimed::Ours);
        assert_eq!(alive(place.path()), 1);
        // Who has ended as it should has no file.
        std::fs::write(place.path().join(CLAIMS).join("8"), &theirs).unwrap();
        std::fs::remove_file(&file).unwrap();
        assert_eq!(worker.claim("8").unwrap(), Claimed::Ours);
    }

    #[test]
    fn many_workers_compute_each_item_once() {
        let place = tempfile::tempdir().unwrap();
        let done = |item: usize| place.path().join(format!("{item}.done"));
        let made: usize = std::thread::scope(|scope| {
            let work = || {
                let worker = Worker::new(place.path()).unwrap();
                let one = |item: usize| {
                    let name = item.to_string();
                    let free = !done(item).exists() && worker.claim(&name).unwrap() == Claimed::Ours;
                    // It may have been done between the two.
                    let made = free && !done(item).exists() && File::create_new(done(item)).is_ok();
                    if free {
                        worker.let_go(&name);
                    }
                    usize::from(made)
                };
                (0..50).map(one).sum::<usize>()
            };
            let workers: Vec<_> = (0..4).map(|_| scope.spawn(work)).collect();
            workers.into_iter().map(|worker| worker.join().unwrap()).sum()
        });
        assert_eq!(made, 50);
    }
}
