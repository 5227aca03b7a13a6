//! Images that a sweep keeps: labels, masks, pressures, a card, and what is lost of them is made again.

use super::press::scene as phantom;
use super::sweep::{SWEEP, place, points, run, sweep};
use super::*;
use std::collections::BTreeMap;

#[test]
fn a_data_set_has_images_labels_masks_and_a_card() {
    let place = Place::new();
    let scene = include_str!("../../scenes/phantom-size-8mm.toml")
        .replace("pixels = [348, 261]", "pixels = [32, 24]")
        .replace("depths_mm = [1.0, 2.0, 4.0]", "depths_mm = [0.25, 0.5]\nresolution = 0.5\nestimate_error = false")
        + "\n[render]\nmap_texel_mm = 0.5\nspp = 16\nphotons = 1000\n";
    place.write("phantom.toml", &scene);
    let sphere = "phantom.inclusion[0].shape.diameter_mm";
    place.write(
        "sweep.toml",
        &format!(
            "[sweep]\nscene = \"phantom.toml\"\ndesign = {{ kind = \"sobol\", points = 4, seed = 1 }}\n\
             random_numbers = \"own\"\n\
             images = {{ loads = \"all\", baseline = true, masks = true, pressures = true, test_share = 0.4 }}\n\
             [[vary]]\nname = \"size\"\nkey = \"{sphere}\"\nuniform = [5, 12]\n\
             [[vary]]\nname = \"error\"\nkey = \"press.estimate_error\"\nfixed = false\n\
             [[measure]]\nkind = \"force\"\n[[measure]]\nkind = \"paper\"\nless_baseline = true\n"
        ),
    );
    let output = run(&place, "set", &["--json"]);
    assert_eq!(code(&output), 0, "{output:?}");
    assert_eq!(json(&output)["done"], 4, "{output:?}");
    // Without an estimate of its error a force is told all the same, and so is what is missing.
    let table = points(&place, "set");
    assert!(table.contains("force_n: of unknown error: press.estimate_error is off"), "{table}");
    let folder = place.path().join("set");
    let mut images = 0;
    let mut splits = 0;
    // Pixels about the middle of 32 x 24, and the mean pressure there at each load.
    let within = |k: usize| (k % 32).abs_diff(16) < 6 && (k / 32).abs_diff(12) < 6;
    let mut means = [Vec::new(), Vec::new()];
    for split in ["train", "test"] {
        let Ok(mut labels) = csv::Reader::from_path(folder.join(split).join("metadata.csv")) else { continue };
        splits += 1;
        let head = labels.headers().unwrap().clone();
        for record in labels.records() {
            let record = record.unwrap();
            let cell = |name: &str| record.get(head.iter().position(|h| h == name).unwrap()).unwrap();
            let read = |name: &str| tirtouch::image_io::read_grey(&folder.join(split).join(cell(name))).unwrap();
            let (frame, baseline, mask) = (read("file_name"), read("baseline_file_name"), read("mask_file_name"));
            assert_eq!([frame.width, baseline.width, mask.width], [32; 3]);
            assert_eq!(cell("size"), cell("true_size_mm"));
            assert_eq!([cell("split"), cell("seed")], [split, "1"]);
            assert!(cell("force_n").parse::<f64>().unwrap() > 0.0);
            // The mask is a disc of the inclusion's size, by the scale on the axis.
            let size: f64 = cell("size").parse().unwrap();
            let pixels = mask.values.iter().filter(|&&v| v == 255.0).count() as f64;
            let scale: f64 = cell("mm_per_pixel").parse().unwrap();
            let found = 2.0 * (pixels / std::f64::consts::PI).sqrt() * scale;
            assert!((found / size - 1.0).abs() < 0.15, "{found} {size}");
            let bytes = std::fs::read(folder.join(split).join(cell("pressure_npy"))).unwrap();
            assert_eq!(bytes.len(), 128 + 4 * 32 * 24);
            let kpa = bytes[128..].chunks_exact(4).map(|v| f64::from(f32::from_le_bytes(v.try_into().unwrap())));
            let inner: Vec<f64> = kpa.enumerate().filter(|(k, _)| within(*k)).map(|(_, kpa)| kpa).collect();
            assert!(inner.iter().all(|kpa| *kpa > 0.0), "{inner:?}");
            let load = cell("load").parse::<usize>().unwrap();
            means[load].push(inner.iter().sum::<f64>() / inner.len() as f64);
            images += 1;
        }
    }
    assert_eq!((images, splits), (8, 2));
    // Twice the depth presses about twice as hard.
    let mean = |load: usize| means[load].iter().sum::<f64>() / means[load].len() as f64;
    assert!((1.8..2.3).contains(&(mean(1) / mean(0))), "{means:?}");
    let card = std::fs::read_to_string(folder.join("README.md")).unwrap();
    assert!(card.contains("8 images of 4 points") && card.contains("| `size` |"), "{card}");
    assert!(card.contains("| `error` | false | `press.estimate_error` |"), "{card}");
    assert!(card.contains("PDMS 1.41 (2 mm, n = 1.41)") && card.contains("## How to cite"), "{card}");

    // A point one of whose images is lost is made again.
    let mask = if folder.join("train/0000001_mask.png").exists() { "train" } else { "test" };
    let mask = folder.join(mask).join("0000001_mask.png");
    let drawn = std::fs::read(&mask).unwrap();
    std::fs::remove_file(&mask).unwrap();
    assert_eq!(json(&sweep(&place, &["status", "set", "--json"]))["damaged"], 1);
    assert_eq!(code(&run(&place, "set", &["--resume"])), 0);
    assert_eq!((std::fs::read(&mask).unwrap(), points(&place, "set")), (drawn, table.clone()));

    // A point whose record is lost is made again, with the same images.
    let bytes = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let image = if folder.join("train/0000002_1.png").exists() { "train/0000002_1.png" } else { "test/0000002_1.png" };
    let before = bytes(image);
    std::fs::remove_file(folder.join("items/0000002.json")).unwrap();
    std::fs::write(folder.join(image), "garbage").unwrap();
    assert_eq!(code(&run(&place, "set", &["--resume"])), 0);
    assert_eq!((bytes(image), points(&place, "set")), (before, table));
    assert_eq!(code(&run(&place, "set", &["--force"])), 0);
}

