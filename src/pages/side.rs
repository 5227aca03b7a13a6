//! The side view of a scene: the stack in the section y = 0 with some rays.

use super::PageError;
use crate::pipeline::{Prepared, view_of};
use crate::report::side_view::{SideLayer, SideLed};
use crate::report::{Fate, RayPolyline, SideView, side_view};
use crate::trace::cpu::End;
use crate::trace::rays::{Ray, contact_profile, interface_profiles, leds_in_section, sample_rays};

/// Rays sampled to choose from.
const SAMPLED: usize = 600;
/// Rays drawn of each fate, and whether they leave towards the camera: more would hide each other.
const DRAWN: [(Fate, bool, usize); 5] = [
    (Fate::Guided, false, 4),
    (Fate::EscapedTop, false, 3),
    (Fate::Scattered, false, 1),
    (Fate::Scattered, true, 4),
    (Fate::EscapedBottom, true, 5),
];
/// Places along x at which deformed interfaces and contact are drawn.
const PLACES: usize = 301;

/// Draws the side view.
pub fn side_picture(prepared: &Prepared, seed: u32) -> Result<String, PageError> {
    let scene = prepared.scene();
    let lambda = scene.light.wavelength_nm;
    let half_width_mm = 0.5 * scene.stack.footprint_mm[0];
    let mut interfaces_mm = interface_profiles(&prepared.model, PLACES);
    interfaces_mm.reverse();
    let layer = |layer: &crate::scene::Layer| SideLayer {
        name: layer.name.clone(),
        n: layer.index(lambda),
        thickness_mm: layer.thickness_mm,
    };
    let contact_mm = contact_stretches(&contact_profile(&prepared.model, PLACES));
    let rays = chosen(prepared, sample_rays(&prepared.model, SAMPLED, seed), &contact_mm);
    let leds = leds_in_section(&prepared.model).into_iter().map(|(led, half_chord)| SideLed {
        x_mm: (half_width_mm + led.gap) * if led.wall.is_low() { -1.0 } else { 1.0 },
        z_mm: led.height,
        diameter_mm: 2.0 * half_chord,
    });
    Ok(side_view(&SideView {
        title: format!("{}: from the side", scene.name),
        subtitle: subtitle(prepared),
        half_width_mm,
        layers: scene.stack.layer.iter().map(layer).collect(),
        interfaces_mm,
        surround_n: scene.stack.surround_n,
        view_edge_mm: view_edge(prepared, half_width_mm)?,
        leds: leds.collect(),
        contact_mm,
        rays,
    })?)
}

/// The right edge of the camera's field of view as (x, z), up to the side wall.
fn view_edge(prepared: &Prepared, half_width_mm: f64) -> Result<Vec<[f64; 2]>, PageError> {
    let [width, height] = prepared.scene().camera.pixels.map(f64::from);
    let ray: Vec<[f64; 2]> =
        view_of(prepared.scene())?.ray_mm([width, 0.5 * height]).iter().map(|&[x, _, z]| [x, z]).collect();
    let mut edge: Vec<[f64; 2]> = Vec::new();
    for &[x, z] in &ray {
        match edge.last() {
            Some(&[x0, z0]) if x > half_width_mm => {
                let share = (half_width_mm - x0) / (x - x0);
                edge.push([half_width_mm, z0 + share * (z - z0)]);
                break;
            }
            _ => edge.push([x, z]),
        }
    }
    Ok(edge)
}

/// Stretches of x with at least half of the median share of true contact. (The greatest is often that of a sharp edge.)
fn contact_stretches(profile: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut shares: Vec<f64> = profile.iter().map(|p| p[1]).filter(|&share| share > 0.0).collect();
    shares.sort_by(f64::total_cmp);
    let median = shares.get(shares.len() / 2).copied().unwrap_or(f64::INFINITY);
    let touched = |p: &[f64; 2]| p[1] >= 0.5 * median;
    let stretches = profile.chunk_by(|a, b| touched(a) == touched(b)).filter(|run| run.first().is_some_and(touched));
    stretches.filter_map(|run| Some([run.first()?[0], run.last()?[0]])).filter(|[from, to]| to > from).collect()
}

fn subtitle(prepared: &Prepared) -> String {
    let grid = prepared.contact.as_ref().is_some_and(|contact| contact.columns > 0);
    let tissue = if grid { " · tissue where its true contact is at least half of the median" } else { "" };
    let rays = match leds_in_section(&prepared.model).is_empty() {
        true => "no LED lies in it, so there are no rays",
        false => "rays picked to show what becomes of light",
    };
    format!("section y = 0 · {rays}{tissue}")
}

fn fate(ray: &Ray) -> Fate {
    match ray.end {
        End::Absorbed | End::Roulette | End::Cap => Fate::Absorbed,
        _ if ray.touched_mm.is_some() => Fate::Scattered,
        End::Top => Fate::EscapedTop,
        End::Bottom => Fate::EscapedBottom,
        _ => Fate::Guided,
    }
}

/// The first rays of each fate that can be followed in the picture, guided ones below.
fn chosen(prepared: &Prepared, rays: Vec<Ray>, contact_mm: &[[f64; 2]]) -> Vec<RayPolyline> {
    let drawn = |[x, _, _]: &[f64; 3]| contact_mm.iter().any(|[from, to]| (from..=to).contains(&x));
    let clear = |ray: &Ray| ray.ends_in_section(&prepared.model) && ray.touched_mm.as_ref().is_none_or(drawn);
    let rays: Vec<Ray> = rays.into_iter().filter(clear).collect();
    let pick = |&(drawn, down, count): &(Fate, bool, usize)| {
        let like = move |ray: &&Ray| fate(ray) == drawn && (ray.end == End::Bottom) == down;
        let line = move |ray: &Ray| RayPolyline { fate: drawn, points_mm: ray.points_mm.clone() };
        rays.iter().filter(like).take(count).map(line)
    };
    DRAWN.iter().flat_map(pick).collect()
}
