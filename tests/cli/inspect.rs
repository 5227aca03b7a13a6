//! `inspect` and `schema`.

use super::*;

fn inspected(scene: &str) -> Value {
    let output = tirtouch(&["inspect", scene, "--json"]);
    assert_eq!(code(&output), 0, "{output:?}");
    json(&output)
}

#[test]
fn the_papers_angles_come_out() {
    let path = shown(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tsis-paper.toml"));
    let seen = inspected(&path);
    let expected = [(1.41, 83.737, 45.1715), (1.40, 78.463, 45.5847), (1.39, 74.896, 46.0070), (1.38, 71.989, 46.4387)];
    for (layer, (n, acceptance, critical)) in seen["layers"].as_array().unwrap().iter().zip(expected) {
        // Half a unit of the last digit printed.
        assert!((layer["acceptance_deg"].as_f64().unwrap() - acceptance).abs() < 5e-4, "{layer}");
        assert!((layer["critical_to_surround_deg"].as_f64().unwrap() - critical).abs() < 5e-5, "{layer}");
        assert_eq!(layer["n"], n);
        assert!(layer["name"].is_string() && layer["thickness_mm"].is_number() && layer["note"].is_null());
    }
    assert!((seen["launch_cone_deg"].as_f64().unwrap() - 143.979).abs() < 5e-4);
    assert!(seen["regimes"][0].as_str().unwrap().contains("the camera sees nothing"), "{seen}");
    assert_eq!(seen["surface"], "planes");
    assert_eq!(seen["integrator"], "path");
    let table = tirtouch(&["inspect", &path]);
    for figure in ["83.737", "78.463", "74.896", "71.989", "143.979"] {
        assert!(text(&table.stdout).contains(figure), "{figure}");
    }
}

#[test]
fn an_index_of_root_two_traps_everything_and_says_so() {
    let seen = inspected("preset:tsis-literature");
    assert_eq!(seen["launch_cone_deg"], 180.0);
    for layer in seen["layers"].as_array().unwrap() {
        assert_eq!(layer["acceptance_deg"], 90.0);
        assert!(layer["note"].as_str().unwrap().contains("trapped"), "{layer}");
    }
    assert!(seen["regimes"][0].as_str().unwrap().contains("sqrt(2)"), "{seen}");
    assert!(text(&tirtouch(&["inspect", "preset:tsis-literature"]).stdout).contains("sqrt(2)"));
}

#[test]
fn kernel_pieces_follow_the_scene() {
    let list = |seen: &Value, which: &str| -> Vec<String> {
        seen["kernel"][which].as_array().unwrap().iter().map(|piece| piece.as_str().unwrap().to_owned()).collect()
    };
    let flat = inspected("preset:tsis-paper");
    assert_eq!(list(&flat, "included"), ["clear walls"]);
    let pressed = inspected("preset:press-hertz");
    let touched =
        ["tissue contact", "tissue as a half space of scatterers", "sideways spread in tissue", "contact share grid"];
    for piece in touched {
        assert!(list(&pressed, "included").contains(&piece.to_owned()), "{piece}");
        assert!(list(&flat, "left_out").contains(&piece.to_owned()), "{piece}");
    }
    assert_eq!(list(&flat, "included").len() + list(&flat, "left_out").len(), 19);
    let edge = "edge of the tissue".to_owned();
    assert!(list(&pressed, "left_out").contains(&edge), "a pressure that falls off has tissue over the whole face");
    assert!(list(&inspected("preset:contact-disc"), "included").contains(&edge));
    assert_eq!(inspected("preset:tsis-dent")["surface"], "spherical cap in closed form");
    assert!(pressed["adapter"].is_string() && pressed["memory"]["device_bytes"].as_u64().unwrap() > 0);
    // 16 replicates of two sums a texel of the map.
    let kept = |scene: &Value| scene["memory"]["asked_error_bytes"].as_u64().unwrap();
    assert!(kept(&pressed) >= 256 && kept(&pressed).is_multiple_of(256));
    assert_eq!(kept(&inspected("preset:tsis-dent")), 0, "light that camera paths find leaves nothing");
}

#[test]
fn schema_is_a_json_schema() {
    let output = tirtouch(&["schema"]);
    assert_eq!(code(&output), 0);
    let schema = json(&output);
    assert!(schema["properties"]["stack"].is_object() && schema["$schema"].is_string());
}

/// What is left out would cost time and change nothing.
#[test]
fn gains_name_what_is_left_out_and_leave_the_image_as_it_is() {
    let place = Place::new();
    let cap = "{ kind = \"spherical_dent\", depth_mm = 1.0, radius_mm = 4.0 }";
    let dent = small("dent-cap").replace(cap, "{ kind = \"gaussian_dent\", depth_mm = 1.0, sigma_mm = 2.0 }");
    assert!(!dent.contains(cap));
    let scene = place.write("scene.toml", &dent.replace("photons = 65536", "photons = 8192"));
    let output = tirtouch_in(place.path(), &["inspect", &scene, "--gains", "--rounds", "2", "--json", "--quiet"]);
    assert_eq!(code(&output), 0, "{output:?}");
    let seen = json(&output);
    let gains = seen["gains"].as_array().unwrap();
    assert_eq!(gains.len(), 9, "{gains:?}");
    for gain in gains {
        assert_eq!(gain["same_image"], true, "{gain}");
        assert!(gain["slower"].as_f64().unwrap() > 0.0 && gain["low"].as_f64() <= gain["high"].as_f64(), "{gain}");
    }
    assert_eq!(gains.last().unwrap()["piece"], "all of these");
    assert!(text(&tirtouch(&["inspect", "preset:tsis-paper"]).stdout).contains("leaves out"));
}

/// What is pressed, and how.
#[test]
fn the_phantom_and_its_loads_are_listed() {
    let output = tirtouch(&["inspect", "preset:phantom-size-8mm"]);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = text(&output.stdout);
    for line in
        ["phantom     5 kPa", "inclusion   8 mm across, 5 mm deep to its top, 120 kPa", "loads       to 1, 2, 4 mm"]
    {
        assert!(said.contains(line), "{line}: {said}");
    }
    let steps = "depths_mm = [1.0, 2.0, 4.0]";
    let place = Place::new();
    let lifted = small("phantom-size-8mm").replace(steps, "step = [{ depth_mm = 0.5 }, { depth_mm = 0.25 }]");
    let scene = place.write("scene.toml", &lifted);
    let output = tirtouch_in(place.path(), &["inspect", &scene, "--json"]);
    assert_eq!(json(&output)["truth"]["size_mm"], 8.0, "{output:?}");
    let output = tirtouch_in(place.path(), &["inspect", &scene]);
    assert!(text(&output.stdout).contains("to 0.5 mm; to 0.25 mm"), "{output:?}");
}
