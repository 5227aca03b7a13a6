//! `estimate` on images from anywhere.

use super::*;
use tirtouch::image_io::write_png_grey;

/// A disc of the given radius and grey level on 100 x 80 dark pixels.
fn disc(place: &Place, name: &str, radius: f64, grey: u16) -> String {
    let pixel = |i: u32| {
        let (x, y) = (f64::from(i % 100) + 0.5 - 50.0, f64::from(i / 100) + 0.5 - 40.0);
        if x.hypot(y) < radius { grey } else { 0 }
    };
    let levels: Vec<u16> = (0..8000).map(pixel).collect();
    write_png_grey(&place.path().join(name), 100, 80, &levels, 8).unwrap();
    name.to_owned()
}

fn estimated(place: &Place, arguments: &[&str]) -> Value {
    let output = tirtouch_in(place.path(), &[&["estimate", "--json", "--quiet"], arguments].concat());
    assert_eq!(code(&output), 0, "{output:?}");
    json(&output)
}

#[test]
fn a_disc_has_its_diameter_centroid_and_sum() {
    let place = Place::new();
    let image = disc(&place, "disc.png", 20.0, 100);
    let said = estimated(&place, &[&image]);
    let paper = &said["images"][0]["paper"];
    let lit = paper["lit_pixels"].as_f64().unwrap();
    // Counting pixels on 40 pixels of diameter: good to a hundredth or so.
    assert!((paper["diameter_px"]["value"].as_f64().unwrap() - 40.0).abs() < 0.4, "{paper}");
    assert!((paper["centroid_px"]["value"][0].as_f64().unwrap() - 50.0).abs() < 1e-9, "{paper}");
    assert_eq!(paper["sum_grey"]["value"].as_f64().unwrap(), 100.0 * lit);
    assert_eq!(paper["h_grey"]["value"], 100.0);
    assert!(said["images"][0]["estimates"]["size_mm"]["undefined"].is_string(), "no model");
    assert!(paper["diameter_mm"]["undefined"].is_string(), "no calibration");
    assert!(paper["intervals"].as_str().unwrap().contains("noise of light and camera is not known"), "{paper}");
    assert!(said["stiffness"]["undefined"].as_str().unwrap().contains("two images"));
}

#[test]
fn two_images_and_a_calibration_give_a_relative_stiffness() {
    let place = Place::new();
    place.write(
        "calibration.toml",
        "mm_per_pixel = 0.1\nbottom_area_mm2 = 900.0\nforce_n_from_sum_grey = [[0.0, 0.0], [1e6, 10.0]]\n",
    );
    let images = [disc(&place, "a.png", 15.0, 100), disc(&place, "b.png", 30.0, 100)];
    let said = estimated(&place, &[&images[0], &images[1], "--calibration", "calibration.toml"]);
    // Growth by the factor 2, the counts of pixels good to a per cent.
    assert!((said["stiffness"]["deformation"]["value"].as_f64().unwrap() - 1.0).abs() < 0.03, "{said}");
    assert!(said["stiffness"]["relative_stiffness_kpa"]["value"].as_f64().unwrap() > 0.0);
    assert!((said["images"][1]["paper"]["diameter_mm"]["value"].as_f64().unwrap() - 6.0).abs() < 0.06, "{said}");
    let same = estimated(&place, &[&images[0], &images[0], "--calibration", "calibration.toml"]);
    assert!(same["stiffness"]["relative_stiffness_kpa"]["undefined"].is_string());
    assert!(estimated(&place, &[&images[0], &images[1]])["stiffness"]["undefined"].is_string(), "no calibration");
}

#[test]
fn threshold_and_reference_count() {
    let place = Place::new();
    let image = disc(&place, "disc.png", 20.0, 100);
    let dimmer = disc(&place, "dimmer.png", 20.0, 40);
    let undefined =
        |arguments: &[&str]| estimated(&place, arguments)["images"][0]["paper"]["diameter_px"]["undefined"].is_string();
    assert!(!undefined(&[&image, "--threshold", "99"]) && undefined(&[&image, "--threshold", "100"]));
    assert!(!undefined(&[&image, "--reference", &dimmer, "--threshold", "59"]));
    assert!(undefined(&[&image, "--reference", &dimmer, "--threshold", "60"]));
    assert!(undefined(&[&image, "--reference", &image]));
}

