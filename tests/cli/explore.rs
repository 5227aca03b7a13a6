//! The report in a browser: what it tells of a pixel and of a load is what the files say.
//!
//! A headless Chromium reads the page. Without one nothing is tested, unless `TIRTOUCH_REQUIRE_BROWSER` is set, as
//! `TIRTOUCH_REQUIRE_GPU` does for adapters.

use super::*;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::sync::LazyLock;
use tirtouch::film::Film;
use tirtouch::image_io::{read_grey, read_radiance};
use tirtouch::pipeline::view_of;

/// Names that it goes by.
const BROWSERS: [&str; 4] = ["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"];
/// Flags with which it draws in three dimensions, by software, and without.
const SOLID: [&str; 2] = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
const FLAT: [&str; 2] = ["--disable-gpu", "--disable-3d-apis"];
const SIZE: [usize; 2] = [48, 36];
/// Pixels in all quarters of the image and on its edges.
const PIXELS: [[usize; 2]; 6] = [[24, 18], [0, 15], [47, 20], [11, 22], [33, 9], [20, 16]];

/// A run of a press with two loads, in a folder that all tests of this file read.
struct Looked {
    folder: PathBuf,
    said: Value,
}

impl Looked {
    fn file(&self, name: &str) -> PathBuf {
        self.folder.join("out").join(name)
    }

    fn page(&self) -> String {
        std::fs::read_to_string(self.file("report.html")).unwrap()
    }

    fn radiance(&self) -> Film {
        read_radiance(&self.file("radiance.exr")).unwrap().0
    }
}

static RUN: LazyLock<Looked> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("explore");
    std::fs::create_dir_all(&folder).unwrap();
    let scene = include_str!("../../scenes/phantom-size-8mm.toml")
        .replace("pixels = [348, 261]", "pixels = [48, 36]")
        .replace("pixel_pitch_um = 18.6 ", "pixel_pitch_um = 135.0 ")
        .replace("exposure_ms = 0.7 ", "exposure_ms = 0.012 ")
        .replace("depths_mm = [1.0, 2.0, 4.0]", "depths_mm = [1.0, 3.0]\nresolution = 0.5\nestimate_error = false")
        + "\n[render]\nmap_texel_mm = 0.5\nsymmetry = false\n"; // Mirror images of a pixel differ.
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    let flags = ["--spp", "32", "--photons", "16384", "--backend", "cpu", "--json", "--quiet"];
    let output = tirtouch_in(&folder, &[&["run", "scene.toml", "-o", "out", "--force"][..], &flags].concat());
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let said = json(&output);
    Looked { folder, said }
});

/// The browser, if there is one.
fn browser() -> Option<&'static str> {
    let found = BROWSERS.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok());
    let is_required = std::env::var_os("TIRTOUCH_REQUIRE_BROWSER").is_some();
    assert!(found.is_some() || !is_required, "none of {BROWSERS:?} is installed");
    if found.is_none() {
        eprintln!("no browser is installed: nothing was tested");
    }
    found
}

/// The page as it stands after its scripts, in a window of a telephone's width.
fn opened(page: &str, flags: &[&str]) -> Option<String> {
    let place = Place::new();
    place.write("page.html", page);
    let address = format!("file://{}", shown(place.path().join("page.html")));
    let profile = format!("--user-data-dir={}", shown(place.path().join("profile")));
    let output = Command::new(browser()?)
        .args(["--headless", "--no-sandbox", "--window-size=390,844", "--virtual-time-budget=30000", "--dump-dom"])
        .args(["--enable-logging=stderr", &profile])
        .args(flags)
        .arg(address)
        .output()
        .unwrap();
    // The test itself reads pictures back more often than Chromium likes.
    let is_complaint = |line: &&str| line.contains("CONSOLE") && !line.contains("willReadFrequently");
    let complaints: Vec<&str> = text(&output.stderr).lines().filter(is_complaint).collect();
    assert!(complaints.is_empty(), "{complaints:#?}");
    Some(String::from_utf8(output.stdout).unwrap())
}

/// What a reader of the page is told who points at the pixels under both loads.
fn looked(page: &str, flags: &[&str]) -> Option<Value> {
    let catch = "<script>const faults=[];addEventListener('error',(e)=>faults.push(String(e.message)));\
                 addEventListener('unhandledrejection',(e)=>faults.push(String(e.reason)));</script>";
    let asked = serde_json::json!({ "pixels": PIXELS, "loads": [0, 1, 0, 1] });
    let script = format!("<script>const asked = {asked};\n{}</script>", include_str!("explore.js"));
    let page =
        page.replacen("<head>", &format!("<head>{catch}"), 1).replacen("</body>", &format!("{script}</body>"), 1);
    let dom = opened(&page, flags)?;
    let said = dom.split_once("<pre id=\"said\">").unwrap_or_else(|| panic!("the script did not end")).1;
    let said = STANDARD.decode(said.split_once('<').unwrap().0).unwrap();
    let said: Value = serde_json::from_slice(&said).unwrap();
    assert_eq!(said["faults"], serde_json::json!([]), "{said:#}");
    Some(said)
}

