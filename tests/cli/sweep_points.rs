//! Points of a sweep: files that they name, values that are no numbers, what the sweep says for all of them.

use super::sweep::{points, run};
use super::*;
use sha2::Digest as _;

const DESIGN: &str =
    "[sweep]\nscene = \"disc.toml\"\ndesign = { kind = \"grid\" }\n[[measure]]\nkind = \"mean_radiance\"\n";
const LAMP: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 100 1 3 1 1 2 0 0 0\n1 1 1\n0 45 90\n0\n";

/// A folder with a small disc, which is lit by a lamp's file, and a sweep of it.
fn place(vary: &str) -> Place {
    let place = Place::new();
    let ies = "pattern = { kind = \"ies\", file = \"lamp.ies\" }";
    let disc = small("contact-disc").replace("photons = 65536", "photons = 4096\nspp = 4");
    place.write("disc.toml", &disc.replace("pattern = { kind = \"lambertian\" }", ies));
    place.write("lamp.ies", &format!("{LAMP}100 70 0\n"));
    place.write("other.ies", &format!("{LAMP}100 20 0\n"));
    place.write("sweep.toml", &format!("{DESIGN}{vary}"));
    place
}

fn vary(key: &str, values: &str) -> String {
    format!("[[vary]]\nkey = '{key}'\n{values}\n")
}

#[test]
fn files_that_vary_are_part_of_the_order() {
    let both = vary("led[*].pattern.file", "values = ['lamp.ies', 'other.ies']");
    let place = place(&(both + &vary("stack.layer[0].n", "values = [1.40, 1.42]")));
    assert_eq!(code(&run(&place, "out", &[])), 0);
    let whole = points(&place, "out");
    std::fs::remove_file(place.path().join("out/items/0000003.json")).unwrap();
    // What was read for some points must be what is read for the others.
    place.write("other.ies", &format!("{LAMP}100 90 80\n"));
    let output = run(&place, "out", &["--resume"]);
    assert_eq!(code(&output), 2, "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("inputs.other.ies"), "{output:?}");
    std::fs::remove_file(place.path().join("other.ies")).unwrap();
    for flags in [["-o", "out", "--resume"], ["-o", "new", "--quiet"]] {
        let output =
            tirtouch_in(place.path(), &[&["sweep", "run", "sweep.toml", "--backend", "cpu"], &flags[..]].concat());
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("other.ies: its scenes name it"), "{output:?}");
    }
    assert!(!place.path().join("new").exists());
    place.write("other.ies", &format!("{LAMP}100 20 0\n"));
    assert_eq!(code(&run(&place, "out", &["--resume"])), 0);
    assert_eq!(points(&place, "out"), whole);
}

#[test]
fn a_value_that_makes_no_scene_stops_its_own_points_alone() {
    // A mirror lacks its reflectance, whichever comes first.
    for values in ["values = ['mirror', 'black']", "values = ['black', 'mirror']"] {
        let place = place(&vary("stack.walls.kind", values));
        let output = run(&place, "out", &["--json"]);
        assert_eq!(code(&output), 0, "{output:?}");
        assert_eq!([&json(&output)["done"], &json(&output)["rejected"]], [1, 1], "{output:?}");
    }
    let all = place(&vary("stack.walls.kind", "values = ['mirror']"));
    assert_eq!(code(&run(&all, "out", &[])), 2);
    assert!(!all.path().join("out").exists());
    // A key that there is not is found behind any number of points that a constraint leaves out.
    let typo = "[[vary]]\nname = \"w\"\nkey = \"stack.layer[0].nn\"\nlinear = { from = 1.4, to = 1.5, points = 201 }\n";
    let typo = self::place(&format!("{typo}[[require]]\nexpression = \"w > 1.49\"\n"));
    assert_eq!(code(&run(&typo, "out", &[])), 2);
    assert!(!typo.path().join("out").exists());
}

#[test]
fn what_the_sweep_says_for_all_points_does_not_vary() {
    let varies = vary("render.seed", "values = [5, 6]");
    let kept = place(&varies);
    kept.write("sweep.toml", &(DESIGN.replace("[[measure]]", "images = { format = \"png\" }\n[[measure]]") + &varies));
    assert_eq!(code(&run(&kept, "out", &[])), 0);
    let labels = std::fs::read_to_string(kept.path().join("out/train/metadata.csv")).unwrap();
    let mut rows = csv::Reader::from_reader(labels.as_bytes());
    let column = rows.headers().unwrap().iter().position(|name| name == "seed").unwrap();
    let seeds: Vec<String> = rows.records().map(|row| row.unwrap()[column].to_owned()).collect();
    assert!(!seeds.is_empty() && seeds.iter().all(|seed| seed == "5" || seed == "6"), "{labels}");
    for (key, said) in [("render.seed", "seed = 3"), ("render.photons", "target_error = 0.1")] {
        let place = place(&vary(key, "values = [1000, 2000]"));
        let text = std::fs::read_to_string(place.path().join("sweep.toml")).unwrap();
        place.write("sweep.toml", &text.replace("[[measure]]", &format!("{said}\n[[measure]]")));
        let output = run(&place, "out", &[]);
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(
            String::from_utf8_lossy(&output.stderr).contains(&format!("{key} changes nothing beside")),
            "{output:?}"
        );
    }
}

#[test]
fn a_scene_is_printed_as_its_hash_was_taken() {
    let place = place(&vary("stack.layer[0].n", "values = [1.40]"));
    let disc = std::fs::read_to_string(place.path().join("disc.toml")).unwrap();
    place.write("disc.toml", &(disc + "# the end   \n\n\n"));
    assert_eq!(code(&run(&place, "out", &[])), 0);
    let printed = tirtouch_in(place.path(), &["sweep", "scene", "out", "0"]).stdout;
    assert!(printed.ends_with(b"# the end   \n\n\n"));
    let kept = std::fs::read_to_string(place.path().join("out/items/0000000.json")).unwrap();
    let hash: String = sha2::Sha256::digest(&printed).iter().map(|byte| format!("{byte:02x}")).collect();
    assert!(kept.contains(&hash), "{hash}: {kept}");
}
