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

/// Two phantoms, one of them hardly there, of a sweep in the scene's own folder.
fn small_study(place: &Place) {
    let base = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/calibrations/sensor.toml");
    place.write("sensor.toml", &std::fs::read_to_string(base).unwrap());
    let sweep = |extra: &str| {
        format!(
            "[sweep]\nscene = \"sensor.toml\"\ndesign = {{ kind = \"grid\" }}\n\
             images = {{ format = \"exr\", loads = \"all\" }}\n\
             [[vary]]\nkey = \"render.photons\"\nfixed = 60000\n\
             [[vary]]\nkey = \"press.resolution\"\nfixed = 0.5\n{extra}\n[[measure]]\nkind = \"force\"\n"
        )
    };
    let sizes = "[[vary]]\nkey = \"phantom.inclusion[0].shape.diameter_mm\"\nvalues = [8.0, 10.0]";
    place.write("phantoms.toml", &sweep(sizes));
    place.write("empty.toml", &sweep("[[vary]]\nkey = \"phantom.inclusion[0].material.youngs_kpa\"\nvalues = [5.0]"));
    let study = format!(
        "[study]\ncalibration = \"{CALIBRATION}\"\nphantoms = \"phantoms.toml\"\nempty = \"empty.toml\"\n\
         exposure_ms = 0.0778\nexposures = 2\n"
    );
    place.write("study.toml", &study);
}

#[test]
fn a_study_tells_true_against_estimated() {
    let place = Place::new();
    small_study(&place);
    let study =
        |more: &[&str]| tirtouch_in(place.path(), &[&["study", "study.toml", "--json", "--quiet"], more].concat());
    let output = study(&[]);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    assert_eq!((&said["phantoms"], &said["empty"]), (&2.into(), &1.into()), "{said}");
    let [size, depth, youngs] = ["size_mm", "depth_mm", "youngs_kpa"].map(|name| {
        let quantities = said["quantities"].as_array().unwrap();
        quantities.iter().find(|one| one["name"] == name).unwrap().clone()
    });
    for quantity in [&size, &depth, &youngs] {
        let undefined: u64 =
            quantity["reasons"].as_array().unwrap().iter().map(|one| one["phantoms"].as_u64().unwrap()).sum();
        assert_eq!(quantity["known"].as_u64().unwrap() + undefined, 2, "{quantity}");
        assert!(quantity["ranks"]["undefined"].is_string(), "two phantoms have no histogram: {quantity}");
    }
    let out = place.path().join("out/study");
    let table = std::fs::read_to_string(out.join("estimates.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 3 * 2, "{table}");
    assert!(table.starts_with("sweep,row,exposure,true_size_mm,true_depth_mm,true_youngs_kpa,"), "{table}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert_eq!(page.contains("Estimated against true size"), size["known"] != 0);
    // What is there is not computed again, and says the same.
    assert_eq!(json(&study(&[]))["quantities"], said["quantities"]);

    // A folder of something else stays as it is.
    std::fs::create_dir(place.path().join("other")).unwrap();
    place.write("other/report.html", "mine");
    let output = study(&["-o", "other"]);
    assert_eq!(
        (code(&output), std::fs::read_to_string(place.path().join("other/report.html")).unwrap().as_str()),
        (2, "mine")
    );

    let broken = |text: &str, why: &str| {
        place.write("broken.toml", text);
        let output = tirtouch_in(place.path(), &["study", "broken.toml"]);
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains(why), "{output:?}");
    };
    broken("[study]\nphantoms = \"phantoms.toml\"\nexposures = 0\n", "study.exposures");
    broken("[study]\nphantoms = \"phantoms.toml\"\nexposure_ms = -1.0\n", "study.exposure_ms");
    broken("[study]\nphantoms = \"phantoms.toml\"\ncalibration = \"none.json\"\n", "none.json");
    broken("[study]\nphantom = \"phantoms.toml\"\n", "phantom");
}

#[test]
fn bounds_of_a_protocol_fall_with_its_frames() {
    let place = Place::new();
    let bound = |more: &[&str]| {
        tirtouch_in(place.path(), &[&["calibrate", CALIBRATION, "--bound", "--json", "--quiet"], more].concat())
    };
    let of = |more: &[&str]| -> Vec<serde_json::Value> {
        let output = bound(more);
        assert_eq!(code(&output), 0, "{output:?}");
        json(&output)["bounds"].as_array().unwrap().clone()
    };
    let (one, many, dim) = (of(&[]), of(&["--frames", "8,8,8"]), of(&["--exposure-ms", "0.01"]));
    assert_eq!(one.len(), 27);
    let size = |row: &serde_json::Value, of: &str| row[of]["size"]["value"].as_f64().unwrap();
    for ((one, many), dim) in one.iter().zip(&many).zip(&dim) {
        assert!(size(one, "frames") > size(many, "frames") && size(one, "frames") < size(one, "calibrated"), "{one}");
        assert!(dim["frames"]["undefined"].is_string() || size(dim, "frames") > size(one, "frames"), "{dim}");
    }
    assert_eq!(code(&bound(&["--frames", "1,1"])), 2);
    assert_eq!(code(&tirtouch_in(place.path(), &["calibrate", CALIBRATION, "--frames", "1,1,1"])), 2);
}
