//! The scenes of the tests: every preset, and variants for the pieces of the kernels that no preset needs.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{LazyLock, Mutex};
use tirtouch::pipeline::{Order, Session, model_of};
use tirtouch::scene::{
    self, Inner, Inputs, Lens, LoadedScene, Normals, PRESETS, Pattern, Press, Roughness, Shape, Walls,
};
use tirtouch::stability::scenes::dent_obj;
use tirtouch::trace::{Devices, Model, Precision};

/// A scene by name.
pub struct Case {
    pub name: String,
    pub loaded: LoadedScene,
}

impl Case {
    pub fn preset(name: &str) -> Self {
        Self { name: name.into(), loaded: scene::preset(name).unwrap() }
    }

    /// A preset or a variant.
    pub fn named(name: &str) -> Self {
        presets().into_iter().chain(variants()).find(|case| case.name == name).unwrap()
    }

    fn variant(name: &str, preset: &str, change: impl FnOnce(&mut scene::Scene)) -> Self {
        let mut case = Self { name: name.into(), ..Self::preset(preset) };
        case.loaded.files = FILES.clone();
        change(&mut case.loaded.scene);
        case
    }

    /// Its model, seen by a camera of other pixels over the same view.
    pub fn model(&self, pixels: [u32; 2]) -> Model<f64> {
        let mut loaded = self.loaded.clone();
        loaded.scene.camera.pixels = pixels;
        loaded.scene.render.map_texel_mm = FEW_TEXELS_MM;
        model(&loaded)
    }
}

/// What `job` says of each, in their order, four at a time: one that waits for a driver's compiler leaves the machine
/// to the others.
pub fn at_once<T: Sync, U: Send>(of: &[T], job: impl Fn(&T) -> U + Sync) -> Vec<U> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mine = std::iter::from_fn(|| {
            let k = next.fetch_add(1, Ordering::Relaxed);
            of.get(k).map(|item| (k, job(item)))
        });
        mine.collect::<Vec<_>>()
    };
    let mut said: Vec<(usize, U)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(work)).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap_or_else(|e| std::panic::resume_unwind(e))).collect()
    });
    said.sort_by_key(|(k, _)| *k);
    said.into_iter().map(|(_, said)| said).collect()
}

/// Texels for images of few pixels: a sixteenth of the default's, and below a pixel.
pub const FEW_TEXELS_MM: f64 = 0.5;

pub fn model(loaded: &LoadedScene) -> Model<f64> {
    match loaded.scene.press {
        Some(_) => pressed(loaded),
        None => model_of(loaded, None).unwrap().2,
    }
}

/// At the last load of its press. Scenes that differ in their light and their tissue alone share the press.
fn pressed(loaded: &LoadedScene) -> Model<f64> {
    static SESSION: LazyLock<Mutex<Session>> =
        LazyLock::new(|| Mutex::new(Session::from(Devices::cpu(Precision::F32))));
    let mut loaded = loaded.clone();
    loaded.scene.press.as_mut().unwrap().estimate_error = false;
    let order = Order::of(&loaded.scene);
    SESSION.lock().unwrap().prepare(loaded, &order, &mut |_| true).unwrap().model
}

pub fn presets() -> Vec<Case> {
    // Of those with a press one is among the variants, with coarse elements.
    PRESETS.iter().map(|(name, _)| Case::preset(name)).filter(|case| case.loaded.scene.press.is_none()).collect()
}

/// What the presets leave out: height fields of both kinds, a mesh, mirrors, a lens, a tabulated LED, contact on a
/// deformed face and on a mesh, a press.
pub fn variants() -> Vec<Case> {
    let dent = Shape::GaussianDent { depth_mm: 1.0, sigma_mm: 1.5, center_mm: [0.5, -1.0] };
    vec![
        Case::variant("gaussian-dent", "dent-cap", |s| {
            s.touch.shape = dent.clone();
            s.touch.inner = Inner::Follow;
        }),
        Case::variant("height-map", "dent-cap", |s| {
            s.touch.shape = Shape::HeightMap { file: "dent.csv".into(), scale_mm: 1.0 };
            s.touch.inner = Inner::Follow;
        }),
        Case::variant("dent-contact", "press-hertz", |s| s.touch.shape = dent.clone()),
        Case::variant("mesh-contact", "press-hertz", |s| {
            s.touch.shape = Shape::Mesh { file: "dent.obj".into(), normals: Normals::Smooth };
        }),
        // Coarse finite elements: half a second.
        Case::variant("pressed", "phantom-size-8mm", |s| {
            let press = s.press.take().unwrap();
            s.press = Some(Press { depths_mm: Some(vec![2.0]), resolution: 0.5, ..press });
        }),
        Case::variant("mesh-dent", "dent-cap", |s| {
            s.touch.shape = Shape::Mesh { file: "dent.obj".into(), normals: Normals::Smooth };
        }),
        Case::variant("mirror-walls", "contact-disc", |s| s.stack.walls = Walls::Mirror { reflectance: 0.95 }),
        Case::variant("lens", "contact-disc", |s| {
            s.camera.lens = Lens::ThinLens { focus_mm: 24.0 };
            s.camera.sensor.f_number = 1.4;
        }),
        Case::variant("ies-led", "dent-cap", |s| {
            s.led[0].pattern = Pattern::Ies { file: "led.ies".into() };
        }),
        Case::variant("thin-layers", "flat-bonded", |s| {
            let layer = |name: &str, thickness_mm, n| scene::Layer {
                name: name.into(),
                thickness_mm,
                n: Some(n),
                material: None,
                absorption_per_mm: 0.0,
                upper_roughness: Roughness::None,
                elastic: None,
            };
            // 1 um and 10 nm; steps of 0, 1e-7 and 1e-3; an index of 4.
            s.stack.layer = vec![
                layer("top", 2.0, 1.41),
                layer("no step", 1e-3, 1.41),
                layer("tiny step", 1e-5, 1.410_000_1),
                layer("small step", 4.0, 1.411),
                layer("dense", 1e-3, 4.0),
                layer("glass", 6.0, 1.38),
            ];
        }),
    ]
}

/// The files of the variants.
static FILES: LazyLock<Inputs> = LazyLock::new(|| {
    let mut files = Inputs::default();
    for (name, text) in [("dent.csv", dent_csv()), ("dent.obj", dent_obj()), ("led.ies", LED_IES.into())] {
        files.insert(name, text.as_bytes());
    }
    files
});

/// A dent that is not round: 97 x 65 heights over 30 x 30 mm.
fn dent_csv() -> String {
    let at = |k: u32, n: u32| 30.0 * (f64::from(k) / f64::from(n) - 0.5);
    let height = |x: f64, y: f64| -(-(x * x + 2.0 * y * y) / 8.0).exp();
    let row = |j: u32| (0..97).map(|i| height(at(i, 96), at(j, 64)).to_string()).collect::<Vec<_>>().join(",");
    (0..65).map(|j| row(j) + "\n").collect()
}

/// A narrow beam, wider across than up.
const LED_IES: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1.0 4 2 1 2 0 0 0\n1 1 0\n0 30 60 90\n0 90\n\
                       100 80 30 0\n100, 50, 5, 0\n";
