//! Sweeps: every point is computed once, whatever ends a run; what is wrong is told before anything is written.

use super::folders::{Background, wait_until};
use super::*;

/// Four indices and two radii of a disc of contact: 8 points, two of which a constraint leaves out.
pub const SWEEP: &str = "[sweep]\nscene = \"disc.toml\"\ndesign = { kind = \"grid\" }\n\
                     [[vary]]\nname = \"top\"\nkey = \"stack.layer[0].n\"\nlinear = { from = 1.40, to = 1.43, points = 4 }\n\
                     [[vary]]\nname = \"radius\"\nkey = \"touch.contact.pressure.radius_mm\"\nvalues = [3, 4]\n\
                     [[vary]]\nname = \"below\"\nkey = \"stack.layer[1].n\"\nexpression = \"top - 0.01\"\n\
                     [[require]]\nexpression = \"top < 1.425\"\nreason = \"a top that is too dense\"\n\
                     [[measure]]\nkind = \"mean_radiance\"\n\
                     [[measure]]\nkind = \"contrast\"\nradius_mm = 3\naround_mm = [5, 7]\n";

/// A folder with that sweep.
pub fn place() -> Place {
    let place = Place::new();
    place.write("disc.toml", &(small("contact-disc").replace("photons = 65536", "photons = 16384\nspp = 16")));
    place.write("sweep.toml", SWEEP);
    place
}

pub fn sweep(place: &Place, arguments: &[&str]) -> Output {
    tirtouch_in(place.path(), &[&["sweep"], arguments].concat())
}

pub fn run(place: &Place, out: &str, flags: &[&str]) -> Output {
    sweep(place, &[&["run", "sweep.toml", "-o", out, "--backend", "cpu", "--quiet"], flags].concat())
}

pub fn points(place: &Place, out: &str) -> String {
    std::fs::read_to_string(place.path().join(out).join("points.csv")).unwrap()
}

fn items(place: &Place, out: &str) -> Vec<PathBuf> {
    // What belongs to no point or press.
    let others = ["order.json", "place.json", "tables.json"];
    let is_point = |path: &PathBuf| !others.iter().any(|other| path.file_name().unwrap() == *other);
    let entries = std::fs::read_dir(place.path().join(out).join("items")).into_iter().flatten();
    let mut items: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).filter(is_point).collect();
    items.sort();
    items
}

