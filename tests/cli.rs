//! The command as a user meets it: exit codes, one line of error, JSON.
#![allow(clippy::unwrap_used)]

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    WritableImage,
};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tirtouch::film::{BlockAccumulator, Film};
use tirtouch::image_io::{Provenance, write_radiance};

#[path = "cli/bad_input.rs"]
mod bad_input;
#[path = "cli/begin.rs"]
mod begin;
#[path = "cli/calibrated.rs"]
mod calibrated;
#[path = "cli/converge.rs"]
mod converge;
#[path = "cli/data_sets.rs"]
mod data_sets;
#[path = "cli/environment.rs"]
mod environment;
#[path = "cli/estimate.rs"]
mod estimate;
#[path = "cli/examples.rs"]
mod examples;
#[path = "cli/explore.rs"]
mod explore;
#[path = "cli/flags.rs"]
mod flags;
#[path = "cli/folders.rs"]
mod folders;
#[path = "cli/frames.rs"]
mod frames;
#[path = "cli/inspect.rs"]
mod inspect;
#[path = "cli/jobs.rs"]
mod jobs;
#[path = "cli/press.rs"]
mod press;
#[path = "cli/stability.rs"]
mod stability;
#[path = "cli/sweep.rs"]
mod sweep;
#[path = "cli/sweep_points.rs"]
mod sweep_points;
#[path = "cli/view.rs"]
mod view;

fn tirtouch(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tirtouch")).args(arguments).output().unwrap()
}

/// Runs in a folder of its own, so that default folders land there.
fn tirtouch_in(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tirtouch")).args(arguments).current_dir(folder).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("no JSON: {output:?}"))
}

/// Standard error is one line that begins with the program's name; gives the rest of it.
fn one_line(output: &Output) -> &str {
    let said = text(&output.stderr);
    assert_eq!(said.lines().count(), 1, "{said}");
    said.trim_end().strip_prefix("tirtouch: ").unwrap()
}

/// A film of 32x32 pixels around `mean`, noise of about 5 % that depends on `seed`.
fn film(seed: u64, mean: f64) -> Film {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut uniform = move || {
        // Marsaglia's xorshift.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut sums = BlockAccumulator::new(32, 32);
    for _ in 0..16 {
        let image: Vec<f64> = (0..1024).map(|_| mean * (1.0 + 0.7 * (uniform() - 0.5))).collect();
        sums.add(&image).unwrap();
    }
    sums.finish()
}

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, text: &str) -> String {
        std::fs::write(self.path().join(name), text).unwrap();
        name.to_owned()
    }

    /// Names of everything in it.
    fn names(&self) -> Vec<PathBuf> {
        let mut names: Vec<PathBuf> =
            std::fs::read_dir(self.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
        names.sort();
        names
    }

    fn radiance(&self, name: &str, film: &Film, unit: &str) -> String {
        let path = self.path().join(name);
        let provenance = Provenance { unit: unit.into(), scene_name: name.into(), ..Provenance::default() };
        write_radiance(&path, film, &Provenance { scene_sha256: name.into(), ..provenance }).unwrap();
        shown(path)
    }
}

/// A scene of the repository with a camera of 48 x 36 pixels.
fn small(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).with_extension("toml");
    let text = std::fs::read_to_string(path).unwrap();
    let line = text.lines().find(|line| line.starts_with("pixels = ")).unwrap();
    text.replace(line, "pixels = [48, 36]") + "\n[render]\nphotons = 65536\nmap_texel_mm = 0.5\n"
}

fn shown(path: PathBuf) -> String {
    path.into_os_string().into_string().unwrap()
}

const UNIT: &str = "W/(m^2 sr)";

#[test]
fn compare_passes_equal_light_and_says_so() {
    let place = Place::new();
    let a = place.radiance("a.exr", &film(1, 1.0), UNIT);
    let b = place.radiance("b.exr", &film(2, 1.0), UNIT);
    let output = tirtouch(&["compare", &a, &b]);
    assert_eq!(code(&output), 0, "{output:?}");
    assert!(text(&output.stdout).starts_with("same"), "{output:?}");
    assert!(output.stderr.is_empty(), "{output:?}");
}

