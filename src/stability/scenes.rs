//! Scenes that are hard on the tracer's geometry.

use super::StabilityError;
use crate::pipeline::{Order, Session, model_of};
use crate::scene::{Inner, Layer, Lens, LoadedScene, Normals, PRESETS, Roughness, Scene, Shape, Walls, preset};
use crate::surface::{HeightField, Surface};
use crate::trace::{Devices, Model, Precision};

/// Pixels of the camera, which plays no part.
const PIXELS: [u32; 2] = [4, 3];

/// A scene by name, with what a tracer sees of it.
pub struct HardScene {
    /// Its name.
    pub name: String,
    /// The model, with a camera of a few pixels.
    pub model: Model<f64>,
}

/// What the tracers see of a scene, by a camera of a few pixels.
///
/// # Errors
/// `Surface`, as [`model_of`]: a scene that presses, a shape that does not fit its stack, a file that cannot be used.
pub fn model(loaded: &LoadedScene) -> Result<Model<f64>, StabilityError> {
    let mut loaded = loaded.clone();
    loaded.scene.camera.pixels = PIXELS;
    Ok(model_of(&loaded, None)?.2)
}

/// A changed preset.
fn variant(name: &str, change: impl FnOnce(&mut Scene)) -> Result<Model<f64>, StabilityError> {
    let mut loaded = preset(name)?;
    change(&mut loaded.scene);
    model(&loaded)
}

/// A preset at its last load.
fn pressed(name: &str) -> Result<Model<f64>, StabilityError> {
    let mut loaded = preset(name)?;
    loaded.scene.camera.pixels = PIXELS;
    let order = Order::of(&loaded.scene);
    let mut session = Session::from(Devices::cpu(Precision::F64));
    Ok(session.prepare(loaded, &order, &mut |_| true)?.model)
}

/// A flat stack with mirrors all round and without LEDs.
///
/// # Errors
/// As [`model`], of what `change` makes of the scene.
pub fn cavity(change: impl FnOnce(&mut Scene)) -> Result<Model<f64>, StabilityError> {
    let mut model = variant("flat-bonded", |scene| {
        scene.stack.walls = Walls::Mirror { reflectance: 1.0 };
        change(scene);
    })?;
    model.leds.clear();
    Ok(model)
}

/// The same with a dent so shallow that all light stays guided, as a height field: normals are looked up, and
/// reflections are those of any slope.
///
/// # Errors
/// `Surface` for a dent that reaches through the layer.
pub fn dented_cavity(depth_mm: f64) -> Result<Model<f64>, StabilityError> {
    cavity(|scene| {
        scene.touch.shape = Shape::GaussianDent { depth_mm, sigma_mm: 2.0, center_mm: [0.0, 0.0] };
    })
}

/// Layers as thickness (mm) and index, touch side first.
pub fn layers(scene: &mut Scene, layers: &[[f64; 2]]) {
    let layer = |&[thickness_mm, n]: &[f64; 2]| Layer {
        name: format!("{thickness_mm} mm of {n}"),
        thickness_mm,
        n: Some(n),
        material: None,
        absorption_per_mm: 0.0,
        upper_roughness: Roughness::None,
        elastic: None,
    };
    scene.stack.layer = layers.iter().map(layer).collect();
}

/// Layers of 1 um and 10 nm, steps of the index of 0, 1e-7 and 1e-3, an index of 4.
pub const THIN: [[f64; 2]; 6] =
    [[2.0, 1.41], [1e-3, 1.41], [1e-5, 1.410_000_1], [4.0, 1.411], [1e-3, 4.0], [6.0, 1.38]];

