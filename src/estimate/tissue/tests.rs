use super::noise::{KINDS, Seen, numbers};
use super::unknowns::{Outline, force};
use super::*;
use crate::camera::noise::PixelRandom;
use crate::mechanics::frames::scan::{Held, ScanSetup, frames};
use crate::mechanics::frames::{Frame, Settings, of_frame};
use crate::scene::{Indenter, Positions, scan_preset};

/// Frames of a round head: half ellipses that grow higher and narrower towards the middle, and lean.
fn made_up() -> Frames {
    let frame = |position: f64| {
        let near = (-(position / 6.0).powi(2)).exp();
        let (peak, half) = (5.0 + 3.0 * near, 13.0 - 2.0 * near);
        let x_mm: Vec<f64> = (0..129).map(|k| f64::from(k) * 0.25 - 16.0).collect();
        let p = |x: &f64| {
            let lean = 1.0 - 0.02 * position * near * x;
            peak * (1.0 - (x / half).powi(2)).max(0.0).sqrt() * lean.max(0.1)
        };
        Frame { position_mm: position, pressure_kpa: x_mm.iter().map(p).collect(), x_mm }
    };
    Frames::new((-10..=10).map(|k| frame(2.0 * f64::from(k))).collect()).unwrap()
}

const SETTINGS: Settings = Settings { window_mm: Some(9.0), contact_above_kpa: 0.0, vanishing_share: 1e-6 };

#[test]
fn noise_of_frames_is_found_and_smooth_frames_have_little() {
    let found = Noise::of(&noisy(&made_up(), 0.02, 3).unwrap(), 0.0).unwrap();
    // Some 2,000 third differences of which every fourth is independent: good to 1/sqrt(2 * 500) = 3 %.
    assert!((found.share / 0.02 - 1.0).abs() < 0.1, "{found:?}");
    let smooth = Noise::of(&made_up(), 0.0).unwrap();
    assert!(smooth.share < 0.002 && smooth.constant_kpa < 0.01, "{smooth:?}");
    let mut random = PixelRandom::new(5, 0);
    let mut even = |frame: &Frame| Frame {
        pressure_kpa: frame
            .pressure_kpa
            .iter()
            .map(|p| if *p > 0.0 { p + 0.1 * random.normal() } else { 0.0 })
            .collect(),
        ..frame.clone()
    };
    let found = Noise::of(&Frames::new(made_up().as_slice().iter().map(&mut even).collect()).unwrap(), 0.0).unwrap();
    assert!((found.constant_kpa / 0.1 - 1.0).abs() < 0.25 && found.share < 0.012, "{found:?}");
}

/// Variances of features over many noisy frames, less what `by_force` says that those of the same force change, over
/// the covariance's; by kinds.
fn scatter(exact: &Frames, noise: Noise, seen: &Seen, by_force: &[f64]) -> [Vec<f64>; KINDS] {
    const DRAWS: u32 = 600;
    let mut sums = vec![[0.0; 2]; seen.used.len()];
    for seed in 0..DRAWS {
        let frames = noisy(exact, noise.share, seed).unwrap();
        let all: Vec<_> =
            frames.as_slice().iter().map(|f| numbers(&of_frame(f, frames.farthest(), &SETTINGS))).collect();
        for (k, (sum, place)) in sums.iter_mut().zip(&seen.used).enumerate() {
            let pressed = [&frames, exact].map(|frames| force(&frames.as_slice()[place / KINDS]).ln());
            let of_force = by_force.get(k).map_or(0.0, |slope| slope * (pressed[0] - pressed[1]));
            let off = all[place / KINDS][place % KINDS].unwrap() - seen.values[k] - of_force;
            sum[0] += off;
            sum[1] += off * off;
        }
    }
    std::array::from_fn(|kind| {
        let of_kind = (0..seen.used.len()).filter(|&k| seen.used[k] % KINDS == kind);
        let variance = |k: usize| (sums[k][1] - sums[k][0].powi(2) / f64::from(DRAWS)) / f64::from(DRAWS);
        of_kind.map(|k| variance(k) / seen.covariance[(k, k)]).collect()
    })
}

