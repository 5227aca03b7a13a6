//! Size, depth and modulus of an inclusion by the calibration that comes with the program.

use super::*;
use tirtouch::image_io::{read_grey, write_png_grey};

const CALIBRATION: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/calibrations/phantoms.json");

#[test]
fn a_phantom_is_estimated_and_its_frames_say_the_same_from_anywhere() {
    let place = Place::new();
    // Smoothed maps of fewer photons are off by more than their noise (docs/decisions/inference.md).
    let flags = ["--photons", "1000000", "--spp", "16", "--json", "--quiet"];
    let run = |scene: &str, more: &[&str]| {
        let output = tirtouch_in(place.path(), &[&["run", scene][..], &flags, more].concat());
        assert_eq!(code(&output), 0, "{output:?}");
        json(&output)
    };
    let said = run("preset:phantom-size-8mm", &[]);
    let estimates = &said["estimates"];
    assert_eq!(estimates["detected"], true, "{estimates}");
    for (key, truth) in [("size_mm", 8.0), ("depth_mm", 5.0)] {
        let at = |end: &str| estimates[key][end].as_f64().unwrap();
        assert!(at("low") <= truth && truth <= at("high"), "{key}: {estimates}");
        // An interval that says something: the calibration knows 3.8 to 14.5 mm, and depths of 1.9 to 11.3 mm.
        assert!(at("high") - at("low") < 0.5 * truth, "{key}: {estimates}");
    }

    let out = place.path().join("out/phantom-size-8mm");
    let images = ["camera_1mm.png", "camera_2mm.png", "camera.png"].map(|name| shown(out.join(name)));
    let of_images = |more: &[&str]| {
        let images = images.each_ref().map(String::as_str);
        tirtouch_in(place.path(), &[&["estimate", "--json", "--calibration", CALIBRATION][..], &images, more].concat())
    };
    let output = of_images(&["--depths-mm", "1,2,4"]);
    assert_eq!(code(&output), 0, "{output:?}");
    assert_eq!(json(&output)["estimates"], *estimates);
    // It is the calibration that comes with the program.
    let images_alone = images.each_ref().map(String::as_str);
    let words = [&["estimate", "--json", "--depths-mm", "1,2,4"][..], &images_alone].concat();
    assert_eq!(json(&tirtouch_in(place.path(), &words))["estimates"], *estimates);
    // All unknowns of the calibration: the size is the same, the phantom's own modulus is told too.
    let inferred = &json(&output)["inferred"];
    let unknowns = inferred["unknowns"].as_array().unwrap();
    let of = |name: &str| unknowns.iter().find(|one| one["name"] == name).unwrap();
    assert_eq!(of("size")["value"], estimates["size_mm"]);
    assert_eq!(of("phantom")["keys"][0], "phantom.material.youngs_kpa");
    let [low, high] = ["low", "high"].map(|end| of("phantom")["value"][end].as_f64().unwrap());
    assert!(low < 5.0 && 5.0 < high && high - low < 2.0, "{inferred}");
    let correlation = |i: usize, j: usize| inferred["correlations"][i][j].as_f64().unwrap();
    for i in 0..unknowns.len() {
        assert!((correlation(i, i) - 1.0).abs() < 1e-9);
        assert!((0..i).all(|j| correlation(i, j) == correlation(j, i) && correlation(i, j).abs() <= 1.0), "{inferred}");
    }
    assert!(inferred["leds"].as_array().unwrap().iter().all(|led| led["off"].as_f64().unwrap().abs() < 0.04));
    let noise = inferred["noise"].as_f64().unwrap();
    assert!(noise > 0.3 && noise < 3.0, "{inferred}");
    // Forces of the same presses, as far off as they may be, agree and tell more of the tissue; twice as large ones are
    // those of no phantom.
    let forces = |times: f64| {
        let of = |step: &serde_json::Value| (times * step["force_n"].as_f64().unwrap()).to_string();
        said["mechanics"]["steps"].as_array().unwrap().iter().map(of).collect::<Vec<_>>().join(",")
    };
    let with_forces = |times: f64| of_images(&["--depths-mm", "1,2,4", "--forces-n", &forces(times)]);
    let width = |inferred: &serde_json::Value| {
        let one = inferred["unknowns"].as_array().unwrap().iter().find(|one| one["name"] == "phantom").unwrap();
        let [low, high] = ["low", "high"].map(|end| one["value"][end].as_f64().unwrap());
        assert!(low < 5.0 && 5.0 < high, "{inferred}");
        high - low
    };
    let more = json(&with_forces(1.01));
    let at = |end: &str| more["estimates"]["size_mm"][end].as_f64().unwrap();
    assert!(at("low") <= 8.0 && 8.0 <= at("high"), "{more}");
    assert!(width(&more["inferred"]) < 0.8 * width(inferred), "{more}");
    let wrong = json(&with_forces(2.0));
    assert!(wrong["inferred"]["undefined"].as_str().unwrap().contains("forces"), "{wrong}");
    assert_eq!(code(&of_images(&["--depths-mm", "1,2,4", "--forces-n", "1,2"])), 2);
    // Depths that the calibration does not know, and too few of them.
    let other = json(&of_images(&["--depths-mm", "1.5,2.5,5"]));
    assert!(other["inferred"]["undefined"].is_string(), "{other}");
    assert!(other["estimates"]["size_mm"]["undefined"].as_str().unwrap().contains("1, 2, 4, 5.5 mm deep"), "{other}");
    let odd = json(&of_images(&["--depths-mm", "1,2,3"]));
    assert!(odd["inferred"]["undefined"].as_str().unwrap().contains("of 3 mm is of no press"), "{odd}");
    let twice = json(&of_images(&["--depths-mm", "1,1.001,4"]));
    assert!(twice["inferred"]["undefined"].as_str().unwrap().contains("second of one press"), "{twice}");
    assert_eq!(code(&of_images(&["--depths-mm", "1,2"])), 2);

    // The same frames half as bright, and as levels of 16 bits: neither is read as a phantom.
    let other = |name: &str, bits: u32, level: fn(f64) -> f64| {
        let changed = images.each_ref().map(|image| {
            let frame = read_grey(Path::new(image)).unwrap();
            let levels: Vec<u16> = frame.values.iter().map(|grey| level(*grey).round() as u16).collect();
            let file = place.path().join(format!("{name}-{}", Path::new(image).file_name().unwrap().to_str().unwrap()));
            write_png_grey(&file, 348, 261, &levels, bits).unwrap();
            shown(file)
        });
        let changed = changed.each_ref().map(String::as_str);
        let asked = [&["estimate", "--json", "--calibration", CALIBRATION][..], &changed, &["--depths-mm", "1,2,4"]];
        json(&tirtouch_in(place.path(), &asked.concat()))["estimates"].clone()
    };
    let dim = other("dim", 8, |grey| 0.5 * grey);
    assert!(dim["detected"]["undefined"].is_string() && dim["size_mm"]["undefined"].is_string(), "{dim}");
    let deep = other("deep", 16, |grey| 257.0 * grey);
    assert!(deep["detected"]["undefined"].as_str().unwrap().contains("65535"), "{deep}");

    // The same phantom without its inclusion: none is found.
    let none = run("preset:phantom-size-8mm", &["--without-inclusions", "-o", "none"]);
    assert_eq!(none["estimates"]["detected"], false, "{}", none["estimates"]);
    assert!(none["estimates"]["size_mm"]["undefined"].is_string());
}