#[test]
fn radiance_is_taken_as_it_is_or_exposed() {
    let place = Place::new();
    let exr = place.radiance("a.exr", &film(1, 1.0), UNIT);
    let output = tirtouch_in(place.path(), &["estimate", &exr]);
    assert_eq!(code(&output), 0, "{output:?}");
    assert!(one_line(&output).contains("--exposure"), "{output:?}");
    let raw = estimated(&place, &[&exr]);
    assert!(raw["images"][0]["paper"]["max_grey"].as_f64().unwrap() < 2.0, "{raw}");
    place.write("scene.toml", &small("tsis-paper").replace("pixels = [48, 36]", "pixels = [32, 32]"));
    let exposed = estimated(&place, &[&exr, "--exposure", "scene.toml"]);
    // Some 27,000 electrons for a radiance of 1 fill the well of 15,000.
    assert_eq!(exposed["images"][0]["paper"]["max_grey"], 255.0);
    let refused = tirtouch_in(place.path(), &["estimate", &exr, "--exposure", "preset:tsis-paper"]);
    assert_eq!(code(&refused), 2);
    assert!(one_line(&refused).contains("a.exr") && one_line(&refused).contains("32 x 32"), "{refused:?}");
}

#[test]
fn bad_images_and_calibrations_are_named() {
    let place = Place::new();
    let image = disc(&place, "disc.png", 20.0, 100);
    place.write("no.png", "no image");
    place.write("bad.toml", "mm_per_pixel = -1.0\n");
    write_png_grey(&place.path().join("other.png"), 2, 2, &[0; 4], 8).unwrap();
    for (arguments, named) in [
        (&["missing.png"][..], "missing.png"),
        (&["no.png"], "no.png"),
        (&[&image, "--calibration", "bad.toml"], "bad.toml:1"),
        (&[&image, "--reference", "other.png"], "other.png"),
        (&[&image, "--threshold", "nan"], "--threshold"),
        (&[], "IMAGE"),
    ] {
        let output = tirtouch_in(place.path(), &[&["estimate"], arguments].concat());
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains(named), "{output:?}");
    }
}

/// 2 x 2 pixels of the given levels in a file of 8 or 16 bits.
fn four(place: &Place, name: &str, levels: [u16; 4], depth: u32) -> String {
    write_png_grey(&place.path().join(name), 2, 2, &levels, depth).unwrap();
    name.to_owned()
}

fn refused(place: &Place, arguments: &[&str]) -> String {
    let output = tirtouch_in(place.path(), arguments);
    assert_eq!(code(&output), 2, "{output:?}");
    one_line(&output).to_owned()
}

#[test]
fn a_reference_of_another_depth_is_refused() {
    let place = Place::new();
    let narrow = four(&place, "narrow.png", [9, 20, 30, 40], 8);
    let wide = four(&place, "wide.png", [900, 2000, 3000, 4000], 16);
    let exr = place.radiance("a.exr", &film(1, 1.0), UNIT);
    for (image, reference) in [(&narrow, &wide), (&wide, &narrow), (&narrow, &exr)] {
        let said = refused(&place, &["estimate", image, "--reference", reference, "--quiet"]);
        assert!(said.contains(reference.as_str()) && (said.contains("one depth") || said.contains("pixels")), "{said}");
    }
    // A camera of 8 bits makes no frame of 16.
    place.write("scene.toml", &small("tsis-paper").replace("pixels = [48, 36]", "pixels = [2, 2]"));
    let said = refused(&place, &["run", "scene.toml", "--reference", &wide]);
    assert!(said.contains("wide.png"), "{said}");
}

#[test]
fn estimate_offers_no_baseline_that_it_cannot_make() {
    let place = Place::new();
    let image = four(&place, "a.png", [1, 2, 3, 4], 8);
    assert!(refused(&place, &["estimate", &image, "--subtract-baseline"]).contains("--subtract-baseline"));
}

#[test]
fn full_scale_can_be_declared_and_thresholds_are_shares_of_it() {
    let place = Place::new();
    let image = four(&place, "a.png", [16_383, 400, 300, 0], 16);
    let paper =
        |arguments: &[&str]| estimated(&place, &[&[image.as_str()], arguments].concat())["images"][0]["paper"].clone();
    assert_eq!(paper(&[])["saturated_pixels"], 0, "unknown to a file of 16 bits");
    assert_eq!(paper(&["--full-scale-bits", "14"])["saturated_pixels"], 1);
    let said = paper(&["--full-scale-bits", "14", "--threshold", "2%"]);
    assert_eq!((&said["threshold_grey"], &said["lit_pixels"]), (&Value::from(0.02 * 16_383.0), &Value::from(2)));
    assert_eq!(paper(&["--threshold", "2%"])["lit_pixels"], 1, "2 % of 65,535 is 1311");
    assert!(refused(&place, &["estimate", &image, "--full-scale-bits", "12"]).contains("row 1, column 1"));
    let narrow = four(&place, "narrow.png", [0; 4], 8);
    assert!(refused(&place, &["estimate", &narrow, "--full-scale-bits", "12"]).contains("has 8 bits"));
    let exr = place.radiance("a.exr", &film(1, 1.0), UNIT);
    assert!(refused(&place, &["estimate", &exr, "--threshold", "2%", "--quiet"]).contains("no full scale"));
    for bad in ["100%", "x%", "%", "-1", "65535"] {
        assert!(refused(&place, &["estimate", &image, "--threshold", bad]).contains("--threshold"), "{bad}");
    }
}

