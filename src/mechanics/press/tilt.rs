//! A phantom that is not pressed straight down: it is turned about x, then y, through the middle of the sensor's face.
//!
//! Faces that slide are turned from the start, and depths count from where the phantom's face first meets the sensor's
//! rim. Faces that are tied lie flat on each other at rest; there the base turns as it comes down, and has turned all
//! the way at the last depth.

use super::{AssemblyError, Load, SensorBody, Setup};
use crate::mechanics::contact::Grip;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::mesh::{Boundary, Footprint, Mesh};
use crate::mechanics::problem::Support;
use std::collections::HashSet;

/// Points around a rim and across it at which a turned face is brought to touch.
const AROUND: usize = 720;
const ACROSS: usize = 20;

/// A rotation, by rows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rotation([[f64; 3]; 3]);

impl Rotation {
    /// About x by the first angle, then about y by the second, degrees.
    fn new(tilt_deg: [f64; 2]) -> Self {
        let [(sx, cx), (sy, cy)] = tilt_deg.map(|angle| angle.to_radians().sin_cos());
        Self([[cy, sy * sx, sy * cx], [0.0, cx, -sx], [-sy, cy * sx, cy * cx]])
    }

    fn of(&self, x: [f64; 3]) -> [f64; 3] {
        self.0.map(|row| (0..3).map(|i| row[i] * x[i]).sum())
    }

    /// Height of the turned plane z = 0 above a point of the plan.
    fn height(&self, x: f64, y: f64) -> f64 {
        let normal = [0, 1, 2].map(|i| self.0[i][2]);
        -(normal[0] * x + normal[1] * y) / normal[2]
    }

    /// How steep the turned plane z = 0 is.
    fn slope(&self) -> f64 {
        self.0[0][2].hypot(self.0[1][2]) / self.0[2][2]
    }
}

/// Turns a phantom whose faces slide, and lifts it until it just touches.
///
/// # Errors
/// A tilt in two dimensions.
pub(super) fn turn(setup: &Setup, phantom: &mut Mesh) -> Result<(), AssemblyError> {
    if setup.tilt_deg == [0.0; 2] {
        return Ok(());
    }
    if setup.kinematics != Kinematics::ThreeDimensional {
        return Err(AssemblyError::Unsupported("a tilted press has three dimensions".into()));
    }
    if setup.grip == Grip::Bonded {
        return Ok(());
    }
    let rotation = Rotation::new(setup.tilt_deg);
    let lift = match &setup.sensor {
        SensorBody::Indenter(profile) => profile.lift(rotation.slope(), setup.reach_mm()),
        SensorBody::Rigid { edge_radius_mm } | SensorBody::Layers { edge_radius_mm, .. } => {
            let rim = rim(setup, *edge_radius_mm).into_iter();
            rim.map(|[x, y, z]| z - rotation.height(x, y)).fold(0.0, f64::max)
        }
    };
    for node in &mut phantom.nodes {
        *node = rotation.of(*node);
        node[2] += lift;
    }
    Ok(())
}

/// Points of a sensor's face, its rim of this radius, that a tilted phantom may meet first, mm.
fn rim(setup: &Setup, radius: f64) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    for k in 0..AROUND {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / AROUND as f64).sin_cos();
        for j in 0..=ACROSS {
            // From where the arc begins to where it has turned by 60 degrees: more than any tilt.
            let turned = std::f64::consts::FRAC_PI_3 * j as f64 / ACROSS as f64;
            let inward = radius * (std::f64::consts::FRAC_PI_3.sin() - turned.sin());
            let place = match setup.phantom.footprint {
                Footprint::Round { radius_mm } => [(radius_mm - inward) * cos, (radius_mm - inward) * sin],
                Footprint::Rectangle { half_widths_mm: [x, y] } => {
                    [(x - inward) * cos.signum(), (y - inward) * sin.signum()]
                }
            };
            points.push([place[0], place[1], -radius * (1.0 - turned.cos())]);
        }
    }
    points
}

/// Lets the base of a tied phantom turn with the load.
///
/// # Errors
/// A press by force: how far the base has turned would not be known.
pub(super) fn turn_base(setup: &Setup, phantom: &Mesh, supports: &mut [Support]) -> Result<(), AssemblyError> {
    if setup.tilt_deg == [0.0; 2] || setup.grip != Grip::Bonded {
        return Ok(());
    }
    let Load::Depths(depths) = &setup.load else {
        return Err(AssemblyError::Unsupported(
            "a tied press that tilts is one to depths, not to forces or in steps".into(),
        ));
    };
    let last = depths.last().copied().unwrap_or(1.0);
    let rotation = Rotation::new(setup.tilt_deg);
    let base: HashSet<u32> = phantom.boundary_nodes(Boundary::Base).into_iter().collect();
    for support in supports.iter_mut().filter(|support| base.contains(&support.node)) {
        let x = phantom.nodes[support.node as usize];
        support.displacement_mm += (rotation.of(x)[support.axis] - x[support.axis]) / last;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_keeps_lengths_and_turns_the_way_it_says() {
        let rotation = Rotation::new([30.0, -40.0]);
        let (a, b) = (rotation.of([1.0, 2.0, 3.0]), rotation.of([0.5, -1.0, 2.0]));
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
        assert!((dot(a, a) - 14.0).abs() < 1e-12 && (dot(a, b) - 4.5).abs() < 1e-12);
        // About x, y goes up; about y, x goes down.
        assert!(Rotation::new([1.0, 0.0]).of([0.0, 1.0, 0.0])[2] > 0.0);
        assert!(Rotation::new([0.0, 1.0]).of([1.0, 0.0, 0.0])[2] < 0.0);
        let on_plane = rotation.of([0.3, -0.7, 0.0]);
        assert!((rotation.height(on_plane[0], on_plane[1]) - on_plane[2]).abs() < 1e-12);
    }
}
