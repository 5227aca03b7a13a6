//! What is wrong with a scene or its place is one line and exit code 2, and nothing is written.

use super::*;

/// `render` of a scene text beside the files of `place` fails; gives the line and the JSON object of the error.
fn refusal(place: &Place, scene: &str, flags: &[&str]) -> (String, Value) {
    place.write("scene.toml", scene);
    let before = place.names();
    let arguments = [&["render", "scene.toml"], flags].concat();
    let output = tirtouch_in(place.path(), &arguments);
    assert_eq!(code(&output), 2, "{output:?}");
    assert!(output.stdout.is_empty(), "{output:?}");
    let output = tirtouch_in(place.path(), &[&arguments[..], &["--json"]].concat());
    assert_eq!(code(&output), 2, "{output:?}");
    assert_eq!(place.names(), before, "nothing is written");
    let error = json(&output)["error"].clone();
    assert_eq!(error["message"], one_line(&output));
    (one_line(&output).to_owned(), error)
}

fn without_layers() -> String {
    let text = small("tsis-paper");
    let (head, rest) = text.split_once("[[stack.layer]]").unwrap();
    let (_, tail) = rest.split_once("[[led]]").unwrap();
    format!("{head}layer = []\n\n[[led]]{tail}")
}

#[test]
fn mistakes_in_a_scene_name_file_line_and_key() {
    let good = small("tsis-paper");
    let cases = [
        (good.replacen("wavelength_nm", "wavelenght_nm", 1), "light.wavelenght_nm", "did you mean wavelength_nm"),
        (good.replacen("thickness_mm = 2.0", "thickness_mm = -2.0", 1), "stack.layer[0].thickness_mm", "-2"),
        (good.replacen("n = 1.41", "n = 0.9", 1), "stack.layer[0].n", "0.9"),
        (without_layers(), "stack.layer", ""),
        (good.replacen("distance_mm = 17.32", "distance_mm = -1.0", 1), "camera.distance_mm", "inside the glass"),
        (good.replacen("height_mm = 6.0", "height_mm = 11.0", 1), "led[0].height_mm", ""),
        (good.replacen("exposure_ms = 10.0", "exposure_ms = \"long\"", 1), "camera.sensor.exposure_ms", "a number"),
    ];
    for (scene, key, said) in cases {
        let place = Place::new();
        let (line, error) = refusal(&place, &scene, &[]);
        assert!(line.starts_with("scene.toml:") && line.contains(key) && line.contains(said), "{key}: {line}");
        assert_eq!(
            (&error["kind"], &error["file"], &error["key"]),
            (&"input".into(), &"scene.toml".into(), &key.into())
        );
        assert!(error["line"].as_u64().unwrap() > 1, "{error}");
    }
}

fn with_height_map(file: &str) -> String {
    small("tsis-paper")
        + &format!("\n[touch]\nshape = {{ kind = \"height_map\", file = \"{file}\", scale_mm = 0.1 }}\n")
}

#[test]
fn mistakes_in_a_height_map_name_it() {
    let place = Place::new();
    place.write("nan.csv", "0,0,0\n0,nan,0\n0,0,0\n");
    let whole = place.radiance("whole.exr", &film(1, 1.0), UNIT);
    let mut cut = std::fs::read(whole).unwrap();
    cut.truncate(cut.len() / 2);
    std::fs::write(place.path().join("cut.exr"), cut).unwrap();
    for (file, said) in [("nan.csv", "row 2, column 2"), ("cut.exr", "damaged"), ("missing.csv", "not a file")] {
        let (line, error) = refusal(&place, &with_height_map(file), &[]);
        assert!(line.contains(file) && line.contains(said), "{line}");
        assert_eq!(error["key"], "touch.shape.file");
    }
}