#[test]
fn a_sweep_ends_bit_equal_whatever_stopped_it() {
    let place = place();
    let output = run(&place, "whole", &["--json"]);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    assert_eq!([&said["points"], &said["done"], &said["rejected"], &said["failed"]], [8, 6, 2, 0]);
    assert!(said["points_per_minute"].as_f64().unwrap() > 0.0);
    let whole = points(&place, "whole");
    let rows: Vec<&str> = whole.lines().collect();
    assert_eq!(rows.len(), 9, "{whole}");
    assert!(rows[0].starts_with("row,status,top,radius,below,mean_radiance_w_m2_sr,"), "{whole}");
    assert!(rows[1].starts_with("0,done,1.4,3,1.39,") && rows[8].contains("a top that is too dense"), "{whole}");
    assert!(rows[8].starts_with("7,rejected,1.43,4,1.42,"), "what is rejected is known: {whole}");
    let page = std::fs::read_to_string(place.path().join("whole/report.html")).unwrap();
    assert!(page.contains("Rejected and failed") && page.contains("a top that is too dense"));

    // Killed at any moment, with `kill -9`: nothing that was done is lost.
    let mut killed = 0;
    for _ in 0..4 {
        let before = items(&place, "killed").len();
        let flags = ["sweep", "run", "sweep.toml", "-o", "killed", "--backend", "cpu", "--quiet", "--resume"];
        let flags = if before == 0 { &flags[..8] } else { &flags[..] };
        let mut worker = Background::start(&place, flags);
        wait_until("a point is done or it ends", || {
            items(&place, "killed").len() > before || worker.child().try_wait().unwrap().is_some()
        });
        killed += u32::from(worker.child().try_wait().unwrap().is_none());
        drop(worker);
        assert!(items(&place, "killed").len() > before);
    }
    assert!(killed >= 2, "{killed}");
    let kept: Vec<_> = items(&place, "killed").iter().map(|item| std::fs::read(item).unwrap()).collect();
    assert_eq!(code(&run(&place, "killed", &["--resume"])), 0);
    assert_eq!(points(&place, "killed"), whole);
    let after: Vec<_> = items(&place, "killed").iter().map(|item| std::fs::read(item).unwrap()).collect();
    assert!(kept.iter().all(|item| after.contains(item)), "what was done is not done again");

    // A truncated record, one of garbage and one that is gone are computed again, and no other.
    let all = items(&place, "killed");
    let bytes = std::fs::read(&all[0]).unwrap();
    std::fs::write(&all[0], &bytes[..bytes.len() / 2]).unwrap();
    std::fs::write(&all[1], [0xff; 99]).unwrap();
    std::fs::remove_file(&all[2]).unwrap();
    let status = json(&sweep(&place, &["status", "killed", "--json"]));
    assert_eq!([&status["done"], &status["damaged"]], [3, 2]);
    assert!(points(&place, "killed") == whole && code(&sweep(&place, &["collect", "killed"])) == 0);
    assert!(points(&place, "killed").contains("0,missing,1.4,3,1.39"));
    assert_eq!(code(&run(&place, "killed", &["--resume"])), 0);
    assert_eq!(points(&place, "killed"), whole);

    // Three workers at once in one folder, and the same in two parts by hand.
    let flags = ["sweep", "run", "sweep.toml", "-o", "shared", "--backend", "cpu", "--quiet", "--resume"];
    let first = Background::start(&place, &flags[..8]);
    wait_until("the folder is there", || place.path().join("shared/items/order.json").exists());
    let others = [(); 2].map(|()| Background::start(&place, &flags));
    for worker in others.into_iter().chain([first]) {
        let output = worker.end();
        assert_eq!(code(&output), 0, "{output:?}");
    }
    assert_eq!(points(&place, "shared"), whole);
    for (part, flags) in [("1/2", &["--shard", "1/2"][..]), ("2/2", &["--shard", "2/2", "--resume"])] {
        assert_eq!(code(&run(&place, "parts", flags)), 0, "{part}");
    }
    assert_eq!(points(&place, "parts"), whole);

    // A point is a scene of its own: rendered by hand, it is the same scene.
    let scene = sweep(&place, &["scene", "whole", "3"]);
    assert_eq!(code(&scene), 0, "{scene:?}");
    let tirtouch::scene::Loaded { scene, sha256, .. } =
        tirtouch::scene::parse(text(&scene.stdout), Path::new("point.toml")).unwrap();
    let record = std::fs::read_to_string(place.path().join("whole/items/0000003.json")).unwrap();
    assert!(record.contains(&format!("\"scene_sha256\":\"{sha256}\"")), "{record}");
    assert_eq!(scene.stack.layer[0].n, Some(1.41));
    assert_eq!(scene.stack.layer[1].n, Some(1.41 - 0.01));
    let none = sweep(&place, &["scene", "whole", "7"]);
    assert!(code(&none) == 2 && one_line(&none).contains("a top that is too dense"), "{none:?}");
}

#[test]
fn another_order_is_refused_with_the_difference() {
    let place = place();
    place.write("sweep.toml", &SWEEP.replace("points = 4", "points = 1"));
    assert_eq!(code(&run(&place, "out", &[])), 0);
    let before = points(&place, "out");
    let again = run(&place, "out", &[]);
    assert!(code(&again) == 2 && one_line(&again).contains("--resume"), "{again:?}");
    place.write("sweep.toml", &SWEEP.replace("points = 4", "points = 2"));
    let other = run(&place, "out", &["--resume"]);
    assert_eq!(code(&other), 2);
    let said = one_line(&other);
    assert!(said.contains("line 7 of sweep") && said.contains("points = 1") && said.contains("points = 2"), "{said}");
    let scene = std::fs::read_to_string(place.path().join("disc.toml")).unwrap();
    place.write("sweep.toml", &SWEEP.replace("points = 4", "points = 1"));
    place.write("disc.toml", &scene.replace("pixels = [48, 36]", "pixels = [40, 30]"));
    let other = run(&place, "out", &["--resume"]);
    assert!(one_line(&other).contains("of scene is \"pixels = [48, 36]\""), "{other:?}");
    assert_eq!(points(&place, "out"), before);
    // Replaced only where it is asked for, and only what this program wrote.
    std::fs::write(place.path().join("out/notes.txt"), "mine").unwrap();
    assert!(one_line(&run(&place, "out", &["--force"])).contains("notes.txt"));
    std::fs::remove_file(place.path().join("out/notes.txt")).unwrap();
    assert_eq!(code(&run(&place, "out", &["--force"])), 0);
    assert_ne!(points(&place, "out"), before);
}

