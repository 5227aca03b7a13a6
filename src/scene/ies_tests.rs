#![allow(clippy::unwrap_used)]
use super::*;
use proptest::prelude::*;

const QUADRANT: &str = "IESNA:LM-63-2002\n[TEST] small table\nTILT=NONE\n1 -1 2.0 3 2 1 2 0 0 0\n0.5 1 0\n0 45 90\n0 90\n\
                        100 60 0\n100, 20, 0\n";

fn close(a: f64, b: f64) {
    // Interpolation takes a few roundings of values around 100.
    assert!((a - b).abs() < 1e-12, "{a} for {b}");
}

#[test]
fn a_quadrant_table_is_mirrored_over_its_planes() {
    let table = parse(QUADRANT).unwrap();
    assert_eq!(table.horizontal_deg, [0.0, 90.0, 180.0, 270.0, 360.0]);
    close(table.intensity(45.0, 0.0), 60.0);
    close(table.intensity(45.0, 90.0), 20.0);
    close(table.intensity(45.0, 180.0), 60.0);
    close(table.intensity(45.0, 270.0), 20.0);
    close(table.intensity(45.0, 360.0), 60.0);
    close(table.intensity(45.0, -90.0), 20.0);
}

#[test]
fn intensity_is_bilinear_between_angles_and_zero_outside() {
    let table = parse(QUADRANT).unwrap();
    // Halfway in both: (100 + 60)/2 at phi 0 and (100 + 20)/2 at phi 90.
    close(table.intensity(22.5, 45.0), 70.0);
    close(table.intensity(0.0, 45.0), 100.0);
    assert_eq!(table.intensity(90.0, 10.0), 0.0);
    assert_eq!(table.intensity(90.1, 10.0), 0.0);
    assert_eq!(table.intensity(f64::NAN, 10.0), 0.0);
}

#[test]
fn the_multiplier_and_the_ballast_factor_scale_the_table() {
    let doubled = QUADRANT.replace("2.0 3 2", "4.0 3 2");
    close(parse(&doubled).unwrap().intensity(0.0, 0.0), 200.0);
    let full = QUADRANT.replace("0.5 1 0", "1 1 0");
    close(parse(&full).unwrap().intensity(0.0, 0.0), 200.0);
}

#[test]
fn an_axial_table_is_the_same_all_around() {
    let text = "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 0\n0 90\n0\n10 0\n";
    let table = parse(text).unwrap();
    close(table.intensity(45.0, 0.0), 5.0);
    close(table.intensity(45.0, 211.0), 5.0);
}

#[test]
fn a_half_circle_is_mirrored_and_a_full_circle_is_kept() {
    let half = "TILT=NONE\n1 -1 1 2 3 1 2 0 0 0\n1 1 0\n0 90\n0 90 180\n10 0\n20 0\n30 0\n";
    let table = parse(half).unwrap();
    assert_eq!(table.horizontal_deg, [0.0, 90.0, 180.0, 270.0, 360.0]);
    close(table.intensity(0.0, 180.0), 30.0);
    close(table.intensity(0.0, 270.0), 20.0);
    let full = "TILT=NONE\n1 -1 1 2 3 1 2 0 0 0\n1 1 0\n0 90\n0 120 360\n10 0\n20 0\n10 0\n";
    assert_eq!(parse(full).unwrap().horizontal_deg, [0.0, 120.0, 360.0]);
}

#[test]
fn an_included_tilt_is_passed_over() {
    let text = QUADRANT.replace("TILT=NONE\n", "TILT=INCLUDE\n1\n3\n0 45 90\n1 0.9 0.8\n");
    assert_eq!(parse(&text).unwrap(), parse(QUADRANT).unwrap());
}

#[test]
fn a_bad_file_says_line_and_rule() {
    let said = |text: &str| parse(text).unwrap_err();
    for (from, to, line, part) in [
        ("TILT=NONE", "TILT=lamp.tlt", Some(3), "NONE or INCLUDE"),
        ("3 2 1 2", "3 2 2 2", Some(4), "type C"),
        ("3 2 1 2", "722 2 1 2", Some(4), "from 1 to 721"),
        ("3 2 1 2", "2.5 2 1 2", Some(4), "whole number"),
        ("0 45 90\n", "0 45 45\n", Some(6), "ascend"),
        ("0 90\n", "0 100\n", Some(9), "0, 90, 180 or 360"),
        ("100 60 0", "100 -60 0", Some(8), "not be negative"),
        ("100 60 0", "100 inf 0", Some(8), "finite"),
        ("20, 0\n", "\n", Some(9), "ends before"),
    ] {
        let error = said(&QUADRANT.replace(from, to));
        assert_eq!(error.line, line, "{from} -> {to}: {}", error.message);
        assert!(error.message.contains(part), "{}", error.message);
    }
    assert!(said("no lamp").message.contains("TILT="));
    assert!(said(&QUADRANT.replace("100", "0").replace("60", "0").replace("20,", "0,")).message.contains("positive"));
}

proptest! {
    #[test]
    fn no_mutation_makes_the_reader_panic(changes in proptest::collection::vec((0..QUADRANT.len(), any::<u8>()), 0..8)) {
        let mut bytes = QUADRANT.as_bytes().to_vec();
        for (at, byte) in changes {
            bytes[at] = byte;
        }
        let _ = parse(&String::from_utf8_lossy(&bytes));
    }
}
