//! `frames`: computed and measured frames, and what is wrong with either.

use super::*;

/// The scan scene of the repository, coarse and with three positions.
fn scan() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/frames-galea.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.replace("from = -20.0, to = 20.0, count = 41", "from = -6.0, to = 6.0, count = 3");
    text.replace("frame_points = 129", "frame_points = 33") + "resolution = 0.25\n"
}

pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

const PICTURES: [&str; 6] = [
    "features_eccentricity.svg",
    "features_pressure.svg",
    "features_width.svg",
    "frame.svg",
    "frames.svg",
    "pressed.svg",
];

#[test]
fn a_scan_gives_frames_features_and_pictures() {
    let place = Place::new();
    place.write("scan.toml", &scan());
    let output = tirtouch_in(place.path(), &["frames", "scan.toml", "-o", "out/scan", "--json"]);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    assert_eq!((&said["scene"], &said["source"]), (&"frames-galea".into(), &"computed".into()));
    assert_eq!(said["positions_mm"], serde_json::json!([-6.0, 0.0, 6.0]));
    assert_eq!((&said["window_mm"], &said["shown_mm"], &said["places"]), (&10.0.into(), &0.0.into(), &33.into()));
    for key in ["dofs", "iterations", "seconds", "error_seconds"] {
        assert!(said["mechanics"][key].as_f64().unwrap() > 0.0, "{key}: {said}");
    }
    assert_eq!(said["mechanics"]["one_factorisation"], true);
    let error = said["mechanics"]["error"]["rms"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.1, "{said}");
    let feature = |k: usize, name: &str| said["features"][k][name].as_f64().unwrap();
    assert!(feature(1, "peak_kpa") > feature(0, "peak_kpa"), "{said}");
    assert!(feature(1, "fwhm_mm") < feature(0, "fwhm_mm"), "{said}");
    // The mesh mirrors to rounding.
    assert!((feature(0, "eccentricity") + feature(2, "eccentricity")).abs() < 1e-4, "{said}");
    let folder = place.path().join("out/scan");
    let mut expected =
        vec!["deformed.vtu", "features.csv", "frames.csv", "frames_without_inclusion.csv", "report.html"];
    expected.extend(["SHA256SUMS", "result.json", "scene.toml"]);
    expected.extend(PICTURES);
    expected.sort_unstable();
    assert_eq!(names(&folder), expected);
    let vtu = std::fs::read(folder.join("deformed.vtu")).unwrap();
    for field in ["contact_pressure_kpa", "contact_shear_kpa", "pressure_kpa", "least_jacobian", "stress_kpa"] {
        let name = format!("Name=\"{field}\"");
        assert!(vtu.windows(name.len()).any(|bytes| bytes == name.as_bytes()), "{field}");
    }
    let report = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(report.contains("What the phantom holds"), "its truth is not there");
    let again = tirtouch_in(place.path(), &["frames", "scan.toml", "-o", "out/scan"]);
    assert_eq!(code(&again), 2, "an existing folder stays");

    // Its own table is read back as measured frames.
    let table = shown(folder.join("frames.csv"));
    let flags = ["frames", "--measured", &table, "--window-mm", "10", "--json"];
    let output = tirtouch_in(place.path(), &flags);
    assert_eq!(code(&output), 0, "{output:?}");
    let read = json(&output);
    assert_eq!((&read["source"], &read["scene"]), (&"measured".into(), &"frames".into()));
    assert!(read["mechanics"]["undefined"].is_string());
    for k in 0..3 {
        for key in ["position_mm", "peak_kpa", "base_kpa", "center_mm", "fwhm_mm"] {
            assert_eq!(read["features"][k][key], said["features"][k][key], "{key}");
        }
    }
    let measured = names(&place.path().join("out/frames"));
    assert!(!measured.contains(&"deformed.vtu".to_owned()) && !measured.contains(&"pressed.svg".to_owned()));
    assert!(measured.contains(&"report.html".to_owned()) && measured.contains(&"frames.svg".to_owned()));
}