#[test]
fn a_mistake_in_a_sweep_is_one_line_and_writes_nothing() {
    let vary = |old: &str, new: &str| SWEEP.replace(old, new);
    let axis = "linear = { from = 1.40, to = 1.43, points = 4 }";
    for (file, line, said) in [
        (
            vary(axis, &format!("{axis}\nuniform = [1.4, 1.5]")),
            "[[vary]]",
            "has linear and uniform, which cannot all hold",
        ),
        (vary("stack.layer[0].n", "stack.layer[0].m"), "[[vary]]", "unknown key"),
        (vary("stack.layer[0].n", "stack.layer[9].n"), "key = \"stack.layer[9]", "has 4 elements"),
        (vary(axis, "uniform = [1.4, 1.4]"), "[[vary]]", "must have a width"),
        (vary("kind = \"grid\"", "kind = \"random\", points = 1000000000"), "design", "at most 1000000"),
        (
            vary("values = [3, 4]", "linear = { from = 1, to = 2, points = 100000 }")
                .replace("points = 4", "points = 10000"),
            "design",
            "1000000000 points",
        ),
        (vary("values = [3, 4]", "values = [\"wide\"]"), "[[vary]]", "must be a number"),
        (vary("\"disc.toml\"", "\"dish.toml\""), "scene =", "dish.toml, which is not a file"),
        (vary("kind = \"contrast\"", "kind = \"contrats\""), "contrats", "contrats"),
        (
            vary("kind = \"contrast\"\nradius_mm = 3", "kind = \"contrast\"\nradius_mm = 6"),
            "around_mm",
            "must be [inner, outer]",
        ),
        (vary("kind = \"mean_radiance\"", "kind = \"force\""), "force", "needs a scene with a [press]"),
        (vary("top < 1.425", "tip < 1.425"), "tip", "tip is no variable"),
        (vary("[sweep]", "[sweeep]"), "[sweeep]", "unknown key"),
        (
            SWEEP.replacen("touch.contact.pressure.radius_mm", "stack.layer[\\\"PDMS 1.41\\\"].n", 1),
            "layer[\\\"PDMS",
            "varies stack.layer[0].n, which top varies too",
        ),
        (vary("\"radius\"", "\"contrast_low\""), "contrast_low", "is a column of the tables already"),
    ] {
        let place = place();
        place.write("sweep.toml", &file);
        let before = place.names();
        let output = run(&place, "out", &["--json"]);
        assert_eq!(code(&output), 2, "{said}: {output:?}");
        let error = &json(&output)["error"];
        let message = error["message"].as_str().unwrap();
        assert!(message.contains(said), "{said}: {message}");
        let at = error["line"].as_u64().unwrap() as usize;
        assert!(file.lines().nth(at - 1).unwrap().contains(line), "{line}: {message}");
        assert_eq!(place.names(), before, "{said}");
    }
    let place = place();
    for (flags, said) in [
        (&["run", "sweep.toml", "--shard", "3/2"][..], "K from 1 to N"),
        (&["run", "none.toml"], "none.toml"),
        (&["status", "."], "holds no records"),
        (&["scene", "sweep.toml", "8"], "has 8 points"),
    ] {
        let output = sweep(&place, flags);
        assert!(code(&output) == 2 && one_line(&output).contains(said), "{output:?}");
    }
}

#[test]
fn a_sweep_none_of_whose_points_is_done_says_why() {
    let place = place();
    place.write("sweep.toml", &SWEEP.replace("top < 1.425", "top < 1"));
    let output = run(&place, "out", &[]);
    assert_eq!(code(&output), 2, "{output:?}");
    let said = one_line(&output);
    assert!(said.contains("none of 8 points is done: point 0: a top that is too dense"), "{said}");
    assert_eq!(points(&place, "out").matches(",rejected,").count(), 8);
}

