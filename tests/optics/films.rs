//! Methods that share no light find the same image: paths from the camera, photons splatted, photons in a map.

use crate::beams::{lambertian, scattering};
use crate::bench;
use tirtouch::film::{self, Film};
use tirtouch::scene::{IntegratorChoice, Led, LoadedScene, Pattern, Pressure, Roughness, Tissue};
use tirtouch::trace::{Devices, Model, Precision, Settings, render};

/// Chance of a false alarm, over all levels of blocks together: as four standard errors.
const LEVEL: f64 = 6.334e-5;

fn film(model: &Model<f64>, integrator: IntegratorChoice, spp: u32, photons: u64, seed: u32) -> Film {
    let settings = Settings { integrator, spp, photons: Some(photons), seconds: None, target_error: None, seed };
    let outcome = render(&bench::devices(), model, &settings, &mut |_| true).unwrap();
    println!("{integrator:?}: {:.2} s, mean {:.6e}", outcome.seconds, outcome.mean_radiance);
    assert_eq!(outcome.ledger.residual, 0.0);
    outcome.film
}

fn agree(what: &str, a: &Film, b: &Film) -> bool {
    let c = film::compare(a, b, LEVEL).unwrap();
    println!("{what}: {:?}, p {:?}", c.ratio, c.tests.iter().map(|t| (t.edge, t.cells, t.p_value)).collect::<Vec<_>>());
    c.passed
}

/// Two films agree, and would not if one were brighter by `fault`.
fn agree_within(fault: f32, what: &str, a: &Film, b: &Film) {
    assert!(agree(what, a, b), "{what}");
    assert!(!agree("brighter", &brighter(a, 1.0 + fault), b), "{what} would not see a fault of {fault}");
}

/// The film with every radiance multiplied.
fn brighter(film: &Film, k: f32) -> Film {
    let by = |values: &mut Vec<f32>, k: f32| values.iter_mut().for_each(|v| *v *= k);
    let mut out = film.clone();
    by(&mut out.mean, k);
    by(&mut out.variance, k * k);
    for block in &mut out.blocks {
        by(&mut block.mean, k);
        by(&mut block.variance, k * k);
    }
    out
}

/// A preset with few pixels and large LEDs, two at each wall: paths find them so often that a second tells methods
/// apart that differ by 2 %. A disc of contact is made larger, for the same reason.
fn bright(preset: &str) -> LoadedScene {
    let mut loaded = bench::sensor(preset);
    let camera = &mut loaded.scene.camera;
    camera.pixel_pitch_um *= f64::from(camera.pixels[0]) / 96.0;
    camera.pixels = [96, 72];
    for led in std::mem::take(&mut loaded.scene.led) {
        for along_mm in [-7.25, 7.25] {
            loaded.scene.led.push(Led { along_mm, diameter_mm: 11.5, ..led.clone() });
        }
    }
    if let Some(Pressure::Disc { radius_mm, .. }) = loaded.scene.touch.contact.as_mut().map(|c| &mut c.pressure) {
        *radius_mm = 8.0;
    }
    loaded
}

/// Films of all three methods, of so many times 32 camera paths a pixel, agree within a fault; that by splats.
fn all_agree(fault: f32, times: u32, model: &Model<f64>) -> Film {
    // Splats are the noisiest: with 32, 2 % are 7 standard errors or more in each pair.
    let photons = u64::from(times) << 16;
    let path = film(model, IntegratorChoice::Path, 32 * times, 1 << 18, 1);
    let splat = film(model, IntegratorChoice::Splat, 2 * times, 2 * photons, 2);
    let map = film(model, IntegratorChoice::Map, times, photons, 3);
    agree_within(fault, "path and splat", &path, &splat);
    agree_within(fault, "path and map", &path, &map);
    agree_within(fault, "splat and map", &splat, &map);
    splat
}

#[test]
fn paths_splats_and_map_agree_on_a_disc_of_contact_and_see_an_albedo_off_by_4_percent() {
    let mut loaded = bright("contact-disc");
    let splat = all_agree(0.02, 32, &bench::model(&loaded));
    if let Some(contact) = &mut loaded.scene.touch.contact {
        contact.tissue.diffuse_reflectance = Some(0.52);
    }
    let other = film(&bench::model(&loaded), IntegratorChoice::Map, 32, 1 << 21, 4);
    assert!(!agree("another albedo", &splat, &other));
}

