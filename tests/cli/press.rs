//! `press`, and `run` on a scene with a press.

use super::frames::names;
use super::*;

/// A phantom of the paper on a coarse mesh, with a small camera and texels that suit it.
pub fn scene(more: &str) -> String {
    include_str!("../../scenes/phantom-size-8mm.toml")
        .replace("pixels = [348, 261]", "pixels = [32, 24]")
        .replace("pixel_pitch_um = 18.6 ", "pixel_pitch_um = 202.0 ")
        .replace("depths_mm = [1.0, 2.0, 4.0]", &format!("depths_mm = [0.5, 1.0]\nresolution = 0.5\n{more}"))
        + "\n[render]\nmap_texel_mm = 0.5\n"
}

#[test]
fn a_press_writes_its_files_and_says_its_figures() {
    let place = Place::new();
    place.write("scene.toml", &scene(""));
    let output = tirtouch_in(place.path(), &["press", "scene.toml", "-o", "with", "--json", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let mechanics = &json(&output)["mechanics"];
    for key in ["force_n", "peak_pressure_kpa", "iterations", "dofs", "seconds"] {
        assert!(mechanics[key].as_f64().unwrap() > 0.0, "{key}: {mechanics}");
    }
    for key in ["pressure_error", "peak_error", "force_error"] {
        assert!(mechanics[key].as_f64().unwrap() > 0.0, "{key}: {mechanics}");
    }
    assert_eq!(mechanics["steps"].as_array().unwrap().len(), 2);
    assert_eq!(mechanics["peak_at_mm"], serde_json::json!([0.0, 0.0]), "over the inclusion");
    let files = names(&place.path().join("with"));
    for name in ["contact.csv", "deformed.vtu", "mesh.svg", "pressure.svg", "report.html"] {
        assert!(files.contains(&name.to_owned()), "{files:?}");
    }
    let table = std::fs::read_to_string(place.path().join("with/contact.csv")).unwrap();
    assert!(table.starts_with("depth_mm,r_mm,pressure_kpa,shear_kpa,gap_mm,displacement_r_mm,displacement_z_mm\n"));
    let without = ["press", "scene.toml", "-o", "without", "--json", "--quiet", "--without-inclusions"];
    let without = json(&tirtouch_in(place.path(), &without));
    let peak = |said: &serde_json::Value| said["peak_pressure_kpa"].as_f64().unwrap();
    assert!(peak(mechanics) > 1.2 * peak(&without["mechanics"]), "the inclusion presses");
}

/// A contact that is narrower than the elements: hardly touched, a rounded edge bears all at its rim.
#[test]
fn a_contact_that_elements_do_not_resolve_has_no_error_and_says_why() {
    let place = Place::new();
    let round = "indenter = { kind = \"round\", radius_mm = 6.0 }";
    let flat = "indenter = { kind = \"rounded_flat\", flat_mm = 3.0, edge_radius_mm = 1.5 }";
    let ball = include_str!("../../benches/presses/ball.toml");
    assert!(ball.contains(round));
    let text_of = ball.replace(round, flat).replace("[0.5, 1.0, 2.0, 3.0]", "[0.005, 1.0]");
    place.write("scene.toml", &text_of);
    let output = tirtouch_in(place.path(), &["press", "scene.toml", "-o", "out", "--json", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let said = json(&output);
    let steps = said["mechanics"]["steps"].as_array().unwrap();
    let unresolved = steps[0]["peak_error"]["undefined"].as_str().unwrap_or_else(|| panic!("{said}"));
    assert!(unresolved.contains("do not resolve the contact: a higher press.resolution does"), "{unresolved}");
    assert!(steps[1]["peak_error"].as_f64().unwrap() < 0.25, "{said}");
    let output = tirtouch_in(place.path(), &["press", "scene.toml", "-o", "told"]);
    let told = ["its peak not resolved", "its peak within"].map(|words| text(&output.stdout).matches(words).count());
    assert_eq!(told, [1, 1], "{}", text(&output.stdout));
}

#[test]
fn a_run_presses_first_and_subtracts_its_baseline() {
    let place = Place::new();
    place.write("scene.toml", &scene("estimate_error = false"));
    let work = ["--spp", "16", "--photons", "4096", "--backend", "cpu"];
    let flags = [&["run", "scene.toml", "--subtract-baseline", "--json", "--quiet"][..], &work].concat();
    let output = tirtouch_in(place.path(), &flags);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let said = json(&output);
    assert!(said["mechanics"]["force_n"].as_f64().unwrap() > 0.0, "{said}");
    assert_eq!((&said["paper"]["reference"], &said["map"]["mirror_images"]), (&"baseline.png".into(), &4.into()));
    assert_eq!(said["earlier_frames"][0]["depth_mm"], 0.5);
    let files = names(&place.path().join("out/phantom-size-8mm"));
    for name in ["baseline.png", "camera_0.5mm.png", "camera.png", "deformed.vtu", "contact.csv", "report.html"] {
        assert!(files.contains(&name.to_owned()), "{files:?}");
    }
}

#[test]
fn steps_are_pressed_traced_and_shown_one_after_another() {
    let place = Place::new();
    let steps = "[[press.step]]\ndepth_mm = 1.0\n[[press.step]]\nhold_s = 2.0\n[[press.step]]\ndepth_mm = 0.5\n";
    let text_of = scene("rate_mm_per_s = 1.0\nestimate_error = false").replace("depths_mm = [0.5, 1.0]\n", "");
    place.write("scene.toml", &(text_of + steps));
    let work = ["--spp", "16", "--photons", "4096", "--backend", "cpu", "--subtract-baseline", "--json", "--quiet"];
    let output = tirtouch_in(place.path(), &[&["run", "scene.toml", "-o", "out"][..], &work].concat());
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let said = json(&output);
    let steps = said["mechanics"]["steps"].as_array().unwrap();
    let of = |key: &str| steps.iter().map(|step| step[key].as_f64().unwrap()).collect::<Vec<_>>();
    assert_eq!((of("depth_mm"), of("hold_s")), (vec![1.0, 1.0, 0.5], vec![0.0, 2.0, 0.0]));
    assert!((of("force_n")[1] / of("force_n")[0] - 1.0).abs() < 1e-6, "nothing relaxes: {steps:?}");
    assert!(of("force_n")[2] < 0.6 * of("force_n")[0]);
    let files = names(&place.path().join("out"));
    for name in ["camera_1.png", "camera_2.png", "camera.png", "deformed_1.vtu", "deformed_2.vtu", "deformed.vtu"] {
        assert!(files.contains(&name.to_owned()), "{files:?}");
    }
    let list = std::fs::read_to_string(place.path().join("out/deformed.pvd")).unwrap();
    assert_eq!(list.matches("<DataSet").count(), 3, "{list}");
    let table = std::fs::read_to_string(place.path().join("out/contact.csv")).unwrap();
    assert!(table.starts_with("step,depth_mm,slide_x_mm,slide_y_mm,r_mm,"));
    assert!(table.lines().any(|line| line.starts_with("3,0.5,0,0,")));
}

#[test]
fn a_press_of_nothing_is_refused() {
    let place = Place::new();
    for flags in [&["press", "preset:press-hertz"][..], &["render", "preset:press-hertz", "--without-inclusions"]] {
        let output = tirtouch_in(place.path(), flags);
        assert_eq!(code(&output), 2, "{flags:?}: {}", text(&output.stderr));
        assert!(text(&output.stderr).contains("[press]"), "{}", text(&output.stderr));
    }
    assert!(names(place.path()).is_empty(), "nothing is left behind");
}

#[test]
fn a_press_beyond_the_memory_is_refused_with_what_would_fit() {
    let place = Place::new();
    let scene = scene("dimensions = \"three\"").replace("[0.5, 1.0]\nresolution = 0.5", "[0.5]\nresolution = 1.0");
    place.write("scene.toml", &scene);
    let limited = |gib: &str, arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tirtouch"));
        command.args(arguments).current_dir(place.path()).env("TIRTOUCH_MEMORY_GIB", gib).output().unwrap()
    };
    let refused = limited("0.1", &["press", "scene.toml", "--quiet"]);
    assert_eq!(code(&refused), 2, "{refused:?}");
    let said = one_line(&refused);
    assert!(said.contains("the limit is 0.1 GiB") && said.contains("press.resolution times 0."), "{said}");
    assert!(!place.path().join("out").exists());
    assert_eq!(code(&limited("lots", &["schema"])), 2);
    let seen = json(&limited("2", &["inspect", "scene.toml", "--json"]));
    assert_eq!(seen["press"]["dofs"], 101_514, "{seen}");
    assert_eq!(seen["press"]["method"], "multigrid");
    assert_eq!(seen["press"]["memory_limit_gib"], 2.0);
}

#[test]
fn an_indenter_is_pressed_and_inspected_and_guides_no_light() {
    let place = Place::new();
    let indenter = "sensor = \"rigid\"\nindenter = { kind = \"table\", file = \"ball.csv\" }\nestimate_error = false";
    let good =
        scene("").replace("sensor = \"deformable\"", indenter).replace("kind = \"tied\"", "kind = \"frictionless\"");
    let good = good.replace("footprint = { kind = \"round\", radius_mm = 15.0 }\n", "");
    place.write("scene.toml", &good);
    place.write("ball.csv", "x_mm,below_mm\n0,0\n1,0.1\n2,0.4\n3,0.9\n4,1.6\n");
    let output = tirtouch_in(place.path(), &["press", "scene.toml", "-o", "out", "--json", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    assert!(json(&output)["mechanics"]["force_n"].as_f64().unwrap() > 0.0);
    // As sha256sum says it.
    let sha256 = "e92f5fdf954757800d88f2f0b40a63e4f7cfb458936c14a4654eef656a66251e";
    assert_eq!(json(&output)["inputs"]["ball.csv"], sha256);
    let page = std::fs::read_to_string(place.path().join("out/report.html")).unwrap();
    assert!(page.contains("ball.csv") && page.contains(sha256));
    let seen = json(&tirtouch_in(place.path(), &["inspect", "scene.toml", "--json"]));
    assert!(seen["press"]["dofs"].as_u64().unwrap() > 0 && seen["light"]["undefined"].is_string(), "{seen}");
    let said = tirtouch_in(place.path(), &["inspect", "scene.toml"]);
    assert!(text(&said.stdout).contains("none: an indenter"), "{said:?}");
    for command in [&["render"][..], &["run"], &["converge"], &["inspect", "--gains"]] {
        let output = tirtouch_in(place.path(), &[command, &["scene.toml", "--json"]].concat());
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains("press.indenter: an indenter guides no light"), "{output:?}");
    }
    // Mistakes name the line.
    for (from, to, key, line) in
        [("frictionless", "tied", "press.interface", true), ("ball.csv", "none.csv", "press.indenter.file", true)]
    {
        place.write("wrong.toml", &good.replace(from, to));
        let output = tirtouch_in(place.path(), &["press", "wrong.toml", "--json"]);
        let error = json(&output)["error"].clone();
        assert_eq!((code(&output), &error["key"], error["line"].is_u64()), (2, &key.into(), line), "{error}");
    }
}
