//! Kinds of a table that are set: keys of the base scene's kind that another kind has not.

use super::KeyPath;
use crate::scene::parse;
use std::path::Path;
use toml_edit::DocumentMut;

/// Keys that say of which kind a table is.
const TAGS: [&str; 2] = ["kind", "law"];

/// Leaves out what a table has from the base scene and its kind has not, where that kind is among the keys that were
/// set: an LED in air has a gap, a bonded one has none.
pub(super) fn leave_strangers_out<'k>(document: &mut DocumentMut, base: &str, keys: impl Iterator<Item = &'k KeyPath>) {
    let of_tag = |place: String| {
        let (table, tag) = place.rsplit_once('.')?;
        TAGS.contains(&tag).then(|| format!("{table}."))
    };
    let tables: Vec<String> = keys.flat_map(|key| key.places(document.as_item())).filter_map(of_tag).collect();
    let Some(base) = base.parse::<DocumentMut>().ok().filter(|_| !tables.is_empty()) else { return };
    let is_stranger = |key: &KeyPath| {
        let name = key.to_string();
        let alone = |table: &String| name.strip_prefix(table.as_str()).is_some_and(|rest| !rest.contains(['.', '[']));
        tables.iter().any(alone) && key.is_in(base.as_item())
    };
    // What is unknown is told of the whole file at once.
    let Err(error) = parse(&document.to_string(), Path::new("")) else { return };
    for one in std::iter::once(&error).chain(&error.others).filter(|one| one.kind == "unknown_key") {
        if let Some(key) = one.key.as_deref().and_then(|key| key.parse().ok()).filter(is_stranger) {
            key.remove(document.as_item_mut());
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::scene::{Mount, preset};
    use crate::vary::with;

    fn set(texts: &[&str]) -> Result<crate::scene::LoadedScene, crate::scene::SceneError> {
        let sets: Vec<_> = texts.iter().map(|text| text.parse().unwrap()).collect();
        with(preset("phantom-size-8mm").unwrap(), std::path::Path::new("s.toml"), &sets)
    }

    #[test]
    fn a_kind_takes_no_keys_of_the_one_before_it() {
        let bonded = set(&["led[*].mount.kind=bonded"]).unwrap();
        assert!(bonded.scene.led.iter().all(|led| led.mount == Mount::Bonded));
        assert!(!bonded.text.contains("gap_mm"), "{}", bonded.text);
        let one = set(&["led[1].mount.kind=bonded"]).unwrap();
        assert_eq!(one.scene.led.iter().filter(|led| led.mount == Mount::Bonded).count(), 1);
        let same = set(&["led[*].mount.kind=air", "led[*].mount.gap_mm=0.25"]).unwrap();
        assert!(same.scene.led.iter().all(|led| led.mount == Mount::Air { gap_mm: 0.25 }));
        let law = set(&["phantom.material.law=linear"]).unwrap();
        assert!(law.text.contains("youngs_kpa"), "what both kinds have stays");
    }

    #[test]
    fn what_is_written_wrongly_is_still_told() {
        for wrong in [&["led[*].mount.kind=bonded", "led[*].mount.gap=1"][..], &["led[*].mount.kind=glued"]] {
            assert!(set(wrong).is_err(), "{wrong:?}");
        }
    }
}
