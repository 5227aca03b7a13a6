//! Which symmetries a model has.

use super::disc::Disc;
use super::leds::Led;
use super::model::{Deformation, Heights, Model};
use super::symmetry::{Move, STILL, Symmetry};
use crate::scene::Wall;

/// How far numbers of a place and its image may be apart, as a share of the largest: the rounding of f32.
const ALIKE: f64 = 1e-7;

impl Symmetry {
    /// Those of a model.
    pub fn of(model: &Model<f64>) -> Self {
        Self::under(|one| one.leaves(model))
    }
}

impl Move {
    /// The LED that one is moved to.
    fn led(self, led: &Led<f64>) -> Led<f64> {
        let (across, along) = (led.wall.axis(), 1 - led.wall.axis());
        let wall = Wall::across(across, led.wall.is_low() != self.0[across]);
        Led { wall, along: if self.0[along] { -led.along } else { led.along }, ..*led }
    }

    /// Whether a model is its own image.
    fn leaves(self, model: &Model<f64>) -> bool {
        let holds = |center: [f64; 2]| alike(&center, &self.point(center));
        let shape = match &model.shape {
            Deformation::Plane => true,
            Deformation::Cap(cap) => holds(cap.center),
            Deformation::Field(field) => {
                holds(field.center)
                    && match &field.heights {
                        Heights::Profile { .. } => true,
                        Heights::Grid { size, control, .. } => {
                            control.iter().all(|heights| self.leaves_grid(heights, size.map(|edge| edge + 2)))
                        }
                    }
            }
            Deformation::Mesh(_) => self == STILL,
        };
        let tissue = model.tissue.as_ref().is_none_or(|tissue| {
            tissue.disc.is_none_or(|Disc { center, .. }| holds(center))
                && (tissue.grid.is_empty() || self.leaves_grid(&tissue.grid, tissue.grid_size))
        });
        let count = |wanted: &Led<f64>, of: fn(Self, &Led<f64>) -> Led<f64>| {
            model.leds.iter().filter(|led| same(&of(self, led), wanted)).count()
        };
        let leds = model.leds.iter().all(|led| {
            let plain = led.table.is_none() || self == STILL;
            plain && count(led, |_, led| *led) == count(led, Self::led)
        });
        shape && tissue && leds
    }

    /// Whether numbers of a grid about the axis are their own images.
    fn leaves_grid(self, cells: &[f64], size: [usize; 2]) -> bool {
        let image = |k: usize| {
            let [column, row] = self.cell([k % size[0], k / size[0]], size);
            cells.get(row * size[0] + column).copied().unwrap_or(f64::NAN)
        };
        let images: Vec<f64> = (0..cells.len()).map(image).collect();
        alike(cells, &images)
    }
}

/// Whether numbers are alike, for their largest.
fn alike(one: &[f64], other: &[f64]) -> bool {
    let largest = one.iter().fold(0.0, |largest: f64, v| largest.max(v.abs()));
    one.iter().zip(other).all(|(a, b)| (a - b).abs() <= ALIKE * largest)
}

/// Whether two LEDs are one, but for their places in tables of all.
fn same(one: &Led<f64>, other: &Led<f64>) -> bool {
    let numbers = |led: &Led<f64>| [led.height, led.radius, led.gap, led.radiance, led.exponent, led.cos_cutoff];
    let pairs = numbers(one).into_iter().zip(numbers(other));
    one.wall == other.wall
        && one.air == other.air
        && one.table == other.table
        && (one.along - other.along).abs() <= ALIKE * one.radius
        && pairs.into_iter().all(|(a, b)| (a - b).abs() <= ALIKE * a.abs())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{LoadedScene, preset};

    fn model(loaded: &LoadedScene) -> Model<f64> {
        let shape = crate::surface::surface(loaded).unwrap();
        Model::new(loaded, &shape, crate::surface::contact_map(loaded).unwrap()).unwrap()
    }

    fn order(loaded: &LoadedScene) -> u32 {
        model(loaded).symmetry.order()
    }

    /// The scene of four LEDs with one thing changed at a time, and what is left of its four symmetries.
    #[test]
    fn what_is_changed_takes_the_symmetries_that_it_breaks() {
        let whole = preset("contact-disc").unwrap();
        assert_eq!((order(&whole), whole.scene.led.len()), (4, 4));
        let with = |change: fn(&mut LoadedScene)| {
            let mut loaded = whole.clone();
            change(&mut loaded);
            order(&loaded)
        };
        // One LED brighter: its own mirror plane. All four moved the same way round: half a turn. One that is not in
        // the middle: none.
        assert_eq!(with(|loaded| loaded.scene.led[0].radiance_w_per_m2_sr = Some(1.1)), 2);
        assert_eq!(with(|loaded| drop(loaded.scene.led.drain(2..))), 4);
        assert_eq!(
            with(|loaded| {
                let along = [1.0, -1.0, -1.0, 1.0];
                loaded.scene.led.iter_mut().zip(along).for_each(|(led, along)| led.along_mm = along);
            }),
            2
        );
        assert_eq!(with(|loaded| loaded.scene.led[0].along_mm = 1.0), 1);
        assert_eq!(with(|loaded| loaded.scene.stack.footprint_mm = [30.0, 32.0]), 4);
        assert_eq!(with(|loaded| loaded.scene.render.symmetry = false), 1);
    }
}