#[test]
fn a_calibration_of_another_sensor_or_of_nothing_is_said() {
    let place = Place::new();
    let flags = ["--set", "stack.layer[0].n=1.42", "--set", "camera.pixels[0]=29", "--set", "camera.pixels[1]=29"];
    let flags = [&flags[..], &["--photons", "20000", "--spp", "16", "--backend", "cpu", "--json", "--quiet"]].concat();
    let output = tirtouch_in(place.path(), &[&["run", "preset:phantom-size-8mm"][..], &flags].concat());
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    let why = said["estimates"]["size_mm"]["undefined"].as_str().unwrap();
    assert!(why.contains("no calibrated model") && why.contains("another"), "{why}");

    let whole = std::fs::read_to_string(CALIBRATION).unwrap();
    place.write("image.txt", "");
    for (name, text) in [("cut.json", &whole[..whole.len() / 2]), ("empty.json", "{}"), ("list.json", "[1, 2]")] {
        place.write(name, text);
        let output = tirtouch_in(place.path(), &["estimate", "image.txt", "--calibration", name, "--depths-mm", "1"]);
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains("is no calibration"), "{output:?}");
    }
    // Parts of other lengths than the rest, and intervals that would become narrower.
    for (part, other) in [("\"elements\":[[0,", "\"elements\":[[0,0],[0,"), ("\"widened\":1.0", "\"widened\":0.5")] {
        let changed = whole.replacen(part, other, 1);
        assert_ne!(changed, whole);
        place.write("changed.json", &changed);
        let output =
            tirtouch_in(place.path(), &["estimate", "image.txt", "--calibration", "changed.json", "--depths-mm", "1"]);
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains("do not fit together"), "{output:?}");
    }
}