/// Paths and photons of an image whose noise does not matter.
const FEW: &str = "spp = 16\nphotons = 1000\n";

fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

#[test]
fn masks_go_with_a_phantom_that_slides() {
    let place = Place::new();
    let scene = phantom("estimate_error = false")
        .replace("depths_mm = [0.5, 1.0]\nresolution = 0.5", "resolution = 0.25")
        .replace("sensor = \"deformable\"", "sensor = \"rigid\"")
        .replace("interface = { kind = \"tied\" }", "interface = { kind = \"frictionless\" }")
        .replace(
            "[touch.contact]",
            "[[press.step]]\ndepth_mm = 0.25\n[[press.step]]\nslide_mm = [3, -2]\n[touch.contact]",
        );
    place.write("slide.toml", &(scene + FEW));
    let sweep = "[sweep]\nscene = \"slide.toml\"\ndesign = { kind = \"grid\" }\n\
                 images = { loads = \"all\", masks = true, test_share = 0 }\n\
                 [[vary]]\nkey = \"render.seed\"\nvalues = [1]\n[[measure]]\nkind = \"force\"\n";
    place.write("sweep.toml", sweep);
    assert_eq!(code(&run(&place, "set", &[])), 0);
    let train = place.path().join("set/train");
    let rows = table(&train.join("metadata.csv"));
    let middle = |row: &BTreeMap<String, String>| {
        let mask = tirtouch::image_io::read_grey(&train.join(&row["mask_file_name"])).unwrap();
        let lit: Vec<usize> = (0..mask.values.len()).filter(|&k| mask.values[k] == 255.0).collect();
        let mean = |of: &dyn Fn(usize) -> usize| lit.iter().map(|&k| of(k) as f64).sum::<f64>() / lit.len() as f64;
        [mean(&|k| k % 32), mean(&|k| k / 32)]
    };
    let number = |name: &str| rows.iter().map(|row| row[name].parse::<f64>().unwrap()).collect::<Vec<_>>();
    assert_eq!([number("slide_x_mm"), number("slide_y_mm")], [[0.0, 3.0], [0.0, -2.0]]);
    let ([from, to], scale) = ([middle(&rows[0]), middle(&rows[1])], number("mm_per_pixel")[0]);
    let moved = [0, 1].map(|k| (to[k] - from[k]).abs() * scale);
    assert!((moved[0] - 3.0).abs() < 0.3 && (moved[1] - 2.0).abs() < 0.3, "{moved:?}");
}

/// Pixels that are full hold no more: what an inclusion adds to them is not known.
#[test]
fn a_signal_of_full_pixels_is_none() {
    let place = Place::new();
    place.write("phantom.toml", &(phantom("estimate_error = false") + FEW));
    let sweep = "[sweep]\nscene = \"phantom.toml\"\ndesign = { kind = \"grid\" }\n\
                 [[vary]]\nname = \"ms\"\nkey = \"camera.sensor.exposure_ms\"\nvalues = [0.001, 10]\n\
                 [[measure]]\nkind = \"snr\"\nradius_mm = 3\n";
    place.write("sweep.toml", sweep);
    assert_eq!(code(&run(&place, "out", &[])), 0);
    let rows = table(&place.path().join("out/points.csv"));
    assert!(!rows[0]["snr"].is_empty() && rows[0]["note"].is_empty(), "{rows:?}");
    assert!(rows[1]["snr"].is_empty() && rows[1]["note"].contains("top grey level"), "{rows:?}");
}

#[test]
fn a_data_set_of_arrays_is_as_large_as_its_images() {
    let place = place();
    let text = SWEEP.replacen("[sweep]\n", "[sweep]\nimages = { format = \"npy\" }\n", 1);
    place.write("sweep.toml", &text);
    assert_eq!(code(&run(&place, "set", &[])), 0);
    let bytes = std::fs::read(place.path().join("set/train/0000000.npy")).unwrap();
    let [columns, rows] = tirtouch::scene::load(&place.path().join("disc.toml")).unwrap().scene.camera.pixels;
    assert_eq!(bytes.len(), 128 + 4 * (columns * rows) as usize);
    assert!(bytes[128..].chunks_exact(4).any(|v| f32::from_le_bytes(v.try_into().unwrap()) > 0.0));
}