fn mean(ratios: &[f64]) -> f64 {
    ratios.iter().sum::<f64>() / ratios.len() as f64
}

/// The covariance that derivatives give is that of many noisy frames; half of it would be told from it.
#[test]
fn features_scatter_as_their_covariance_says() {
    let (exact, noise) = (made_up(), Noise { constant_kpa: 0.0, share: 0.01 });
    let seen = Seen::of(&exact, noise, &SETTINGS).unwrap();
    for (kind, ratios) in scatter(&exact, noise, &seen, &[]).iter().enumerate() {
        // Each ratio is good to sqrt(2/600) = 6 %.
        assert!(!ratios.is_empty() && (mean(ratios) - 1.0).abs() < 0.1, "feature {kind}: {ratios:?}");
        assert!(ratios.iter().all(|ratio| (0.7..1.4).contains(ratio)), "feature {kind}: {ratios:?}");
    }
}

/// Where forces are held their noise counts, with the sign that it has: peaks and bases that rise with the force
/// scatter less about those of the same force, widths that fall with it more.
#[test]
fn features_of_the_same_force_scatter_as_their_covariance_says() {
    let (exact, noise) = (made_up(), Noise { constant_kpa: 0.0, share: 0.01 });
    let mut seen = Seen::of(&exact, noise, &SETTINGS).unwrap();
    let slope = |(place, value): (&usize, &f64)| value * [0.8, 1.5, -10.0, 0.0][place % KINDS];
    let by_force: Vec<f64> = seen.used.iter().zip(&seen.values).map(slope).collect();
    let without = scatter(&exact, noise, &seen, &by_force);
    seen.hold_forces(&exact, noise, &SETTINGS, &by_force);
    for (kind, ratios) in scatter(&exact, noise, &seen, &by_force).iter().enumerate() {
        assert!((mean(ratios) - 1.0).abs() < 0.1, "feature {kind}: {ratios:?}");
    }
    assert!(mean(&without[2]) > 1.3 && mean(&without[0]) < 0.95, "{without:?}");
}