/// The number that a text begins with and the one after "±", in the unit that follows, and half of the last digit of
/// either.
fn numbers(told: &str) -> [[f64; 2]; 2] {
    let raised = |c: char| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|digit| digit == c).map(|digit| digit.to_string());
    let power: String = told.split_once(" 10").map_or(String::new(), |(_, after)| {
        let exponent = after.chars().map_while(|c| if c == '⁻' { Some("-".to_owned()) } else { raised(c) });
        exponent.collect()
    });
    let power = 10f64.powi(power.parse().unwrap_or(0));
    let read = |word: &str| {
        let decimals = word.split_once('.').map_or(0, |(_, decimals)| decimals.len()) as i32;
        [word.replace('−', "-").parse::<f64>().unwrap() * power, 0.5 * 10f64.powi(-decimals) * power]
    };
    let words: Vec<&str> = told.split_whitespace().collect();
    assert_eq!(words[1], "±", "{told}");
    [read(words[0]), read(words[2])]
}

/// Faults of what is told of the radiance, as pixels with both values.
fn wrong_radiances(said: &Value, film: &Film) -> Vec<String> {
    let told = said["loads"][1]["radiance"].as_array().unwrap();
    let mut wrong = Vec::new();
    for (&[column, row], told) in PIXELS.iter().zip(told) {
        let told = told.as_str().unwrap();
        let at = row * SIZE[0] + column;
        let [[value, digit], [error, error_digit]] = numbers(told);
        let (true_value, true_error) = (f64::from(film.mean[at]), f64::from(film.variance[at]).sqrt());
        // What packing loses, and rounding of what is shown.
        let is_right = (value - true_value).abs() <= 2.2e-4 * true_value + 1.001 * digit
            && (error - true_error).abs() <= 0.028 * true_error + 1.001 * error_digit
            && told.contains(&format!("column {column}, row {row};"));
        if !is_right {
            wrong.push(format!("{told}: is {true_value} ± {true_error}"));
        }
    }
    wrong
}

/// Faults of what is told of the camera's frames, of a load as the slider's position and that as asked.
fn wrong_greys(said: &Value, load: usize) -> Vec<String> {
    let names = ["camera_1mm.png", "camera.png"];
    let frames = names.map(|name| read_grey(&RUN.file(name)).unwrap());
    let high = frames.iter().flat_map(|frame| &frame.values).copied().fold(0.0, f64::max);
    let seen = &said["loads"][load];
    let own = load % 2;
    let mut wrong = Vec::new();
    if seen["file"] != names[own] {
        wrong.push(format!("file {}", seen["file"]));
    }
    for (i, &[column, row]) in PIXELS.iter().enumerate() {
        let told = seen["camera"][i].as_str().unwrap();
        let value = frames[own].values[row * SIZE[0] + column];
        assert!(value > 0.0 && value < 255.0, "neither dark nor saturated: {value}");
        let share = (value / high * 255.0).round() / 255.0;
        let color = colorous::INFERNO.eval_continuous(share);
        if numbers(told)[0][0] != value || seen["colors"][i] != serde_json::json!([color.r, color.g, color.b]) {
            wrong.push(format!("{told}: is {value}, in {color:?} and not {}", seen["colors"][i]));
        }
    }
    wrong
}

/// Faults of a load's figures.
fn wrong_figures(said: &Value, load: usize) -> Vec<String> {
    let step = &RUN.said["mechanics"]["steps"][load % 2];
    let number = |key: &str| step[key].as_f64().unwrap();
    let told = said["loads"][load]["figures"].as_str().unwrap();
    let (name, figures) = told.split_once(": force ").unwrap();
    let (force, peak) = figures.split_once(" N, peak pressure ").unwrap();
    let near = |told: &str, value: f64| (told.parse::<f64>().unwrap() / value - 1.0).abs() < 5e-3;
    let is_right = name == format!("{} mm", number("depth_mm"))
        && near(force, number("force_n"))
        && near(peak.trim_end_matches(" kPa"), number("peak_pressure_kpa"));
    if is_right { Vec::new() } else { vec![format!("{told}: is {step}")] }
}

