//! Damping of Newton's method: pseudo-transient continuation (Kelley and Keyes, SIAM J. Numer. Anal. 35, 508, 1998).
//!
//! Soft tissue that slides around an edge comes to loads at which its balance is lost and it snaps to another; there
//! Newton's method cycles, however short the step. With a share of each node's own stiffness added, the tangent is that
//! of a viscous body, which creeps to the next stable balance. The residual is left alone, and the share goes as the
//! residual goes.

/// Share at the start, and the largest.
const FIRST: f64 = 1.0;
const LARGEST: f64 = 10.0;
/// Growth where the residual grows; factor beside the residual's own where it falls; the least of both together.
const GROWTH: f64 = 2.0;
const FALL: f64 = 0.5;
const LEAST_FALL: f64 = 0.05;
/// Share below which there is none: Newton's method then converges at its own rate.
const NEGLIGIBLE: f64 = 1e-4;

/// Share of the nodes' own stiffness in the tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Damping {
    pub share: f64,
    force: f64,
}

impl Damping {
    pub const NONE: Self = Self { share: 0.0, force: f64::INFINITY };
    pub const START: Self = Self { share: FIRST, force: f64::INFINITY };

    /// After a step to a residual `force`. While nodes change what they do (not `same`), a fall of the residual says
    /// little.
    pub fn renew(&mut self, force: f64, same: bool) {
        let ratio = force / std::mem::replace(&mut self.force, force);
        self.share *= match ratio {
            ratio if ratio > 1.0 => GROWTH,
            ratio if same && ratio > 0.0 => (FALL * ratio).max(LEAST_FALL),
            _ => 1.0,
        };
        self.share = if self.share < NEGLIGIBLE { 0.0 } else { self.share.min(LARGEST) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_goes_with_the_residual_and_comes_back() {
        let mut damping = Damping::START;
        let steps = [
            (1.0, true, 1.0),
            (2.0, true, 2.0),
            (1.0, false, 2.0),
            (0.5, true, 0.5),
            (1e-9, true, 0.025),
            (2e-9, true, 0.05),
            (1e-20, true, 0.0025),
            (1e-30, true, 1.25e-4),
            (1e-40, true, 0.0),
        ];
        for (force, same, expected) in steps {
            damping.renew(force, same);
            assert!((damping.share - expected).abs() < 1e-12, "{force}: {} for {expected}", damping.share);
        }
    }
}
