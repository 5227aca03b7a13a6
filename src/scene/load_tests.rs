#![allow(clippy::unwrap_used)]
use super::*;
use crate::scene::bad_scenes::{bad, check, text_of};
use crate::scene::presets::{PRESETS, SCAN_PRESETS, preset, scan_preset};
use proptest::prelude::*;

#[test]
fn every_preset_is_valid_and_bears_its_name() {
    for (name, _) in PRESETS {
        let loaded = preset(name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(loaded.scene.name, *name);
    }
    for (name, _) in SCAN_PRESETS {
        let loaded = scan_preset(name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(loaded.scene.name, *name);
    }
}

#[test]
fn every_scene_of_the_folder_is_a_preset() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    files.sort();
    let mut names: Vec<&str> = PRESETS.iter().chain(SCAN_PRESETS).map(|(name, _)| *name).collect();
    names.sort();
    assert_eq!(files, names);
}

#[test]
fn the_phantom_scenes_differ_in_their_inclusion_alone() {
    let scenes: Vec<_> = PRESETS
        .iter()
        .filter(|(name, _)| name.starts_with("phantom-"))
        .map(|(name, _)| preset(name).unwrap().scene)
        .collect();
    assert_eq!(scenes.len(), 9);
    for scene in &scenes {
        let mut same = scene.clone();
        same.name = scenes[0].name.clone();
        same.description = scenes[0].description.clone();
        let inclusion = |scene: &Scene| scene.phantom.as_ref().unwrap().inclusion.clone();
        assert_eq!(inclusion(scene).len(), 1);
        same.phantom.as_mut().unwrap().inclusion = inclusion(&scenes[0]);
        assert_eq!(same, scenes[0]);
    }
}

#[test]
fn a_scan_scene_is_told_from_a_scene() {
    let error = parse(text_of("frames-galea"), Path::new("s.toml")).unwrap_err();
    assert_eq!((error.kind, error.key.as_deref()), ("unknown_key", Some("scan")));
    assert!(error.message.contains("which frames takes"), "{error}");
    let error = parse_scan(text_of("tsis-paper"), Path::new("s.toml")).unwrap_err();
    assert_eq!(error.kind, "unknown_key");
    assert!(error.message.contains("the keys here are description, name, phantom, scan"), "{error}");
    assert!(scan_preset("tsis-paper").unwrap_err().message.contains("frames-galea"));
}

#[test]
fn an_unknown_preset_lists_the_known_ones() {
    let error = preset("tsis").unwrap_err();
    assert_eq!(error.kind, "unknown_preset");
    assert!(error.message.contains("tsis-paper"), "{error}");
}

#[test]
fn the_hash_is_that_of_the_text() {
    // SHA-256 changes with a single byte of the file, even one in a comment.
    let text = text_of("tsis-paper");
    let one = parse(text, Path::new("a.toml")).unwrap();
    let other = parse(&format!("{text}#"), Path::new("a.toml")).unwrap();
    assert_eq!(one.sha256.len(), 64);
    assert_eq!(one.scene, other.scene);
    assert_ne!(one.sha256, other.sha256);
}

#[test]
fn mistakes_of_structure_name_key_and_line() {
    #[rustfmt::skip]
    let wrong = [
        bad("tsis-paper", "thickness_mm = 3.0", "tickness_mm = 3.0 #!", "unknown_key", "stack.layer[1].tickness_mm", "did you mean thickness_mm?"),
        bad("tsis-paper", "surround_n = 1.0", "zzz = 1 #!\n", "unknown_key", "stack.zzz", "the keys here are footprint_mm"),
        bad("tsis-paper", "name = \"tsis-paper\"", "name = \"a\"\nlights = 1 #!", "unknown_key", "lights", "did you mean light?"),
        bad("tsis-paper", "{ kind = \"clear\" }", "{ kind = \"clear\", reflectance = 0.5 } #!", "unknown_key", "stack.walls.reflectance", "the keys here are kind"),
        bad("tsis-paper", "{ kind = \"clear\" }", "{ kind = \"cleer\" } #!", "invalid_value", "stack.walls.kind", "did you mean clear?"),
        bad("tsis-paper", "{ kind = \"clear\" }", "{ } #!", "missing_key", "stack.walls.kind", "\"black\", \"clear\", \"mirror\""),
        bad("tsis-paper", "{ kind = \"clear\" }", "\"clear\" #!", "wrong_type", "stack.walls", "must be a table with a kind"),
        bad("tsis-paper", "{ kind = \"clear\" }", "{ kind = \"mirror\" } #!", "missing_key", "stack.walls.reflectance", "give a number"),
        bad("tsis-paper", "[[stack.layer]]\nname = \"PDMS 1.40\"\nthickness_mm = 3.0", "[[stack.layer]] #!\nname = \"PDMS 1.40\"", "missing_key", "stack.layer[1].thickness_mm", "give a number (Thickness"),
        bad("tsis-paper", "[light]\nwavelength_nm = 532.0", "[light] #!", "missing_key", "light.wavelength_nm", "give a number"),
        bad("tsis-paper", "[light]\nwavelength_nm = 532.0", "", "missing_key", "light", "give a table"),
        bad("tsis-paper", "name = \"tsis-paper\"\n", "", "missing_key", "name", "give a string"),
        bad("tsis-paper", "name = \"tsis-paper\"", "name = 3 #!", "wrong_type", "name", "must be a string, is 3"),
        bad("tsis-paper", "thickness_mm = 3.0", "thickness_mm = \"3\" #!", "wrong_type", "stack.layer[1].thickness_mm", "must be a number, is \"3\""),
        bad("tsis-paper", "thickness_mm = 3.0", "thickness_mm = nan #!", "invalid_value", "stack.layer[1].thickness_mm", "finite"),
        bad("tsis-paper", "thickness_mm = 3.0", "thickness_mm = -inf #!", "invalid_value", "stack.layer[1].thickness_mm", "finite"),
        bad("tsis-paper", "thickness_mm = 3.0", "thickness_mm = 1e999 #!", "invalid_value", "stack.layer[1].thickness_mm", "finite"),
        bad("tsis-paper", "thickness_mm = 3.0", "thickness_mm = 99999999999999999999 #!", "wrong_type", "stack.layer[1].thickness_mm", "must be a number"),
        bad("tsis-paper", "[30.0, 30.0]", "[30.0] #!", "wrong_type", "stack.footprint_mm", "must have 2 values, has 1"),
        bad("tsis-paper", "[30.0, 30.0]", "[30.0,\n\"30\"] #!", "wrong_type", "stack.footprint_mm[1]", "must be a number"),
        bad("tsis-paper", "pixels = [1392, 1042]", "pixels = [1392, 1042.0] #!", "wrong_type", "camera.pixels[1]", "whole number"),
        bad("tsis-paper", "pixels = [1392, 1042]", "pixels = [-1, 1042] #!", "invalid_value", "camera.pixels[0]", "from 0 to 4294967295"),
        bad("tsis-paper", "bit_depth = 8", "bit_depth = 5000000000 #!", "invalid_value", "camera.sensor.bit_depth", "from 0 to 4294967295"),
        bad("tsis-paper", "wall = \"+x\"", "wall = \"x\" #!", "invalid_value", "led[0].wall", "\"+x\", \"-x\", \"+y\", \"-y\""),
        bad("tsis-paper", "view_axis = \"width\"", "view_axis = 1 #!", "invalid_value", "camera.view_axis", "\"width\""),
        bad("tsis-paper", "[camera]", "[kamera] #!", "unknown_key", "kamera", "did you mean camera?"),
        bad("press-hertz", "n = 1.40\nred", "m = 1.40 #!\nred", "unknown_key", "touch.contact.tissue.m", "the keys here are"),
    ];
    wrong.iter().for_each(check);
}

#[test]
fn broken_toml_names_the_line() {
    for (text, line) in [("name = 'a'\nname = 'b'\n", 2), ("name = 'a'\n\n[light\n", 3), ("name = \n", 1), ("\u{0}", 1)]
    {
        let error = parse(text, Path::new("scene.toml")).unwrap_err();
        assert_eq!((error.kind, error.line), ("syntax", Some(line)), "{error}");
        assert_eq!(error.to_string().lines().count(), 1, "{error}");
    }
}

#[test]
fn a_file_that_does_not_exist_is_named_with_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let shape = "{ kind = \"spherical_dent\", depth_mm = 1.0, radius_mm = 4.0 }";
    let text = text_of("dent-cap").replace(shape, "{ kind = \"mesh\", file = \"plate.obj\" } #!");
    std::fs::write(&path, &text).unwrap();
    let error = load(&path).unwrap_err();
    assert_eq!((error.kind, error.key.as_deref()), ("missing_file", Some("touch.shape.file")));
    assert_eq!(error.line, Some(line_at(&text, text.find("#!").unwrap())));
    std::fs::write(folder.path().join("plate.obj"), "").unwrap();
    let loaded = load(&path).unwrap();
    assert_eq!(loaded.files.resolve(Path::new("plate.obj")), folder.path().join("plate.obj"));
}

