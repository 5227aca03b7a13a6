//! Flat stacks: slabs, trapped light, lateral shift, absorption.

use crate::bench::{self, close};
use tirtouch::optics::fresnel::{incoherent_slab, reflectance};
use tirtouch::trace::Model;
use tirtouch::trace::cpu::{End, Path, vec3::V3};
use tirtouch::trace::model::Real;

/// Enters the stack from below, or from above; false where it is reflected.
fn enter<T: Real>(path: &mut Path<T>, up: bool) -> bool {
    let top = path.model.faces.len() - 1;
    let (face, side) = if up { (0, T::one()) } else { (top, -T::one()) };
    let inside = path.meet(face, V3::up(), side);
    path.layer = if up { 1 } else { top };
    inside
}

#[test]
fn an_incoherent_slab_transmits_0_941288_at_30_and_0_926946_at_45_degrees() {
    let mut loaded = bench::stack(&[[1.0, 1.41]]);
    loaded.scene.stack.footprint_mm = [1e4, 1e4];
    let model = bench::model(&loaded).cast::<f32>();
    for (angle, listed) in [(30.0f64, 0.941_288), (45.0, 0.926_946)] {
        let (sin, cos) = angle.to_radians().sin_cos();
        let r = reflectance(cos, 1.0, 1.41);
        // The sum over all orders, (1 - R)/(1 + R), and the printed digits.
        close("slab", 1.0 - incoherent_slab(r, r), (1.0 - r) / (1.0 + r), 1e-12);
        close("slab, listed", (1.0 - r) / (1.0 + r), listed, 5e-7);
        bench::count(&model, 4, 1 << 24, |path| {
            bench::put(path, 0, [0.0; 3], [sin, 0.0, cos]);
            enter(path, true) && path.walk() == End::Top
        })
        .is(&format!("slab at {angle} degrees"), listed, 3);
    }
}

#[test]
fn isotropic_light_in_a_slab_is_trapped_by_the_cosine_of_the_critical_angle() {
    for (n, listed) in [(1.38, 0.689_130), (1.41, 0.704_987)] {
        let exact = f64::sqrt(1.0 - 1.0 / (n * n));
        close("trapped share", exact, listed, 5e-7);
        close("trapped share, by the critical angle", (1.0f64 / n).asin().cos(), exact, 1e-12);
        let mut loaded = bench::stack(&[[1.0, n]]);
        loaded.scene.stack.footprint_mm = [1e6, 1e6];
        let model = bench::model(&loaded).cast::<f32>();
        bench::count(&model, 5, 1 << 24, |path| {
            let cos = 2.0 * f64::from(path.draw()) - 1.0;
            bench::put(path, 1, [0.0, 0.0, 0.5], [n * (1.0 - cos * cos).sqrt(), 0.0, n * cos]);
            // Trapped light takes no random number at either face (or grazes to a wall before).
            path.limits.event_cap = 3;
            let before = path.draws;
            matches!(path.walk(), End::Cap | End::Wall) && path.draws == before
        })
        .is(&format!("trapped share of {n}"), listed, 3);
    }
}

/// How far a ray at `angle_deg` in air comes out beside where it went in, through layers from the top down.
fn shift<T: Real>(model: &Model<f64>, angle_deg: f64) -> f64 {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let model = model.cast::<T>();
    let top = model.faces.len() - 1;
    // Some random numbers reflect it on the way; the first that let it through straight give the answer.
    (0..1000)
        .find_map(|k| {
            let z = model.faces[top].z.wide();
            let mut path = bench::path(&model, top + 1, [0.0, 0.0, z], [sin, 0.0, -cos]);
            path.start_random(6, k, 0);
            let through = enter(&mut path, false) && path.walk() == End::Bottom && path.turns == 0;
            through.then(|| path.o.x.wide())
        })
        .unwrap()
}

#[test]
fn a_ray_through_the_papers_silicone_shifts_by_3_833178_mm() {
    let layers = [[2.0, 1.41], [3.0, 1.40], [5.0, 1.39]];
    let exact: f64 = layers.iter().map(|[t, n]: &[f64; 2]| t * (0.5 / n).asin().tan()).sum();
    let model = bench::model(&bench::stack(&layers));
    close("shift, f64", shift::<f64>(&model, 30.0), exact, 1e-12);
    close("shift, listed", shift::<f64>(&model, 30.0), 3.833_178, 5e-7);
    // f32: heights of 10 mm, indices and momenta rounded to 2^-24, some ten times.
    close("shift, f32", shift::<f32>(&model, 30.0), exact, 1e-5);
}

#[test]
fn light_fades_exponentially_along_its_path() {
    let layers = [[2.0, 1.41], [3.0, 1.40], [5.0, 1.39]];
    let absorption = [0.003, 0.01, 0.03];
    let mut loaded = bench::stack(&layers);
    for (layer, mu) in loaded.scene.stack.layer.iter_mut().zip(absorption) {
        layer.absorption_per_mm = mu;
    }
    let model = bench::model(&loaded);
    let (sin, cos) = 60f64.to_radians().sin_cos();
    let depth: f64 = layers.iter().zip(absorption).map(|([t, n], mu)| mu * t / (sin / n).asin().cos()).sum();
    fn weight<T: Real>(model: &Model<T>, p: [f64; 3]) -> f64 {
        (0..1000)
            .find_map(|k| {
                let mut path = bench::path(model, 4, [0.0, 0.0, 10.0], p);
                path.start_random(7, k, 0);
                let through = enter(&mut path, false) && path.walk() == End::Bottom && path.turns == 0;
                through.then(|| path.weight.wide())
            })
            .unwrap()
    }
    close("transmittance, f64", weight(&model, [sin, 0.0, -cos]), (-depth).exp(), 1e-12);
    // f32: three factors, each off by an ulp of 1 and by the rounding of its exponent.
    close("transmittance, f32", weight(&model.cast::<f32>(), [sin, 0.0, -cos]), (-depth).exp(), 1e-6);
}
