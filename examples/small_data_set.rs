//! A data set in one warm session: images of phantoms that differ in their inclusion, with what is truly in each.
//!
//!     cargo run --release --example small_data_set [-- FOLDER IMAGES]

use std::error::Error;
use std::path::PathBuf;
use tirtouch::pipeline::{Order, Session, Truth};
use tirtouch::scene::{InclusionBody, preset};
use tirtouch::trace::{BackendChoice, Precision};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().map_or_else(|| PathBuf::from("out/small-data-set"), PathBuf::from);
    let images: u32 = arguments.next().map_or(Ok(4), |images| images.parse())?;
    std::fs::create_dir_all(&folder)?;
    let mut labels = csv::Writer::from_path(folder.join("labels.csv"))?;
    labels.write_record(["image", "size_mm", "depth_mm", "youngs_kpa", "force_n"])?;

    // Devices and kernels are opened for the first image and serve all.
    let mut session = Session::open(BackendChoice::Auto, Precision::F32)?;
    for number in 0..images {
        let mut loaded = preset("phantom-size-8mm")?;
        let scene = &mut loaded.scene;
        // The same view in a ninth of the pixels, each of which collects nine times the light; a coarser map of it.
        let camera = &mut scene.camera;
        (camera.pixels, camera.pixel_pitch_um) = ([116, 87], 3.0 * camera.pixel_pitch_um);
        camera.sensor.exposure_ms /= 9.0;
        scene.render.map_texel_mm = 0.375;
        let press = scene.press.as_mut().ok_or("the preset presses")?;
        (press.depths_mm, press.estimate_error) = (Some(vec![1.0]), false);
        let inclusion = &mut scene.phantom.as_mut().ok_or("the preset has a phantom")?.inclusion[0];
        let diameter_mm = 4.0 + 10.0 * f64::from(number) / f64::from(images);
        inclusion.shape = InclusionBody::Sphere { diameter_mm };
        let truth = Truth::of(scene.phantom.as_ref(), &loaded.files, false)?;

        let mut order = Order::of(&loaded.scene);
        (order.settings.spp, order.settings.photons) = (16, Some(1 << 17));
        // This press starts from the last one's.
        order.near = true;
        let prepared = session.prepare(loaded, &order, &mut |_| true)?;
        let shot = session.shoot(&prepared, &mut |_| true)?;
        let (_, step) = prepared.pressed().ok_or("the preset presses")?;
        let name = format!("{number:04}.png");
        shot.frame.write_png(&folder.join(&name))?;
        let known = [&truth.size_mm, &truth.depth_mm, &truth.youngs_kpa].map(|figure| figure.value());
        let [size, depth, youngs] = known.map(|value| value.map_or(String::new(), |value| value.to_string()));
        println!("{name}: {size} mm, {depth} mm deep");
        labels.write_record([name, size, depth, youngs, step.force_n.to_string()])?;
    }
    labels.flush()?;
    println!("{}: {images} images, labels.csv", folder.display());
    Ok(())
}
