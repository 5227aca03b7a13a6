//! The asymmetry of what an inclusion adds to a frame.

use crate::figure::Figure;

/// (integral of D right of x = 0 - left of it) / integral of |D| with D = `frame` - `reference` on the places `x` (mm).
///
/// D is linear between the places; its sign changes and the centre are met exactly. 0 where the integral of |D| is at
/// most `vanishing_share` of that of |frame| + |reference|.
pub(super) fn eccentricity(x: &[f64], frame: &[f64], reference: &[f64], vanishing_share: f64) -> Figure {
    if x.first().is_none_or(|&left| left >= 0.0) || x.last().is_none_or(|&right| right <= 0.0) {
        return Figure::undefined("the frame does not lie on both sides of the indenter's centre");
    }
    let difference: Vec<f64> = frame.iter().zip(reference).map(|(p, r)| p - r).collect();
    let total = absolute(x, &difference);
    if total <= vanishing_share * (absolute(x, frame) + absolute(x, reference)) {
        return Figure::known(0.0);
    }
    let pieces = x.windows(2).zip(difference.windows(2));
    let signed: f64 = pieces.map(|(x, d)| right_minus_left([x[0], x[1]], [d[0], d[1]])).sum();
    Figure::known(signed / total)
}

/// Integral of sign(x) times a linear piece.
fn right_minus_left([x0, x1]: [f64; 2], [d0, d1]: [f64; 2]) -> f64 {
    let area = |from: f64, to: f64, a: f64, b: f64| 0.5 * (to - from) * (a + b);
    if x0 >= 0.0 {
        area(x0, x1, d0, d1)
    } else if x1 <= 0.0 {
        -area(x0, x1, d0, d1)
    } else {
        let at_center = d0 + (d1 - d0) * (-x0 / (x1 - x0));
        area(0.0, x1, at_center, d1) - area(x0, 0.0, d0, at_center)
    }
}

/// Integral of the absolute value of a function linear between the places.
fn absolute(x: &[f64], values: &[f64]) -> f64 {
    let piece = |x: &[f64], d: &[f64]| {
        let (length, a, b) = (x[1] - x[0], d[0].abs(), d[1].abs());
        if d[0] * d[1] >= 0.0 {
            0.5 * length * (a + b)
        } else {
            // Two triangles that meet where the sign changes.
            0.5 * length * (a * (a / (a + b)) + b * (b / (a + b)))
        }
    };
    x.windows(2).zip(values.windows(2)).map(|(x, d)| piece(x, d)).sum()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const X: [f64; 6] = [-3.0, -2.0, -0.5, 1.0, 2.5, 3.0];

    fn of(difference: &dyn Fn(f64) -> f64) -> f64 {
        let reference: Vec<f64> = X.iter().map(|x| 9.0 - x * x).collect();
        let frame: Vec<f64> = X.iter().zip(&reference).map(|(&x, r)| r + difference(x)).collect();
        eccentricity(&X, &frame, &reference, 1e-9).value().unwrap()
    }

    #[test]
    fn known_asymmetries_come_out() {
        // Odd: all that is added on the right is taken away on the left.
        assert!((of(&|x| x) - 1.0).abs() < 1e-13);
        assert!((of(&|x| -0.2 * x) + 1.0).abs() < 1e-13);
        // Even: nothing.
        assert!(of(&|_| 0.7).abs() < 1e-13);
        // 1 + x/3 never changes sign on (-3, 3): the odd part's 2 * integral of x/3 over 0..3 = 3, the whole 6.
        assert!((of(&|x| 1.0 + x / 3.0) - 0.5).abs() < 1e-13);
        // 1 + x changes sign at -1, between two places: right 7.5, left -1.5 (+ 0.5, - 2), absolute 7.5 + 0.5 + 2.
        assert!((of(&|x| 1.0 + x) - 9.0 / 10.0).abs() < 1e-13);
    }

    #[test]
    fn a_vanishing_difference_is_not_asymmetric() {
        assert_eq!(of(&|_| 0.0), 0.0);
        assert_eq!(of(&|x| 1e-12 * x), 0.0);
        assert!((of(&|x| 1e-6 * x) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_frame_on_one_side_has_no_eccentricity() {
        let e = eccentricity(&[0.0, 1.0], &[1.0, 2.0], &[0.0, 0.0], 1e-9);
        assert!(e.reason().unwrap().contains("both sides"));
    }
}
