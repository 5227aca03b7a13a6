//! `converge`: rungs with errors and times, kept one by one; a fault in a rung shows as an error that samples do not
//! cure.

use super::frames::names;
use super::*;
use tirtouch::converge::{ErrorEstimate, is_lit, square_error};

/// A scene of few pixels and large texels.
fn scene(place: &Place, name: &str) -> String {
    place.write("scene.toml", &small(name))
}

#[test]
fn a_contact_scene_has_ladders_pictures_and_a_table() {
    let place = Place::new();
    let scene = scene(&place, "contact-disc");
    let work = ["--quick", "--shrink", "2", "--spp", "64", "--backend", "cpu"];
    let flags = [&["converge", &scene, "-o", "ladders", "--json", "--quiet"][..], &work].concat();
    let output = tirtouch_in(place.path(), &flags);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let said = json(&output);
    assert!(said["reference"]["light"].as_str().unwrap().starts_with("splat, without bias"), "{said}");
    assert!(said["reference"]["mechanics"]["undefined"].is_string(), "{said}");
    let rungs = said["rungs"].as_array().unwrap();
    for family in ["samples", "map texel", "precision"] {
        let members: Vec<&Value> = rungs.iter().filter(|rung| rung["family"] == family).collect();
        assert!(members.len() >= 2, "{family}");
        assert!(members.iter().any(|rung| rung["pareto"] == true), "{family}: no front");
        for rung in members {
            let error = ["low", "value", "high"].map(|key| rung["error"][key].as_f64().unwrap());
            assert!(error[0] <= error[1] && error[1] <= error[2] && error[2] > 0.0, "{rung}");
            assert!(rung["seconds"].as_f64().unwrap() > 0.0 && rung["repeats"] == 3, "{rung}");
        }
    }
    // More samples, less noise: that the splat's error halves from 16 to 64 lies within both intervals. The quotient of
    // the values says less: rare bright photons spread it from 0.9 to 2 over seeds 1 to 4.
    let error = |setting: &str| {
        let rung = rungs.iter().find(|r| r["series"] == "splat" && r["setting"] == setting).unwrap();
        ["low", "high"].map(|end| rung["error"][end].as_f64().unwrap())
    };
    let ([low, high], [low_64, high_64]) = (error("16 samples a pixel"), error("64 samples a pixel"));
    assert!(low <= 2.0 * high_64 && high >= 2.0 * low_64, "{low} to {high}, {low_64} to {high_64}");
    let folder = place.path().join("ladders");
    let found = names(&folder);
    for name in ["converge.csv", "converge_samples.svg", "converge_map_texel.svg", "converge_precision.svg", "items"] {
        assert!(found.contains(&name.to_owned()), "{found:?}");
    }
    let table = std::fs::read_to_string(folder.join("converge.csv")).unwrap();
    assert_eq!(table.lines().count(), rungs.len() + 1);

    // What was kept is not computed again; what is missing is; other flags are refused.
    let items = names(&folder.join("items"));
    let gone = items.iter().find(|name| name.starts_with("light-precision")).unwrap();
    std::fs::remove_file(folder.join("items").join(gone)).unwrap();
    let again = tirtouch_in(place.path(), &[&flags[..], &["--resume"]].concat());
    assert_eq!(code(&again), 0, "{}", text(&again.stderr));
    let again = json(&again);
    let kept = |said: &Value| said["rungs"].as_array().unwrap()[0]["seconds"].clone();
    assert_eq!(kept(&again), kept(&said), "a rung was rendered again");
    assert_eq!(names(&folder.join("items")), items);
    let mut other = flags.to_vec();
    let spp = other.iter().position(|flag| *flag == "64").unwrap();
    other[spp] = "32";
    for (arguments, says) in [(&flags[..], "--resume"), (&[&other[..], &["--resume"]].concat(), "another scene")] {
        let refused = tirtouch_in(place.path(), arguments);
        assert_eq!(code(&refused), 2, "{refused:?}");
        assert!(one_line(&refused).contains(says), "{refused:?}");
    }
}

