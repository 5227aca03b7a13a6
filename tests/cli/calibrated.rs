//! Size, depth and modulus of an inclusion by the calibration that comes with the program.

use super::*;
use tirtouch::image_io::{read_grey, write_png_grey};

const CALIBRATION: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/calibrations/phantoms.json");

#[test]
fn a_phantom_is_estimated_and_its_frames_say_the_same_from_anywhere() {
    let place = Place::new();
    let flags = ["--photons", "500000", "--spp", "16", "--json", "--quiet"];
    let run = |scene: &str, more: &[&str]| {
        let output = tirtouch_in(place.path(), &[&["run", scene][..], &flags, more].concat());
        assert_eq!(code(&output), 0, "{output:?}");
        json(&output)
    };
    let said = run("preset:phantom-size-8mm", &[]);
    let estimates = &said["estimates"];
    assert_eq!(estimates["detected"], true, "{estimates}");
    for (key, truth) in [("size_mm", 8.0), ("depth_mm", 5.0)] {
        let at = |end: &str| estimates[key][end].as_f64().unwrap();
        assert!(at("low") <= truth && truth <= at("high"), "{key}: {estimates}");
        // An interval that says something: the calibration knows 3.8 to 14.5 mm, and depths of 1.9 to 11.3 mm.
        assert!(at("high") - at("low") < 0.5 * truth, "{key}: {estimates}");
    }

    let out = place.path().join("out/phantom-size-8mm");
    let images = ["camera_1mm.png", "camera_2mm.png", "camera.png"].map(|name| shown(out.join(name)));
    let of_images = |more: &[&str]| {
        let images = images.each_ref().map(String::as_str);
        tirtouch_in(place.path(), &[&["estimate", "--json", "--calibration", CALIBRATION][..], &images, more].concat())
    };
    let output = of_images(&["--depths-mm", "1,2,4"]);
    assert_eq!(code(&output), 0, "{output:?}");
    assert_eq!(json(&output)["estimates"], *estimates);
    // Depths that the calibration does not know, and too few of them.
    let other = json(&of_images(&["--depths-mm", "1.5,2.5,5"]));
    assert!(other["estimates"]["size_mm"]["undefined"].as_str().unwrap().contains("1, 2, 4 mm deep"), "{other}");
    assert_eq!(code(&of_images(&["--depths-mm", "1,2"])), 2);

    // The same frames half as bright, and as levels of 16 bits: neither is read as a phantom.
    let other = |name: &str, bits: u32, level: fn(f64) -> f64| {
        let changed = images.each_ref().map(|image| {
            let frame = read_grey(Path::new(image)).unwrap();
            let levels: Vec<u16> = frame.values.iter().map(|grey| level(*grey).round() as u16).collect();
            let file = place.path().join(format!("{name}-{}", Path::new(image).file_name().unwrap().to_str().unwrap()));
            write_png_grey(&file, 348, 261, &levels, bits).unwrap();
            shown(file)
        });
        let changed = changed.each_ref().map(String::as_str);
        let asked = [&["estimate", "--json", "--calibration", CALIBRATION][..], &changed, &["--depths-mm", "1,2,4"]];
        json(&tirtouch_in(place.path(), &asked.concat()))["estimates"].clone()
    };
    let dim = other("dim", 8, |grey| 0.5 * grey);
    assert!(dim["detected"]["undefined"].is_string() && dim["size_mm"]["undefined"].is_string(), "{dim}");
    let deep = other("deep", 16, |grey| 257.0 * grey);
    assert!(deep["detected"]["undefined"].as_str().unwrap().contains("65535"), "{deep}");

    // The same phantom without its inclusion: none is found.
    let none = run("preset:phantom-size-8mm", &["--without-inclusions", "-o", "none"]);
    assert_eq!(none["estimates"]["detected"], false, "{}", none["estimates"]);
    assert!(none["estimates"]["size_mm"]["undefined"].is_string());
}

#[test]
fn a_calibration_of_another_sensor_or_of_nothing_is_said() {
    let place = Place::new();
    let flags = ["--set", "stack.layer[0].n=1.42", "--set", "camera.pixels[0]=29", "--set", "camera.pixels[1]=29"];
    let flags = [&flags[..], &["--photons", "20000", "--spp", "16", "--backend", "cpu", "--json", "--quiet"]].concat();
    let output = tirtouch_in(place.path(), &[&["run", "preset:phantom-size-8mm"][..], &flags].concat());
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    let why = said["estimates"]["size_mm"]["undefined"].as_str().unwrap();
    assert!(why.contains("no calibrated model") && why.contains("another"), "{why}");

    let whole = std::fs::read_to_string(CALIBRATION).unwrap();
    place.write("image.txt", "");
    for (name, text) in [("cut.json", &whole[..whole.len() / 2]), ("empty.json", "{}"), ("list.json", "[1, 2]")] {
        place.write(name, text);
        let output = tirtouch_in(place.path(), &["estimate", "image.txt", "--calibration", name, "--depths-mm", "1"]);
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains("is no calibration"), "{output:?}");
    }
    // Parts of other lengths than the rest.
    let shorter = whole.replacen("\"elements\":[[0,", "\"elements\":[[0,0],[0,", 1);
    assert_ne!(shorter, whole);
    place.write("longer.json", &shorter);
    let output =
        tirtouch_in(place.path(), &["estimate", "image.txt", "--calibration", "longer.json", "--depths-mm", "1"]);
    assert_eq!(code(&output), 2, "{output:?}");
}
