//! The examples do what they say.

use super::*;

/// Runs an example in a folder of its own; what it says.
fn example(place: &Place, name: &str, arguments: &[&str]) -> String {
    let folder = Path::new(env!("CARGO_BIN_EXE_tirtouch")).parent().unwrap().join("examples");
    let program = folder.join(name);
    assert!(program.with_extension(std::env::consts::EXE_EXTENSION).exists(), "not built: cargo build --examples");
    let output = Command::new(program).args(arguments).current_dir(place.path()).output().unwrap();
    assert_eq!(code(&output), 0, "{name}: {output:?}");
    text(&output.stdout).to_owned()
}

#[test]
fn a_scene_becomes_an_image_with_its_variance() {
    let place = Place::new();
    example(&place, "scene_to_image", &["here"]);
    let (film, origin) = tirtouch::image_io::read_radiance(&place.path().join("here/radiance.exr")).unwrap();
    assert_eq!((film.width, film.height), (116, 87));
    assert!(film.mean.iter().any(|&mean| mean > 0.0) && film.variance.iter().any(|&variance| variance > 0.0));
    assert_eq!(origin.unwrap().scene_name, "dent-cap");
    assert!(place.path().join("here/camera.png").exists());
}

#[test]
fn a_press_is_read_beside_its_truth() {
    let said = example(&Place::new(), "press_to_reading", &[]);
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines[0].starts_with("1 mm: ") && lines[1].starts_with("2 mm: "), "{said}");
    assert!(said.contains("true inclusion: Some(14.0) mm across"), "{said}");
}

#[test]
fn a_data_set_has_an_image_for_each_label() {
    let place = Place::new();
    example(&place, "small_data_set", &["here", "3"]);
    let mut table = csv::Reader::from_path(place.path().join("here/labels.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.unwrap()).collect();
    assert_eq!(rows.len(), 3);
    let images: Vec<Vec<u8>> =
        rows.iter().map(|row| std::fs::read(place.path().join("here").join(&row[0])).unwrap()).collect();
    assert!(images[0] != images[1] && images[1] != images[2], "all phantoms look alike");
    // A larger inclusion bears more.
    let force = |k: usize| rows[k][4].parse::<f64>().unwrap();
    assert!(force(0) < force(1) && force(1) < force(2), "{rows:?}");
}

#[test]
fn an_index_is_swept_with_one_press() {
    let said = example(&Place::new(), "index_sweep", &[]);
    let rows: Vec<Vec<f64>> =
        said.lines().skip(1).map(|row| row.split_whitespace().map(|word| word.parse().unwrap()).collect()).collect();
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), [1.39, 1.41, 1.43]);
    assert!(rows.iter().all(|row| row[1] > 0.0), "{said}");
}

/// A disc of contact with a sharp rim: to a pixel.
#[test]
fn an_estimator_of_ones_own_is_judged_by_the_truth() {
    let said = example(&Place::new(), "own_estimator", &["3"]);
    let bias: f64 = said.split("bias ").nth(1).unwrap().split_whitespace().next().unwrap().parse().unwrap();
    assert!(bias.abs() < 0.15, "{said}");
}