/// Pressure at a distance from the axis by contact.csv.
fn pressure_at(depth: &str, distance: f64) -> f64 {
    let table = std::fs::read_to_string(RUN.file("contact.csv")).unwrap();
    let rows = table.lines().skip(1).filter(|line| line.split(',').next() == Some(depth));
    let points: Vec<[f64; 2]> = rows
        .map(|line| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            [cells[1] + cells[5], cells[2]]
        })
        .collect();
    let pair = points.windows(2).find(|pair| pair[1][0] >= distance).unwrap();
    let share = (distance - pair[0][0]) / (pair[1][0] - pair[0][0]);
    pair[0][1] + share * (pair[1][1] - pair[0][1])
}

#[test]
fn a_pixel_tells_what_the_files_say_of_it_under_each_load() {
    let Some(said) = looked(&RUN.page(), &SOLID) else { return };
    let film = RUN.radiance();
    // Else a neighbour's value would do.
    for [column, row] in PIXELS {
        let value = |column: usize, row: usize| f64::from(film.mean[row * SIZE[0] + column]);
        let own = value(column, row);
        let others = [(column.abs_diff(1), row), (column, row.abs_diff(1)), (column, SIZE[1] - 1 - row)];
        let near = |&(c, r): &(usize, usize)| (c, r) != (column, row) && (value(c, r) / own - 1.0).abs() < 1e-3;
        assert!(own > 0.0 && !others.iter().any(near), "column {column}, row {row}");
    }
    assert_eq!(wrong_radiances(&said, &film), Vec::<String>::new());
    // Forth and back: 0, 1, 0, 1.
    for load in 0..4 {
        assert_eq!(wrong_greys(&said, load), Vec::<String>::new(), "load {load}");
        assert_eq!(wrong_figures(&said, load), Vec::<String>::new(), "load {load}");
    }
    assert_eq!((&said["first"], &said["most"]), (&"1".into(), &"1".into()));
    assert_eq!(said["loads"][1]["alone"], "radiance.exr");
    assert_eq!(said["loads"][0]["alone"], "radiance.exr, traced at 3 mm alone");
}

#[test]
fn places_are_those_of_the_lens_and_link_the_pictures() {
    let Some(said) = looked(&RUN.page(), &SOLID) else { return };
    let scene = tirtouch::scene::open(&RUN.folder.join("scene.toml")).unwrap().0.scene;
    let view = view_of(&scene).unwrap();
    for (i, [column, row]) in PIXELS.into_iter().enumerate() {
        let [x, y] = view.touched_from_pixel([column as f64 + 0.5, row as f64 + 0.5]).unwrap();
        let told = said["loads"][0]["radiance"][i].as_str().unwrap();
        let number = |before: &str, after: &str| {
            let text = told.split_once(before).unwrap().1.split_once(after).unwrap().0;
            text.replace('−', "-").parse::<f64>().unwrap()
        };
        let shown = [number("; x ", ","), number(", y ", ","), number(", r ", " mm")];
        // Of two decimals.
        for (shown, exact) in shown.into_iter().zip([x, y, x.hypot(y)]) {
            assert!((shown - exact).abs() < 0.0052, "{told}: {x} {y}");
        }
    }
    let [column, row] = PIXELS[PIXELS.len() - 1];
    let [x, y] = view.touched_from_pixel([column as f64 + 0.5, row as f64 + 0.5]).unwrap();
    for (load, depth) in [(0, "1"), (1, "3")] {
        let linked = said["loads"][load]["linked"].as_str().unwrap();
        assert!(linked.contains(&format!("column {column}, row {row};")), "the camera shows the same place: {linked}");
        let curve = said["loads"][load]["curve"].as_str().unwrap();
        let pressure: f64 = curve.split_whitespace().next().unwrap().parse().unwrap();
        let exact = pressure_at(depth, x.hypot(y));
        assert!((pressure / exact - 1.0).abs() < 5e-3, "{curve}: is {exact}");
        assert!(curve.contains(&format!("at {:.2} mm, pressed by {depth} mm", x.hypot(y))), "{curve}");
    }
    // The other way round: a circle of the distance that the curve told.
    let along = said["along"].as_str().unwrap();
    let distance: f64 = along.split_once("at ").unwrap().1.split_once(" mm").unwrap().0.parse().unwrap();
    let edge = view.pixel_from_touched([distance, 0.0])[0] - 0.5 * SIZE[0] as f64;
    assert_eq!(said["ring"][0], "visible");
    let ring = said["ring"][1].as_f64().unwrap();
    // Half a hundredth of a millimetre.
    assert!((ring - edge).abs() < 0.006 * edge / distance, "{ring} {edge}");
}

