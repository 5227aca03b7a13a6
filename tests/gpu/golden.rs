//! Fresh GPU renders against stored images, made by the twin in f64 with camera paths alone.
//!
//! `golden/NAME/scene.toml` is the scene, `radiance.exr` its image, `README.md` says how it was made. Contact scenes
//! are rendered by `splat`, or by smoothed maps where they are deformed, so that their light is found in another way
//! than it was for the stored image. With `TIRTOUCH_REGENERATE_GOLDEN=1`, or a name in place of 1, the images and their
//! READMEs are written anew, and the test fails saying so.

use crate::adapter::require_gpu;
use crate::films::{failed, film, gpu};
use crate::scenes::{at_once, model};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tirtouch::film::{Comparison, Film, compare};
use tirtouch::image_io::{Provenance, read_radiance, write_radiance};
use tirtouch::scene::{IntegratorChoice, LoadedScene, Scene, load};
use tirtouch::trace::backend::CpuTracer;
use tirtouch::trace::batch::Work;
use tirtouch::trace::gpu::{Gpu, GpuTracer};
use tirtouch::trace::plan::Integrator;
use tirtouch::trace::render::REPLICATES;
use tirtouch::trace::{Backend, Kernel, Model, Plan};

const REGENERATE: &str = "TIRTOUCH_REGENERATE_GOLDEN";
/// Chance of a false alarm over all stored images together.
const LEVEL: f64 = 1e-3;
/// Seeds of the stored images and of the fresh ones.
const SEEDS: [u32; 2] = [1, 2];

/// A stored image.
struct Golden {
    name: &'static str,
    /// What it shows, for its README.
    shows: &'static str,
    /// Camera paths per pixel of the stored image.
    spp: u32,
    /// Camera paths per pixel, and photons where the integrator sends them, of the fresh image.
    fresh: Work,
}

/// Stored: half a minute of one core or less, a minute for `literature-press`. Fresh: a second or two.
const GOLDENS: &[Golden] = &[
    Golden {
        name: "dark-flat",
        shows: "The flat stack of the paper: all light is trapped.",
        spp: 1024,
        fresh: work(64, 0),
    },
    Golden {
        name: "literature",
        shows: "The flat stack with the indices of the literature: all light is trapped.",
        spp: 1024,
        fresh: work(64, 0),
    },
    Golden {
        name: "literature-press",
        shows: "Tissue pressed on the stack with the indices of the literature: a soft blob on a dim background.",
        spp: 16384,
        fresh: work(64, 1 << 20),
    },
    Golden {
        name: "dent",
        shows: "Glints of the LEDs in a spherical dent, bright where its flank reflects totally.",
        spp: 8192,
        fresh: work(1024, 0),
    },
    Golden {
        name: "contact",
        shows: "A disc of matched Lambertian tissue in full contact.",
        spp: 8192,
        fresh: work(16, 1 << 21),
    },
    Golden {
        name: "rough",
        shows: "The haze of a touched face that is rough by 100 nm.",
        spp: 8192,
        fresh: work(1024, 0),
    },
    Golden {
        name: "pressed",
        shows: "A phantom with an inclusion pressed on the paper's stack: light that tissue sends back through bent layers.",
        spp: 8192,
        fresh: work(64, 1 << 20),
    },
    Golden {
        name: "absorbing",
        shows: "A disc of tissue seen through, and lit through, layers that absorb 0.003 to 0.03 per mm.",
        spp: 8192,
        fresh: work(16, 1 << 20),
    },
];

/// Work of one replicate of a film of that many camera paths per pixel and photons.
const fn work(spp: u32, photons: u64) -> Work {
    Work { spp: spp.div_ceil(REPLICATES), photons: photons.div_ceil(REPLICATES as u64) }
}

impl Golden {
    fn named(name: &str) -> &'static Self {
        GOLDENS.iter().find(|golden| golden.name == name).unwrap()
    }

    fn file(&self, name: &str) -> PathBuf {
        [env!("CARGO_MANIFEST_DIR"), "golden", self.name, name].iter().collect()
    }

    fn scene(&self) -> LoadedScene {
        load(&self.file("scene.toml")).unwrap()
    }

    fn stored(&self) -> Film {
        read_radiance(&self.file("radiance.exr")).unwrap().0
    }

    /// A fresh image of a scene, which is this one's unless a fault was planted in it.
    fn fresh(&self, loaded: &LoadedScene, open: impl FnOnce(&Model<f64>) -> Backend) -> Film {
        let model = model(loaded);
        let kernel = Kernel::of(&model);
        let plan = [IntegratorChoice::Splat, IntegratorChoice::Map, IntegratorChoice::Path]
            .map(|asked| Plan::choose(asked, &kernel));
        let integrator = plan.into_iter().flatten().next().unwrap().integrator;
        film(open(&model), &model, integrator, SEEDS[1], self.fresh)
    }

    fn regenerate(&self) {
        let loaded = self.scene();
        let model = model(&loaded);
        let start = std::time::Instant::now();
        let backend = Backend::Cpu64(Box::new(CpuTracer::new(model.clone())));
        let film = film(backend, &model, Integrator::Path, SEEDS[0], work(self.spp, 0));
        let seconds = start.elapsed().as_secs_f64();
        let provenance = Provenance {
            unit: "W/(m^2 sr)".into(),
            scene_name: loaded.scene.name.clone(),
            scene_sha256: loaded.sha256.clone(),
            seed: SEEDS[0],
            spp: self.spp,
            integrator: "path".into(),
            backend: "cpu".into(),
            adapter: "built-in CPU tracer, f64".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            ..Provenance::default()
        };
        write_radiance(&self.file("radiance.exr"), &film, &provenance).unwrap();
        let [columns, rows] = loaded.scene.camera.pixels;
        let mean = film.mean.iter().map(|&v| f64::from(v)).sum::<f64>() / film.mean.len() as f64;
        let whole = film.blocks.iter().find(|block| block.edge == 0).unwrap();
        let error = f64::from(whole.variance[0]).sqrt();
        let text = format!(
            "# {}\n\n{}\n\n{columns} x {rows} pixels, {} camera paths each, followed until they meet an LED \
             (`--integrator path`), by the\nbuilt-in CPU tracer in f64; seed {}, {REPLICATES} replicates. Mean radiance \
             {mean:.4e} W/(m^2 sr), standard error {error:.1e}.\n\nThe test `golden` renders it afresh in f32 on the GPU \
             with seed {} and compares by the variances of both.\nMade anew, on purpose only, by\n\n    {REGENERATE}=1 \
             cargo test --profile ci --test gpu golden::\n",
            self.name, self.shows, self.spp, SEEDS[0], SEEDS[1],
        );
        std::fs::write(self.file("README.md"), text).unwrap();
        println!("{}: {seconds:.1} s, mean {mean:.4e} +- {error:.1e}", self.name);
    }
}

