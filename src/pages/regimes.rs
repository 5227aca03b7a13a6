//! What a scene's numbers mean for its light, in sentences.

use super::facts::figure;
use crate::figure::Figure;
use crate::optics::{acceptance_deg, critical_deg};
use crate::pipeline::Prepared;
use crate::scene::{Mount, Roughness, Shape};
use serde::Serialize;

/// Rounding of a cut-off that was copied from a table of acceptance angles, degrees.
const COPIED_DEG: f64 = 1e-3;

/// The angles of one layer.
#[derive(Debug, Clone, Serialize)]
pub struct LayerAngles {
    pub name: String,
    pub n: f64,
    pub thickness_mm: f64,
    /// Largest angle to the edge's normal, in the surround, that is still trapped; 90: everything is.
    pub acceptance_deg: f64,
    /// Critical angle of total reflection to the surround.
    critical_to_surround_deg: Figure,
    /// Why the acceptance is 90 or 0, where it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

impl LayerAngles {
    /// The critical angle to the surround in degrees, or a dash where there is none.
    pub fn critical_text(&self) -> String {
        self.critical_to_surround_deg.value().map_or("-".to_owned(), |v| format!("{v:.4}"))
    }
}

/// The angles of every layer, touch side first.
pub fn layers(prepared: &Prepared) -> Vec<LayerAngles> {
    let stack = &prepared.scene().stack;
    let n_0 = stack.surround_n;
    let angles = |layer: &crate::scene::Layer| {
        let n = layer.index(prepared.scene().light.wavelength_nm);
        let accepted = acceptance_deg(n, n_0, n_0);
        let note = match accepted {
            None => Some(format!(
                "everything launched from the surround is trapped: the index is at least sqrt(2) = {:.4} times that of the surround",
                std::f64::consts::SQRT_2
            )),
            Some(0.0) => Some("nothing is trapped: the index is not above that of the surround".to_owned()),
            Some(_) => None,
        };
        LayerAngles {
            name: layer.name.clone(),
            n,
            thickness_mm: layer.thickness_mm,
            acceptance_deg: accepted.unwrap_or(90.0),
            critical_to_surround_deg: Figure::of(critical_deg(n, n_0), "the index is not above that of the surround"),
            note,
        }
    };
    stack.layer.iter().map(angles).collect()
}

/// The sentences, from the LEDs to the camera.
pub fn regimes(prepared: &Prepared, layers: &[LayerAngles]) -> Vec<String> {
    let touched = prepared.contact.is_some();
    let smooth = !rough(prepared);
    let undisturbed = !touched && smooth && matches!(prepared.scene().touch.shape, Shape::Flat);
    let mut said = vec![launch(prepared, layers, undisturbed)];
    if prepared.surface.is_deformed() {
        let inner = if touched { "" } else { ": without contact or roughness these are all the camera sees" };
        said.push(format!("the deformed face is mirror-smooth and shows sharp glints of the LEDs{inner}"));
    }
    if let Some(contact) = &prepared.contact {
        let shares = contact.share.iter().copied().chain((contact.columns == 0).then_some(contact.uniform));
        let (least, most) = shares.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
        let range = if least == most { figure(most) } else { format!("{} to {}", figure(least), figure(most)) };
        said.push(format!(
            "tissue touches: the share of true contact, where light gets out and comes back diffuse, is {range}"
        ));
    }
    if !smooth {
        said.push("rough interfaces turn guided light out of its cone: a flat stack glows".to_owned());
    }
    said
}

fn rough(prepared: &Prepared) -> bool {
    let stack = &prepared.scene().stack;
    let uppers = stack.layer.iter().map(|layer| layer.upper_roughness);
    uppers.chain([stack.lower_roughness]).any(|roughness| roughness != Roughness::None)
}

/// What becomes of the light as it is launched.
fn launch(prepared: &Prepared, layers: &[LayerAngles], undisturbed: bool) -> String {
    let leds = &prepared.scene().led;
    if leds.iter().any(|led| led.mount == Mount::Bonded) {
        return "LEDs are bonded to the edge and send light at every angle: what is steeper than the critical angle \
                leaves at once, also from a flat stack"
            .to_owned();
    }
    let least = layers.iter().map(|layer| layer.acceptance_deg).fold(90.0, f64::min);
    let widest = leds.iter().map(|led| led.cutoff_half_angle_deg.unwrap_or(90.0)).fold(0.0, f64::max);
    let dark = if undisturbed { "; the stack is flat and nothing touches: the camera sees nothing" } else { "" };
    if least >= 90.0 {
        format!(
            "LEDs stand in the surround, and every index is at least sqrt(2) times that of the surround, so everything \
             they launch is trapped between top and bottom{dark}"
        )
    } else if widest <= least + COPIED_DEG {
        format!(
            "LEDs stand in the surround, and their cone of {:.3} degrees lies within what every layer traps{dark}",
            2.0 * widest
        )
    } else {
        format!(
            "LEDs stand in the surround, and their cone of {:.3} degrees is wider than the {:.3} degrees that every layer traps: some light leaks from a flat stack",
            2.0 * widest,
            2.0 * least
        )
    }
}
