//! Rigid counterparts: a height below the plane z = 0 against the distance from an axis.

/// Shape of a rigid body pressed from below against the tissue's face; its top touches z = 0.
#[derive(Debug, Clone, PartialEq)]
pub enum Profile {
    /// The plane z = 0.
    Flat,
    /// A ball (a cylinder in plane strain) of this radius, mm.
    Round {
        /// Radius, mm.
        radius_mm: f64,
    },
    /// Flat out to a distance, then rounded by a quarter circle.
    RoundedFlat {
        /// Half width of the flat part, mm.
        flat_mm: f64,
        /// Radius of the rounding, mm.
        edge_radius_mm: f64,
    },
    /// Depth below the top at increasing distances, mm, linear in between; the last slope continues.
    Table(Vec<[f64; 2]>),
}

/// Part of a circle's radius up to which its shape is followed; beyond, the tangent continues.
const CIRCLE_SHARE: f64 = 0.97;

impl Profile {
    /// Depth below the top at a distance from the axis, its slope and its curvature (mm, 1, per mm).
    pub fn depth(&self, distance: f64) -> [f64; 3] {
        match self {
            Self::Flat => [0.0; 3],
            Self::Round { radius_mm } => circle(*radius_mm, distance),
            Self::RoundedFlat { flat_mm, edge_radius_mm } => match distance - flat_mm {
                beyond if beyond > 0.0 => circle(*edge_radius_mm, beyond),
                _ => [0.0; 3],
            },
            Self::Table(rows) => {
                let after = rows.partition_point(|row| row[0] <= distance).clamp(1, rows.len().max(2) - 1);
                match (rows.get(after - 1), rows.get(after)) {
                    (Some(a), Some(b)) => {
                        let slope = (b[1] - a[1]) / (b[0] - a[0]);
                        [a[1] + slope * (distance - a[0]), slope, 0.0]
                    }
                    _ => [0.0; 3],
                }
            }
        }
    }

    /// How far below its top a profile first meets a plane that rises by `slope` from the axis outwards, mm, within a
    /// distance of the axis: how far the plane's height on the axis lies above the top as they touch.
    pub fn lift(&self, slope: f64, within_mm: f64) -> f64 {
        let places = (0..=PLACES).map(|k| within_mm * k as f64 / PLACES as f64);
        places.map(|r| slope * r - self.depth(r)[0]).fold(0.0, f64::max)
    }

    /// The farthest distance from the axis, up to `within_mm`, at which the profile reaches above a plane that falls by
    /// `slope` outwards and went down by `depth_mm` since they touched, mm.
    pub fn reach(&self, depth_mm: f64, slope: f64, within_mm: f64) -> f64 {
        let below = depth_mm - self.lift(slope, within_mm);
        let reaches = |r: f64| self.depth(r)[0] - slope * r < below;
        let place = |k: usize| within_mm * k as f64 / PLACES as f64;
        let last = (0..=PLACES).rev().find(|&k| reaches(place(k))).unwrap_or(0);
        if last == PLACES {
            return within_mm;
        }
        let [mut inside, mut outside] = [place(last), place(last + 1)];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            *(if reaches(middle) { &mut inside } else { &mut outside }) = middle;
        }
        inside
    }
}

/// Places along a profile at which it is compared with a plane, and halvings of the stretch between two.
const PLACES: usize = 2000;
const HALVINGS: usize = 40;

fn circle(radius: f64, s: f64) -> [f64; 3] {
    let inside = s.min(CIRCLE_SHARE * radius);
    let height = (radius * radius - inside * inside).sqrt();
    let slope = inside / height;
    let depth = radius - height + slope * (s - inside);
    let curvature = if inside < s { 0.0 } else { radius * radius / height.powi(3) };
    [depth, slope, curvature]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_reaches_above_a_plane_as_far_as_geometry_says() {
        let ball = Profile::Round { radius_mm: 6.0 };
        let chord = (6.0f64.powi(2) - 5.0f64.powi(2)).sqrt();
        assert!((ball.reach(1.0, 0.0, 20.0) - chord).abs() < 1e-9);
        // A plane tilted by an angle touches at R sin(angle), R (1 / cos(angle) - 1) above the tip.
        let angle = 0.1f64;
        let lift = 6.0 * (1.0 / angle.cos() - 1.0);
        assert!((ball.lift(angle.tan(), 20.0) - lift).abs() < 1e-5);
        // Down by 1 along the axis it cuts off a cap as high as 1 times cos(angle).
        let far = 6.0 * (angle + (1.0 - angle.cos() / 6.0).acos()).sin();
        assert!((ball.reach(1.0, angle.tan(), 20.0) - far).abs() < 1e-4, "{}", ball.reach(1.0, angle.tan(), 20.0));
        let cone = Profile::Table(vec![[0.0, 0.0], [1.0, 0.5]]);
        assert!((cone.reach(2.0, 0.0, 20.0) - 4.0).abs() < 1e-9);
        // A face that never falls that deep, and one with a ring outside a groove.
        assert_eq!(Profile::Flat.reach(1.0, 0.0, 20.0), 20.0);
        let ring = Profile::Table(vec![[0.0, 0.0], [2.0, 2.0], [4.0, 0.0], [5.0, 2.0]]);
        assert!((ring.reach(1.0, 0.0, 20.0) - 4.5).abs() < 1e-9);
    }
}
