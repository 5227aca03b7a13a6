//! `render`, `run` and `demo` on small scenes.

use super::*;
use tirtouch::image_io::{read_grey, read_radiance};

const LEDGER: [&str; 9] = [
    "emitted",
    "absorbed",
    "escaped_top",
    "escaped_bottom",
    "escaped_sides",
    "detected",
    "terminated",
    "roulette",
    "residual",
];

fn scene(place: &Place, name: &str) {
    place.write("scene.toml", &small(name));
}

/// Keys that design and docs fix for whatever renders.
fn check_render_keys(said: &Value) {
    for key in ["backend", "adapter", "integrator", "why", "scene", "out"] {
        assert!(said[key].is_string(), "{key}: {said}");
    }
    for key in [
        "seconds",
        "setup_seconds",
        "paths",
        "segments",
        "segments_per_second",
        "mean_radiance",
        "absolute_error",
        "spp",
        "photons",
        "replicates",
        "seed",
    ] {
        assert!(said[key].is_number(), "{key}: {said}");
    }
    for key in LEDGER {
        assert!(said["ledger"][key].is_number(), "{key}: {said}");
    }
    assert!(said["ledger"]["residual"].as_f64().unwrap().abs() <= 1e-6);
    assert!(said["ledger"]["terminated"].as_f64().unwrap() <= 1e-4);
}

#[test]
fn the_flat_sensor_is_exactly_dark() {
    let place = Place::new();
    scene(&place, "tsis-paper");
    let output = tirtouch_in(place.path(), &["render", "scene.toml", "--json", "--backend", "cpu"]);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    check_render_keys(&said);
    assert_eq!(said["mean_radiance"], 0.0);
    assert!(said["relative_error"]["undefined"].is_string());
    assert!(said["known_dark"].is_string() && said["absolute_error"] == 0.0, "{said}");
    assert!(said["camera"]["suggested_exposure_ms"]["undefined"].is_string());
    assert_eq!(said["mean_radiance_below"], 0.0, "what geometry forbids needs no bound");
    let (film, provenance) = read_radiance(&place.path().join("out/tsis-paper/radiance.exr")).unwrap();
    assert!(film.mean.iter().all(|&v| v == 0.0));
    let provenance = provenance.unwrap();
    assert_eq!((provenance.unit.as_str(), provenance.scene_name.as_str()), (UNIT, "tsis-paper"));
    assert_eq!((provenance.scene_sha256.len(), provenance.integrator.as_str()), (64, "path"));
}

/// 64 paths that find nothing on a disc that glows: the error holds what they missed, in JSON and in the file.
#[test]
fn a_film_without_light_has_an_error() {
    let place = Place::new();
    place.write("scene.toml", &small("contact-disc").replace("pixels = [48, 36]", "pixels = [2, 2]"));
    let render = |flags: &[&str]| {
        let always = ["render", "scene.toml", "--json", "--quiet", "--force", "--backend", "cpu", "-o", "image"];
        let output = tirtouch_in(place.path(), &[&always, flags].concat());
        assert_eq!(code(&output), 0, "{output:?}");
        json(&output)
    };
    let truth = render(&["--spp", "256", "--photons", "100000"])["mean_radiance"].as_f64().unwrap();
    let dark = |seed: u32| render(&["--integrator", "path", "--spp", "1", "--seed", &seed.to_string()]);
    let said = (1..20).map(dark).find(|said| said["mean_radiance"] == 0.0).unwrap();
    assert!(said["known_dark"].is_null() && said["relative_error"]["undefined"].is_string(), "{said}");
    let bound = |key: &str| said[key].as_f64().unwrap();
    assert!(truth > 0.0 && bound("absolute_error") > truth && bound("mean_radiance_below") > truth, "{truth}: {said}");
    let file = exr::prelude::read_first_flat_layer_from_file(place.path().join("image/radiance.exr")).unwrap();
    let variances: Vec<f32> = file.layer_data.channel_data.list[1].sample_data.values_as_f32().collect();
    assert!(variances.iter().all(|v| 1.96 * f64::from(*v).sqrt() > truth), "{variances:?}");
    // Replicates of nothing have no variance: that is how two films are compared.
    let (film, _) = read_radiance(&place.path().join("image/radiance.exr")).unwrap();
    assert_eq!(film.variance, [0.0; 4]);
}

