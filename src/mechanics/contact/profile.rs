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
}

fn circle(radius: f64, s: f64) -> [f64; 3] {
    let inside = s.min(CIRCLE_SHARE * radius);
    let height = (radius * radius - inside * inside).sqrt();
    let slope = inside / height;
    let depth = radius - height + slope * (s - inside);
    let curvature = if inside < s { 0.0 } else { radius * radius / height.powi(3) };
    [depth, slope, curvature]
}
