//! What lies between the page and the painter: the scene that is wished for, and what there is to see.

use super::look::Look;
use crate::scene::{Invalid, LoadedScene, SceneError, at_its_place};
use crate::vary::{self, Set};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;

/// A scene that is wished for.
#[derive(Clone)]
pub(super) struct Wish {
    /// Counted from 1.
    pub number: u64,
    /// The numbers that are other than the file's.
    pub values: BTreeMap<String, f64>,
    pub loaded: Arc<LoadedScene>,
}

/// Where the painter stands.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Seen {
    /// Counts what the page has not seen yet.
    pub revision: u64,
    /// The wish that this is about.
    pub wish: u64,
    /// Whether there is more to come.
    pub busy: bool,
    /// What is being done, and the share of it that is, 0 to 1.
    pub what: String,
    /// That share.
    pub done: f64,
    /// The image that is being made, from 1, and how many there will be.
    pub step: usize,
    /// How many.
    pub steps: usize,
    /// Why there is no image of the wish.
    pub error: Option<String>,
    /// What all frames of the latest image's scene say of the inclusion, as `run --json` does.
    pub estimates: Option<Value>,
    /// The latest image.
    #[serde(skip)]
    pub look: Option<Arc<Look>>,
}

/// The wish, and what there is to see.
pub struct Desk {
    base: LoadedScene,
    file: PathBuf,
    wish: Mutex<Wish>,
    wished: Condvar,
    /// Number of the latest wish, for the painter to look at between two pieces of its work.
    latest: AtomicU64,
    ends: AtomicBool,
    seen: watch::Sender<Seen>,
}

impl Desk {
    /// A desk for a scene; `file` is where it came from.
    pub fn new(base: LoadedScene, file: PathBuf) -> Self {
        let wish = Wish { number: 1, values: BTreeMap::new(), loaded: Arc::new(base.clone()) };
        let seen = Seen { busy: true, ..Seen::default() };
        Self {
            base,
            file,
            wish: Mutex::new(wish),
            wished: Condvar::new(),
            latest: AtomicU64::new(1),
            ends: AtomicBool::new(false),
            seen: watch::Sender::new(seen),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Wish> {
        self.wish.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The scene as it was opened.
    pub fn base(&self) -> &LoadedScene {
        &self.base
    }

    /// Wishes for the scene with keys set to numbers; gives the number of the wish.
    ///
    /// # Errors
    /// A key that is none, a scene that breaks a rule: the wish before it stands.
    pub fn wish(&self, values: &BTreeMap<String, f64>) -> Result<u64, SceneError> {
        let set = |(key, value): (&String, &f64)| {
            let wrong = |why: String| at_its_place(&self.base.text, &self.file, &Invalid::new(key.as_str(), why));
            Ok(Set { key: key.parse().map_err(wrong)?, value: (*value).into() })
        };
        let sets = values.iter().map(set).collect::<Result<Vec<_>, SceneError>>()?;
        let loaded = vary::with(self.base.clone(), &self.file, &sets)?;
        let mut wish = self.lock();
        *wish = Wish { number: wish.number + 1, values: values.clone(), loaded: Arc::new(loaded) };
        self.latest.store(wish.number, Ordering::Relaxed);
        self.wished.notify_all();
        Ok(wish.number)
    }

    /// Number of the latest wish, and its numbers that are other than the file's.
    pub(super) fn latest(&self) -> (u64, BTreeMap<String, f64>) {
        let wish = self.lock();
        (wish.number, wish.values.clone())
    }

    /// The text of the scene that is wished for.
    pub fn text(&self) -> String {
        self.lock().loaded.text.clone()
    }

    /// Waits for a wish after number `before`; `None` at the end.
    pub(super) fn next(&self, before: u64) -> Option<Wish> {
        let mut wish = self.lock();
        while wish.number <= before && !self.ends.load(Ordering::Relaxed) {
            wish = self.wished.wait(wish).unwrap_or_else(PoisonError::into_inner);
        }
        (!self.ends.load(Ordering::Relaxed)).then(|| wish.clone())
    }

    /// Whether a wish still is the latest, and the desk in use.
    pub(super) fn is_latest(&self, number: u64) -> bool {
        self.latest.load(Ordering::Relaxed) == number && !self.ends.load(Ordering::Relaxed)
    }

    /// Ends the painter's work at its next pause.
    pub fn end(&self) {
        let _wish = self.lock();
        self.ends.store(true, Ordering::Relaxed);
        self.wished.notify_all();
    }

    /// Shows something.
    pub(super) fn show(&self, change: impl FnOnce(&mut Seen)) {
        self.seen.send_modify(|seen| {
            change(seen);
            seen.revision += 1;
        });
    }

    /// What there is to see, now and later.
    pub fn seen(&self) -> watch::Receiver<Seen> {
        self.seen.subscribe()
    }
}