#[test]
fn compare_fails_with_exit_code_1_on_light_of_another_brightness() {
    let place = Place::new();
    let a = place.radiance("a.exr", &film(1, 1.0), UNIT);
    let b = place.radiance("b.exr", &film(2, 1.02), UNIT);
    let output = tirtouch(&["compare", &a, &b, "--json"]);
    assert_eq!(code(&output), 1, "{output:?}");
    let found = json(&output);
    assert_eq!(found["passed"], false);
    assert_eq!(found["level"], 0.001);
    assert_eq!(found["tests"].as_array().unwrap().len(), 5);
    for key in ["edge", "cells", "max_z", "mean_square", "chi2", "dof", "p_value", "passed", "smallest_change"] {
        assert!(!found["tests"][0][key].is_null(), "{key}");
    }
    // Whole images err by 0.05/32 = 0.16 % each: the interval holds 1.02 and not 1.
    assert!(found["ratio"]["low"].as_f64().unwrap() > 1.0, "{found}");
    assert!(found["ratio"]["high"].as_f64().unwrap() > 1.02, "{found}");
    assert!(found["mean_a"].is_number() && found["mean_b"].is_number());
}

#[test]
fn an_image_that_does_not_say_its_replicates_is_taken_to_have_few() {
    let place = Place::new();
    let folder = |seed: u64| {
        let film = film(seed, 1.0);
        let folder = place.path().join(seed.to_string());
        std::fs::create_dir(&folder).unwrap();
        for (name, values) in [("mean.exr", &film.mean), ("variance.exr", &film.variance)] {
            let channel = AnyChannel::new("Y", FlatSamples::F32(values.clone()));
            let encoding = Encoding {
                compression: Compression::PIZ,
                blocks: Blocks::ScanLines,
                line_order: LineOrder::Increasing,
            };
            let channels = AnyChannels::sort(std::iter::once(channel).collect());
            let layer = Layer::new((32, 32), LayerAttributes::default(), encoding, channels);
            Image::from_layer(layer).write().to_file(folder.join(name)).unwrap();
        }
        shown(folder)
    };
    let (a, b) = (folder(1), folder(2));
    let largest = |replicates: &str| {
        let output = tirtouch(&["compare", &a, &b, "--json", "--replicates", replicates]);
        assert_eq!(code(&output), 0, "{output:?}");
        json(&output)["tests"][0]["max_z"].as_f64().unwrap()
    };
    // The fewer runs, the less a large quotient means.
    assert!(largest("4") < largest("16") && largest("16") < largest("1000"));
    let refused = tirtouch(&["compare", &a, &b, "--replicates", "1"]);
    assert_eq!(code(&refused), 2, "{refused:?}");
}

#[test]
fn compare_takes_folders_that_render_wrote() {
    let place = Place::new();
    for (folder, seed) in [("a", 1), ("b", 2)] {
        std::fs::create_dir(place.path().join(folder)).unwrap();
        place.radiance(&format!("{folder}/radiance.exr"), &film(seed, 1.0), UNIT);
        place.write(&format!("{folder}/camera.png"), "not looked at");
    }
    let output = tirtouch_in(place.path(), &["compare", "a", "b", "--json"]);
    assert_eq!(code(&output), 0, "{output:?}");
    assert_eq!((&json(&output)["a"], &json(&output)["b"]), (&"a".into(), &"b".into()));
    std::fs::create_dir(place.path().join("empty")).unwrap();
    let refused = tirtouch_in(place.path(), &["compare", "a", "empty"]);
    assert_eq!(code(&refused), 2, "{refused:?}");
    assert!(one_line(&refused).contains("radiance.exr") && one_line(&refused).contains("mean.exr"), "{refused:?}");
}

#[test]
fn a_preset_of_the_other_kind_names_its_command() {
    for (arguments, named) in [
        (["run", "preset:frames-galea"], "a scan scene, which frames takes"),
        (["inspect", "preset:frames-galea"], "a scan scene, which frames takes"),
        (["frames", "preset:tsis-dent"], "a scene of a sensor, which run"),
    ] {
        let output = tirtouch(&arguments);
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains(named), "{output:?}");
    }
}

