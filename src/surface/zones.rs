//! Where height fields bend little, and where much.
//!
//! A search along a ray steps as far as a bound on the bending allows. A pressed sensor bends thousands of times more at its rim than
//! within; a dent bends within its rim and not beyond. So there are two bounds, within a radius about the middle of the footprint, or about
//! the axis, and beyond it.

use super::Relief;

/// Radii on trial.
const RADII: usize = 32;
/// What belongs to both sides of the radius, mm: more than what rounding moves a ray by.
const OVERLAP_MM: f64 = 0.01;

/// Bounds within a radius and beyond.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Zones {
    /// The radius, mm.
    pub radius_mm: f64,
    /// For each field, bounds on the second derivative within and beyond, per mm.
    pub bounds: Vec<[f64; 2]>,
}

impl Zones {
    /// The radius that spares most steps: those within a length go about as the root of the bound.
    pub fn of<R: Relief>(fields: &[&R]) -> Self {
        let bends: Vec<_> = fields.iter().map(|field| field.bends()).collect();
        let edge_mm = bends.iter().flatten().map(|bend| bend.farthest_mm).fold(0.0, f64::max);
        let zones = |k: usize| {
            let radius_mm = edge_mm * k as f64 / RADII as f64;
            let bounds = bends.iter().map(|bends| {
                bends.iter().fold([0.0f64; 2], |[within, beyond], bend| {
                    let inside = bend.nearest_mm < radius_mm + OVERLAP_MM;
                    let outside = bend.farthest_mm > radius_mm - OVERLAP_MM;
                    [
                        if inside { within.max(bend.bound) } else { within },
                        if outside { beyond.max(bend.bound) } else { beyond },
                    ]
                })
            });
            Self { radius_mm, bounds: bounds.collect() }
        };
        let share = |zones: &Self| {
            let cells = bends.iter().flatten();
            let inside = cells.clone().filter(|bend| bend.farthest_mm <= zones.radius_mm).count();
            inside as f64 / cells.count().max(1) as f64
        };
        let steps = |zones: &Self| {
            let share = share(zones);
            zones
                .bounds
                .iter()
                .map(|[within, beyond]| share * within.sqrt() + (1.0 - share) * beyond.sqrt())
                .sum::<f64>()
        };
        let trials = (1..RADII).map(zones).map(|zones| (steps(&zones), zones));
        trials.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, best)| best).unwrap_or_default()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::surface::HeightField;

    fn field(height: impl Fn(f64) -> f64) -> HeightField {
        HeightField::sample(129, [30.0, 30.0], |x, y| height(x.hypot(y))).unwrap()
    }

    #[test]
    fn a_rim_and_a_dent_are_told_from_what_is_smooth() {
        let rim = field(|r| -0.2 * (1.0 + ((r - 13.0) / 0.5).tanh()) - 1e-4 * r * r);
        let zones = Zones::of(&[&rim]);
        let [within, beyond] = zones.bounds[0];
        assert!(zones.radius_mm > 9.0 && zones.radius_mm < 13.0, "{zones:?}");
        assert!(within < 1e-2 * beyond, "{zones:?}");
        let dent = field(|r| -(-0.5 * (r / 1.5).powi(2)).exp());
        let zones = Zones::of(&[&dent]);
        let [within, beyond] = zones.bounds[0];
        assert!(zones.radius_mm > 4.0 && zones.radius_mm < 12.0 && beyond < 0.1 * within, "{zones:?}");
    }

    #[test]
    fn both_bounds_hold_where_they_are_said_to() {
        let field = field(|r| -0.2 * (1.0 + ((r - 11.0) / 0.4).tanh()));
        let zones = Zones::of(&[&field]);
        for k in 0..20_000 {
            let (x, y) = (0.0173 * f64::from(k) % 29.0 - 14.5, 0.0531 * f64::from(k) % 29.0 - 14.5);
            let (c, s) = (f64::from(k).cos(), f64::from(k).sin());
            let e = 1e-4;
            let h = |t: f64| field.at(x + t * c, y + t * s)[0];
            let found = ((h(e) - 2.0 * h(0.0) + h(-e)) / (e * e)).abs();
            let bound = zones.bounds[0][usize::from(x.hypot(y) > zones.radius_mm)];
            assert!(found <= bound + 1e-6, "{found} against {bound} at {x}, {y}");
        }
    }
}
