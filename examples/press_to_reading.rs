//! A phantom is pressed, and what the paper would read from the camera's image, beside what is truly there.
//!
//!     cargo run --release --example press_to_reading

use std::error::Error;
use tirtouch::estimate::Value;
use tirtouch::pipeline::{Order, PressSummary, ReadAs, Session, Truth};
use tirtouch::scene::preset;
use tirtouch::trace::{BackendChoice, Precision};

fn main() -> Result<(), Box<dyn Error>> {
    let mut loaded = preset("phantom-size-14mm")?;
    let camera = &mut loaded.scene.camera;
    // The same view in a ninth of the pixels, each of which collects nine times the light; a coarser map of it.
    (camera.pixels, camera.pixel_pitch_um) = ([116, 87], 3.0 * camera.pixel_pitch_um);
    camera.sensor.exposure_ms /= 9.0;
    loaded.scene.render.map_texel_mm = 0.375;
    let press = loaded.scene.press.as_mut().ok_or("the preset presses")?;
    press.depths_mm = Some(vec![1.0, 2.0]);
    let truth = Truth::of(loaded.scene.phantom.as_ref(), &loaded.files, false)?;

    let mut session = Session::open(BackendChoice::Auto, Precision::F32)?;
    let mut order = Order::of(&loaded.scene);
    (order.settings.spp, order.settings.photons) = (16, Some(1 << 18));
    let prepared = session.prepare(loaded, &order, &mut |_| true)?;
    // The same press without the inclusion, traced with random numbers of its own.
    let baseline = session.baseline(&prepared, &mut |_| true)?;
    let reference = session.shoot(&baseline, &mut |_| true)?.as_reference()?;
    let shot = session.shoot(&prepared, &mut |_| true)?;

    let (pressed, _) = prepared.pressed().ok_or("the preset presses")?;
    for step in PressSummary::of(pressed).steps {
        let error = step.force_error.value().map_or("unknown".into(), |error| format!("{:.1} %", 100.0 * error));
        println!("{} mm: {:.3} N (error {error}), {:.2} kPa", step.depth_mm, step.force_n, step.peak_pressure_kpa);
    }
    let reading = shot.read(&ReadAs { reference: Some(&reference), ..ReadAs::default() })?;
    match &reading.paper.diameter_mm {
        Value::Known { value, low, high } => println!("lit: {value:.1} mm across (95 %: {low:.1} to {high:.1})"),
        Value::Undefined { reason } => println!("lit: undefined: {reason}"),
    }
    println!("warnings: {:?}", reading.paper.warnings);
    println!("true inclusion: {:?} mm across, {:?} mm deep", truth.size_mm.value(), truth.depth_mm.value());
    Ok(())
}
