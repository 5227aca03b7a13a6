//! Critical and acceptance angles.

/// Critical angle of total reflection from index `n_i` to `n_t`, degrees. `None` where there is none (`n_t >= n_i`).
pub fn critical_deg(n_i: f64, n_t: f64) -> Option<f64> {
    (n_t < n_i).then(|| (n_t / n_i).asin().to_degrees())
}

/// Acceptance angle of a layer: the largest angle to the edge's normal, in the launch medium `n_launch`, that is still
/// trapped between top and bottom against a surround `n_0`. asin(sqrt(n^2 - n_0^2) / n_launch), degrees.
///
/// `None` where the root exceeds one: everything launched is trapped (and 90 degrees is meant). Zero where `n <= n_0`.
pub fn acceptance_deg(n: f64, n_0: f64, n_launch: f64) -> Option<f64> {
    let root = ((n - n_0) * (n + n_0)).max(0.0).sqrt() / n_launch;
    (root < 1.0).then(|| root.asin().to_degrees())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn acceptance_of_the_papers_layers() {
        for (n, expected) in [(1.41, 83.737), (1.40, 78.463), (1.39, 74.896), (1.38, 71.989)] {
            // Half a unit of the last digit printed.
            assert!((acceptance_deg(n, 1.0, 1.0).unwrap() - expected).abs() < 5e-4);
        }
        assert_eq!(acceptance_deg(1.4143, 1.0, 1.0), None);
    }

    #[test]
    fn critical_angles_of_the_papers_layers() {
        let expected = [
            (1.41, 1.0, 45.1715),
            (1.40, 1.0, 45.5847),
            (1.39, 1.0, 46.0070),
            (1.38, 1.0, 46.4387),
            (1.41, 1.40, 83.1721),
            (1.40, 1.39, 83.1478),
            (1.39, 1.38, 83.1231),
        ];
        for (n_i, n_t, angle) in expected {
            assert!((critical_deg(n_i, n_t).unwrap() - angle).abs() < 5e-5);
        }
        assert_eq!(critical_deg(1.38, 1.41), None);
    }
}
