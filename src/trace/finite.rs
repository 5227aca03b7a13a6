//! Every number of a model is finite, in the precision of the tracer that takes it: a NaN would end in the text of a
//! kernel, or as an image that is dark for no reason.

use super::TraceError;
use super::model::{CapShape, Deformation, FieldShape, Heights, MeshShape, Model, Real};
use super::scatter::{Lambertian, Scatter};

/// Refuses a model with a number that is not finite, and names it.
pub(super) fn check<T: Real>(model: &Model<T>, precision: &'static str) -> Result<(), TraceError> {
    let refused = |what: String, value: T| TraceError::NotFinite { what, value: value.wide(), precision };
    let all = |what: &str, values: &[T]| match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(refused(what.into(), *value)),
        None => Ok(()),
    };
    let named = |of: &str, values: &[(&str, T)]| match values.iter().find(|(_, value)| !value.is_finite()) {
        Some((what, value)) => Err(refused(format!("{of}{what}"), *value)),
        None => Ok(()),
    };
    let [half_x, half_y] = model.half_size;
    named(
        "",
        &[
            ("half the footprint along x", half_x),
            ("half the footprint along y", half_y),
            ("the index of the surround", model.surround_n),
            ("the walls' reflectance", model.wall_reflectance),
            ("the film's unit of radiance", T::of(model.unit_radiance)),
            ("the LEDs' power in that unit", T::of(model.power)),
            ("the share of aimed light", T::of(model.aimed_share)),
        ],
    )?;
    for (k, layer) in model.layers.iter().enumerate() {
        let of = format!("layer {k} (0: the surround below): ");
        let values =
            [("n", layer.n), ("n^2", layer.n_sq), ("absorption", layer.absorption), ("side step", layer.side_dn_sq)];
        named(&of, &values)?;
    }
    for (k, face) in model.faces.iter().enumerate() {
        let values = [
            ("height", face.z),
            ("share", face.share),
            ("step of n^2", face.dn_sq),
            ("slope", face.slope),
            ("curvature", face.curvature),
            ("lowest displacement", face.low),
            ("highest displacement", face.high),
            ("roughness", face.rough),
            ("lobe", face.alpha),
        ];
        named(&format!("interface {k} from below: "), &values)?;
    }
    for (k, led) in model.leds.iter().enumerate() {
        let values = [
            ("place along the wall", led.along),
            ("height", led.height),
            ("radius", led.radius),
            ("gap", led.gap),
            ("radiance", led.radiance),
            ("exponent", led.exponent),
            ("cosine of the cut-off", led.cos_cutoff),
            ("share of the power", led.cumulative),
            ("launch", led.launch),
            ("lower aim", led.aim[0]),
            ("upper aim", led.aim[1]),
            ("share of the aimed power", led.cumulative_aimed),
        ];
        named(&format!("led[{k}]: "), &values)?;
    }
    model.led_tables.iter().try_for_each(|entry| all("a table of an LED", entry))?;
    let camera = &model.camera;
    named(
        "camera: ",
        &[
            ("angle of a pixel", camera.pixel_tan),
            ("distance", camera.distance),
            ("radius of the lens", camera.lens_radius),
            ("focus", camera.focus),
        ],
    )?;
    if let Some(tissue) = &model.tissue {
        let values = [
            ("n", tissue.n),
            ("spread", tissue.spread_d),
            ("share of contact", tissue.share),
            ("step of n^2", tissue.dn_sq),
            ("step of n^2 of the gap", tissue.gap_dn_sq),
        ];
        named("tissue: ", &values)?;
        if let Some(disc) = &tissue.disc {
            let [x, y] = disc.center;
            let values = [("centre along x", x), ("centre along y", y), ("square of the radius", disc.radius_sq)];
            named("tissue: ", &values)?;
        }
        all("tissue: a share of contact", &tissue.grid)?;
        match &tissue.scatter {
            Scatter::Lambertian(Lambertian { albedo, reentry_contact, reentry_gap }) => {
                all("tissue: a reflectance", &[*albedo, *reentry_contact, *reentry_gap])?;
            }
            Scatter::HalfSpace(half) => {
                all("tissue: scattering", &[half.quarter_albedo, half.floor])?;
                all("tissue: scattering", half.terms.as_flattened())?;
                all("tissue: scattering", &[half.cosines, half.toward, half.between].concat())?;
                all("tissue: a reflectance", &[half.reentry_contact, half.reentry_gap].concat().concat())?;
            }
        }
    }
    shape(&model.shape, &all)
}

/// Refuses numbers of one name that are not all finite.
type All<'a, T> = dyn Fn(&str, &[T]) -> Result<(), TraceError> + 'a;

fn shape<T: Real>(shape: &Deformation<T>, all: &All<T>) -> Result<(), TraceError> {
    match shape {
        Deformation::Plane => Ok(()),
        Deformation::Cap(CapShape { center: [x, y], ball, depth, rim_sq }) => {
            all("the cap of the touched face", &[*x, *y, *ball, *depth, *rim_sq])
        }
        Deformation::Field(FieldShape { heights, center }) => {
            all("the centre of the height fields", center)?;
            match heights {
                Heights::Grid { per_mm, control, .. } => {
                    all("samples per mm of the height fields", per_mm)?;
                    control.iter().try_for_each(|field| all("a height", field))
                }
                Heights::Profile { per_mm, cells } => {
                    all("cells per mm of the height fields", &[*per_mm])?;
                    cells.iter().flatten().try_for_each(|cell| all("a height", cell))
                }
            }
        }
        Deformation::Mesh(MeshShape { corners, normals, .. }) => {
            let triangles = || corners.iter().chain(normals).flatten();
            triangles().try_for_each(|corner| all("a corner or normal of the mesh", corner))
        }
    }
}
