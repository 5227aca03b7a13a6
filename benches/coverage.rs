//! Do the intervals of the paper's figures hold what they claim, and are warnings of noise right?
//!
//!     cargo run --release --example coverage -- [--seeds N] [--shrink K] [--spp N] [--photons N] [--phantom | --dent]
//!
//! Renders N seeds (200) of a pressed phantom, of the same press without its inclusion, and of a dent; exposes each and
//! reads M, d, the centroid and h of the raw frame and of the frame less the other (the dent less the undeformed
//! stack). A device is opened once a scene, and each is pressed once. What is to be held is the mean of the figure over
//! all seeds. Printed for each figure: intervals that hold it, with the 95 % interval of that share (Clopper and
//! Pearson), and the spread that the intervals claim over the spread there is. Warnings are counted on the phantom less
//! the press without inclusion, where there is something to see, and on two presses without inclusion less each other,
//! where there is nothing.

use anyhow::{Context as _, Result, bail};
use statrs::distribution::{Beta, ContinuousCDF};
use tirtouch::camera::expose;
use tirtouch::estimate::{Exposed, GreyImage, PaperEstimate, Subtracted, Value, measure};
use tirtouch::film::Film;
use tirtouch::pipeline::{Order, Session};
use tirtouch::scene::{Camera, LoadedScene, preset};
use tirtouch::trace::{Backend, BackendChoice, Model, Precision, Settings, render_on};

const THRESHOLD: f64 = 5.0;

struct Flags {
    seeds: u32,
    shrink: u32,
    spp: u32,
    photons: Option<u64>,
    phantom: bool,
    dent: bool,
}

impl Flags {
    fn read() -> Result<Self> {
        let mut flags = Self { seeds: 200, shrink: 1, spp: 32, photons: None, phantom: true, dent: true };
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut number = || words.next().with_context(|| format!("{word} takes a number"));
            match word.as_str() {
                "--seeds" => flags.seeds = number()?.parse()?,
                "--shrink" => flags.shrink = number()?.parse()?,
                "--spp" => flags.spp = number()?.parse()?,
                "--photons" => flags.photons = Some(number()?.parse()?),
                "--phantom" => flags.dent = false,
                "--dent" => flags.phantom = false,
                other => bail!("there is no flag {other}"),
            }
        }
        Ok(flags)
    }
}

/// A scene on a device of its own.
struct Bench {
    loaded: LoadedScene,
    model: Model<f64>,
    backend: Backend,
    settings: Settings,
}

impl Bench {
    /// A scene of fewer pixels, as bright. A phantom is pressed to its last depth, with or without its inclusions.
    fn new(name: &str, inclusions: bool, shrink: u32, flags: &Flags) -> Result<Self> {
        let mut loaded = preset(name)?;
        let camera = &mut loaded.scene.camera;
        camera.pixels = camera.pixels.map(|pixels| pixels / shrink);
        camera.pixel_pitch_um *= f64::from(shrink);
        camera.sensor.exposure_ms /= f64::from(shrink * shrink);
        let last = loaded.scene.press.as_mut().and_then(|press| press.depths_mm.as_mut());
        if let Some(depths) = last {
            depths.drain(..depths.len().saturating_sub(1));
        }
        if let Some(press) = &mut loaded.scene.press {
            press.estimate_error = false;
        }
        let order = Order { without_inclusions: !inclusions, ..Order::of(&loaded.scene) };
        let mut session = Session::open(BackendChoice::Auto, Precision::F32)?;
        let model = session.prepare(loaded.clone(), &order, &mut |_| true)?.model;
        let settings = Settings { spp: flags.spp, photons: flags.photons, ..Settings::of(&loaded.scene.render) };
        let backend = session.devices().load(&model)?;
        Ok(Self { loaded, model, backend, settings })
    }

    fn shoot(&mut self, seed: u32) -> Result<Shot> {
        self.settings.seed = seed;
        let film = render_on(&mut self.backend, &self.model, &self.settings, &mut |_| true)?.film;
        let (camera, wavelength) = (&self.loaded.scene.camera, self.loaded.scene.light.wavelength_nm);
        let image = GreyImage::from_frame(&expose(&film, camera, wavelength, seed)?)?;
        Ok(Shot { film, image })
    }

    fn view(&self) -> (&Camera, f64) {
        (&self.loaded.scene.camera, self.loaded.scene.light.wavelength_nm)
    }
}

struct Shot {
    film: Film,
    image: GreyImage,
}

/// Figures of a shot, raw or less another.
fn read(shot: &Shot, reference: Option<&Shot>, (camera, wavelength): (&Camera, f64)) -> Result<PaperEstimate> {
    let frame = Exposed::new(&shot.film, camera, wavelength)?;
    let Some(reference) = reference else {
        return Ok(measure(&shot.image, &frame, Subtracted::Nothing, THRESHOLD));
    };
    let other = Exposed::new(&reference.film, camera, wavelength)?;
    Ok(measure(&shot.image.minus(&reference.image)?, &frame, Subtracted::Frame(&other), THRESHOLD))
}

