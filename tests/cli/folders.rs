//! Output folders: what is replaced, who writes, what a stop leaves, what a result says of itself.

#![cfg(unix)]

use super::frames::names;
use super::*;
use std::process::{Child, Stdio};

/// A render that would take hours.
const ENDLESS: [&str; 7] = ["render", "scene.toml", "--spp", "100000000", "--backend", "cpu", "--quiet"];
/// One that takes a moment.
const SHORT: [&str; 9] = ["render", "scene.toml", "--spp", "1", "--photons", "1000", "--backend", "cpu", "--json"];

/// A run in the background, which does not outlive its test.
pub(super) struct Background(Option<Child>);

impl Background {
    pub(super) fn start(place: &Place, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tirtouch"));
        command.args(arguments).current_dir(place.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(Some(command.spawn().unwrap()))
    }

    pub(super) fn child(&mut self) -> &mut Child {
        self.0.as_mut().unwrap()
    }

    fn signal(&mut self, name: &str) {
        let id = self.child().id().to_string();
        assert!(Command::new("kill").args([name, &id]).status().unwrap().success());
    }

    pub(super) fn end(mut self) -> Output {
        wait_until("it stops", || self.child().try_wait().unwrap().is_some());
        self.0.take().unwrap().wait_with_output().unwrap()
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }
}

/// Waits until `ready`: two minutes, which nothing but a fault takes.
pub(super) fn wait_until(what: &str, mut ready: impl FnMut() -> bool) {
    for _ in 0..12_000 {
        if ready() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("it never came to this: {what}");
}

#[test]
fn force_spares_what_this_program_did_not_write() {
    let place = Place::new();
    place.write("scene.toml", &small("tsis-dent"));
    std::fs::create_dir(place.path().join("here")).unwrap();
    place.write("here/thesis.tex", "years");
    let forced = [&SHORT[..], &["-o", "here", "--force"]].concat();
    let refused = tirtouch_in(place.path(), &forced);
    assert_eq!(code(&refused), 2, "{refused:?}");
    assert!(one_line(&refused).contains("thesis.tex"), "{refused:?}");
    assert_eq!(names(&place.path().join("here")), ["thesis.tex"]);

    std::fs::remove_file(place.path().join("here/thesis.tex")).unwrap();
    for _ in 0..2 {
        let output = tirtouch_in(place.path(), &forced);
        assert_eq!(code(&output), 0, "an empty folder and one of its own are replaced: {output:?}");
    }
    place.write("here/notes.txt", "mine");
    let refused = tirtouch_in(place.path(), &forced);
    assert_eq!(code(&refused), 2, "{refused:?}");
    assert!(one_line(&refused).contains("notes.txt"), "{refused:?}");
    assert!(place.path().join("here/notes.txt").exists() && place.path().join("here/radiance.exr").exists());
}

#[test]
fn a_second_run_of_a_folder_is_refused_at_once_and_a_killed_one_leaves_no_trace() {
    let place = Place::new();
    place.write("scene.toml", &small("tsis-dent"));
    let mut first = Background::start(&place, &[&ENDLESS[..], &["-o", "new/result"]].concat());
    let partial = place.path().join("new/.result.tirtouch.partial");
    wait_until("the first run writes", || partial.exists());
    // It returns although the first never would.
    let second = tirtouch_in(place.path(), &[&SHORT[..], &["-o", "new/result"]].concat());
    assert_eq!(code(&second), 2, "{second:?}");
    assert!(one_line(&second).contains("another run"), "{second:?}");
    let other = tirtouch_in(place.path(), &[&SHORT[..], &["-o", "new/other"]].concat());
    assert_eq!(code(&other), 0, "{other:?}");

    first.signal("-KILL");
    first.end();
    assert!(partial.exists(), "it had no chance");
    let third = tirtouch_in(place.path(), &[&SHORT[..], &["-o", "new/result"]].concat());
    assert_eq!(code(&third), 0, "{third:?}");
    assert_eq!(names(&place.path().join("new")), ["other", "result"]);
}

/// This press is meshed within a second; then its first factorisation takes minutes, and nothing interrupts it.
/// Wherever the signals meet it (the pause is for the second stage, and no verdict hangs on it), it stops.
#[test]
fn a_stop_does_not_wait_for_a_factorisation() {
    let place = Place::new();
    let scene = include_str!("../../scenes/phantom-size-8mm.toml")
        .replace("depths_mm = [1.0, 2.0, 4.0]", "depths_mm = [1.0]\ndimensions = \"three\"\nresolution = 1.5");
    place.write("scene.toml", &scene);
    for (name, json, pause_s) in [("-INT", true, 0), ("-TERM", false, 3)] {
        let arguments = ["press", "scene.toml", "-o", "new/result", "--quiet", "--json"];
        let mut run = Background::start(&place, if json { &arguments } else { &arguments[..5] });
        wait_until("it writes", || place.path().join("new/.result.tirtouch.partial").exists());
        std::thread::sleep(std::time::Duration::from_secs(pause_s));
        run.signal(name);
        let output = run.end();
        assert_eq!(code(&output), 3, "{output:?}");
        assert_eq!(one_line(&output), "stopped on request; nothing was written");
        match json {
            true => assert_eq!(super::json(&output)["error"]["kind"], "cancelled"),
            false => assert!(output.stdout.is_empty()),
        }
        assert_eq!(names(place.path()), ["scene.toml"]);
    }
}

#[test]
fn a_second_signal_ends_a_ladder_at_once_and_its_rungs_stay() {
    let place = Place::new();
    place.write("scene.toml", &small("flat-bonded"));
    let flags = ["converge", "scene.toml", "--spp", "16384", "-o", "ladders", "--backend", "cpu", "--quiet"];
    let mut run = Background::start(&place, &flags);
    let order = place.path().join("ladders/items/order.json");
    wait_until("it has begun", || order.exists());
    let second = tirtouch_in(place.path(), &[&flags[..], &["--resume"]].concat());
    assert_eq!(code(&second), 2, "{second:?}");
    assert!(one_line(&second).contains("another run"), "{second:?}");
    run.signal("-TERM");
    run.signal("-INT");
    let output = run.end();
    assert_eq!(code(&output), 3, "{output:?}");
    assert!(one_line(&output).ends_with("go on with --resume"), "{output:?}");
    assert!(order.exists());
    assert_eq!(names(place.path()), ["ladders", "scene.toml"]);
    assert_eq!(
        std::fs::read(place.path().join("ladders/scene.toml")).unwrap(),
        std::fs::read(place.path().join("scene.toml")).unwrap()
    );
}

#[test]
fn a_result_says_what_made_it_and_what_is_true() {
    let place = Place::new();
    let scene = include_str!("../../scenes/phantom-size-8mm.toml")
        .replace("pixels = [348, 261]", "pixels = [32, 24]")
        .replace("depths_mm = [1.0, 2.0, 4.0]", "depths_mm = [0.5]\nresolution = 0.5\nestimate_error = false")
        + "\n[render]\nmap_texel_mm = 0.5\n";
    let scene = scene.replace('\n', "\r\n");
    place.write("scene.toml", &scene);
    let flags = ["run", "scene.toml", "--spp", "16", "--photons", "1000", "--backend", "cpu", "--json", "--out=result"];
    let output = tirtouch_in(place.path(), &flags);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    let folder = place.path().join("result");
    assert_eq!(std::fs::read(folder.join("scene.toml")).unwrap(), scene.as_bytes());
    let kept: Value = serde_json::from_slice(&std::fs::read(folder.join("result.json")).unwrap()).unwrap();
    assert_eq!(kept, said);
    let command: Vec<&str> = said["command"].as_array().unwrap().iter().map(|word| word.as_str().unwrap()).collect();
    assert_eq!(command[1..], flags);
    assert_eq!(said["version"], env!("CARGO_PKG_VERSION"));
    // The sphere of the scene: 8 mm, its top 5 mm deep, 120 kPa, in 5 kPa.
    let truth = &said["truth"];
    assert_eq!(truth["phantom_youngs_kpa"], 5.0);
    assert_eq!([&truth["size_mm"], &truth["depth_mm"], &truth["youngs_kpa"]], [8.0, 5.0, 120.0]);
    let inclusion = &truth["inclusions"][0];
    assert_eq!([&inclusion["size_mm"], &inclusion["depth_mm"], &inclusion["youngs_kpa"]], [8.0, 5.0, 120.0]);
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.contains("true size") && page.contains("--out=result"));

    let header = tirtouch::image_io::read_radiance(&folder.join("radiance.exr")).unwrap().1.unwrap();
    assert_eq!(header.command, "tirtouch run scene.toml --spp 16 --photons 1000 --backend cpu");
    // The list is that of `sha256sum`, of all files but itself.
    let sums = std::fs::read_to_string(folder.join("SHA256SUMS")).unwrap();
    let listed: Vec<&str> = sums.lines().skip(1).map(|line| line.split_once("  ").unwrap().1).collect();
    let there: Vec<String> = names(&folder).into_iter().filter(|name| name != "SHA256SUMS").collect();
    assert_eq!(listed, there);
}
