//! A spherical cap pressed into a plane.

/// A spherical cap of given depth and rim radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cap {
    /// Centre, mm.
    pub center_mm: [f64; 2],
    /// Depth at the centre, mm.
    pub depth_mm: f64,
    /// Radius of the rim, mm.
    pub rim_mm: f64,
}

impl Cap {
    /// Radius of the ball the cap is cut from, mm: (rim^2 + depth^2) / (2 depth).
    pub fn ball_radius_mm(&self) -> f64 {
        (self.rim_mm * self.rim_mm + self.depth_mm * self.depth_mm) / (2.0 * self.depth_mm)
    }

    /// Slope at the rim, where it is steepest; infinite from a hemisphere on.
    pub fn steepest(&self) -> f64 {
        let above = self.ball_radius_mm() - self.depth_mm;
        if above > 0.0 { self.rim_mm / above } else { f64::INFINITY }
    }

    /// Displacement of the touched face, mm (zero or negative).
    pub fn height_mm(&self, x: f64, y: f64) -> f64 {
        let (dx, dy) = (x - self.center_mm[0], y - self.center_mm[1]);
        let r_sq = dx * dx + dy * dy;
        if r_sq >= self.rim_mm * self.rim_mm {
            return 0.0;
        }
        let ball = self.ball_radius_mm();
        ball - self.depth_mm - (ball * ball - r_sq).sqrt()
    }
}
