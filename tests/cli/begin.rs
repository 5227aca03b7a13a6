//! `new`, `completions` and `man`.

use super::*;
use std::process::Stdio;
use tirtouch::scene::begin::BEGINNINGS;
use tirtouch::scene::{Scene, parse, preset};
use tirtouch::view::Knob;

#[test]
fn a_new_scene_is_one_that_can_be_inspected() {
    let folder = tempfile::tempdir().unwrap();
    for kind in ["sensor", "dent", "contact", "phantom"] {
        let set = ["--set", "stack.layer[0].n=1.43"];
        let made = tirtouch_in(folder.path(), &[&["new", &format!("my-{kind}"), "--kind", kind], &set[..]].concat());
        assert_eq!(code(&made), 0, "{made:?}");
        let file = folder.path().join(format!("my-{kind}.toml"));
        let seen = json(&tirtouch(&["inspect", &shown(file.clone()), "--json"]));
        assert_eq!(seen["scene"], format!("my-{kind}"), "{seen}");
        assert_eq!(seen["layers"][0]["n"], 1.43, "{seen}");
        assert!(std::fs::read_to_string(file).unwrap().starts_with("#:schema tirtouch.schema.json\n"));
    }
    let schema = std::fs::read(folder.path().join("tirtouch.schema.json")).unwrap();
    assert!(serde_json::from_slice::<Value>(&schema).unwrap()["properties"]["stack"].is_object());

    for name in ["my-dent", "my-dent.toml"] {
        let again = tirtouch_in(folder.path(), &["new", name]);
        assert_eq!((code(&again), one_line(&again)), (2, "./my-dent.toml: is there already"));
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("nowhere", folder.path().join("link.toml")).unwrap();
        let refused = tirtouch_in(folder.path(), &["new", "link"]);
        assert_eq!((code(&refused), one_line(&refused)), (2, "./link.toml: is there already"));
    }
    // Several at once: one of them writes it.
    let start = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tirtouch"));
        command.args(["new", "same"]).current_dir(folder.path()).stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().unwrap()
    };
    let started: Vec<_> = (0..6).map(|_| start()).collect();
    let codes: Vec<_> = started.into_iter().map(|mut child| child.wait().unwrap().code().unwrap()).collect();
    assert_eq!(codes.iter().filter(|code| **code == 0).count(), 1, "{codes:?}");
    assert_eq!(codes.iter().filter(|code| **code == 2).count(), 5, "{codes:?}");
    for name in ["", "../a", ".a", "a/b", "a\nb"] {
        let refused = tirtouch_in(folder.path(), &["new", name]);
        assert_eq!(code(&refused), 2, "{refused:?}");
        assert!(one_line(&refused).contains("a name has letters"), "{refused:?}");
    }
    let wrong = tirtouch_in(folder.path(), &["new", "other", "--set", "stack.layer[0].n=-1"]);
    assert_eq!(code(&wrong), 2);
    assert!(one_line(&wrong).contains("stack.layer[0].n") && !folder.path().join("other.toml").exists());
}

#[test]
fn shells_and_manuals_know_every_command() {
    let help = tirtouch(&["--help"]);
    let commands = text(&help.stdout).lines().skip_while(|line| !line.starts_with("Commands:")).skip(1);
    let commands: Vec<&str> = commands.map_while(|line| line.strip_prefix("  ")?.split(' ').next()).collect();
    assert!(commands.contains(&"sweep") && commands.contains(&"view"), "{commands:?}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let printed = tirtouch(&["completions", shell]);
        assert_eq!(code(&printed), 0);
        let printed = text(&printed.stdout);
        assert!(commands.iter().all(|command| printed.contains(command)), "{shell}");
    }
    let refused = tirtouch(&["man", &shown(std::env::current_exe().unwrap())]);
    assert_eq!(code(&refused), 2, "{refused:?}");
    assert!(one_line(&refused).contains("is no folder"));
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("man/man1");
    assert_eq!(code(&tirtouch(&["man", &shown(pages.clone())])), 0);
    for command in commands.iter().filter(|command| **command != "help") {
        let page = std::fs::read_to_string(pages.join(format!("tirtouch-{command}.1"))).unwrap();
        assert!(page.contains(".SH NAME"), "{command}");
    }
    let all = std::fs::read_dir(&pages).unwrap().map(|page| page.unwrap().file_name().into_string().unwrap());
    assert!(all.into_iter().all(|name| name.starts_with("tirtouch") && name.ends_with(".1")));
}

#[test]
fn every_beginning_is_a_scene_that_has_what_is_asked() {
    for beginning in BEGINNINGS {
        let loaded = preset(beginning.preset).unwrap();
        let file = Path::new("mine.toml");
        let knobs = Knob::of(&loaded, file, &[]).unwrap();
        for (key, _) in beginning.questions {
            assert!(knobs.iter().any(|knob| knob.key == *key), "{beginning:?}: {key}");
        }
        let begun = parse(&beginning.text(&loaded, "mine", "schema.json"), file).unwrap().scene;
        let named = (begun.name.as_str(), begun.description.contains(beginning.preset));
        assert_eq!(named, ("mine", true));
        let (name, description) = (loaded.scene.name.clone(), loaded.scene.description.clone());
        assert_eq!(Scene { name, description, ..begun }, loaded.scene, "{beginning:?}");
    }
}
