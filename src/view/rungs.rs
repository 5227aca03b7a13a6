//! How much work each image of a scene takes that somebody looks at.

use crate::trace::{REPLICATES, Settings};

/// Photons of the first image: they take less time than its camera paths.
const FIRST_PHOTONS: u64 = 1 << 15;
/// More camera paths, and more photons, from one image to the next: the last takes longer than all before it together.
const MORE_PATHS: u32 = 4;
const MORE_PHOTONS: u64 = 8;

/// The work of one image.
#[derive(Debug, Clone)]
pub(super) struct Rung {
    pub settings: Settings,
    /// On a press of a coarse mesh.
    pub sketch: bool,
}

/// Images from the quickest to the one that is asked for. The first is of a coarse mesh where the scene `presses`.
pub(super) fn rungs(asked: &Settings, presses: bool) -> Vec<Rung> {
    let mut rungs = Vec::new();
    let (mut spp, mut photons) = (REPLICATES, FIRST_PHOTONS);
    let at = |spp: u32, photons: u64| {
        let photons = Some(asked.photons.map_or(photons, |most| most.min(photons)));
        Settings { spp, photons, ..asked.clone() }
    };
    if presses {
        rungs.push(Rung { settings: at(spp, photons), sketch: true });
    }
    while spp < asked.spp {
        rungs.push(Rung { settings: at(spp, photons), sketch: false });
        (spp, photons) = (spp.saturating_mul(MORE_PATHS), photons.saturating_mul(MORE_PHOTONS));
    }
    rungs.push(Rung { settings: asked.clone(), sketch: false });
    rungs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Render;

    #[test]
    fn the_last_image_is_the_one_that_is_asked_for_and_none_takes_more() {
        for (spp, photons) in [(1, None), (16, Some(1000)), (64, None), (1000, Some(1 << 20)), (u32::MAX, None)] {
            let asked = Settings::of(&Render { spp, photons, ..Render::default() });
            for presses in [false, true] {
                let rungs = rungs(&asked, presses);
                let Some((last, before)) = rungs.split_last() else { panic!("no image") };
                assert_eq!((last.settings.spp, last.settings.photons, last.sketch), (spp, photons, false));
                assert!(before.iter().all(|rung| rung.settings.spp <= spp.max(REPLICATES)));
                assert!(before.iter().all(|rung| rung.settings.photons <= photons.or(Some(u64::MAX))));
                assert_eq!(rungs.first().is_some_and(|rung| rung.sketch), presses);
            }
        }
    }
}
