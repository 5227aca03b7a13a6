//! What it gains to leave out what a scene does not need: the same image with pieces of the kernels, or stages, that it
//! has no use for, against the image without, alternating in one run.

use super::asked::render;
use super::backend::Devices;
use super::disc::Disc;
use super::error::TraceError;
use super::kernel::{Kernel, ShapePiece};
use super::model::{Camera, Deformation, FieldShape, Heights, Model, Spare, Tissue};
use super::render::Settings;
use super::scatter::Scatter;
use crate::film::compare::compare;
use crate::film::{Film, mean_interval};
use crate::progress::{Observer, Stage};
use crate::scene::IntegratorChoice;
use crate::surface::{HeightField, Profile, Relief};
use serde::Serialize;

/// Points along each side of a height field that stays flat.
const FLAT_POINTS: usize = 128;
/// Chance of a false alarm in the comparison of two images.
const LEVEL: f64 = 1e-4;

/// What one piece or stage costs where nothing needs it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gain {
    /// The piece, or the pieces.
    pub piece: String,
    /// Run time with it over run time without, median of the rounds.
    pub slower: f64,
    /// Lower end of the 95 % interval of the mean ratio, of logarithms.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Whether the images agree.
    pub same_image: bool,
}

/// Samples a pixel and most pixels along a side of the images that gains are measured on.
const SMALL: (u32, u32) = (64, 192);

/// A model and settings for small images of the same scene: gains are to be measured in seconds.
pub fn small(model: &Model<f64>, settings: &Settings) -> (Model<f64>, Settings) {
    let (spp, most) = SMALL;
    let mut model = model.clone();
    let camera = &mut model.camera;
    let shrink = camera.size[0].max(camera.size[1]).div_ceil(most);
    camera.size = camera.size.map(|pixels| (pixels / shrink).max(1));
    camera.pixel_tan *= f64::from(shrink);
    // No more photons than paths: the fewest that an image has by itself are for its quality, and would hide its paths
    // here.
    let paths = u64::from(camera.size[0]) * u64::from(camera.size[1]) * u64::from(spp);
    let photons = Some(settings.photons.unwrap_or(paths).min(paths));
    (model, Settings { spp, photons, ..settings.clone() })
}

/// Whether two images are of the same light.
fn agree(plain: &Film, film: &Film) -> bool {
    film.mean == plain.mean || compare(plain, film, LEVEL).is_ok_and(|comparison| comparison.passed)
}

/// A model with something more in it than it needs.
struct Laden {
    piece: String,
    model: Model<f64>,
    settings: Settings,
}

/// Renders `model` with and without each piece that it leaves out, `rounds` times in turn; with them by `other_seed`,
/// since equal noise would hide differences. `observe` as for [`render()`].
///
/// # Errors
/// As [`render()`].
pub fn gains(
    devices: &Devices,
    model: &Model<f64>,
    settings: &Settings,
    other_seed: u32,
    rounds: u32,
    observe: &mut Observer,
) -> Result<Vec<Gain>, TraceError> {
    // Connections to the pinhole need flat, smooth stacks; what is loaded on may be neither.
    let integrator =
        if settings.integrator == IntegratorChoice::Splat { IntegratorChoice::Auto } else { settings.integrator };
    let settings = &Settings { integrator, ..settings.clone() };
    let laden = laden(model, &Settings { seed: other_seed, ..settings.clone() });
    let mut ratios = vec![Vec::new(); laden.len()];
    let mut films: Vec<Option<Film>> = vec![None; laden.len()];
    let mut plain = None;
    let turns = f64::from(rounds) * (laden.len() + 1) as f64;
    let mut turn = 0.0;
    let mut one = |model: &Model<f64>, settings: &Settings| {
        let outcome = render(devices, model, settings, &mut |stage| {
            observe(Stage { done: (turn + stage.done) / turns, what: "with and without" })
        })?;
        turn += 1.0;
        Ok::<_, TraceError>((outcome.film, outcome.seconds))
    };
    for _ in 0..rounds {
        let (film, seconds) = one(model, settings)?;
        plain.get_or_insert(film);
        for (k, Laden { model, settings, .. }) in laden.iter().enumerate() {
            let (film, with) = one(model, settings)?;
            ratios[k].push((with / seconds).ln());
            films[k].get_or_insert(film);
        }
    }
    let gain = |((laden, mut ratios), film): ((Laden, Vec<f64>), Option<Film>)| {
        let same = film.zip(plain.as_ref()).is_some_and(|(film, plain)| agree(plain, &film));
        let [mean, half] = mean_interval(&ratios);
        ratios.sort_by(f64::total_cmp);
        Gain {
            piece: laden.piece,
            slower: ratios.get(ratios.len() / 2).map_or(1.0, |r| r.exp()),
            low: (mean - half).exp(),
            high: (mean + half).exp(),
            same_image: same,
        }
    };
    Ok(laden.into_iter().zip(ratios).zip(films).map(gain).collect())
}

