//! For tests: presets with one change that makes them wrong, and the error that must follow.
#![allow(clippy::unwrap_used)]

use super::error::SceneError;
use super::load::{parse, parse_scan};
use super::locate::line_at;
use super::presets::{PRESETS, SCAN_PRESETS};
use std::path::Path;

pub(super) fn text_of(name: &str) -> &'static str {
    PRESETS.iter().chain(SCAN_PRESETS).find(|(known, _)| *known == name).unwrap().1
}

/// One change to a preset that makes it wrong. The line that the error must name is marked `#!` in the change.
pub(super) struct Bad {
    preset: &'static str,
    from: &'static str,
    to: &'static str,
    kind: &'static str,
    key: &'static str,
    says: &'static str,
}

pub(super) fn bad(
    preset: &'static str,
    from: &'static str,
    to: &'static str,
    kind: &'static str,
    key: &'static str,
    says: &'static str,
) -> Bad {
    Bad { preset, from, to, kind, key, says }
}

pub(super) fn check(case: &Bad) {
    check_read_by(case, |text| parse(text, Path::new("scene.toml")).unwrap_err());
}

/// As [`check`], for scan scenes.
pub(super) fn check_scan(case: &Bad) {
    check_read_by(case, |text| parse_scan(text, Path::new("scene.toml")).unwrap_err());
}

fn check_read_by(case: &Bad, read: fn(&str) -> SceneError) {
    let original = text_of(case.preset);
    assert!(original.contains(case.from), "{} has no {:?}", case.preset, case.from);
    let text = original.replacen(case.from, case.to, 1);
    let marked = text.find("#!").map(|at| line_at(&text, at));
    let error = read(&text);
    let seen = (error.kind, error.key.as_deref(), error.line);
    assert_eq!(seen, (case.kind, Some(case.key), marked.or(Some(1))), "{:?} gives {error}", case.to);
    assert!(error.message.contains(case.says), "{:?} gives {error}", case.to);
    assert_eq!(error.to_string().lines().count(), 1, "{error}");
    // One mistake is one, not a train of what follows from it.
    assert!(error.others.is_empty(), "{:?} gives {error}, and {}", case.to, error.others[0]);
}

/// Rules of ranges and of parts that fit together, all of kind `invalid_value`.
pub(super) fn rule(
    preset: &'static str,
    from: &'static str,
    to: &'static str,
    key: &'static str,
    says: &'static str,
) -> Bad {
    bad(preset, from, to, "invalid_value", key, says)
}