#[test]
fn paths_splats_and_map_agree_on_tissue_given_by_coefficients_and_see_a_lambertian_one() {
    let mut loaded = bright("contact-disc");
    let set = |loaded: &mut LoadedScene, tissue| {
        if let Some(contact) = &mut loaded.scene.touch.contact {
            contact.tissue = tissue;
        }
    };
    set(&mut loaded, Tissue { n: 1.38, ..scattering(0.01) });
    let splat = all_agree(0.03, 16, &bench::model(&loaded));
    // As much light in all, but alike in all directions.
    set(&mut loaded, Tissue { n: 1.38, ..lambertian(0.7955) });
    let even = film(&bench::model(&loaded), IntegratorChoice::Map, 32, 1 << 21, 4);
    assert!(!agree("Lambertian", &splat, &even));
}

#[test]
fn paths_splats_and_map_agree_on_a_press_with_partial_contact_and_spread() {
    let model = bench::model(&bright("press-hertz"));
    let path = film(&model, IntegratorChoice::Path, 960, 1 << 18, 1);
    let splat = film(&model, IntegratorChoice::Splat, 48, 3 << 20, 2);
    let map = film(&model, IntegratorChoice::Map, 24, 3 << 19, 3);
    // Light trapped between clear walls makes long paths: 6 s of them see 4 %.
    agree_within(0.04, "path and splat", &path, &splat);
    agree_within(0.04, "path and map", &path, &map);
    agree_within(0.04, "splat and map", &splat, &map);
}

#[test]
fn photons_leave_leds_of_every_pattern_as_paths_find_them() {
    let mut loaded = bright("contact-disc");
    for (k, led) in loaded.scene.led.iter_mut().enumerate() {
        led.pattern = Pattern::CosinePower { half_power_deg: 30.0 + 4.0 * k as f64 };
        led.cutoff_half_angle_deg = Some(60.0 + 3.0 * k as f64);
    }
    let model = bench::model(&loaded);
    let path = film(&model, IntegratorChoice::Path, 512, 1 << 18, 7);
    let map = film(&model, IntegratorChoice::Map, 24, 3 << 19, 8);
    agree_within(0.03, "cosine powers", &path, &map);
}

#[test]
fn paths_and_photons_agree_through_microfacets() {
    let mut loaded = bright("contact-disc");
    let rough = Roughness::Microfacet { alpha: 0.2 };
    loaded.scene.stack.layer[0].upper_roughness = rough;
    loaded.scene.stack.lower_roughness = rough;
    let model = bench::model(&loaded);
    let path = film(&model, IntegratorChoice::Path, 160, 1 << 18, 9);
    let map = film(&model, IntegratorChoice::Map, 80, 5 << 19, 10);
    agree_within(0.04, "microfacets", &path, &map);
}

#[test]
fn paths_that_weigh_what_the_outer_faces_mirror_find_what_paths_that_draw_it_find() {
    // Where nothing touches, camera paths carry Fresnel's share as a weight. A speck of tissue makes them draw it.
    let mut speck = bright("contact-disc").scene.touch.contact;
    if let Some(Pressure::Disc { radius_mm, .. }) = speck.as_mut().map(|contact| &mut contact.pressure) {
        *radius_mm = 0.01;
    }
    for preset in ["flat-bonded", "dent-cap"] {
        let mut loaded = bright(preset);
        let weighed = film(&bench::model(&loaded), IntegratorChoice::Path, 192, 1 << 18, 12);
        loaded.scene.touch.contact = speck.clone();
        let drawn = film(&bench::model(&loaded), IntegratorChoice::Path, 1536, 1 << 18, 13);
        agree_within(0.04, preset, &weighed, &drawn);
    }
}

#[test]
fn an_image_of_few_pixels_and_many_samples_loses_no_light_on_the_gpu() {
    // Few pixels mean many samples a thread, and a software driver ends a thread's loops after 65,535 turns.
    let mut loaded = bright("contact-disc");
    loaded.scene.camera.pixels = [4, 3];
    let model = bench::model(&loaded);
    let mean = |devices| {
        let settings = Settings {
            integrator: IntegratorChoice::Path,
            spp: 1 << 17,
            photons: Some(1 << 14),
            seconds: None,
            target_error: None,
            seed: 11,
        };
        render(&devices, &model, &settings, &mut |_| true).unwrap().mean_radiance
    };
    // The same paths: they part only where rounding decides an event, one in 1e5 of them.
    let (gpu, cpu) = (mean(bench::devices()), mean(Devices::cpu(Precision::F32)));
    bench::close("mean of few pixels", gpu / cpu, 1.0, 1e-3);
}
