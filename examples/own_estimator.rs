//! An estimator of one's own, put to the test: it sees grey levels alone, and the truth says how good it is.
//!
//! This one takes the radius of a disc of contact to be where the grey level, averaged over rings about the middle,
//! falls to half of its middle.
//!
//!     cargo run --release --example own_estimator [-- SEEDS]

use std::error::Error;
use tirtouch::estimate::GreyImage;
use tirtouch::pipeline::{Order, Session};
use tirtouch::scene::{Pressure, preset};
use tirtouch::trace::{BackendChoice, Precision};

/// Radius at which the mean over rings a pixel wide falls to half of the inner ones', pixels.
fn half_radius_px(image: &GreyImage) -> Option<f64> {
    let (width, height) = (image.width(), image.height());
    let mut rings = vec![[0.0, 0.0]; width.min(height) / 2];
    for (k, grey) in image.grey().iter().enumerate() {
        let [x, y] = [(k % width) as f64 + 0.5 - width as f64 / 2.0, (k / width) as f64 + 0.5 - height as f64 / 2.0];
        if let Some([sum, count]) = rings.get_mut(x.hypot(y) as usize) {
            (*sum, *count) = (*sum + grey, *count + 1.0);
        }
    }
    let means: Vec<f64> = rings.iter().map(|[sum, count]| sum / count).collect();
    let half = 0.5 * means[..means.len() / 8].iter().sum::<f64>() / (means.len() / 8) as f64;
    let at = means.windows(2).position(|pair| pair[0] >= half && pair[1] < half)?;
    // Between the middles of two rings.
    Some(at as f64 + 0.5 + (means[at] - half) / (means[at] - means[at + 1]))
}

fn main() -> Result<(), Box<dyn Error>> {
    let seeds: u32 = std::env::args().nth(1).map_or(Ok(8), |seeds| seeds.parse())?;
    if seeds < 2 {
        return Err("at least 2 seeds: one alone has no spread".into());
    }
    let mut session = Session::open(BackendChoice::Auto, Precision::F32)?;
    let mut errors = Vec::new();
    let mut true_mm = 0.0;
    for seed in 0..seeds {
        let mut loaded = preset("contact-disc")?;
        let camera = &mut loaded.scene.camera;
        // The same view in a quarter of the pixels, each of which collects four times the light.
        (camera.pixels, camera.pixel_pitch_um) = ([174, 130], 2.0 * camera.pixel_pitch_um);
        camera.sensor.exposure_ms /= 4.0;
        let contact = loaded.scene.touch.contact.as_ref().ok_or("the preset has contact")?;
        let Pressure::Disc { radius_mm, .. } = contact.pressure else { return Err("its contact is a disc".into()) };
        true_mm = radius_mm;
        let mut order = Order::of(&loaded.scene);
        (order.settings.spp, order.settings.photons) = (16, Some(1 << 18));
        order.settings.seed = seed;
        let prepared = session.prepare(loaded, &order, &mut |_| true)?;
        let shot = session.shoot(&prepared, &mut |_| true)?;
        let radius_px = half_radius_px(&GreyImage::from_frame(&shot.frame)?).ok_or("no ring falls to half")?;
        errors.push(radius_px * shot.mm_per_pixel - radius_mm);
    }
    let n = f64::from(seeds);
    let bias = errors.iter().sum::<f64>() / n;
    let spread = (errors.iter().map(|error| (error - bias).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    println!("true radius {true_mm} mm, {seeds} seeds: bias {bias:.4} mm, spread {spread:.4} mm");
    Ok(())
}