/// The model with each thing that it leaves out, one at a time and all together.
fn laden(model: &Model<f64>, settings: &Settings) -> Vec<Laden> {
    let kernel = Kernel::of(model);
    type Load = fn(&mut Model<f64>, &mut Settings);
    let spare: [(&str, bool, Load); 12] = [
        ("height fields", kernel.shape == ShapePiece::Plane, |m, _| flat_fields(m)),
        ("height fields over the plane in place of profiles", kernel.shape == ShapePiece::Profile, |m, _| {
            over_the_plane(m)
        }),
        ("search on both faces of a layer", kernel.deformed() && !kernel.deformed_pairs, |m, _| {
            m.spare.push(Spare::DeformedPairs);
        }),
        ("absorption", !kernel.absorbing, |m, _| m.spare.push(Spare::Absorption)),
        ("roughness", !kernel.rough, |m, _| m.spare.push(Spare::Roughness)),
        ("tabulated LED patterns", !kernel.led_tables, |m, _| m.spare.push(Spare::LedTables)),
        ("cosine-power LED patterns", !kernel.cosine_power, |m, _| m.spare.push(Spare::CosinePower)),
        ("thin lens", !kernel.lens, |m, _| {
            m.camera = Camera { focus: m.camera.distance, ..m.camera };
            m.spare.push(Spare::Lens);
        }),
        ("edge of the tissue", kernel.touched && !kernel.tissue_disc, |m, _| {
            let [x, y] = m.half_size;
            let disc = Disc { center: [0.0; 2], radius_sq: 2.0 * (x * x + y * y) };
            m.tissue.iter_mut().for_each(|tissue| tissue.disc = Some(disc));
        }),
        ("photons that can meet no tissue", kernel.aimed, |m, _| m.spare.push(Spare::Astray)),
        ("photons for light that unfolding finds", kernel.unfolded > 0, |m, _| m.spare.push(Spare::Direct)),
        ("tissue contact, photons and their map", !kernel.touched, |m, s| {
            m.tissue = Some(out_of_reach(m.surround_n));
            s.integrator = IntegratorChoice::Map;
        }),
    ];
    let left_out: Vec<_> = spare.into_iter().filter(|(_, left_out, _)| *left_out).collect();
    let with = |loads: &[(&str, bool, Load)], piece: String| {
        let (mut model, mut settings) = (model.clone(), settings.clone());
        loads.iter().for_each(|(_, _, load)| load(&mut model, &mut settings));
        Laden { piece, model, settings }
    };
    let mut laden: Vec<Laden> = left_out.chunks(1).map(|one| with(one, one[0].0.to_owned())).collect();
    if laden.len() > 1 {
        laden.push(with(&left_out, "all of these".to_owned()));
    }
    laden
}

/// Height fields without a relief on the touched face and on every other above the rigid layer.
fn flat_fields(model: &mut Model<f64>) {
    let first = 2.min(model.faces.len() - 1);
    for face in model.faces.iter_mut().skip(first) {
        (face.share, face.low, face.high) = (1.0, -1e-3, 1e-3);
    }
    let cells = (FLAT_POINTS - 1) as f64;
    model.shape = Deformation::Field(FieldShape {
        heights: Heights::Grid {
            size: [FLAT_POINTS; 2],
            per_mm: model.half_size.map(|half| cells / (2.0 * half)),
            control: vec![vec![0.0; (FLAT_POINTS + 2) * (FLAT_POINTS + 2)]],
        },
        center: [0.0; 2],
    });
}

/// The same heights on a grid.
fn over_the_plane(model: &mut Model<f64>) {
    let footprint = model.half_size.map(|half| 2.0 * half);
    let Deformation::Field(FieldShape { heights: Heights::Profile { per_mm, cells }, center, .. }) = &model.shape
    else {
        return;
    };
    // As fine as the profiles.
    let points = (per_mm * footprint[0].max(footprint[1])).round() as usize + 1;
    let profiles = cells.iter().map(|cells| Profile { center_mm: *center, per_mm: *per_mm, cells: cells.clone() });
    let field = |profile: Profile| HeightField::sample(points, footprint, |x, y| profile.at(x, y)[0]);
    let Some(fields) = profiles.map(field).collect::<Option<Vec<_>>>() else { return };
    for face in model.faces.iter_mut().filter(|face| face.share != 0.0) {
        face.follow(&fields[face.field]);
    }
    let Some(first) = fields.first() else { return };
    model.shape = Deformation::Field(FieldShape {
        heights: Heights::Grid {
            size: [first.columns, first.rows],
            per_mm: first.per_mm,
            control: fields.iter().map(|field| field.control.clone()).collect(),
        },
        center: [0.0; 2],
    });
}

/// Tissue that no path meets.
fn out_of_reach(n: f64) -> Tissue<f64> {
    Tissue {
        n,
        scatter: Scatter::lambertian(0.0, |_| 0.0, |_| 0.0),
        spread_d: 0.0,
        disc: Some(Disc { center: [0.0; 2], radius_sq: -1.0 }),
        share: 0.0,
        grid_size: [0; 2],
        grid: Vec::new(),
        dn_sq: 0.0,
        gap_dn_sq: 0.0,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::LoadedScene;
    use crate::trace::Precision;

    fn film(loaded: &LoadedScene, seed: u32) -> Film {
        let surface = crate::surface::surface(loaded).unwrap();
        let model = Model::new(loaded, &surface, crate::surface::contact_map(loaded).unwrap()).unwrap();
        let settings = Settings { spp: 32, photons: Some(1 << 18), seed, ..Settings::of(&loaded.scene.render) };
        render(&Devices::cpu(Precision::F32), &model, &settings, &mut |_| true).unwrap().film
    }

    #[test]
    fn another_albedo_is_another_image_and_another_seed_is_not() {
        let mut loaded = crate::scene::preset("contact-disc").unwrap();
        loaded.scene.camera.pixel_pitch_um *= 8.0;
        loaded.scene.camera.pixels = [48, 36];
        let plain = film(&loaded, 1);
        assert!(agree(&plain, &film(&loaded, 2)));
        if let Some(contact) = &mut loaded.scene.touch.contact {
            contact.tissue.diffuse_reflectance = Some(0.55);
        }
        assert!(!agree(&plain, &film(&loaded, 3)));
    }
}