#[test]
fn the_dented_sensor_lights_up() {
    let place = Place::new();
    scene(&place, "tsis-dent");
    let output = tirtouch_in(place.path(), &["render", "scene.toml", "-o", "deep/er", "--json"]);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    check_render_keys(&said);
    assert!(said["mean_radiance"].as_f64().unwrap() > 0.01 && said["relative_error"].is_number(), "{said}");
    let edges: Vec<_> =
        said["block_errors"].as_array().unwrap().iter().map(|block| block["edge_pixels"].clone()).collect();
    assert_eq!(edges, [4, 16, 64, 0]);
    assert!(said["block_errors"][0]["relative_error"].as_f64() < said["relative_error"].as_f64(), "{said}");
    let mut names: Vec<String> = std::fs::read_dir(place.path().join("deep/er"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let own = ["SHA256SUMS", "camera.png", "radiance.exr", "radiance.svg", "relief.svg", "result.json", "scene.toml"];
    assert_eq!(names, [&own[..], &["side.svg"]].concat());
    let again = tirtouch_in(place.path(), &["render", "scene.toml", "-o", "deep/er"]);
    assert_eq!(code(&again), 2, "an existing folder stays");
}

#[test]
fn one_seed_gives_one_image_and_another_seed_another() {
    let place = Place::new();
    scene(&place, "press-hertz");
    let image = |name: &str, seed: &str| {
        let flags = ["--spp", "16", "--photons", "20000", "--backend", "cpu", "--seed", seed, "-o", name, "--quiet"];
        let output = tirtouch_in(place.path(), &[&["render", "scene.toml"], &flags[..]].concat());
        assert_eq!(code(&output), 0, "{output:?}");
        std::fs::read(place.path().join(name).join("radiance.exr")).unwrap()
    };
    let first = image("a", "1");
    assert!(first == image("b", "1"));
    assert!(first != image("c", "2"));
}

#[test]
fn run_measures_what_the_camera_sees() {
    let place = Place::new();
    scene(&place, "press-hertz");
    let flags = ["run", "scene.toml", "--json", "--spp", "16", "--photons", "200000", "--backend", "cpu"];
    let output = tirtouch_in(place.path(), &flags);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    check_render_keys(&said);
    for key in ["max_grey", "sum_grey", "lit_pixels", "mm_per_pixel"] {
        assert!(said["camera"][key].as_f64().unwrap() > 0.0, "{key}: {said}");
    }
    let size = &said["paper"]["diameter_mm"];
    let diameter = &said["paper"]["diameter_px"];
    // The same figure, in pixels and in millimetres.
    let scale = said["camera"]["mm_per_pixel"].as_f64().unwrap();
    let ratio = size["value"].as_f64().unwrap() / diameter["value"].as_f64().unwrap();
    assert!((ratio / scale - 1.0).abs() < 1e-12, "{said}");
    assert!(size["low"].as_f64().unwrap() <= size["value"].as_f64().unwrap());
    // The bump is in the middle of the 48 x 36 pixels.
    let centroid = &said["paper"]["centroid_px"]["value"];
    assert!((centroid[0].as_f64().unwrap() - 24.0).abs() < 1.0, "{centroid}");
    assert!((centroid[1].as_f64().unwrap() - 18.0).abs() < 1.0, "{centroid}");
    assert!(said["paper"]["h_grey"]["value"].as_f64().unwrap() > 20.0);
    for key in ["size_mm", "depth_mm", "youngs_kpa"] {
        assert!(said["estimates"][key]["undefined"].as_str().unwrap().contains("no calibrated model"), "{key}: {said}");
        assert!(said["truth"][key]["undefined"].as_str().unwrap().contains("no phantom"), "{key}: {said}");
    }
    assert!(said["paper"]["intervals"].as_str().unwrap().contains("light and camera"), "{said}");
    assert!(said["mechanics"]["undefined"].is_string());

    let out = place.path().join("out/press-hertz");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    let picture = std::fs::read_to_string(out.join("radiance.svg")).unwrap();
    for written in [&page, &picture] {
        assert!(written.contains(UNIT) && !written.contains("m²"), "one way to write a unit");
    }
    assert!(page.contains("What the camera sees") && page.contains("size"));
    assert!(out.join("camera_false_color.svg").is_file() && out.join("camera_relief.svg").is_file());
    let seen = read_grey(&out.join("camera.png")).unwrap();
    assert_eq!(seen.values.iter().sum::<f64>(), said["camera"]["sum_grey"].as_f64().unwrap());

    // Less itself nothing is left: no lit area.
    let frame = shown(out.join("camera.png"));
    let output = tirtouch_in(place.path(), &[&flags[..], &["--reference", &frame, "-o", "less"]].concat());
    assert_eq!(code(&output), 0, "{output:?}");
    let less = json(&output);
    assert!(less["paper"]["diameter_mm"]["undefined"].is_string(), "{less}");
    assert_eq!(less["camera"]["sum_grey"], said["camera"]["sum_grey"], "the camera's own figures are of the raw frame");
}

#[test]
fn demo_replaces_its_own_folder_and_no_other() {
    let place = Place::new();
    let out = place.path().join("out/demo");
    std::fs::create_dir_all(&out).unwrap();
    std::fs::write(out.join("mine.txt"), "mine").unwrap();
    let flags = ["demo", "--spp", "1", "--photons", "50000", "--backend", "cpu"];
    let refused = tirtouch_in(place.path(), &flags);
    assert_eq!(code(&refused), 2, "{refused:?}");
    assert!(one_line(&refused).contains("mine.txt") && out.join("mine.txt").exists());

    std::fs::remove_dir_all(&out).unwrap();
    scene(&place, "dent-cap");
    let before = ["render", "scene.toml", "--spp", "1", "--backend", "cpu", "--quiet", "-o", "out/demo"];
    assert_eq!(code(&tirtouch_in(place.path(), &before)), 0);
    let output = tirtouch_in(place.path(), &flags);
    assert_eq!(code(&output), 0, "what a run before has written is replaced: {output:?}");
    assert!(text(&output.stdout).trim_end().ends_with("Open out/demo/report.html in a browser."), "{output:?}");
    assert!(std::fs::read(out.join("report.html")).unwrap().len() > 10_000);
}

/// An asked error below that of the least work is reached, and missed from below by less than a factor of 1.5.
#[test]
fn an_asked_error_is_reached_and_not_far_below() {
    let place = Place::new();
    for (name, asked) in [("flat-bonded", "0.1"), ("contact-disc", "0.05"), ("phantom-size-8mm", "0.02")] {
        place.write("scene.toml", &small(name).replace("depths_mm = [1.0, 2.0, 4.0]", "depths_mm = [1.0]"));
        let flags = ["render", "scene.toml", "--target-error", asked, "--force", "--json", "--quiet"];
        let output = tirtouch_in(place.path(), &flags);
        assert_eq!(code(&output), 0, "{output:?}");
        let said = json(&output);
        let (found, asked) = (said["relative_error"].as_f64().unwrap(), asked.parse::<f64>().unwrap());
        assert!(found <= asked && found > asked / 1.5, "{name}: {found} for {asked}");
    }
}

/// Ctrl-C in the middle: exit code 3, one line, and nothing is left.
#[cfg(unix)]
#[test]
fn a_stopped_render_leaves_nothing() {
    let place = Place::new();
    scene(&place, "tsis-dent");
    let out = place.path().join("out");
    let entries = || std::fs::read_dir(&out).map_or(0, Iterator::count);
    // The folder in the making is there once the signal is listened for.
    let arguments = ["render", "scene.toml", "--spp", "100000000", "--backend", "cpu", "--quiet"];
    let output = interrupted(&place, &arguments, &|| entries() > 0);
    assert_eq!(code(&output), 3, "{output:?}");
    assert!(one_line(&output).contains("stopped"), "{output:?}");
    assert_eq!(entries(), 0);
}

/// Ctrl-C in the middle of a ladder: what was done is kept, and the line says how to go on.
#[cfg(unix)]
#[test]
fn a_stopped_ladder_keeps_its_rungs() {
    let place = Place::new();
    scene(&place, "flat-bonded");
    let items = place.path().join("ladders/items");
    let kept = || std::fs::read_dir(&items).map_or(0, Iterator::count);
    let arguments = ["converge", "scene.toml", "--spp", "16384", "-o", "ladders", "--backend", "cpu", "--quiet"];
    let output = interrupted(&place, &arguments, &|| items.exists());
    assert_eq!(code(&output), 3, "{output:?}");
    assert!(one_line(&output).contains("--resume"), "{output:?}");
    assert!(kept() < 3);
}

/// Runs the program and stops it by Ctrl-C once `ready`.
#[cfg(unix)]
fn interrupted(place: &Place, arguments: &[&str], ready: &dyn Fn() -> bool) -> std::process::Output {
    use std::process::Stdio;
    use std::time::{Duration, Instant};
    let mut command = Command::new(env!("CARGO_BIN_EXE_tirtouch"));
    command.args(arguments).current_dir(place.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    let begun = Instant::now();
    while !ready() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

/// A camera of few pixels matches few photons: an asked time and an asked error still send enough.
#[test]
fn few_pixels_see_the_same_light_for_a_time_or_an_error() {
    let place = Place::new();
    place.write("scene.toml", &small("contact-disc").replace("pixels = [48, 36]", "pixels = [2, 2]"));
    let seen = |flag: &str, value: &str| {
        let output = tirtouch_in(place.path(), &["render", "scene.toml", flag, value, "--force", "--json", "--quiet"]);
        assert_eq!(code(&output), 0, "{output:?}");
        let said = json(&output);
        ["mean_radiance", "absolute_error", "photons"].map(|key| said[key].as_f64().unwrap())
    };
    let exact = seen("--spp", "4096");
    for (flag, value, photons) in [("--seconds", "0.3", 3.0 * 4096.0), ("--target-error", "0.1", 65_537.0)] {
        let found = seen(flag, value);
        assert!((found[0] - exact[0]).abs() < 5.0 * found[1].hypot(exact[1]), "{flag}: {found:?} for {exact:?}");
        assert!(found[2] >= photons, "{flag}: {} photons", found[2]);
    }
}

#[test]
fn expose_repeats_the_frame_of_a_rendered_folder_and_makes_others() {
    let place = Place::new();
    scene(&place, "tsis-dent");
    let run = |arguments: &[&str]| {
        let output = tirtouch_in(place.path(), arguments);
        assert_eq!(code(&output), 0, "{output:?}");
        output
    };
    let flags = ["--spp", "16", "--photons", "20000", "--backend", "cpu", "--seed", "9", "-o", "a", "--json"];
    let rendered = json(&run(&[&["render", "scene.toml"], &flags[..]].concat()));
    let frame = |name: &str| std::fs::read(place.path().join(name).join("camera.png")).unwrap();
    let again = json(&run(&["expose", "a", "-o", "same", "--json"]));
    assert!(frame("a") == frame("same"), "the same exposure and seed");
    assert_eq!(again["camera"], rendered["camera"]);
    assert_eq!(again["bit_depth"], 8);
    run(&["expose", "a", "--scene", "scene.toml", "-o", "other", "--seed", "10", "--quiet"]);
    assert!(frame("a") != frame("other"), "the seed is the noise's");

    // A scene that says the flags' exposure and depth makes the same frame, and at the suggested time nothing is noted.
    let suggested = rendered["camera"]["suggested_exposure_ms"].as_f64().unwrap();
    let output = run(&[
        "expose",
        "a",
        "--scene",
        "scene.toml",
        "-o",
        "b",
        "--exposure-ms",
        &suggested.to_string(),
        "--bit-depth",
        "12",
    ]);
    assert!(!text(&output.stderr).contains("would suit"), "{output:?}");
    let seen = read_grey(&place.path().join("b/camera.png")).unwrap();
    let most = seen.values.iter().copied().fold(0.0, f64::max);
    assert!(most > 0.6 * 4095.0, "12 bits in a file of 16: {most}");
    let kept = tirtouch::scene::load(&place.path().join("b/scene.toml")).unwrap().scene.camera.sensor;
    assert_eq!((kept.exposure_ms, kept.bit_depth), (suggested, 12), "the scene is that of the frame");
    let faint =
        run(&["expose", "a", "--scene", "scene.toml", "-o", "c", "--exposure-ms", &(0.01 * suggested).to_string()]);
    assert!(one_line(&faint).contains("too dark") && one_line(&faint).contains("would suit"), "{faint:?}");
    let bright =
        run(&["expose", "a", "--scene", "scene.toml", "-o", "d", "--exposure-ms", &(3.0 * suggested).to_string()]);
    assert!(one_line(&bright).contains("saturated"), "{bright:?}");
}

#[test]
fn expose_says_what_it_lacks() {
    let place = Place::new();
    place.radiance("a.exr", &film(1, 1.0), UNIT);
    place.write("scene.toml", &small("tsis-paper").replace("pixels = [48, 36]", "pixels = [32, 32]"));
    place.write("other.toml", &small("tsis-paper"));
    for (arguments, named) in [
        (&["a.exr"][..], "--scene"),
        (&["missing", "--scene", "scene.toml"], "missing"),
        (&["a.exr", "--scene", "other.toml"], "32 x 32"),
        (&["a.exr", "--scene", "scene.toml", "--exposure-ms", "-1"], "--exposure-ms"),
        (&["a.exr", "--scene", "scene.toml", "--bit-depth", "20"], "bit_depth"),
    ] {
        let output = tirtouch_in(place.path(), &[&["expose", "--quiet"], arguments].concat());
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains(named), "{output:?}");
        assert!(!place.path().join("out").exists());
    }
    let foreign =
        tirtouch_in(place.path(), &["expose", "a.exr", "--scene", "scene.toml", "-o", "b", "--exposure-ms", "5"]);
    assert_eq!(code(&foreign), 0, "{foreign:?}");
    assert!(one_line(&foreign).contains("another scene"), "{foreign:?}");
}
