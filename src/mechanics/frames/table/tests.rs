use super::super::{Reference, Settings, features};
use super::*;
use proptest::prelude::*;

const HEAD: &str = "position_mm,x_mm,pressure_kpa\n";

fn read(text: &str) -> Result<Frames, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frames.csv");
    std::fs::write(&path, text).unwrap();
    read_frames(&path).map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

#[test]
fn frames_are_written_and_read_back_exactly() {
    let frame = |position_mm: f64| Frame {
        position_mm,
        x_mm: vec![-1.0 / 3.0, 0.0, 0.7],
        pressure_kpa: vec![0.1 + 0.2, 1e-17 * position_mm, -0.003],
    };
    let frames = Frames::new(vec![frame(-2.5), frame(0.0), frame(1.0 / 7.0)]).unwrap();
    assert_eq!(read(&frames_csv(&frames)).unwrap(), frames);
}

#[test]
fn a_bad_table_says_line_and_rule() {
    for (rows, said) in [
        ("", "frames.csv: frame 0, counted from 0: there must be one at least"),
        ("0,1\n", "frames.csv:2: must be UTF-8 text with three columns, position_mm,x_mm,pressure_kpa, in every row"),
        ("0,1,inf\n", "frames.csv:2: pressure_kpa must be a finite number, is \"inf\""),
        ("0,1,2\n0,1,2\n", "frames.csv:3: x_mm must ascend, is 1 after 1"),
        ("1,1,2\n1,2,2\n0,1,2\n", "frames.csv:4: position_mm must not fall, is 0 after 1"),
        ("0,1,2\n0,2,2\n1,1,2\n1,3,2\n", "frames.csv:5: x_mm must be 2 as in the first frame, is 3"),
        ("0,1,2\n0,2,2\n1,1,2\n", "frames.csv:4: the frame at 1 mm has 1 places, the first frame 2"),
        ("0,1,2\n0,2,2\n1,1,2\n2,1,2\n", "frames.csv:5: the frame at 1 mm has 1 places, the first frame 2"),
        ("0,1,2\n0,2,2\n1,1,2\n1,2,2\n1,3,2\n", "frames.csv:6: must not have more places than the first frame"),
        ("0,1,2\n", "frames.csv:2: frame 0, counted from 0: must have one pressure at each of two places at least"),
    ] {
        assert_eq!(read(&format!("{HEAD}{rows}")).unwrap_err(), said);
    }
    assert_eq!(read("x,y,z\n").unwrap_err(), "frames.csv:1: must start with the line position_mm,x_mm,pressure_kpa");
}

#[test]
fn sizes_are_limited() {
    let endless = std::io::repeat(b'1').take(MAX_BYTES + 1);
    assert!(parse(endless).is_err_and(|defect| defect.kind == "too_large"));
    assert!(read_frames(Path::new("no-such-file.csv")).is_err_and(|e| e.kind == "io"));
    let many: String = (0..=MAX_FRAMES).map(|i| format!("{i},0,1\n{i},1,1\n")).collect();
    assert!(read(&format!("{HEAD}{many}")).unwrap_err().contains("at most 10000 positions"));
}

#[test]
fn features_are_numbers_or_empty_with_a_reason() {
    let x_mm = vec![-1.0, 0.0, 1.0];
    let frame = |position_mm, pressure_kpa| Frame { position_mm, x_mm: x_mm.clone(), pressure_kpa };
    let frames = Frames::new(vec![frame(-3.0, vec![1.0, 2.0, 1.0]), frame(0.0, vec![0.0; 3])]).unwrap();
    let csv = features_csv(&features(&frames, Reference::Farthest, &Settings::default()).unwrap());
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines[0], "position_mm,peak_kpa,base_kpa,center_mm,fwhm_mm,eccentricity,undefined");
    assert!(lines[1].starts_with("-3,2,1,") && lines[1].ends_with(",0,\"\""), "{}", lines[1]);
    assert_eq!(lines[2], "0,,,,,0,\"there is no contact\"");
}

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let mut table = HEAD.as_bytes().to_vec();
        table.extend(bytes);
        let _ = parse(table.as_slice().take(MAX_BYTES + 1));
    }

    #[test]
    fn no_numbers_make_the_features_panic(values in proptest::collection::vec(any::<f64>(), 9)) {
        let rows: String = values.chunks_exact(3).map(|v| format!("{},{},{}\n", v[0], v[1], v[2])).collect();
        if let Ok(frames) = parse(format!("{HEAD}{rows}").as_bytes().take(MAX_BYTES + 1)) {
            let all = features(&frames, Reference::Farthest, &Settings::default()).unwrap();
            let _ = features_csv(&all);
        }
    }
}
