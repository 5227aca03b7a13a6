//! What the refractive index of the touched layer does: one press, many sensors.
//!
//!     cargo run --release --example index_sweep

use std::error::Error;
use tirtouch::pipeline::{Order, Session};
use tirtouch::scene::preset;
use tirtouch::trace::{BackendChoice, Precision};

fn main() -> Result<(), Box<dyn Error>> {
    let mut session = Session::open(BackendChoice::Auto, Precision::F32)?;
    println!("{:>6} {:>14} {:>10} {:>12} {:>10}", "n", "mean radiance", "+- %", "absorbed %", "seconds");
    for n in [1.39, 1.41, 1.43] {
        let mut loaded = preset("phantom-size-8mm")?;
        let scene = &mut loaded.scene;
        // The same view in few pixels, and a coarser map of the light.
        (scene.camera.pixels, scene.camera.pixel_pitch_um) = ([58, 43], 6.0 * scene.camera.pixel_pitch_um);
        scene.render.map_texel_mm = 0.75;
        let press = scene.press.as_mut().ok_or("the preset presses")?;
        (press.depths_mm, press.estimate_error) = (Some(vec![1.0]), false);
        scene.stack.layer[0].n = Some(n);
        let mut order = Order::of(&loaded.scene);
        (order.settings.spp, order.settings.photons) = (32, Some(1 << 18));

        // The press does not see the index: the session gives the one that it has. Nor does the kernel.
        let start = std::time::Instant::now();
        let prepared = session.prepare(loaded, &order, &mut |_| true)?;
        let shot = session.shoot(&prepared, &mut |_| true)?;
        let summary = shot.summary();
        let mean_error = shot.outcome.block_errors().last().and_then(|(_, error)| *error);
        println!(
            "{n:6.3} {:14.4e} {:>10} {:12.2} {:10.2}",
            summary.mean_radiance,
            mean_error.map_or("-".into(), |error| format!("{:.2}", 100.0 * error)),
            100.0 * summary.ledger.absorbed,
            start.elapsed().as_secs_f64()
        );
    }
    Ok(())
}