#[test]
fn records_go_on_where_the_files_have_moved() {
    let place = place();
    place.write("sweep.toml", &SWEEP.replace("points = 4", "points = 1"));
    assert_eq!(code(&run(&place, "out", &[])), 0);
    let whole = points(&place, "out");
    std::fs::create_dir(place.path().join("moved")).unwrap();
    for (from, to) in [("sweep.toml", "renamed.toml"), ("disc.toml", "disc.toml"), ("out", "out")] {
        std::fs::rename(place.path().join(from), place.path().join("moved").join(to)).unwrap();
    }
    std::fs::remove_file(place.path().join("moved/out/items/0000000.json")).unwrap();
    let flags = ["run", "moved/renamed.toml", "-o", "moved/out", "--backend", "cpu", "--quiet", "--resume"];
    assert_eq!(code(&sweep(&place, &flags)), 0);
    assert_eq!(points(&place, "moved/out"), whole);
    // The folder knows where its scene lies now.
    assert_eq!(code(&sweep(&place, &["run", "moved/out", "--backend", "cpu", "--quiet"])), 0);
}

#[test]
fn a_point_that_fails_keeps_its_reason_and_the_others_go_on() {
    let place = place();
    // An exposure without light on the sensor is no fault; a photon map finer than its stack is wide is one of the
    // scene.
    let file = SWEEP.replace(
        "key = \"touch.contact.pressure.radius_mm\"\nvalues = [3, 4]",
        "key = \"render.map_texel_mm\"\nvalues = [-1, 0.5]",
    );
    place.write("sweep.toml", &file);
    let output = run(&place, "out", &["--json"]);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    assert_eq!([&said["done"], &said["rejected"]], [3, 5], "{said}");
    assert!(points(&place, "out").lines().nth(1).unwrap().contains("render.map_texel_mm: must be"));
}

#[test]
fn keys_are_set_by_hand() {
    let place = place();
    let output = tirtouch_in(place.path(), &["inspect", "disc.toml", "--json", "--set", "stack.layer[0].n=1.45"]);
    assert_eq!(json(&output)["layers"][0]["n"], 1.45, "{output:?}");
    let flags = ["--spp", "4", "--photons", "1000", "--backend", "cpu", "--json", "--quiet"];
    let set = ["--set", "stack.layer[*].n=1.4", "--set", "camera.pixels[0]=40", "-o", "set"];
    let output = tirtouch_in(place.path(), &[&["render", "disc.toml"], &flags[..], &set[..]].concat());
    assert_eq!(json(&output)["camera"]["pixels"][0], 40, "{output:?}");
    // The folder's scene is the one that was rendered.
    let kept = std::fs::read_to_string(place.path().join("set/scene.toml")).unwrap();
    assert_eq!(tirtouch::scene::parse(&kept, Path::new("s.toml")).unwrap().scene.camera.pixels, [40, 36]);
    for (set, said) in [
        ("stack.layer[0].n=-1", "stack.layer[0].n: must"),
        ("stack.layer[9].n=1", "elements"),
        ("stack.layer[0].m=1", "unknown key"),
        ("stack", "KEY=VALUE"),
    ] {
        let output = tirtouch_in(place.path(), &["inspect", "disc.toml", "--set", set]);
        assert!(code(&output) == 2 && one_line(&output).contains(said), "{output:?}");
    }

    // A sweep without a file.
    let by_hand = ["disc.toml", "--set", "stack.layer[0].n=1.40:1.42:3", "--measure", "contrast radius_mm=3"];
    let output = sweep(&place, &[&by_hand, &["-o", "hand", "--backend", "cpu", "--json", "--quiet"][..]].concat());
    assert_eq!(json(&output)["done"], 3, "{output:?}");
    assert!(points(&place, "hand").starts_with("row,status,stack.layer[0].n,contrast,contrast_low,contrast_high,"));
    let again = sweep(&place, &[&by_hand, &["-o", "hand", "--backend", "cpu", "--quiet", "--resume"][..]].concat());
    assert_eq!(code(&again), 0);
    // Curves with their intervals are of what varies: a key with one value does not. Choices alone are bars.
    let report = |axis: &str, out: &str| {
        let flags = ["disc.toml", "--set", "render.spp=4", "--set", axis, "-o", out, "--backend", "cpu", "--quiet"];
        assert_eq!(code(&sweep(&place, &flags)), 0, "{axis}");
        std::fs::read_to_string(place.path().join(out).join("report.html")).unwrap()
    };
    let [curve, bars] =
        [report("stack.layer[0].n=1.40:1.42:3", "one"), report("stack.walls.kind=clear,black", "choice")];
    assert!(curve.contains("n, with its 95 % interval.") && !curve.contains("each dot a point"));
    assert!(bars.contains("stack.walls.kind, each bar a point with its 95 % interval."));
    // A value of the wrong type is its own point's mistake, wherever it comes.
    for axis in ["render.spp=1.5,4", "render.spp=4,1.5"] {
        let output = sweep(&place, &["disc.toml", "--set", axis, "-o", axis, "--backend", "cpu", "--json", "--quiet"]);
        assert_eq!([&json(&output)["done"], &json(&output)["rejected"]], [1, 1], "{output:?}");
    }
    for (arguments, said) in [
        (&["disc.toml", "--set", "stack.layer[0].n=1:2"][..], "a range is FROM:TO:POINTS"),
        (&["disc.toml", "--set", "stack.layer[0].n=1,2", "--measure", "brightness"], "brightness"),
        (&["disc.toml"], "--set"),
        (&[], "required"),
    ] {
        let output = sweep(&place, arguments);
        assert!(code(&output) == 2 && one_line(&output).contains(said), "{output:?}");
    }
}