#[test]
fn a_moved_mesh_keeps_the_inclusion_round_and_the_faces_flat() {
    let from = Outline { thickness: 25.0, height: 8.0, radius: 5.0 };
    let to = Outline { thickness: 25.4, height: 8.1, radius: 5.05 };
    for k in 0..16 {
        let (sin, cos) = (f64::from(k) * 0.4).sin_cos();
        let [x, z, _] = from.moved(&to, [5.0 * cos, 8.0 + 5.0 * sin, 0.0]);
        assert!((x.hypot(z - 8.1) - 5.05).abs() < 1e-12);
        let far = [30.0 * cos, 25.0 * (0.5 + 0.5 * sin), 0.0];
        let [x, z, _] = from.moved(&to, far);
        // Away from the inclusion's own gap of 3 mm.
        if far[0].hypot(far[1] - 8.0) > 8.0 {
            assert!(x == far[0] && (z / far[1] - 25.4 / 25.0).abs() < 1e-12);
        }
    }
    let still = from.moved(&from, [2.0, 9.0, 0.0]);
    assert!(still.iter().zip([2.0, 9.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{still:?}");
}

/// The preset with fewer positions, on coarser elements.
fn known() -> LoadedScan {
    let mut loaded = scan_preset("frames-galea").unwrap();
    let scan = &mut loaded.scene.scan;
    (scan.positions_mm, scan.resolution) = (Positions { from: -18.0, to: 18.0, count: 13 }, 0.6);
    loaded
}

/// Noisy frames of a tissue that is not the preset's, on a mesh of its own.
fn seen(known: &LoadedScan) -> Frames {
    let mut loaded = known.clone();
    let phantom = &mut loaded.scene.phantom;
    if let PhantomBody::Block { height_mm, .. } = &mut phantom.shape {
        *height_mm = 21.0;
    }
    let linear = |youngs_kpa| Elastic::Linear { youngs_kpa, poisson: 0.4999, relaxation: Vec::new() };
    phantom.material = linear(9.0);
    phantom.inclusion[0].shape = InclusionBody::Sphere { diameter_mm: 8.6 };
    phantom.inclusion[0].material = linear(45.0);
    loaded.scene.scan.resolution = 0.9;
    let setup = ScanSetup::from_scene(&loaded).unwrap();
    let exact = frames(&setup, &setup.tissue.build_2d().unwrap(), Held::Depth, &|| true).unwrap();
    noisy(&exact, 0.01, 11).unwrap()
}

fn question(scene: &LoadedScan) -> Question<'_> {
    Question { scene, by_force: false, free_depth: false, window_mm: Some(10.0), noise_kpa: 0.0, seed: 0 }
}

fn holds(value: &Value, truth: f64) -> bool {
    matches!(value, Value::Known { low, high, .. } if (*low..=*high).contains(&truth))
}

#[test]
fn tissue_of_noisy_frames_is_found_and_a_wrong_depth_is_noticed() {
    let mut known = known();
    let frames = seen(&known);
    // A guess ten times as stiff: what counts as noise is what the measured frames say, not the guess's.
    let linear = |youngs_kpa| Elastic::Linear { youngs_kpa, poisson: 0.4999, relaxation: Vec::new() };
    let mut stiff = known.clone();
    stiff.scene.phantom.material = linear(128.0);
    stiff.scene.phantom.inclusion[0].material = linear(1280.0);
    let found = invert(&frames, &Question { noise_kpa: 0.5, ..question(&stiff) }, &|_| true).unwrap();
    assert!(holds(&found.thickness_mm, 21.0) && holds(&found.tissue_youngs_kpa, 9.0), "{found:?}");
    assert!(holds(&found.radius_mm, 4.3) && holds(&found.inclusion_youngs_kpa, 45.0), "{found:?}");
    let Value::Known { low, high, .. } = found.radius_mm else { panic!("{found:?}") };
    assert!(high / low < 1.1 && found.reduced_chi_square < 2.0, "{found:?}");
    known.scene.phantom.inclusion[0].depth_mm += 1.0;
    let wrong = invert(&frames, &question(&known), &|_| true).unwrap();
    assert!(!holds(&wrong.radius_mm, 4.3) && wrong.reduced_chi_square > 1.2 * found.reduced_chi_square, "{wrong:?}");
}

/// At a given force linear tissue twice as stiff has the same frames under a flat punch, but for its rounded edge, so
/// that they tell ratios of moduli alone; under a round head its contact is narrower and its peak higher.
#[test]
fn a_force_tells_a_modulus_by_the_width_of_the_contact_alone() {
    let middle = |indenter, depth_mm| {
        let mut known = known();
        known.scene.scan.indenter = indenter;
        known.scene.scan.depth_mm = depth_mm;
        known.scene.scan.positions_mm = Positions { from: -6.0, to: 6.0, count: 3 };
        let scan = |loaded: &LoadedScan, held: Held| {
            let setup = ScanSetup::from_scene(loaded).unwrap();
            frames(&setup, &setup.tissue.build_2d().unwrap(), held, &|| true).unwrap()
        };
        let by_depth = scan(&known, Held::Depth);
        let forces: Vec<f64> = by_depth.as_slice().iter().map(force).collect();
        let far = |a: &Frames, b: &Frames| {
            let pairs = a.as_slice().iter().zip(b.as_slice());
            let places = pairs.flat_map(|(a, b)| a.x_mm.iter().zip(a.pressure_kpa.iter().zip(&b.pressure_kpa)));
            places.filter(|(x, _)| x.abs() < 5.0).map(|(_, (p, q))| (p / q - 1.0).abs()).fold(0.0, f64::max)
        };
        // The forces of the frames, by which the fit goes, are those of the contact to a share of an element.
        let same = far(&by_depth, &scan(&known, Held::Force(&forces)));
        for material in [&mut known.scene.phantom.material, &mut known.scene.phantom.inclusion[0].material] {
            let Elastic::Linear { youngs_kpa, .. } = material else { panic!("the preset is linear") };
            *youngs_kpa *= 2.0;
        }
        (same, far(&by_depth, &scan(&known, Held::Force(&forces))))
    };
    let (same, stiffer) = middle(Indenter::RoundedFlat { flat_mm: 8.0, edge_radius_mm: 0.5 }, 0.3);
    assert!(same < 0.02 && stiffer < 0.05, "flat: {same} {stiffer}");
    let (same, stiffer) = middle(Indenter::Round { radius_mm: 20.0 }, 5.0);
    assert!(same < 0.02 && stiffer > 0.2, "round: {same} {stiffer}");
}

#[test]
fn what_the_inverse_does_not_know_is_refused() {
    let good = known();
    let key = |change: &dyn Fn(&mut LoadedScan)| {
        let mut loaded = good.clone();
        change(&mut loaded);
        match check(&loaded, true).unwrap_err() {
            TissueError::Scene { key, .. } => key,
            other => panic!("{other}"),
        }
    };
    assert!(check(&good, true).is_ok());
    assert_eq!(key(&|s| s.scene.phantom.inclusion.clear()), "phantom.inclusion");
    assert_eq!(key(&|s| s.scene.phantom.inclusion[0].center_mm[0] = 1.0), "phantom.inclusion[0]");
    let yeoh = || Elastic::Yeoh { c_kpa: [1.0, 0.0, 0.0], poisson: 0.4999, relaxation: Vec::new() };
    assert_eq!(key(&|s| s.scene.phantom.material = yeoh()), "phantom.material");
    let neo_hookean = || Elastic::NeoHookean { youngs_kpa: 5.0, poisson: 0.4999, relaxation: Vec::new() };
    let mut loaded = good.clone();
    loaded.scene.phantom.material = neo_hookean();
    assert!(check(&loaded, false).is_ok());
    assert_eq!(key(&|s| s.scene.phantom.material = neo_hookean()), "phantom.material");
    assert_eq!(key(&|s| s.scene.phantom.inclusion[0].material = yeoh()), "phantom.inclusion[0].material");
    assert_eq!(key(&|s| s.scene.scan.interface = Interface::Coulomb { friction: 0.5 }), "scan.interface");
    let frames = made_up();
    let ask = |question: &Question| invert(&frames, question, &|_| true).unwrap_err();
    assert!(matches!(ask(&Question { window_mm: Some(20.0), ..question(&good) }), TissueError::Window { .. }));
    let whole = Question { window_mm: None, noise_kpa: 0.1, ..question(&good) };
    assert!(matches!(ask(&whole), TissueError::NoWindow));
    let few = Frame { x_mm: vec![-2.0, 0.0, 2.0], pressure_kpa: vec![1.0; 3], position_mm: 0.0 };
    let few = Frames::new(vec![few]).unwrap();
    let narrow = Question { window_mm: Some(2.0), ..question(&good) };
    assert!(matches!(invert(&few, &narrow, &|_| true), Err(TissueError::NoNoise)));
    let crowd = |k: u32| Frame { position_mm: 0.05 * f64::from(k), ..frames.as_slice()[10].clone() };
    let crowd = Frames::new((0..700).map(crowd).collect()).unwrap();
    assert!(matches!(invert(&crowd, &question(&good), &|_| true), Err(TissueError::TooMany { .. })));
    let cut = Frames::new(vec![Frame { pressure_kpa: vec![1.0; 129], ..frames.as_slice()[0].clone() }]).unwrap();
    let by_force = Question { by_force: true, ..question(&good) };
    assert!(matches!(invert(&cut, &by_force, &|_| true), Err(TissueError::Cut { .. })));
    assert!(matches!(invert(&frames, &question(&good), &|_| false), Err(TissueError::Scan(_))));
}