#[test]
fn frames_without_contact_have_undefined_features() {
    let place = Place::new();
    place.write("none.csv", "position_mm,x_mm,pressure_kpa\n-1,-1,0\n-1,0,0\n-1,1,0\n2,-1,1\n2,0,3\n2,1,1\n");
    let output = tirtouch_in(place.path(), &["frames", "--measured", "none.csv", "--json", "--show-mm", "2"]);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    assert_eq!(said["features"][0]["peak_kpa"]["undefined"], "there is no contact");
    assert_eq!(said["shown_mm"], 2.0);
    assert!((said["features"][1]["peak_kpa"].as_f64().unwrap() - 3.0).abs() < 1e-12, "{said}");
    assert_eq!(said["notes"].as_array().unwrap().len(), 2, "{said}");
    let quiet = tirtouch_in(place.path(), &["frames", "--measured", "none.csv", "--quiet", "--force"]);
    assert!(quiet.stderr.is_empty() && text(&quiet.stdout).contains("undefined: there is no contact"), "{quiet:?}");
}

#[test]
fn pressure_within_the_noise_does_not_cut_a_contact() {
    let place = Place::new();
    let mut table = "position_mm,x_mm,pressure_kpa\n".to_owned();
    for (position, x, pressure) in [
        (0, -2, 0.1),
        (0, -1, 3.0),
        (0, 0, 5.0),
        (0, 1, 3.0),
        (0, 2, 0.1),
        (1, -2, 0.0),
        (1, -1, 3.0),
        (1, 0, 5.0),
        (1, 1, 3.0),
        (1, 2, 0.0),
    ] {
        table.push_str(&format!("{position},{x},{pressure}\n"));
    }
    place.write("noisy.csv", &table);
    let notes = |noise: &str| {
        let flags = ["frames", "--measured", "noisy.csv", "--json", "--force", "--noise-kpa", noise];
        let output = tirtouch_in(place.path(), &flags);
        assert_eq!(code(&output), 0, "{output:?}");
        json(&output)["notes"].to_string()
    };
    assert!(notes("0").contains("1 frames end within the contact"), "{}", notes("0"));
    assert!(notes("0.05").contains("above the noise"), "{}", notes("0.05"));
    assert!(!notes("0.1").contains("end within"), "{}", notes("0.1"));
}

#[test]
fn wrong_use_of_frames_is_said() {
    let place = Place::new();
    place.write("scan.toml", &scan());
    for (flags, said) in [
        (&[][..], "<SCENE>"),
        (&["scan.toml", "--measured", "a.csv"], "--measured"),
        (&["scan.toml", "--window-mm", "0"], "--window-mm"),
        (&["scan.toml", "--noise-kpa", "-1"], "--noise-kpa"),
        (&["scan.toml", "--show-mm", "nan"], "--show-mm"),
        (&["scan.toml", "--calibration", "scan.toml"], "--calibration"),
        (&["--calibration", "scan.toml"], "<SCENE>"),
        (&["scan.toml", "--by-force"], "--invert"),
        (&["scan.toml", "--noise-share", "0.1"], "--invert"),
    ] {
        let output = tirtouch_in(place.path(), &[&["frames"], flags].concat());
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains(said), "{flags:?}: {output:?}");
        let output = tirtouch_in(place.path(), &[&["frames"], flags, &["--json"]].concat());
        assert_eq!(json(&output)["error"]["kind"], "usage", "{flags:?}");
    }
}

