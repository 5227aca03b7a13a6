//! From a scene's text to an image: radiance with its variance, the camera's frame, and where the light went.
//!
//!     cargo run --release --example scene_to_image [-- FOLDER]

use std::error::Error;
use std::path::{Path, PathBuf};
use tirtouch::pipeline::{Order, Session};
use tirtouch::scene::parse;
use tirtouch::trace::{BackendChoice, Precision};

/// A block of silicone between black walls, a dent of 1 mm in its upper face, an LED at each of four walls.
const SCENE: &str = include_str!("../scenes/dent-cap.toml");

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("out/scene-to-image"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    let mut loaded = parse(SCENE, Path::new("dent-cap.toml"))?;
    let camera = &mut loaded.scene.camera;
    // The same view in a ninth of the pixels, each of which collects nine times the light.
    (camera.pixels, camera.pixel_pitch_um) = ([116, 87], 3.0 * camera.pixel_pitch_um);
    camera.sensor.exposure_ms /= 9.0;

    // A GPU where there is one, else the CPU.
    let mut session = Session::open(BackendChoice::Auto, Precision::F32)?;
    let mut order = Order::of(&loaded.scene);
    order.settings.spp = 64;
    // Called as the work goes on; false would stop it.
    let mut observe = |stage: tirtouch::progress::Stage| {
        eprint!("\r{:3.0} % {:30}", 100.0 * stage.done, stage.what);
        true
    };
    let prepared = session.prepare(loaded, &order, &mut observe)?;
    let shot = session.shoot(&prepared, &mut observe)?;
    eprintln!();

    shot.write_radiance(&folder.join("radiance.exr"), "examples/scene_to_image")?;
    shot.frame.write_png(&folder.join("camera.png"))?;
    let summary = shot.summary();
    println!("{} on {}: {} paths", summary.scene, summary.adapter, summary.paths);
    println!(
        "mean radiance {:.3e} W/(m^2 sr), brightest grey level {}",
        summary.mean_radiance, summary.camera.max_grey
    );
    println!("of the light {:.1} % left through the touched face", 100.0 * summary.ledger.escaped_top);
    println!("{}: radiance.exr camera.png", folder.display());
    Ok(())
}