#[test]
fn dark_images_are_the_same_and_their_ratio_undefined() {
    let place = Place::new();
    let a = place.radiance("a.exr", &film(1, 0.0), UNIT);
    let output = tirtouch(&["compare", &a, &a, "--json", "--quiet"]);
    assert_eq!(code(&output), 0, "{output:?}");
    assert!(json(&output)["ratio"]["undefined"].is_string());
}

#[test]
fn images_of_one_seed_are_noted_unless_quiet() {
    let place = Place::new();
    let a = place.radiance("a.exr", &film(1, 1.0), UNIT);
    assert!(one_line(&tirtouch(&["compare", &a, &a])).contains("seed"));
    assert!(tirtouch(&["compare", &a, &a, "--quiet"]).stderr.is_empty());
}

/// Writes a film that says its seed and its work.
fn of_one_seed(place: &Place, name: &str, film: &Film) -> String {
    let path = place.path().join(name);
    let provenance = Provenance {
        unit: UNIT.into(),
        scene_sha256: name.into(),
        seed: 7,
        spp: 16,
        integrator: "path".into(),
        ..Provenance::default()
    };
    write_radiance(&path, film, &provenance).unwrap();
    shown(path)
}

#[test]
fn images_of_one_seed_are_compared_replicate_by_replicate() {
    let place = Place::new();
    // The same noise, 0.1 % brighter: 0.6 standard errors of the whole image.
    let [a, again, brighter] = [("a.exr", 1.0), ("again.exr", 1.0), ("brighter.exr", 1.001)]
        .map(|(name, mean)| of_one_seed(&place, name, &film(1, mean)));
    let same = tirtouch(&["compare", &a, &again]);
    assert_eq!(code(&same), 0, "{same:?}");
    assert!(text(&same.stdout).contains("replicate by replicate") && same.stderr.is_empty(), "{same:?}");
    let found = tirtouch(&["compare", &a, &brighter, "--json"]);
    assert_eq!(code(&found), 1, "{found:?}");
    let found = json(&found);
    assert_eq!(found["paired"]["passed"], false);
    assert!((found["paired"]["ratio"]["value"].as_f64().unwrap() - 1.001).abs() < 1e-5, "{found}");
    assert!(found["tests"].as_array().unwrap().iter().all(|test| test["passed"] == true), "{found}");
}

#[test]
fn exact_and_tolerant_comparisons_see_single_pixels_and_no_noise() {
    let place = Place::new();
    let film = film(1, 1.0);
    let mut other = film.clone();
    other.mean[32 * 4 + 9] *= 1.01;
    let (a, b) = (place.radiance("a.exr", &film, UNIT), place.radiance("b.exr", &other, UNIT));
    assert_eq!(code(&tirtouch(&["compare", &a, &b, "--quiet"])), 0, "1 % of a pixel is noise");
    for (flags, expected) in [
        (&["--exact"][..], 1),
        (&["--tolerance", "0.0101"], 0),
        (&["--tolerance", "0.0098"], 1),
        (&["--absolute", "0.02"], 0),
        (&["--absolute", "1e-3", "--tolerance", "1e-3"], 1),
    ] {
        let output = tirtouch(&[&["compare", &a, &b, "--json"], flags].concat());
        assert_eq!(code(&output), expected, "{flags:?}: {output:?}");
        let found = json(&output);
        assert!((found["largest_relative"].as_f64().unwrap() - 0.0099).abs() < 1e-5, "{found}");
        if expected == 1 {
            let place = ["row", "column"].map(|key| found["first"][key].as_u64().unwrap());
            assert_eq!((found["outside"].as_u64(), place), (Some(1), [5, 10]), "{found}");
        }
    }
    assert_eq!(code(&tirtouch(&["compare", &a, &a, "--exact"])), 0);
    assert_eq!(code(&tirtouch(&["compare", &a, &b, "--exact", "--tolerance", "1"])), 2);
    assert_eq!(code(&tirtouch(&["compare", &a, &b, "--tolerance", "-1"])), 2);
}

