//! Where LEDs and tissue are, seen from above, and how finely the light between them is told.

use crate::trace::cpu::{V3, wall_axis};
use crate::trace::leds::Led;
use crate::trace::model::Model;

/// Step of the tables along r, as a share of the length on which light near an LED changes.
const STEP: f64 = 1e-2;
/// Step between points of the face, as a share of the least radius of an LED, of that length, and of [`THICKNESS`] of
/// the stack, which tells how near to each other the edges of mirrored tissue lie; and fewest points along a side.
const SPACING: f64 = 0.4;
const THICKNESS: f64 = 0.25;
const LEAST_ACROSS: f64 = 16.0;

/// Where tissue is, seen from the LEDs.
pub struct Site {
    /// The tissue's box within the footprint, mm.
    pub low: [f64; 2],
    pub high: [f64; 2],
    /// Least and largest distance between the box and a place on an LED, seen from above, mm.
    pub near: f64,
    pub far: f64,
    /// Points along each side of the box.
    pub across: usize,
    /// Steps of a table between them.
    pub steps: usize,
}

impl Site {
    /// The site of a model, if unfolding suits it at all.
    pub fn of(model: &Model<f64>) -> Option<Self> {
        let disc = model.tissue.as_ref()?.disc?;
        let radius = disc.radius_sq.sqrt();
        let edge =
            |side: f64| [0, 1].map(|k| (disc.center[k] + side * radius).clamp(-model.half_size[k], model.half_size[k]));
        let (low, high) = (edge(-1.0), edge(1.0));
        // The least and largest distance, the least height above an LED and the least radius of one.
        let (mut near, mut far, mut below, mut least) = (f64::INFINITY, 0.0f64, f64::INFINITY, f64::INFINITY);
        for led in &model.leds {
            let spot = Spot::of(model, led);
            let depths = [low, high].map(|corner| spot.depth(corner));
            let asides = [low, high].map(|corner| (spot.along(corner) - led.along).abs() + led.radius);
            near = near.min(depths[0].min(depths[1]));
            far = far.max(depths[0].max(depths[1]).hypot(asides[0].max(asides[1])));
            below = below.min(model.faces[model.faces.len() - 1].z - led.height - led.radius);
            least = least.min(led.radius);
        }
        let extent = (high[0] - low[0]).max(high[1] - low[1]);
        let steps = ((far - near) / (STEP * near.max(below)).max(f64::MIN_POSITIVE)).ceil().clamp(16.0, 1e6) as usize;
        let scale = least.min(near.max(below)).min(THICKNESS * model.faces[model.faces.len() - 1].z);
        let across = (extent / (SPACING * scale).max(f64::MIN_POSITIVE)).ceil().clamp(LEAST_ACROSS, 1e4) as usize;
        let suits = near >= 0.0 && near < far && model.leds.iter().all(|led| !led.air);
        suits.then_some(Self { low, high, near, far, across, steps })
    }

    /// Distance between points along an axis, mm.
    pub fn step(&self, axis: usize) -> f64 {
        (self.high[axis] - self.low[axis]) / (self.across - 1) as f64
    }
}

/// The plane of an LED.
pub struct Spot {
    /// Outward axis of its wall.
    out: V3<f64>,
    /// Distance of the wall from the middle, mm.
    face: f64,
}

impl Spot {
    /// Of an LED.
    pub fn of(model: &Model<f64>, led: &Led<f64>) -> Self {
        Self { out: wall_axis(led.wall), face: model.half_size[led.wall.axis()] }
    }

    /// Distance of a point from the wall, mm.
    pub fn depth(&self, [x, y]: [f64; 2]) -> f64 {
        self.face - (x * self.out.x + y * self.out.y)
    }

    /// Where a point is along the wall, mm.
    pub fn along(&self, [x, y]: [f64; 2]) -> f64 {
        if self.out.x == 0.0 { x } else { y }
    }

    /// A point moved back towards the wall and along it.
    pub fn back(&self, [x, y]: [f64; 2], [depth, along]: [f64; 2]) -> [f64; 2] {
        if self.out.x == 0.0 { [x - along, y + depth * self.out.y] } else { [x + depth * self.out.x, y - along] }
    }
}