#[test]
fn a_scene_is_that_of_its_files_when_it_was_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let (path, plate) = (folder.path().join("scene.toml"), folder.path().join("plate.obj"));
    let shape = "{ kind = \"spherical_dent\", depth_mm = 1.0, radius_mm = 4.0 }";
    std::fs::write(&path, text_of("dent-cap").replace(shape, "{ kind = \"mesh\", file = \"plate.obj\" }")).unwrap();
    let load_with = |text: &str| {
        std::fs::write(&plate, text).unwrap();
        load(&path).unwrap()
    };
    let [one, other, again] = ["v 0 0 1", "v 0 0 2", "v 0 0 1"].map(load_with);
    assert_eq!(one.identity(), again.identity());
    assert_ne!(one.identity(), other.identity());
    assert_eq!(&*other.files.open(Path::new("plate.obj")).unwrap().bytes, b"v 0 0 2");
    assert_eq!(one.inputs().len(), 1);
    // In memory: the same text, and the file's bytes.
    let mut made = parse(&one.text, Path::new("elsewhere/scene.toml")).unwrap();
    made.files.insert("plate.obj", *b"v 0 0 1");
    assert_eq!((made.identity(), made.inputs()), (one.identity(), one.inputs()));
    // A scene that names none is known by its own hash.
    let plain = parse(text_of("dent-cap"), Path::new("scene.toml")).unwrap();
    assert_eq!(plain.identity(), plain.sha256);
}

