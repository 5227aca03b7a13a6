//! Lamps that are dim or dark on their axis, numbers that are none, and light beyond what the sums hold.

use crate::adapter::require_gpu;
use crate::films::{film, gpu};
use crate::scenes::{Case, model};
use std::path::PathBuf;
use tirtouch::scene::{LoadedScene, Pattern};
use tirtouch::trace::backend::CpuTracer;
use tirtouch::trace::batch::{Batch, Work};
use tirtouch::trace::gpu::GpuTracer;
use tirtouch::trace::plan::Integrator;
use tirtouch::trace::{Backend, Devices, Model, Precision, TraceError};

const WORK: Work = Work { spp: 4, photons: 1 << 14 };

/// `contact-disc` under lamps of 100 cd at 5 degrees and 60 at 45, with so many on the axis: the first cell of the
/// tracer's table is read at 5.07 degrees, so that all these lamps are one.
fn lamps(axis_candela: &str) -> LoadedScene {
    let mut loaded = Case::preset("contact-disc").loaded;
    loaded.scene.camera.pixels = [24, 18];
    let file = PathBuf::from(format!("axis-{axis_candela}.ies"));
    let text = format!("TILT=NONE\n1 -1 1 4 1 1 2 0 0 0\n1 1 0\n0 5 45 90\n0\n{axis_candela} 100 60 0\n");
    loaded.files.insert(&file, text.as_bytes());
    for led in &mut loaded.scene.led {
        led.pattern = Pattern::Ies { file: file.clone() };
        (led.power_mw, led.radiance_w_per_m2_sr) = (Some(5.0), None);
    }
    loaded
}

fn backends(model: &Model<f64>) -> Vec<Backend> {
    let cpu = Backend::Cpu32(Box::new(CpuTracer::new(model.cast())));
    std::iter::once(cpu).chain(require_gpu().map(|adapter| gpu(adapter, model))).collect()
}

/// Films of a lamp by each backend and integrator.
fn films(model: &Model<f64>) -> Vec<Vec<f32>> {
    let one =
        |integrator| backends(model).into_iter().map(move |backend| film(backend, model, integrator, 1, WORK).mean);
    [Integrator::Map, Integrator::Path].into_iter().flat_map(one).collect()
}

#[test]
fn a_lamp_that_is_dim_or_dark_on_its_axis_shines_as_any_other() {
    let bright = films(&model(&lamps("100")));
    assert!(bright.iter().all(|film| film.iter().any(|&v| v > 0.0)));
    for axis in ["1e-4", "0"] {
        assert!(films(&model(&lamps(axis))) == bright, "{axis} cd");
    }
}

/// The radiance of the scene is that along the normal: a lamp a million times as bright elsewhere makes a million times
/// the light.
#[test]
fn the_radiance_along_the_normal_scales_a_lamp_that_is_brighter_elsewhere() {
    let of = |axis: &str| {
        let mut loaded = lamps(axis);
        for led in &mut loaded.scene.led {
            (led.power_mw, led.radiance_w_per_m2_sr) = (None, Some(2.0));
        }
        loaded
    };
    let (bright, dim) = (model(&of("100")), model(&of("1e-4")));
    // Both are quotients of the same few numbers: some roundings of f64.
    assert!((dim.unit_radiance / bright.unit_radiance / 1e6 - 1.0).abs() < 1e-12);
    for (bright, dim) in films(&bright).iter().zip(films(&dim)) {
        // f32 films, each rounded once.
        assert!(bright.iter().zip(dim).all(|(b, d)| (d - 1e6 * b).abs() <= 3e-7 * d));
    }
    let dark = of("0");
    let refused = Model::new(&dark, &tirtouch::surface::Surface::Flat, None).unwrap_err().to_string();
    assert!(refused.contains("led[0].radiance_w_per_m2_sr") && refused.contains("power_mw"), "{refused}");
}

#[test]
fn a_number_that_is_not_finite_is_refused_by_its_name_before_a_kernel_is_made() {
    type Fault = fn(&mut Model<f64>);
    let faults: [(Fault, &str); 4] = [
        (|m| m.leds[1].radiance = f64::NAN, "led[1]: radiance"),
        (|m| m.layers[2].n = f64::INFINITY, "layer 2"),
        (|m| m.led_tables[7][0] = f64::INFINITY, "table"),
        // Finite in f64 alone.
        (|m| m.camera.distance = 1e60, "camera: distance"),
    ];
    let good = model(&lamps("100"));
    for (fault, name) in faults {
        let mut bad = good.clone();
        fault(&mut bad);
        let refused = |found: Result<(), TraceError>| match found {
            Err(TraceError::NotFinite { what, precision: "f32", .. }) => assert!(what.contains(name), "{what}"),
            other => panic!("{name}: {other:?}"),
        };
        refused(Devices::cpu(Precision::F32).load(&bad).map(|_| ()));
        if let Some(adapter) = require_gpu() {
            refused(GpuTracer::on(adapter, &bad).map(|_| ()));
        }
    }
    assert!(Devices::cpu(Precision::F32).load(&good).is_ok());
}

fn traced(mut backend: Backend, model: &Model<f64>, integrator: Integrator) -> Result<Vec<f64>, TraceError> {
    let mut batch = Batch::new(model, &mut backend, integrator, 1);
    batch.replicate(0, WORK, &mut |_| true)
}

/// A path's sum holds 65,536 units, a deposit's cell 2^32 photons: LEDs of 1e12 units, seen through faces that let a
/// hundredth through, and tissue whose 1/n^2 is 1e16.
#[test]
fn light_beyond_what_the_sums_hold_is_reported_and_does_not_wrap() {
    let good = model(&lamps("100"));
    let mut bright = Case::preset("flat-bonded").model([24, 18]);
    bright.leds.iter_mut().for_each(|led| led.radiance = 1e12);
    let mut thin = good.clone();
    if let Some(tissue) = &mut thin.tissue {
        tissue.n = 1e-8;
    }
    for (model, integrator, what) in [(&bright, Integrator::Path, "pixels"), (&thin, Integrator::Splat, "pixels")] {
        for backend in backends(model) {
            let name = backend.name();
            match traced(backend, model, integrator) {
                Err(TraceError::Overflow { what: found, full, of }) => {
                    assert!(found == what && full > 0 && full <= of, "{name}: {full} of {of} {found}");
                }
                other => panic!("{name} by {}: {:?}", integrator.name(), other.map(|image| image.len())),
            }
        }
    }
    for backend in backends(&good) {
        assert!(traced(backend, &good, Integrator::Splat).is_ok());
    }
}
