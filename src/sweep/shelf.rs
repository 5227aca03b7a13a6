//! Presses that several points share, kept beside the records for all workers of a sweep.

use crate::mechanics::press::Findings;
use crate::output::{Claimed, Item, Records};
use crate::pipeline::Shelf;
use crate::progress::{Observer, Stage};
use std::collections::HashSet;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Between two looks at a press that another one makes.
const LOOK: Duration = Duration::from_millis(100);

/// The shelf of a folder.
pub(super) struct Presses<'a> {
    records: &'a Records,
    /// What threads of this worker are making: its claims are one worker's.
    making: Mutex<HashSet<String>>,
}

impl<'a> Presses<'a> {
    pub fn of(records: &'a Records) -> Self {
        Self { records, making: Mutex::default() }
    }

    fn making(&self) -> MutexGuard<'_, HashSet<String>> {
        self.making.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn kept(&self, name: &str) -> Option<Findings> {
        match self.records.item(name) {
            Item::There(findings) => Some(findings),
            Item::Missing | Item::Damaged => None,
        }
    }
}

impl Shelf for Presses<'_> {
    fn find(&self, name: &str, observe: &mut Observer) -> Option<Findings> {
        loop {
            if let Some(findings) = self.kept(name) {
                return Some(findings);
            }
            if self.making().insert(name.to_owned()) {
                match self.records.claim(name) {
                    Ok(Claimed::Ours) => {
                        // Whoever had it may have kept it in between.
                        let kept = self.kept(name);
                        if kept.is_some() {
                            self.keep(name, None);
                        }
                        return kept;
                    }
                    Ok(Claimed::Taken) => {
                        self.making().remove(name);
                    }
                    // Where nothing can be claimed the record of the point will say so.
                    Err(_) => return None,
                }
            }
            std::thread::sleep(LOOK);
            if !observe(Stage { done: 0.0, what: "pressing" }) {
                return None;
            }
        }
    }

    fn keep(&self, name: &str, findings: Option<&Findings>) {
        if !self.making().contains(name) {
            return;
        }
        // A press that cannot be kept is made again.
        let _ = findings.map(|findings| self.records.keep_item(name, findings));
        self.records.let_go(name);
        // Last: until then other threads of this worker, whose claim this is too, wait.
        self.making().remove(name);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mechanics::from_scene::press_setup;
    use crate::mechanics::press::{PressSettings, press};
    use serde_json::json;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn found() -> Findings {
        let mut loaded = crate::scene::preset("phantom-size-8mm").unwrap();
        let asked = loaded.scene.press.as_mut().unwrap();
        (asked.depths_mm, asked.resolution) = (Some(vec![0.2]), 0.5);
        press(&press_setup(&loaded).unwrap(), PressSettings::default(), &mut |_| true).unwrap().findings()
    }

    #[test]
    fn of_many_workers_one_makes_a_press_and_the_others_wait_for_it() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("records");
        let workers: Vec<Records> =
            (0..3).map(|_| Records::join(&folder, &json!({ "of": "a test" }), false, true).unwrap()).collect();
        let found = found();
        let whole = serde_json::to_string(&found).unwrap();
        let made = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for records in &workers {
                let presses = Presses::of(records);
                let (found, whole, made) = (&found, &whole, &made);
                scope.spawn(move || {
                    std::thread::scope(|threads| {
                        for _ in 0..2 {
                            threads.spawn(|| match presses.find("press-a", &mut |_| true) {
                                Some(kept) => assert_eq!(serde_json::to_string(&kept).unwrap(), *whole),
                                None => {
                                    made.fetch_add(1, Ordering::Relaxed);
                                    std::thread::sleep(3 * LOOK);
                                    presses.keep("press-a", Some(found));
                                }
                            });
                        }
                    });
                });
            }
        });
        assert_eq!(made.load(Ordering::Relaxed), 1);
    }

    #[test]
    fn a_press_that_was_not_made_or_is_damaged_is_the_next_one_s_to_make() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("records");
        let join = || Records::join(&folder, &json!({ "of": "a test" }), false, true).unwrap();
        let (one, other) = (join(), join());
        let (one, other) = (Presses::of(&one), Presses::of(&other));
        assert!(one.find("press-b", &mut |_| true).is_none(), "one's to make");
        // While one makes it the other waits, for as long as its caller lets it; and has nothing to let go of.
        assert!(other.find("press-b", &mut |_| false).is_none());
        other.keep("press-b", None);
        assert_eq!(one.records.claim("press-b").unwrap(), Claimed::Ours);
        assert_eq!(other.records.claim("press-b").unwrap(), Claimed::Taken);
        one.keep("press-b", None);
        assert!(other.find("press-b", &mut |_| panic!("nobody else makes it")).is_none());
        other.keep("press-b", Some(&found()));
        assert!(one.find("press-b", &mut |_| true).is_some());
        let file = folder.join("items/press-b.json");
        let text = std::fs::read_to_string(&file).unwrap().replacen("0.2", "0.3", 1);
        std::fs::write(&file, text).unwrap();
        assert!(one.find("press-b", &mut |_| true).is_none());
    }
}