#[test]
fn a_picture_of_the_difference_is_written_where_images_differ() {
    let place = Place::new();
    let [a, b] = [("a.exr", 1.0), ("b.exr", 1.1)].map(|(name, mean)| place.radiance(name, &film(1, mean), UNIT));
    let folder = shown(place.path().join("difference"));
    assert_eq!(code(&tirtouch(&["compare", &a, &a, "--exact", "-o", &folder])), 0);
    assert!(!Path::new(&folder).exists(), "nothing to show");
    for flags in [&[][..], &["--exact", "--force"]] {
        assert_eq!(code(&tirtouch(&[&["compare", &a, &b, "-o", &folder], flags].concat())), 1);
        assert!(std::fs::read_to_string(Path::new(&folder).join("difference.svg")).unwrap().contains("B - A"));
    }
    assert_eq!(code(&tirtouch(&["compare", &a, &b, "-o", &folder])), 2, "it exists");
}

#[test]
fn bad_input_is_exit_code_2_and_one_line_that_names_the_file() {
    let place = Place::new();
    let good = place.radiance("good.exr", &film(1, 1.0), UNIT);
    let other_unit = place.radiance("unit.exr", &film(1, 1.0), "cd/m^2");
    let mut small = BlockAccumulator::new(8, 4);
    small.add(&[1.0; 32]).unwrap();
    small.add(&[2.0; 32]).unwrap();
    let small = place.radiance("small.exr", &small.finish(), UNIT);
    let missing = shown(place.path().join("missing.exr"));
    let text = shown(place.path().join("text.exr"));
    std::fs::write(&text, "no image").unwrap();
    let empty = shown(place.path().join("empty"));
    std::fs::create_dir(&empty).unwrap();
    let mut cut = std::fs::read(&good).unwrap();
    cut.truncate(cut.len() / 2);
    let half = shown(place.path().join("half.exr"));
    std::fs::write(&half, cut).unwrap();
    for bad in [&other_unit, &small, &missing, &text, &empty, &half] {
        let output = tirtouch(&["compare", &good, bad]);
        assert_eq!(code(&output), 2, "{bad}: {output:?}");
        assert!(one_line(&output).contains(bad.as_str()), "{output:?}");
        assert!(output.stdout.is_empty());

        let output = tirtouch(&["compare", &good, bad, "--json"]);
        assert_eq!(code(&output), 2);
        let error = &json(&output)["error"];
        assert_eq!(error["kind"], "input");
        assert_eq!(error["message"], one_line(&output));
        assert!(error["file"].as_str().unwrap().starts_with(bad.as_str()), "{error}");
        assert!(error["line"].is_null() && error["key"].is_null());
    }
}

#[test]
fn wrong_use_is_exit_code_2_and_one_line() {
    for arguments in [
        &["compare", "a"][..],
        &["compare", "a", "b", "c"],
        &["compare", "a", "b", "--levels", "1"],
        &["compare", "a", "b", "--level", "2"],
        &["compare", "a", "b", "--level", "nan"],
        &["compare", "a", "b", "--level", "-1"],
        &["comprae"],
        &["--wrong"],
        &[],
    ] {
        let output = tirtouch(arguments);
        assert_eq!(code(&output), 2, "{arguments:?}");
        assert!(!one_line(&output).is_empty());
        assert!(output.stdout.is_empty(), "{arguments:?}");

        let output = tirtouch(&[arguments, &["--json"]].concat());
        assert_eq!(json(&output)["error"]["kind"], "usage", "{arguments:?}");
        assert_eq!(code(&output), 2, "{arguments:?}");
    }
}

#[test]
fn help_and_version_are_no_errors() {
    for (arguments, expected) in
        [(&["--help"][..], "compare"), (&["compare", "--help"], "--level"), (&["--version"], env!("CARGO_PKG_VERSION"))]
    {
        let output = tirtouch(arguments);
        assert_eq!(code(&output), 0);
        assert!(text(&output.stdout).contains(expected), "{output:?}");
        assert!(output.stderr.is_empty());
    }
}

/// /dev/full takes no byte.
#[cfg(target_os = "linux")]
#[test]
fn results_that_cannot_be_written_are_exit_code_3() {
    let place = Place::new();
    let a = place.radiance("a.exr", &film(1, 1.0), UNIT);
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tirtouch"));
    let output = command.args(["compare", &a, &a, "--quiet"]).stdout(full).output().unwrap();
    assert_eq!(code(&output), 3, "{output:?}");
    assert!(one_line(&output).contains("standard output"));
}