#[test]
fn the_camera_of_a_scene_gives_the_scale() {
    let place = Place::new();
    place.write("scene.toml", &small("tsis-paper").replace("pixels = [48, 36]", "pixels = [100, 80]"));
    let image = disc(&place, "disc.png", 20.0, 100);
    let said = estimated(&place, &[&image, "--exposure", "scene.toml"]);
    let inspected = json(&tirtouch_in(place.path(), &["inspect", "scene.toml", "--json"]));
    let scale = inspected["camera"]["mm_per_pixel"].as_f64().unwrap();
    let size = |said: &Value| said["images"][0]["paper"]["diameter_mm"]["value"].as_f64().unwrap();
    let pixels = said["images"][0]["paper"]["diameter_px"]["value"].as_f64().unwrap();
    assert!((size(&said) - pixels * scale).abs() < 1e-12 * size(&said), "{said}");
    place.write("calibration.toml", "mm_per_pixel = 0.5\n");
    let both = estimated(&place, &[&image, "--exposure", "scene.toml", "--calibration", "calibration.toml"]);
    assert_eq!(size(&both), 0.5 * pixels, "a calibration wins");
    let said = refused(&place, &["estimate", &image, "--exposure", "preset:tsis-paper"]);
    assert!(said.contains("100 x 80") && said.contains("disc.png"), "{said}");
}

/// A sensor is calibrated by its scene, and the file serves to read frames of it.
#[test]
fn a_scene_calibrates_its_sensor() {
    let place = Place::new();
    let scene = small("phantom-size-8mm").replace("[render]", "[render]\nspp = 16");
    let quick =
        scene.replace("exposure_ms = 0.7", "exposure_ms = 0.01").replace("[press]", "[press]\nresolution = 0.5");
    place.write("scene.toml", &quick);
    let output = tirtouch_in(place.path(), &["calibrate", "scene.toml", "-o", "sensor", "--json"]);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    let presses = said["presses"].as_array().unwrap();
    assert_eq!(presses.len(), 8);
    let of = |k: usize, key: &str| presses[k][key].as_f64().unwrap();
    assert!(
        (1..8).all(|k| of(k, "force_n") > of(k - 1, "force_n") && of(k, "sum_grey") > of(k - 1, "sum_grey")),
        "{said}"
    );
    let (rms, left_out) = (said["force"]["rms_n"].as_f64().unwrap(), said["force"]["left_out_rms_n"].as_f64().unwrap());
    assert!(rms > 0.0 && rms < left_out && left_out < 0.1, "{said}");
    // Not as deep as the deepest press of the calibration: noise would take every other frame of that beyond its range.
    place.write("pressed.toml", &quick.replace("4.0]", "3.8]"));
    let rendered = tirtouch_in(place.path(), &["run", "pressed.toml", "--without-inclusions", "-o", "run", "--json"]);
    assert_eq!(code(&rendered), 0, "{rendered:?}");
    let frame = shown(place.path().join("run/camera.png"));
    let file = shown(place.path().join("sensor/calibration.toml"));
    let earlier = json(&rendered)["earlier_frames"].as_array().unwrap()[0]["file"].as_str().unwrap().to_owned();
    let first = shown(place.path().join("run").join(earlier));
    let read = tirtouch_in(place.path(), &["estimate", &first, &frame, "--calibration", &file, "--json"]);
    assert_eq!(code(&read), 0, "{read:?}");
    let read = json(&read);
    let force = read["stiffness"]["force_n"]["value"].as_f64().unwrap_or_else(|| panic!("{read}"));
    let truth = json(&rendered)["mechanics"]["force_n"].as_f64().unwrap();
    // Between the noise of light of two images that share no photons, 65,536 each, and the law's own.
    assert!((force / truth - 1.0).abs() < 0.05, "{force} {truth}");
    let saturated = quick.replace("exposure_ms = 0.01", "exposure_ms = 100");
    for (name, text, key, words) in [
        ("bright.toml", &saturated, "camera.sensor.exposure_ms", "saturated"),
        ("flat.toml", &small("tsis-paper"), "press", "no [press]"),
    ] {
        place.write(name, text);
        let output = tirtouch_in(place.path(), &["calibrate", name, "-o", "none", "--json"]);
        assert_eq!((code(&output), &json(&output)["error"]["key"]), (2, &key.into()), "{output:?}");
        assert!(json(&output)["error"]["message"].as_str().unwrap().contains(words), "{output:?}");
        assert!(!place.path().join("none").exists());
    }
}
