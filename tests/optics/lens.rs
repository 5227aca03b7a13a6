//! The thin lens: sharp at its focus, blurred elsewhere.

use crate::bench;
use tirtouch::scene::{Lens, ViewAxis};
use tirtouch::trace::{Integrator, Settings, render};

/// Width of the image of a contact disc's edge along the middle row, from a quarter to three quarters of its height,
/// pixels of 1/96 of the image.
fn edge_width(lens: Lens) -> f64 {
    let mut loaded = bench::sensor("contact-disc");
    let columns = 768u32;
    // Texels that smooth the photons' noise; the contact's edge is not in the map.
    loaded.scene.render.map_texel_mm = 2.0;
    let camera = &mut loaded.scene.camera;
    (camera.view_axis, camera.lens) = (ViewAxis::Width, lens);
    (camera.pixels, camera.pixel_pitch_um) = ([columns, 1], 67.43 * 96.0 / f64::from(columns));
    camera.sensor.f_number = 2.0;
    let settings = Settings {
        integrator: tirtouch::scene::IntegratorChoice::Map,
        spp: 512,
        photons: Some(1 << 21),
        seconds: None,
        target_error: None,
        seed: 5,
    };
    let outcome = render(&bench::devices(), &bench::model(&loaded), &settings, &mut |_| true).unwrap();
    assert_eq!(outcome.plan.integrator, Integrator::Map);
    let row = &outcome.film.mean;
    // The quarter from a fourth to the middle holds the disc's left edge; further out the LEDs' own reflection is seen.
    let quarter = &row[columns as usize / 4..columns as usize / 2];
    let lit = quarter.iter().position(|&v| v > 0.75 * quarter[quarter.len() - 1]).unwrap();
    let plateau = quarter[lit + 8..lit + 24].iter().sum::<f32>() / 16.0;
    let between = quarter.iter().filter(|&&v| v > 0.25 * plateau && v < 0.75 * plateau).count();
    between as f64 * 96.0 / f64::from(columns)
}

#[test]
fn the_edge_of_a_contact_disc_is_sharp_at_the_focus_and_blurred_by_the_pupil_elsewhere() {
    // The layers look thinner by their indices: paraxially the touched face lies there.
    let apparent = 17.32 + 2.0 / 1.41 + 3.0 / 1.40 + 5.0 / 1.39 + 2.0 / 1.38;
    let pinhole = edge_width(Lens::Pinhole);
    let focused = edge_width(Lens::ThinLens { focus_mm: apparent });
    let near = edge_width(Lens::ThinLens { focus_mm: 0.8 * apparent });
    println!("edge widths: pinhole {pinhole}, in focus {focused}, focused nearer {near} of 1/96 image");
    // A pinhole's edge lies within one pixel of 1/8; the lens adds the spherical aberration of flat layers.
    assert!(pinhole <= 0.125 && focused <= 0.25, "{pinhole} {focused}");
    // The disc of confusion: pupil 1.4 mm in radius (f = 5.6 mm at f/2), 1/0.8 - 1 of it at the face: 0.35 mm in
    // radius, whose edge passes from a quarter to three quarters over 0.81 radii, 0.28 mm; a 96th of the image is
    // 0.31 mm there. Counted in eighths, to one at either end.
    assert!((near - 0.91).abs() < 0.25, "{near}");
}