/// A sweep of phantoms that keeps the radiance of all loads, coarse and noisy.
fn small_sweep(place: &Place, name: &str, vary: &[(&str, &str)]) {
    let base = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/calibrations/sensor.toml");
    place.write("sensor.toml", &std::fs::read_to_string(base).unwrap());
    let vary = vary.iter().map(|(key, values)| format!("[[vary]]\nkey = \"{key}\"\nvalues = {values}\n"));
    let sweep = format!(
        "[sweep]\nscene = \"sensor.toml\"\ndesign = {{ kind = \"grid\" }}\n\
         images = {{ format = \"exr\", loads = \"all\" }}\n\
         [[vary]]\nkey = \"render.photons\"\nfixed = 120000\n\
         [[vary]]\nkey = \"press.resolution\"\nfixed = 0.5\n{}\n[[measure]]\nkind = \"force\"\n",
        vary.collect::<String>()
    );
    place.write(name, &sweep);
}

const SIZE: &str = "phantom.inclusion[0].shape.diameter_mm";

/// Two phantoms, and one whose inclusion is none.
fn small_study(place: &Place) {
    small_sweep(place, "phantoms.toml", &[(SIZE, "[8.0, 10.0]")]);
    small_sweep(place, "empty.toml", &[("phantom.inclusion[0].material.youngs_kpa", "[5.0]")]);
    let study = format!(
        "[study]\ncalibration = \"{CALIBRATION}\"\nphantoms = \"phantoms.toml\"\nempty = \"empty.toml\"\n\
         exposure_ms = 0.0778\nexposures = 1\n"
    );
    place.write("study.toml", &study);
}