#[test]
fn fresh_images_agree_with_the_stored_ones() {
    if let Ok(which) = std::env::var(REGENERATE) {
        GOLDENS.iter().filter(|golden| which == "1" || which == golden.name).for_each(Golden::regenerate);
        panic!("the stored images were written anew; look at them, and run without {REGENERATE}");
    }
    let fresh = at_once(GOLDENS, |golden| {
        let adapter = require_gpu()?;
        Some(golden.fresh(&golden.scene(), |model| gpu(adapter, model)))
    });
    for (golden, fresh) in GOLDENS.iter().zip(fresh) {
        let (stored, Some(fresh)) = (golden.stored(), fresh) else { return };
        if stored.mean.iter().all(|&v| v == 0.0) {
            assert!(fresh.mean.iter().chain(&fresh.variance).all(|&v| v == 0.0), "{} is not dark", golden.name);
            continue;
        }
        assert!(judge(golden, &fresh).passed, "{}", golden.name);
    }
}

/// A stored image against a fresh one with a planted fault.
fn judge(golden: &Golden, fresh: &Film) -> Comparison {
    let found = compare(&golden.stored(), fresh, LEVEL / GOLDENS.len() as f64).unwrap();
    println!("{}: {}", golden.name, failed(&found));
    found
}

/// A stored image against a render whose kernel reads `text` in place of `from`.
fn with_kernel(golden: &Golden, adapter: Gpu, from: &'static str, text: &'static str) -> Comparison {
    let changed = Arc::new(AtomicBool::new(false));
    let note = Arc::clone(&changed);
    let edit = move |_, source: String| {
        let edited = source.replace(from, text);
        note.fetch_or(edited != source, Ordering::Relaxed);
        edited
    };
    let fresh =
        golden.fresh(&golden.scene(), |model| GpuTracer::with_source(adapter, model, Box::new(edit)).unwrap().into());
    assert!(changed.load(Ordering::Relaxed), "no kernel reads `{from}`");
    judge(golden, &fresh)
}

#[test]
fn an_index_off_by_0_005_turns_the_dent_red() {
    let Some(adapter) = require_gpu() else { return };
    let golden = Golden::named("dent");
    let mut loaded = golden.scene();
    let n = &mut loaded.scene.stack.layer[0].n;
    *n = n.map(|n| n + 0.005);
    assert!(!judge(golden, &golden.fresh(&loaded, |model| gpu(adapter, model))).passed);
}

#[test]
fn a_shallower_press_and_brighter_tissue_turn_the_press_red() {
    let golden = Golden::named("pressed");
    let faults: [fn(&mut Scene); 2] = [
        |scene| scene.press.iter_mut().flat_map(|press| &mut press.depths_mm).flatten().for_each(|depth| *depth *= 0.9),
        |scene| scene.touch.contact.iter_mut().for_each(|contact| contact.tissue.diffuse_reflectance = Some(0.77)),
    ];
    for (k, fault) in faults.into_iter().enumerate() {
        let Some(adapter) = require_gpu() else { return };
        let mut loaded = golden.scene();
        fault(&mut loaded.scene);
        assert!(!judge(golden, &golden.fresh(&loaded, |model| gpu(adapter, model))).passed, "fault {k}");
    }
}

/// An unpolarised tracer takes the mean of both polarisations: to mistake one for the other is to take one twice.
#[test]
fn one_polarisation_for_the_other_turns_the_dent_red() {
    for one in ["return s * s;", "return p * p;"] {
        let Some(adapter) = require_gpu() else { return };
        let found = with_kernel(Golden::named("dent"), adapter, "return 0.5 * (s * s + p * p);", one);
        assert!(!found.passed, "{one}");
    }
}

#[test]
fn a_missing_cosine_turns_the_contact_red() {
    let faults = [
        // Photons as if all directions from an LED were equally likely.
        ("var cos_sq = x;", "var cos_sq = x * x;"),
        // The solid angle of a pixel off the axis, one cosine short.
        ("cos_c * cos_c * cos_c", "cos_c * cos_c"),
    ];
    for (right, wrong) in faults {
        let Some(adapter) = require_gpu() else { return };
        assert!(!with_kernel(Golden::named("contact"), adapter, right, wrong).passed, "{wrong}");
    }
}