#[test]
fn a_dent_through_the_stack_names_the_scene_and_the_key() {
    let place = Place::new();
    let dented = small("tsis-paper")
        + "\n[touch]\nshape = { kind = \"gaussian_dent\", depth_mm = 3.0, sigma_mm = 2.0 }\ninner = \"flat\"\n";
    let (line, error) = refusal(&place, &dented, &[]);
    assert!(line.starts_with("scene.toml:"), "{line}");
    assert!(error["key"].as_str().unwrap().starts_with("touch.shape"), "{error}");
}

#[test]
fn scenes_that_are_not_there_are_named() {
    let place = Place::new();
    for (scene, said) in [
        ("missing.toml", "missing.toml"),
        ("scenes/tsis-paper.toml", "preset:tsis-paper"),
        ("preset:tsis", "tsis-paper, "),
        (".", ""),
    ] {
        for command in ["render", "run", "inspect"] {
            let output = tirtouch_in(place.path(), &[command, scene]);
            assert_eq!(code(&output), 2, "{output:?}");
            assert!(one_line(&output).contains(said), "{output:?}");
        }
    }
    assert!(place.names().is_empty());
}

#[test]
fn places_that_cannot_be_written_are_refused_before_the_work() {
    let place = Place::new();
    place.write("file", "");
    std::fs::create_dir(place.path().join("taken")).unwrap();
    for (out, said) in [("file/out", "no folder can be made"), ("taken", "--force"), ("file", "exists")] {
        let (line, error) = refusal(&place, &small("tsis-paper"), &["-o", out, "--spp", "1000000"]);
        assert!(line.contains(said), "{line}");
        assert_eq!(error["kind"], "input");
    }
}

#[test]
fn flags_that_do_not_suit_are_wrong_use() {
    let place = Place::new();
    for (flags, said) in [
        (&["--integrator", "map"][..], "tissue"),
        (&["--backend", "gpu", "--precision", "f64"], "f32"),
        (&["--seconds", "1", "--spp", "4"], "--spp"),
        (&["--seconds", "1", "--target-error", "0.1"], "--target-error"),
    ] {
        let (line, error) = refusal(&place, &small("tsis-paper"), flags);
        assert!(line.contains(said), "{line}");
        assert_eq!(error["kind"], "usage");
    }
}

#[test]
fn references_of_another_size_are_refused_before_the_work() {
    let place = Place::new();
    place.write("scene.toml", &small("press-hertz"));
    tirtouch::image_io::write_png_grey(&place.path().join("small.png"), 2, 2, &[0; 4], 8).unwrap();
    let output = tirtouch_in(place.path(), &["run", "scene.toml", "--reference", "small.png", "--spp", "1000000"]);
    assert_eq!(code(&output), 2, "{output:?}");
    assert!(one_line(&output).contains("2 x 2 pixels, the camera 48 x 36"), "{output:?}");
    assert!(!place.path().join("out/press-hertz").exists());
}

#[test]
fn every_mistake_of_a_scene_is_said_one_on_a_line() {
    let place = Place::new();
    place.write("scene.toml", &small("tsis-paper").replace("n = 1.41", "n = 0.5").replace("n = 1.39", "n = 9.0"));
    let output = tirtouch_in(place.path(), &["render", "scene.toml", "--json"]);
    assert_eq!(code(&output), 2, "{output:?}");
    let said = text(&output.stderr);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 3, "{said}");
    assert!(lines.iter().all(|line| line.starts_with("tirtouch: ")), "{said}");
    assert!(lines[0].contains("stack.layer[0].n") && lines[1].ends_with("and 1 more:"), "{said}");
    assert!(lines[2].contains("scene.toml:") && lines[2].contains("stack.layer[2].n"), "{said}");
    let all = json(&output);
    assert_eq!(all["error"], all["errors"][0]);
    let keys: Vec<_> = all["errors"].as_array().unwrap().iter().map(|error| error["key"].clone()).collect();
    assert_eq!(keys, ["stack.layer[0].n", "stack.layer[2].n"]);
    for key in ["kind", "message", "file", "line", "key"] {
        assert!(!all["errors"][1][key].is_null(), "{key}");
    }
}