/// Figures over seeds: of the raw frame, of the frame less its reference, and of a reference less that of the seed
/// before.
#[derive(Default)]
struct Study {
    raw: Vec<PaperEstimate>,
    less: Vec<PaperEstimate>,
    nothing: Vec<PaperEstimate>,
}

impl Study {
    fn run(what: &str, mut scene: Bench, mut reference: Bench, flags: &Flags) -> Result<Self> {
        let mut study = Self::default();
        let mut before: Option<Shot> = None;
        for seed in 0..flags.seeds {
            let shot = scene.shoot(2 * seed + 1)?;
            let other = reference.shoot(2 * seed + 2)?;
            study.raw.push(read(&shot, None, scene.view())?);
            study.less.push(read(&shot, Some(&other), scene.view())?);
            if let Some(before) = &before {
                study.nothing.push(read(&other, Some(before), reference.view())?);
            }
            before = Some(other);
            if (seed + 1) % 20 == 0 {
                eprintln!("{what}: {} of {} seeds", seed + 1, flags.seeds);
            }
        }
        Ok(study)
    }

    fn print(&self, what: &str) {
        coverage(&format!("{what}, raw"), &self.raw);
        coverage(&format!("{what}, subtracted"), &self.less);
        println!("\n| frames | told that what is lit is not told from noise |\n|---|---|");
        for (name, all) in
            [("raw", &self.raw), ("subtracted", &self.less), ("nothing subtracted from nothing", &self.nothing)]
        {
            let told = all.iter().filter(|one| one.warnings.iter().any(|text| text.contains("not told from noise")));
            println!("| {what}: {name} | {} |", share(told.count(), all.len()));
            let lit = all.iter().map(|one| one.lit_pixels as f64).sum::<f64>() / all.len().max(1) as f64;
            eprintln!("{name}: {lit:.1} pixels lit on average");
        }
    }
}

/// A figure of a frame.
type Figure = fn(&PaperEstimate) -> Value;

fn coverage(what: &str, all: &[PaperEstimate]) {
    println!("\n{what}, {} seeds\n", all.len());
    println!(
        "| figure | mean | spread | intervals that hold the mean | claimed over true spread |\n|---|---|---|---|---|"
    );
    let figures: [(&str, Figure); 5] = [
        ("M", |paper| paper.sum_grey.clone()),
        ("d, px", |paper| paper.diameter_px.clone()),
        ("centroid, column", |paper| paper.centroid_px.axis(0)),
        ("centroid, row", |paper| paper.centroid_px.axis(1)),
        ("h", |paper| paper.h_grey.clone()),
    ];
    for (name, figure) in figures {
        let known: Vec<[f64; 3]> = all
            .iter()
            .filter_map(|paper| match figure(paper) {
                Value::Known { value, low, high } => Some([value, low, high]),
                Value::Undefined { .. } => None,
            })
            .collect();
        let n = known.len() as f64;
        if known.len() < 2 {
            println!("| {name} | undefined | - | - | - |");
            continue;
        }
        let mean = known.iter().map(|known| known[0]).sum::<f64>() / n;
        let spread = (known.iter().map(|known| (known[0] - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let held = known.iter().filter(|[_, low, high]| *low <= mean && mean <= *high).count();
        // Half widths are the quantile times the spread; that of 15 or 30 degrees of freedom is 2.13 or 2.04.
        let claimed = (known.iter().map(|[_, low, high]| (0.5 * (high - low)).powi(2)).sum::<f64>() / n).sqrt() / 2.04;
        let ratio = if spread > 0.0 { format!("{:.2}", claimed / spread) } else { "no spread".into() };
        println!("| {name} | {mean:.6} | {spread:.3e} | {} | {ratio} |", share(held, known.len()));
    }
}

/// A share in per cent with its 95 % interval (Clopper and Pearson 1934).
fn share(held: usize, of: usize) -> String {
    let (k, n) = (held as f64, of as f64);
    let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p));
    let low = if held == 0 { 0.0 } else { quantile(k, n - k + 1.0, 0.025) };
    let high = if held == of { 1.0 } else { quantile(k + 1.0, n - k, 0.975) };
    format!("{held} of {of}: {:.1} % ({:.1} to {:.1})", 100.0 * k / n.max(1.0), 100.0 * low, 100.0 * high)
}

fn main() -> Result<()> {
    let flags = Flags::read()?;
    if flags.phantom {
        let bench = |inclusions| Bench::new("phantom-size-8mm", inclusions, flags.shrink, &flags);
        Study::run("phantom", bench(true)?, bench(false)?, &flags)?.print("phantom-size-8mm");
    }
    if flags.dent {
        // 1392 x 1042 pixels of glints: an eighth of them tells as much.
        let bench = |name| Bench::new(name, true, 8 * flags.shrink, &flags);
        Study::run("dent", bench("tsis-dent")?, bench("tsis-paper")?, &flags)?.print("tsis-dent");
    }
    Ok(())
}