#[test]
fn files_of_phantoms_and_scans_are_named_with_their_keys() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let sphere = "{ kind = \"sphere\", diameter_mm = 10.0 }";
    let text = text_of("frames-galea").replace(sphere, "{ kind = \"mesh\", file = \"lump.stl\" }");
    let text = text.replace("{ kind = \"round\", radius_mm = 20.0 }", "{ kind = \"table\", file = \"head.csv\" }");
    std::fs::write(&path, &text).unwrap();
    let key = || load_scan(&path).map_err(|error| error.key.unwrap_or_default()).err();
    assert_eq!(key().as_deref(), Some("phantom.inclusion[0].shape.file"));
    std::fs::write(folder.path().join("lump.stl"), "").unwrap();
    assert_eq!(key().as_deref(), Some("scan.indenter.file"));
    std::fs::write(folder.path().join("head.csv"), "").unwrap();
    assert_eq!(key(), None);
    let sphere = "{ kind = \"sphere\", diameter_mm = 8.0 }";
    let text = text_of("phantom-size-8mm").replace(sphere, "{ kind = \"mesh\", file = \"other.stl\" }");
    std::fs::write(&path, &text).unwrap();
    assert_eq!(load(&path).unwrap_err().key.as_deref(), Some("phantom.inclusion[0].shape.file"));
}

#[test]
fn unreadable_large_and_non_utf8_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    assert_eq!(load(&path).unwrap_err().kind, "io");
    assert_eq!(load(folder.path()).unwrap_err().kind, "io");
    std::fs::write(&path, b"# ok\nname = \"\xff\"\n").unwrap();
    let error = load(&path).unwrap_err();
    assert_eq!((error.kind, error.line), ("not_utf8", Some(2)));
    std::fs::write(&path, vec![b'#'; MAX_BYTES as usize + 1]).unwrap();
    assert_eq!(load(&path).unwrap_err().kind, "too_large");
}

#[test]
fn a_scene_survives_the_way_to_toml_and_back() {
    for (name, _) in PRESETS {
        let scene = preset(name).unwrap().scene;
        let text = toml::to_string(&scene).unwrap();
        assert_eq!(parse(&text, Path::new("s.toml")).unwrap().scene, scene, "{name}");
    }
    for (name, _) in SCAN_PRESETS {
        let scene = scan_preset(name).unwrap().scene;
        let text = toml::to_string(&scene).unwrap();
        assert_eq!(parse_scan(&text, Path::new("s.toml")).unwrap().scene, scene, "{name}");
    }
}