#[test]
fn a_study_tells_true_against_estimated() {
    let place = Place::new();
    small_study(&place);
    let study =
        |more: &[&str]| tirtouch_in(place.path(), &[&["study", "study.toml", "--json", "--quiet"], more].concat());
    let output = study(&[]);
    assert_eq!(code(&output), 0, "{output:?}");
    let said = json(&output);
    assert_eq!((&said["phantoms"], &said["empty"]), (&2.into(), &1.into()), "{said}");
    let [size, depth, youngs] = ["size_mm", "depth_mm", "youngs_kpa"].map(|name| {
        let quantities = said["quantities"].as_array().unwrap();
        quantities.iter().find(|one| one["name"] == name).unwrap().clone()
    });
    for quantity in [&size, &depth, &youngs] {
        let undefined: u64 =
            quantity["reasons"].as_array().unwrap().iter().map(|one| one["phantoms"].as_u64().unwrap()).sum();
        assert_eq!(quantity["known"].as_u64().unwrap() + undefined, 2, "{quantity}");
        assert!(quantity["ranks"]["undefined"].is_string(), "two phantoms have no histogram: {quantity}");
    }
    // Names that the sweep and the calibration share: none here, for the sweep's are keys.
    assert_eq!(said["unknowns"].as_array().unwrap().len(), 0, "{said}");
    let out = place.path().join("out/study");
    let table = std::fs::read_to_string(out.join("estimates.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 3, "{table}");
    assert!(table.starts_with("sweep,row,exposure,true_size_mm,true_depth_mm,true_youngs_kpa,"), "{table}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert_eq!(page.contains("Estimated against true size"), size["known"] != 0);
    // Frames of two loads, exposed twice, tell less than those of all four.
    place.write(
        "some.toml",
        &std::fs::read_to_string(place.path().join("study.toml"))
            .unwrap()
            .replace("\"phantoms.toml\"", "\"out/study/phantoms\"")
            .replace("exposures = 1", "exposures = 2")
            .replace("empty = \"empty.toml\"", "depths_mm = [1.0, 2.0]"),
    );
    assert_eq!(code(&tirtouch_in(place.path(), &["study", "some.toml", "--quiet"])), 0);
    let some = std::fs::read_to_string(place.path().join("out/some/estimates.csv")).unwrap();
    assert_eq!(some.lines().count(), 1 + 2 * 2, "{some}");
    let bound = |table: &str| -> f64 {
        let column = table.lines().next().unwrap().split(',').position(|name| name == "size_mm_bound").unwrap();
        table.lines().nth(1).unwrap().split(',').nth(column).unwrap().parse().unwrap()
    };
    assert!(bound(&some) > 1.1 * bound(&table), "{some}\n{table}");

    // What is there is not computed again, and says the same.
    assert_eq!(json(&study(&[]))["quantities"], said["quantities"]);
    let output = study(&["--force"]);
    assert_eq!((code(&output), &json(&output)["error"]["kind"]), (2, &"usage".into()), "{output:?}");
    assert!(table == std::fs::read_to_string(out.join("estimates.csv")).unwrap());

    // A folder of something else stays as it is.
    std::fs::create_dir(place.path().join("other")).unwrap();
    place.write("other/report.html", "mine");
    let output = study(&["-o", "other"]);
    assert_eq!(
        (code(&output), std::fs::read_to_string(place.path().join("other/report.html")).unwrap().as_str()),
        (2, "mine")
    );

    let broken = |text: &str, why: &str| {
        place.write("broken.toml", text);
        let output = tirtouch_in(place.path(), &["study", "broken.toml"]);
        assert_eq!(code(&output), 2, "{output:?}");
        assert!(one_line(&output).contains(why), "{output:?}");
    };
    broken("[study]\nphantoms = \"phantoms.toml\"\nexposures = 0\n", "study.exposures");
    broken("[study]\nphantoms = \"phantoms.toml\"\nexposure_ms = -1.0\n", "study.exposure_ms");
    broken("[study]\nphantoms = \"phantoms.toml\"\ncalibration = \"none.json\"\n", "none.json");
    broken("[study]\nphantoms = \"phantoms.toml\"\ndepths_mm = []\n", "study.depths_mm");
    broken("[study]\nphantoms = \"out/study/phantoms\"\ndepths_mm = [2.5]\n", "2.5 mm is of no press");
    broken("[study]\nphantom = \"phantoms.toml\"\n", "phantom");
    let of_paper = |figure: &str, more: &str, why: &str| {
        broken(&format!("[study]\nphantoms = \"phantoms.toml\"\n{more}\n[study.paper]\nfigure = \"{figure}\"\n"), why);
    };
    of_paper("stiffness", "", "study.calibration");
    of_paper("size", "exposures = 2", "study.exposures");
    of_paper("size", "empty = \"empty.toml\"", "study.empty");
    of_paper("size", "depths_mm = [4.0]", "study.depths_mm");
    of_paper("girth", "", "study.paper.figure");
    of_paper("stiffness", "calibration = \"c.toml\"\nexposure_ms = 0.1", "study.exposure_ms");
    place.write("c.toml", "mm_per_pixel = 0.1\n");
    of_paper("stiffness", "calibration = \"c.toml\"", "bottom_area_mm2");
    of_paper("size", &format!("calibration = \"{CALIBRATION}\""), "is JSON");
}

/// The TSIS paper's figures, of two phantoms of two images each, and of pairs.
#[test]
fn a_study_of_the_paper_reads_its_figures_from_images_as_they_are() {
    let place = Place::new();
    small_sweep(&place, "phantoms.toml", &[(SIZE, "[8.0, 12.0]"), ("phantom.material.youngs_kpa", "[5.0, 5.1]")]);
    // An exposure at which the phantom itself stays dark, and no press deeper than the paper's.
    let scene = std::fs::read_to_string(place.path().join("sensor.toml")).unwrap();
    let scene = scene.replace("exposure_ms = 0.7 ", "exposure_ms = 0.006 ").replace("4.0, 5.5]", "4.0]");
    place.write("sensor.toml", &scene);
    place.write(
        "sensor-calibration.toml",
        "mm_per_pixel = 0.25\nbottom_area_mm2 = 900.0\nforce_n_from_sum_grey = [[0.0, 0.0], [1e6, 4.0]]\n",
    );
    let study = |figure: &str, more: &str| {
        place.write(
            &format!("{figure}.toml"),
            &format!(
                "[study]\nphantoms = \"{}\"\ncalibration = \"sensor-calibration.toml\"\n\
                 [study.paper]\nfigure = \"{figure}\"\n{more}\n",
                if figure == "size" { "phantoms.toml" } else { "out/size/phantoms" }
            ),
        );
        let output = tirtouch_in(place.path(), &["study", &format!("{figure}.toml"), "--json", "--quiet"]);
        assert_eq!(code(&output), 0, "{output:?}");
        json(&output)
    };
    let table =
        |figure: &str| std::fs::read_to_string(place.path().join(format!("out/{figure}/readings.csv"))).unwrap();
    let size = study("size", "published = [[12.0, 4.0], [8.0, 2.0]]");
    let phantoms = size["phantoms"].as_array().unwrap();
    let of = |key: &str| phantoms.iter().map(|one| one[key].clone()).collect::<Vec<_>>();
    assert_eq!((of("truth"), of("known")), (vec![8.0.into(), 12.0.into()], vec![2.into(), 2.into()]), "{size}");
    assert_eq!((of("true_ratio"), of("published_ratio")), (vec![1.0.into(), 1.5.into()], vec![1.0.into(), 2.0.into()]));
    assert_eq!(size["same_order"], true, "{size}");
    let page = std::fs::read_to_string(place.path().join("out/size/report.html")).unwrap();
    assert!(page.contains("ratios of means to the first"));

    // The same figure as `estimate` reads of the same image, exposed by the same camera.
    let first = shown(place.path().join("out/size/phantoms/train/0000000_2.exr"));
    let flags = ["--exposure", "sensor.toml", "--calibration", "sensor-calibration.toml", "--json"];
    let output = tirtouch_in(place.path(), &[&["estimate", &first][..], &flags].concat());
    let read = json(&output)["images"][0]["paper"]["diameter_mm"]["value"].as_f64().unwrap();
    let ours: f64 = table("size").lines().nth(1).unwrap().split(',').nth(3).unwrap().parse().unwrap();
    assert!((ours / read - 1.0).abs() < 0.05, "{ours} {read}");

    let depth = study("depth", "");
    assert_eq!(depth["phantoms"].as_array().unwrap().len(), 1, "both are 5 mm deep: {depth}");
    assert_eq!(depth["same_order"], serde_json::Value::Null);
    let stiffness = study("stiffness", "");
    assert_eq!(stiffness["phantoms"][0]["readings"], 4, "{stiffness}");
    // E = P / T with P = F / C, at least where the larger inclusion is lit in both images.
    let mut told = 0;
    for line in table("stiffness").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |k: usize| cells[k].parse::<f64>().ok();
        if let (Some(e), Some(f), Some(p), Some(t)) = (number(3), number(5), number(6), number(7)) {
            assert!((e * t / p - 1.0).abs() < 1e-9 && (1e3 * f / 900.0 / p - 1.0).abs() < 1e-9, "{line}");
            told += 1;
        }
    }
    assert!(told >= 2, "{stiffness}");
}

#[test]
fn bounds_of_a_protocol_fall_with_its_frames() {
    let place = Place::new();
    let bound = |more: &[&str]| {
        tirtouch_in(place.path(), &[&["calibrate", CALIBRATION, "--bound", "--json", "--quiet"], more].concat())
    };
    let of = |more: &[&str]| -> Vec<serde_json::Value> {
        let output = bound(more);
        assert_eq!(code(&output), 0, "{output:?}");
        json(&output)["bounds"].as_array().unwrap().clone()
    };
    let (one, many, dim) = (of(&[]), of(&["--frames", "8,8,8,8"]), of(&["--exposure-ms", "0.01"]));
    assert_eq!(one.len(), 27);
    let size = |row: &serde_json::Value, of: &str| row[of]["size"]["value"].as_f64().unwrap();
    for ((one, many), dim) in one.iter().zip(&many).zip(&dim) {
        assert!(size(one, "frames") > size(many, "frames") && size(one, "frames") < size(one, "calibrated"), "{one}");
        assert!(dim["frames"]["undefined"].is_string() || size(dim, "frames") > size(one, "frames"), "{dim}");
    }
    assert_eq!(code(&bound(&["--frames", "1,1"])), 2);
    assert_eq!(code(&tirtouch_in(place.path(), &["calibrate", CALIBRATION, "--frames", "1,1,1"])), 2);
}