/// Presses that are kept in a folder, by their hashes.
fn presses(place: &Place, out: &str) -> Vec<PathBuf> {
    let is_press = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().starts_with("press-");
    items(place, out).into_iter().filter(is_press).collect()
}

#[test]
fn a_press_that_points_share_is_made_once_for_all_workers() {
    let place = Place::new();
    let scene = include_str!("../../scenes/phantom-size-8mm.toml")
        .replace("pixels = [348, 261]", "pixels = [32, 24]")
        .replace("depths_mm = [1.0, 2.0, 4.0]", "depths_mm = [0.25]\nresolution = 0.5\nestimate_error = false")
        + "\n[render]\nmap_texel_mm = 0.5\nspp = 16\nphotons = 1000\n";
    place.write("phantom.toml", &scene);
    let text = |key: &str, values: &str| {
        format!(
            "[sweep]\nscene = \"phantom.toml\"\ndesign = {{ kind = \"grid\" }}\n[[vary]]\nname = \"v\"\nkey = \"{key}\"\n\
             values = {values}\n[[measure]]\nkind = \"force\"\n[[measure]]\nkind = \"snr\"\nradius_mm = 3\n"
        )
    };
    place.write("sweep.toml", &text("stack.layer[0].n", "[1.40, 1.41, 1.42, 1.43]"));
    assert_eq!(code(&run(&place, "alone", &[])), 0);
    let whole = points(&place, "alone");
    // That of the phantom, and that without the inclusion.
    assert_eq!(presses(&place, "alone").len(), 2);

    // The second program finds what the first one pressed; so does a third, of which one is damaged.
    for shard in ["1/2", "2/2"] {
        assert_eq!(code(&run(&place, "parts", &["--resume", "--shard", shard])), 0);
    }
    assert_eq!((points(&place, "parts"), presses(&place, "parts").len()), (whole.clone(), 2));
    let [first, _] = &presses(&place, "parts")[..] else { panic!("two presses") };
    let sound = std::fs::read(first).unwrap();
    std::fs::write(first, &sound[..sound.len() / 2]).unwrap();
    std::fs::remove_file(place.path().join("parts/items/0000003.json")).unwrap();
    assert_eq!(code(&run(&place, "parts", &["--resume"])), 0);
    assert_eq!((points(&place, "parts"), presses(&place, "parts").len()), (whole, 2));

    // What no other point asks for is not kept.
    place.write("sweep.toml", &text("phantom.material.youngs_kpa", "[4, 5]"));
    assert_eq!(code(&run(&place, "each", &[])), 0);
    assert_eq!(presses(&place, "each"), Vec::<PathBuf>::new());
}

/// A stand-in for Slurm's `sbatch`: runs every task of the array, one after the other, the second one twice.
#[cfg(unix)]
const SBATCH: &str = "#!/bin/bash\nn=$(sed -n 's/^#SBATCH --array=1-//p' \"$1\")\nfor k in $(seq $n) 2; do\n\
                      SLURM_ARRAY_TASK_ID=$k bash \"$1\" || exit 1\ndone\necho Submitted batch job 7\n";