proptest! {
    #[test]
    fn no_text_makes_the_parser_panic(text in "\\PC{0,200}") {
        let _ = parse(&text, Path::new("s.toml"));
    }

    #[test]
    fn no_mutated_scan_scene_makes_the_parser_panic(
        changes in proptest::collection::vec((any::<usize>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = SCAN_PRESETS[0].1.as_bytes().to_vec();
        for (at, byte) in changes {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        if let Err(error) = parse_scan(&String::from_utf8_lossy(&bytes), Path::new("s.toml")) {
            prop_assert_eq!(error.to_string().lines().count(), 1);
        }
    }

    #[test]
    fn no_mutated_preset_makes_the_parser_panic(
        which in 0..PRESETS.len(),
        changes in proptest::collection::vec((any::<usize>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = PRESETS[which].1.as_bytes().to_vec();
        for (at, byte) in changes {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        if let Err(error) = parse(&String::from_utf8_lossy(&bytes), Path::new("s.toml")) {
            prop_assert_eq!(error.to_string().lines().count(), 1);
        }
    }

    #[test]
    fn no_swapped_value_makes_the_parser_panic(
        which in 0..PRESETS.len(),
        line in any::<usize>(),
        value in prop_oneof!["-?[0-9]{1,25}", "-?[0-9]{1,3}e-?[0-9]{1,3}", "nan", "-inf", "\"[a-z]{0,9}\"", "\\[\\]", "\\{ \\}"],
    ) {
        let mut lines: Vec<String> = PRESETS[which].1.lines().map(str::to_owned).collect();
        let at = line % lines.len();
        if let Some((key, _)) = lines[at].clone().split_once('=') {
            lines[at] = format!("{key}= {value}");
        }
        if let Err(error) = parse(&lines.join("\n"), Path::new("s.toml")) {
            prop_assert_eq!(error.to_string().lines().count(), 1);
            prop_assert!(error.line.is_some());
        }
    }
}

#[test]
fn every_mistake_of_a_stage_is_told_in_the_order_of_the_file() {
    let keys = |text: &str| {
        let error = parse(text, Path::new("scene.toml")).unwrap_err();
        let all = std::iter::once(&error).chain(error.others.iter());
        all.map(|one| (one.key.clone().unwrap(), one.line.unwrap())).collect::<Vec<_>>()
    };
    let original = text_of("tsis-paper");
    let line = |text: &str, wanted: &str| text.lines().position(|line| line.contains(wanted)).unwrap() + 1;
    // Rules: two of one layer, one of an LED, two of the camera.
    let text = original
        .replacen("n = 1.41", "n = 0.5", 1)
        .replacen("n = 1.39", "n = 9.0\nabsorption_per_mm = -1.0", 1)
        .replacen("power_mw = 5.0", "power_mw = -5.0", 1)
        .replacen("view_angle_deg", "view_angle_deg = 200.0 #", 1);
    let found = keys(&text);
    let expected = [
        ("stack.layer[0].n", "n = 0.5"),
        ("stack.layer[2].n", "n = 9.0"),
        ("stack.layer[2].absorption_per_mm", "absorption_per_mm = -1.0"),
        ("led[0].power_mw", "power_mw = -5.0"),
        ("camera.view_angle_deg", "view_angle_deg = 200.0"),
    ];
    let expected: Vec<_> = expected.iter().map(|(key, shown)| ((*key).to_owned(), line(&text, shown))).collect();
    assert_eq!(found, expected);
    // Structure: an unknown key, a missing one and a wrong type; a misspelt key is not missing too.
    let text = original
        .replacen("surround_n = 1.0", "surrond_n = 1.0", 1)
        .replacen("thickness_mm = 2.0", "thicknes_mm = 2.0", 1)
        .replacen("thickness_mm = 3.0", "", 1)
        .replacen("n = 1.39", "n = \"1.39\"", 1);
    let found: Vec<String> = keys(&text).into_iter().map(|(key, _)| key).collect();
    assert_eq!(
        found,
        ["stack.surrond_n", "stack.layer[0].thicknes_mm", "stack.layer[1].thickness_mm", "stack.layer[2].n"]
    );
}