/// The presets without a press, one with (the others differ in their inclusions), and what they leave out: height
/// fields, a mesh, mirrors, a lens, contact on a deformed face, thin layers.
///
/// # Errors
/// As [`model`]; `Pipeline` where the pressed phantom does not come to its load, `File` where no temporary folder can
/// be written.
pub fn hard_scenes(quick: bool) -> Result<Vec<HardScene>, StabilityError> {
    let mut scenes = Vec::new();
    let mut add = |name: &str, model: Model<f64>| scenes.push(HardScene { name: name.into(), model });
    let few = ["tsis-paper", "tsis-dent", "contact-disc"];
    for (name, _) in PRESETS {
        let loaded = preset(name)?;
        if loaded.scene.press.is_none() && (!quick || few.contains(name)) {
            add(name, model(&loaded)?);
        }
    }
    let dent = Shape::GaussianDent { depth_mm: 1.0, sigma_mm: 1.5, center_mm: [0.5, -1.0] };
    add(
        "gaussian-dent",
        variant("dent-cap", |s| {
            (s.touch.shape, s.touch.inner) = (dent.clone(), Inner::Follow);
        })?,
    );
    add("height-map", height_map()?);
    add("thin-layers", variant("flat-bonded", |s| layers(s, &THIN))?);
    if quick {
        return Ok(scenes);
    }
    add("phantom-size-8mm, pressed", pressed("phantom-size-8mm")?);
    add("dent-contact", variant("press-hertz", |s| s.touch.shape = dent.clone())?);
    add("mirror-walls", variant("contact-disc", |s| s.stack.walls = Walls::Mirror { reflectance: 0.95 })?);
    add(
        "lens",
        variant("contact-disc", |s| {
            s.camera.lens = Lens::ThinLens { focus_mm: 24.0 };
            s.camera.sensor.f_number = 1.4;
        })?,
    );
    add("mesh-dent", mesh_dent()?);
    Ok(scenes)
}

/// An oval dent and a bump beside it as bicubic height fields over the plane, the second interface by half as much.
fn height_map() -> Result<Model<f64>, StabilityError> {
    let mut loaded = preset("dent-cap")?;
    loaded.scene.camera.pixels = PIXELS;
    let bell = |x: f64, y: f64| (-(x * x + 2.0 * y * y) / 8.0).exp();
    let height = |x, y| 0.3 * bell(x - 6.0, y) - bell(x, y);
    let field = HeightField::sample(129, loaded.scene.stack.footprint_mm, height);
    let field = field.ok_or(StabilityError::Missing("a height field needs 3 x 3 samples"))?;
    let mut fields = vec![None; loaded.scene.stack.layer.len() - 1];
    fields.extend([Some(field.scaled(0.5)), Some(field)]);
    Ok(Model::new(&loaded, &Surface::Fields(fields), None)?)
}

/// A dent as a mesh of triangles.
fn mesh_dent() -> Result<Model<f64>, StabilityError> {
    let mut loaded = preset("dent-cap")?;
    loaded.files.insert("dent.obj", dent_obj().as_bytes());
    loaded.scene.touch.shape = Shape::Mesh { file: "dent.obj".into(), normals: Normals::Smooth };
    model(&loaded)
}

/// The touched face of `dent-cap`, 12 mm up, with a dent, as 32 x 32 squares of two triangles: the text of an OBJ file.
pub fn dent_obj() -> String {
    const SIDE: usize = 33;
    let at = |k: usize| -15.0 + 30.0 * k as f64 / (SIDE - 1) as f64;
    let vertex = |k: usize| {
        let (x, y) = (at(k % SIDE), at(k / SIDE));
        format!("v {x} {y} {}\n", 12.0 - 1.2 * (-(x * x + y * y) / (2.0 * 3.0 * 3.0)).exp())
    };
    let square = |k: usize| {
        let a = k / (SIDE - 1) * SIDE + k % (SIDE - 1) + 1;
        format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + SIDE + 1, a + SIDE + 1, a + SIDE)
    };
    (0..SIDE * SIDE).map(vertex).chain((0..(SIDE - 1) * (SIDE - 1)).map(square)).collect()
}