#[test]
fn a_press_has_ladders_of_meshes_orders_and_load_steps() {
    let place = Place::new();
    let scene = include_str!("../../scenes/phantom-size-8mm.toml")
        .replace("depths_mm = [1.0, 2.0, 4.0]", "depths_mm = [0.5, 1.0]\nresolution = 0.5");
    place.write("scene.toml", &scene);
    let flags = ["converge", "scene.toml", "--quick", "--only", "mechanics", "-o", "ladders", "--json", "--quiet"];
    let output = tirtouch_in(place.path(), &flags);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let said = json(&output);
    assert!(said["reference"]["light"]["undefined"].is_string(), "{said}");
    let rungs = said["rungs"].as_array().unwrap();
    let errors = |family: &str, quantity: &str| -> Vec<f64> {
        let own = rungs.iter().filter(|r| r["family"] == family && r["quantity"] == quantity);
        own.map(|r| r["error"]["value"].as_f64().unwrap()).collect()
    };
    for quantity in ["force", "pressure"] {
        let mesh = errors("mesh", quantity);
        assert!(mesh.len() == 2 && mesh[1] < mesh[0] && mesh[0] < 0.2, "{quantity}: {mesh:?}");
        // Each mesh with linear pressures and with constant ones.
        let orders = errors("element order", quantity);
        assert!(orders.len() == 4 && orders[..2] == mesh && orders[3] > mesh[1], "{quantity}: {orders:?}");
        // An elastic press does not remember its way: steps agree to the solver's tolerance.
        let steps = errors("load steps", quantity);
        assert!(steps.len() == 2 && steps.iter().all(|e| *e < 1e-6), "{quantity}: {steps:?}");
    }
    for name in
        ["converge_mesh.svg", "converge_mesh_pressure.svg", "converge_element_order.svg", "converge_load_steps.svg"]
    {
        assert!(place.path().join("ladders").join(name).exists(), "{name}");
    }
}

#[test]
fn a_dark_scene_ends_and_says_so() {
    let place = Place::new();
    let scene = scene(&place, "tsis-paper");
    let output = tirtouch_in(place.path(), &["converge", &scene, "--quick", "--spp", "16", "--json", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let said = json(&output);
    assert!(said["reference"]["light"]["undefined"].as_str().unwrap().contains("dark"), "{said}");
    assert!(said["rungs"].as_array().unwrap().is_empty());
}

#[test]
fn wrong_use_of_ladders_is_refused_before_the_work() {
    let place = Place::new();
    std::fs::create_dir(place.path().join("mine")).unwrap();
    for flags in [
        &["converge", "preset:contact-disc", "--only", "mechanics"][..],
        &["converge", "preset:contact-disc", "--spp", "4"],
        &["converge", "preset:contact-disc", "--quick", "-o", "mine", "--force"],
        &["converge", "preset:contact-disc", "--quick", "-o", "none", "--resume"],
        &["converge", "none.toml"],
    ] {
        let output = tirtouch_in(place.path(), flags);
        assert_eq!(code(&output), 2, "{flags:?}: {output:?}");
        assert!(!one_line(&output).is_empty());
    }
    assert_eq!(names(place.path()), ["mine"], "nothing is left behind");
}

#[test]
fn a_bias_of_a_tenth_is_an_error_that_more_samples_do_not_cure() {
    // The planted fault: images that are a tenth too bright, with less and less noise.
    let reference = film(1, 1.0);
    let lit = is_lit(&reference);
    let error = |mean: f64, shrink: f32| {
        let squares: Vec<[f64; 2]> = (2..6)
            .map(|seed| {
                let mut film = film(seed, mean);
                let level = mean as f32;
                film.mean.iter_mut().for_each(|v| *v = level + (*v - level) * shrink);
                square_error(&film, &reference, &lit).unwrap()
            })
            .collect();
        let own: Vec<f64> = squares.iter().map(|s| s[0]).collect();
        ErrorEstimate::of_squares(&own, squares[0][1], 0.05)
    };
    let honest: Vec<f64> = [1.0, 0.25].map(|shrink| error(1.0, shrink).value).to_vec();
    let faulty: Vec<f64> = [0.25, 0.0].map(|shrink| error(1.1, shrink).value).to_vec();
    assert!(honest[1] < 0.5 * honest[0], "{honest:?}");
    assert!(faulty.iter().all(|e| (e - 0.1).abs() < 0.03), "{faulty:?}");
    assert!(error(1.1, 0.0).low > error(1.0, 0.0).high);
}
