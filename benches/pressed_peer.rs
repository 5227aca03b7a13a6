//! Shape and contact of a pressed sensor at given points, for the renderer that `benches/peers/compare.py` runs beside.
//!
//!     cargo run --release --example pressed_peer -- SCENE < points > faces
//!
//! Standard input: x and y of each point, mm. Standard output: for each interface from the lowest up and each point,
//! its height (mm, the lowest undeformed face at 0) and its two slopes; then for each point the share of true contact.
//! All are 64-bit floats of the machine.

use anyhow::{Context as _, Result};
use std::io::{Read as _, Write as _};
use std::path::PathBuf;
use tirtouch::mechanics::from_scene::press_setup;
use tirtouch::mechanics::press::{PressSettings, press};
use tirtouch::pipeline::model_of;
use tirtouch::scene::load;
use tirtouch::trace::cpu::{Limits, Path};

fn main() -> Result<()> {
    let scene: PathBuf = std::env::args_os().nth(1).context("usage: pressed_peer SCENE")?.into();
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes)?;
    let numbers: Vec<f64> = bytemuck::pod_collect_to_vec(&bytes);
    let points = || numbers.chunks_exact(2).map(|point| [point[0], point[1]]);

    let loaded = load(&scene)?;
    let settings = PressSettings::default();
    let pressed = press(&press_setup(&loaded)?, settings, &mut |_| true)?;
    let step = pressed.steps.last().context("no depth was reached")?;
    let (surface, _, model) = model_of(&loaded, Some((&pressed, step)))?;
    let path = Path::new(&model, Limits::default());

    let mut out: Vec<f64> = Vec::new();
    for (i, face) in model.faces.iter().enumerate() {
        let at = |[x, y]: [f64; 2]| surface.relief(i).map_or([0.0; 3], |relief| relief.at(x, y));
        out.extend(points().map(at).flat_map(|[height, along, across]| [face.z + height, along, across]));
    }
    out.extend(points().map(|[x, y]| path.contact_share(x, y)));
    std::io::stdout().lock().write_all(bytemuck::cast_slice(&out))?;
    Ok(())
}