#[test]
fn keys_move_and_clear_and_bodies_turn() {
    let Some(said) = looked(&RUN.page(), &SOLID) else { return };
    let [column, row] = PIXELS[0].map(|at| at + 1);
    assert!(said["keys"].as_str().unwrap().contains(&format!("column {column}, row {row};")), "{}", said["keys"]);
    assert_eq!(said["escaped"], "No pixel is pointed at.");
    let turns: Vec<&str> = said["turns"].as_array().unwrap().iter().map(|turn| turn.as_str().unwrap()).collect();
    // Dragged by 40 pixels of half a degree; not chosen, so the wheel is the page's; chosen; back.
    assert_eq!(turns, ["-62.00 24.00 1.00", "-82.00 24.00 1.00", "-82.00 24.00 1.00", "-82.00 24.00 1.35", turns[0]]);
    // A picture's file is as long as there is to be seen in it; edges differ by some bytes from drawing to drawing.
    let length = |picture: &Value| picture.as_str().unwrap().len() as f64;
    let is_like = |a: f64, b: f64| (a / b - 1.0).abs() < 0.02;
    let [first, last, again, end] = [0, 1, 2, 3].map(|load| length(&said["loads"][load]["body"]));
    assert!(first > 5000.0 && is_like(first, again) && is_like(last, end), "{first} {last} {again} {end}");
    assert!(!is_like(first, last) && !is_like(again, end), "the other load looks otherwise: {first} {last}");
    let [pressure, displacement] = ["pressure", "displacement"].map(|name| length(&said[name]));
    assert!(is_like(pressure, end) && !is_like(displacement, end), "{pressure} {displacement} {end}");
    assert_eq!(said["picture"], 0);
}

#[test]
fn a_telephone_without_webgl_has_all_but_the_turning() {
    let Some(said) = looked(&RUN.page(), &FLAT) else { return };
    assert_eq!(said["hidden"], false);
    assert!(said["wide"].as_u64().unwrap() <= 390, "{}", said["wide"]);
    assert_eq!(said["titles"], serde_json::json!(["Camera", "Radiance", "Contact pressure", "Deformed bodies"]));
    assert!(said["picture"].as_u64().unwrap() > 10_000, "the picture of the mesh stands there");
    assert!(said["turns"].is_null());
    assert_eq!(wrong_greys(&said, 0), Vec::<String>::new());
}

#[test]
fn without_scripts_pictures_and_tables_stay_and_nothing_else_shows() {
    let page = RUN.page();
    assert!(page.contains("id=\"explore\" hidden") && page.matches("<img ").count() >= 6);
    // As a browser has it that runs none; this script of the test's own alone tells how wide the page is.
    let still = page.replace("<script", "<template").replace("</script>", "</template>");
    let wide = "<script>document.body.dataset.wide = document.documentElement.scrollWidth;\
                document.body.dataset.high = document.getElementById('explore').offsetHeight</script></body>";
    let Some(dom) = opened(&still.replacen("</body>", wide, 1), &FLAT) else { return };
    assert!(dom.contains("id=\"explore\" hidden") && dom.matches("<img ").count() >= 6);
    let number = |name: &str| {
        let text = dom.split_once(&format!("data-{name}=\"")).unwrap().1.split_once('"').unwrap().0;
        text.parse::<u32>().unwrap()
    };
    assert!(number("wide") <= 390 && number("high") == 0, "{} {}", number("wide"), number("high"));
}

/// The comparisons must be able to fail: pages whose scripts swap rows, are off by a pixel, or keep a stale load.
#[test]
fn planted_faults_are_found() {
    let page = RUN.page();
    let planted = |from: &str, to: &str| {
        assert_eq!(page.matches(from).count(), 1, "{from}");
        looked(&page.replace(from, to), &FLAT)
    };
    let film = RUN.radiance();
    let value = "const value = frame.values[row * width + column];";
    for fault in ["(height - 1 - row) * width + column", "row * width + column + 1", "row * width + column - width"] {
        let Some(said) = planted(value, &format!("const value = frame.values[{fault}] ?? 0;")) else { return };
        assert!(wrong_radiances(&said, &film).len() >= 3, "{fault}");
        assert!(!wrong_greys(&said, 0).is_empty(), "{fault}");
    }
    let own = "const own = frames.find((one) => one.load === load);";
    let Some(said) = planted(own, "const own = frames[frames.length - 1];") else { return };
    assert!(wrong_greys(&said, 0).len() >= 3 && wrong_greys(&said, 1).is_empty());
    let Some(said) = planted("peak_pressure_kpa: peak } = loads[load];", "peak_pressure_kpa: peak } = loads[0];")
    else {
        return;
    };
    assert!(wrong_figures(&said, 0).is_empty() && !wrong_figures(&said, 1).is_empty());
}