#[cfg(unix)]
#[test]
fn a_job_array_ends_with_the_same_bytes_as_this_machine() {
    use std::os::unix::fs::PermissionsExt as _;
    let place = place();
    assert_eq!(code(&run(&place, "local", &[])), 0);
    place.write("sbatch", SBATCH);
    std::fs::set_permissions(place.path().join("sbatch"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", place.path().display(), std::env::var("PATH").unwrap());
    let send = |flags: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tirtouch"));
        command.args(["sweep", "run", "sweep.toml", "--engine", "slurm", "--tasks", "3", "--json"]).args(flags);
        command.args(["--backend", "cpu"]);
        command.env("PATH", &path).current_dir(place.path()).output().unwrap()
    };
    let output = send(&["-o", "array", "--submit"]);
    assert_eq!(code(&output), 0, "{output:?}");
    assert_eq!([&json(&output)["tasks"], &json(&output)["done"]], [3, 6]);
    for (flags, said) in [(&["--submit"][..], "`--engine slurm`"), (&["--tasks", "3"], "`--engine slurm`")] {
        let wrong = run(&place, "wrong", flags);
        assert!(code(&wrong) == 2 && one_line(&wrong).contains(said), "{wrong:?}");
    }
    let wrong = send(&["-o", "wrong", "--shard", "1/2"]);
    assert!(code(&wrong) == 2 && wrong.stdout.starts_with(b"{") && !place.path().join("wrong").exists(), "{wrong:?}");
    assert_eq!(points(&place, "array"), points(&place, "local"));
    // Without --submit nothing is computed; the folder itself is enough to go on with.
    let output = send(&["-o", "later"]);
    assert_eq!([&json(&output)["done"], &json(&output)["sent"]], [&Value::from(0), &Value::from(false)]);
    std::fs::remove_file(place.path().join("sweep.toml")).unwrap();
    let output = sweep(&place, &["run", "later", "--backend", "cpu", "--quiet"]);
    assert_eq!(code(&output), 0, "{output:?}");
    assert_eq!(points(&place, "later"), points(&place, "local"));
    let wrong = sweep(&place, &["run", "later", "-o", "other"]);
    assert!(code(&wrong) == 2 && one_line(&wrong).contains("neither --out nor --force"), "{wrong:?}");
    // A refusal of Slurm's is one line.
    place.write("sbatch", "#!/bin/bash\necho 'sbatch: error: invalid partition' >&2\nexit 1\n");
    place.write("sweep.toml", SWEEP);
    let refused = send(&["-o", "refused", "--submit"]);
    assert_eq!(code(&refused), 3);
    assert!(one_line(&refused).contains("invalid partition"), "{refused:?}");
}

/// Part of the points is not learnt from: that waits for the others.
#[test]
fn a_calibration_in_parts_waits_for_all() {
    let place = place();
    place.write("cal.toml", "[calibrate]\ndesign = \"sweep.toml\"\n");
    let images = "[sweep]\nimages = { format = \"exr\", loads = \"all\" }\n";
    let calibrate = |flags: &[&str]| {
        let all: Vec<&str> =
            ["calibrate", "cal.toml", "--backend", "cpu", "--quiet"].iter().chain(flags).copied().collect();
        tirtouch_in(place.path(), &all)
    };
    // Without the light nothing is learnt: that is told before the work.
    let output = calibrate(&[]);
    assert!(code(&output) == 2 && one_line(&output).contains("keeps no radiance"), "{output:?}");
    assert_eq!(items(&place, "out/cal/design"), Vec::<PathBuf>::new());
    place.write("sweep.toml", &SWEEP.replacen("[sweep]\n", images, 1));
    for part in ["1/2", "2/2"] {
        let output = calibrate(&["--shard", part, "--json"]);
        let waits = part == "1/2";
        assert_eq!(code(&output), if waits { 0 } else { 2 }, "{output:?}");
        assert!(!waits || json(&output)["file"].is_null(), "{output:?}");
    }
    // All are there, and hold no press to learn from.
    assert!(one_line(&calibrate(&[])).contains("out/cal/design"));
    assert_eq!(items(&place, "out/cal/design").len(), 8, "six points, and two that make no scene");
}