#[test]
fn bad_scans_and_tables_name_file_line_and_key() {
    let place = Place::new();
    let good = scan();
    place.write("typo.toml", &good.replace("depth_mm = 5.0", "dept_mm = 5.0"));
    place.write("tied.toml", &good.replace("kind = \"frictionless\"", "kind = \"tied\""));
    place.write("out.toml", &good.replace("depth_mm = 3.0", "depth_mm = 24.0"));
    place.write("sensor.toml", &small("tsis-paper"));
    let end = good.find("[scan]").unwrap();
    let second = "[[phantom.inclusion]]\nshape = { kind = \"sphere\", diameter_mm = 2.0 }\ndepth_mm = 3.0\ncenter_mm = [9.0, 0.0]\n\
        material = { law = \"linear\", youngs_kpa = 50.0 }\n";
    place.write("two.toml", &format!("{}{second}{}", &good[..end], &good[end..]));
    place.write("bad.csv", "position_mm,x_mm,pressure_kpa\n0,0,1\n0,1,nan\n");
    place.write("one.csv", "position_mm,x_mm,pressure_kpa\n0,0,1\n");
    let before = place.names();
    for (arguments, file, line, key, said) in [
        (&["typo.toml"][..], "typo.toml", true, Some("scan.dept_mm"), "did you mean depth_mm"),
        (&["tied.toml"], "tied.toml", true, Some("scan.interface"), "frictionless"),
        (&["out.toml"], "out.toml", true, None, ""),
        (&["sensor.toml"], "sensor.toml", true, None, ""),
        (&["missing.toml"], "missing.toml", false, None, "missing.toml"),
        (&["frames-galea.toml"], "frames-galea.toml", false, None, "preset:frames-galea"),
        (&["two.toml", "--invert"], "two.toml", false, Some("phantom.inclusion"), "one inclusion"),
        (&["--measured", "bad.csv"], "bad.csv", true, None, "pressure_kpa"),
        (&["--measured", "one.csv"], "one.csv", true, None, "places"),
        (&["--measured", "none.csv"], "none.csv", false, None, "cannot be read"),
    ] {
        let output = tirtouch_in(place.path(), &[&["frames"], arguments, &["--json"]].concat());
        assert_eq!(code(&output), 2, "{output:?}");
        let error = &json(&output)["error"];
        assert_eq!((&error["kind"], &error["file"]), (&"input".into(), &file.into()), "{error}");
        assert!(error["message"].as_str().unwrap().contains(said), "{error}");
        assert_eq!(error["line"].is_u64(), line, "{error}");
        if let Some(key) = key {
            assert_eq!(error["key"], key);
        }
        assert_eq!(place.names(), before, "nothing is written");
    }
}

/// Frames that were computed of one tissue are inverted from a guess of another, from the table as from the scene.
#[test]
fn the_tissue_behind_frames_is_estimated() {
    let place = Place::new();
    let scan = scan().replace("from = -6.0, to = 6.0, count = 3", "from = -16.0, to = 16.0, count = 9");
    let scan = scan.replace("frame_points = 33", "frame_points = 97").replace("resolution = 0.25", "resolution = 0.5");
    place.write("guess.toml", &scan);
    place.write(
        "truth.toml",
        &scan.replace("height_mm = 25.0", "height_mm = 21.0").replace("youngs_kpa = 12.8", "youngs_kpa = 9.0"),
    );
    let truth = tirtouch_in(place.path(), &["frames", "truth.toml", "-o", "truth", "--invert", "--json"]);
    assert_eq!(code(&truth), 0, "{truth:?}");
    let table = shown(place.path().join("truth/frames.csv"));
    let flags = ["frames", "--measured", &table, "--calibration", "guess.toml", "-o", "found", "--json"];
    let measured = tirtouch_in(place.path(), &flags);
    assert_eq!(code(&measured), 0, "{measured:?}");
    for (output, report) in [(truth, "truth/report.html"), (measured, "found/report.html")] {
        let said = json(&output);
        let tissue = &said["tissue"];
        for (key, value) in [("thickness_mm", 21.0), ("tissue_youngs_kpa", 9.0), ("radius_mm", 5.0)] {
            let number = |part: &str| tissue[key][part].as_f64().unwrap_or_else(|| panic!("{key}: {tissue}"));
            assert!((number("value") / value - 1.0).abs() < 0.03, "{key}: {tissue}");
            assert!(number("low") < number("value") && number("value") < number("high"), "{tissue}");
        }
        assert_eq!((&tissue["held"], tissue["fitted"].as_array().unwrap().len()), (&"depth".into(), 9));
        let report = std::fs::read_to_string(place.path().join(report)).unwrap();
        assert!(report.contains("The tissue that fits") && report.contains("Correlation of their errors"));
    }
}
