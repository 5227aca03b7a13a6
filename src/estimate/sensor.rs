//! How a sensor is calibrated on the bench, as the TSIS paper does it: millimetres per pixel from a reference target,
//! and the force from the integrated pixel value M of presses at known forces.

use crate::camera::projection::View;
use serde::Serialize;

/// Dots of the target across the shorter side of what the camera sees.
const DOTS: f64 = 12.0;
/// Rows of a table of forces.
const ROWS: usize = 33;

/// Millimetres per pixel, fitted to a target of dots on the touched face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Scale {
    /// Millimetres on the touched face per pixel, over all dots.
    pub mm_per_pixel: f64,
    /// Pitch of the dots, mm.
    pub pitch_mm: f64,
    /// Dots that the camera sees.
    pub dots: usize,
    /// How far one factor leaves dots from where they are, rms, mm: refraction makes the scale change across the image.
    pub rms_mm: f64,
    /// The farthest, mm.
    pub worst_mm: f64,
}

/// The scale of a camera of so many pixels, from a square grid of dots as the layers refract it.
pub fn scale(view: &View, [width, height]: [u32; 2]) -> Option<Scale> {
    let (width, height) = (f64::from(width), f64::from(height));
    let pitch_mm = view.mm_per_pixel() * width.min(height) / DOTS;
    let middle = [0.5 * width, 0.5 * height];
    let most = (width.max(height) / width.min(height) * DOTS).ceil() as i32;
    let seen = |i: i32, j: i32| {
        let at = [f64::from(i) * pitch_mm, f64::from(j) * pitch_mm];
        let [column, row] = view.pixel_from_touched(at);
        let inside = (0.0..=width).contains(&column) && (0.0..=height).contains(&row);
        inside.then(|| [at[0], at[1], column - middle[0], middle[1] - row])
    };
    let dots: Vec<[f64; 4]> = (-most..=most).flat_map(|i| (-most..=most).filter_map(move |j| seen(i, j))).collect();
    let sum = |of: &dyn Fn(&[f64; 4]) -> f64| dots.iter().map(of).sum::<f64>();
    let mm_per_pixel = sum(&|[x, y, u, v]| x * u + y * v) / sum(&|[_, _, u, v]| u * u + v * v);
    let off = |[x, y, u, v]: &[f64; 4]| (x - mm_per_pixel * u).hypot(y - mm_per_pixel * v);
    let rms_mm = (sum(&|dot| off(dot).powi(2)) / dots.len() as f64).sqrt();
    let worst_mm = dots.iter().map(off).fold(0.0, f64::max);
    let found = Scale { mm_per_pixel, pitch_mm, dots: dots.len(), rms_mm, worst_mm };
    (dots.len() > 4 && mm_per_pixel.is_finite()).then_some(found)
}

/// How a force may follow M.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// F = a M.
    Proportional,
    /// F = a + b M.
    Line,
    /// F = a M^b.
    Power,
    /// F = a + b M + c M².
    Parabola,
}

const FORMS: [Form; 4] = [Form::Proportional, Form::Line, Form::Power, Form::Parabola];

/// Force against the sum of grey values, of the form that foretells presses that it was not fitted to best.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForceLaw {
    /// The form.
    pub form: Form,
    /// Its coefficients, in their order; N and grey levels.
    pub coefficients: Vec<f64>,
    /// How far it is from the presses that it was fitted to, rms, N.
    pub rms_n: f64,
    /// How far presses are that were left out of the fit one by one, rms, N.
    pub left_out_rms_n: f64,
    /// The same as a table of (M, F), from the first press to the last.
    #[serde(skip)]
    pub rows: Vec<[f64; 2]>,
}

impl Form {
    fn powers(self) -> usize {
        match self {
            Self::Proportional => 1,
            Self::Line | Self::Power => 2,
            Self::Parabola => 3,
        }
    }

    fn coefficients(self, points: &[[f64; 2]]) -> Option<Vec<f64>> {
        if points.len() < self.powers() {
            return None;
        }
        // M in units of its largest, so that powers stay of one size.
        let unit = points.iter().map(|point| point[0]).fold(0.0, f64::max);
        let terms = |m: f64| match self {
            Self::Proportional => vec![m / unit],
            Self::Line => vec![1.0, m / unit],
            Self::Power => vec![1.0, m.ln()],
            Self::Parabola => vec![1.0, m / unit, (m / unit).powi(2)],
        };
        let answer = |f: f64| if self == Self::Power { f.ln() } else { f };
        let rows: Vec<(Vec<f64>, f64)> = points.iter().map(|[m, f]| (terms(*m), answer(*f))).collect();
        let found = least_squares(&rows)?;
        Some(match (self, found.as_slice()) {
            (Self::Power, [a, b]) => vec![a.exp(), *b],
            (Self::Proportional, [a]) => vec![a / unit],
            (_, all) => all.iter().enumerate().map(|(k, c)| c / unit.powi(k as i32)).collect(),
        })
    }

    fn at(self, coefficients: &[f64], m: f64) -> f64 {
        match (self, coefficients) {
            (Self::Power, [a, b]) => a * m.powf(*b),
            (Self::Proportional, [a]) => a * m,
            (_, all) => all.iter().rev().fold(0.0, |sum, c| sum * m + c),
        }
    }
}

/// Solves for the coefficients of terms by least squares.
fn least_squares(rows: &[(Vec<f64>, f64)]) -> Option<Vec<f64>> {
    use faer::linalg::solvers::SolveLstsq as _;
    let n = rows.first()?.0.len();
    let left = faer::Mat::from_fn(rows.len(), n, |i, j| rows[i].0[j]);
    let right = faer::Mat::from_fn(rows.len(), 1, |i, _| rows[i].1);
    let found = left.qr().solve_lstsq(&right);
    let found: Vec<f64> = (0..n).map(|k| found[(k, 0)]).collect();
    found.iter().all(|c| c.is_finite()).then_some(found)
}

impl ForceLaw {
    /// The law of presses (M, F in N), by ascending force.
    ///
    /// # Errors
    /// Says why there is none: too few presses, M that does not rise with the force, or forms that all fall somewhere.
    pub fn fit(points: &[[f64; 2]]) -> Result<Self, String> {
        if points.len() < 5 {
            return Err(format!("{} presses are too few, 5 at least are needed", points.len()));
        }
        if points.iter().flatten().any(|v| !(*v > 0.0 && v.is_finite())) {
            return Err("a press has no light or no force".to_owned());
        }
        if let Some(pair) = points.windows(2).find(|pair| pair[0][0] >= pair[1][0] || pair[0][1] >= pair[1][1]) {
            return Err(format!(
                "the sum of grey values does not rise with the force: {:.6e} at {:.4} N, {:.6e} at {:.4} N",
                pair[0][0], pair[0][1], pair[1][0], pair[1][1]
            ));
        }
        let laws = FORMS.into_iter().filter_map(|form| Self::of(form, points));
        laws.min_by(|a, b| a.left_out_rms_n.total_cmp(&b.left_out_rms_n))
            .ok_or_else(|| "no form rises from the first press to the last".to_owned())
    }

    fn of(form: Form, points: &[[f64; 2]]) -> Option<Self> {
        let coefficients = form.coefficients(points)?;
        let rms = |squares: &mut dyn Iterator<Item = f64>| (squares.sum::<f64>() / points.len() as f64).sqrt();
        let rms_n = rms(&mut points.iter().map(|[m, f]| (form.at(&coefficients, *m) - f).powi(2)));
        let mut left_out = Vec::with_capacity(points.len());
        for (k, [m, f]) in points.iter().enumerate() {
            let others: Vec<[f64; 2]> = [&points[..k], &points[k + 1..]].concat();
            left_out.push((form.at(&form.coefficients(&others)?, *m) - f).powi(2));
        }
        let (first, last) = (points.first()?[0], points.last()?[0]);
        let place = |k: usize| first + (last - first) * k as f64 / (ROWS - 1) as f64;
        let rows: Vec<[f64; 2]> = (0..ROWS).map(|k| [place(k), form.at(&coefficients, place(k))]).collect();
        let rises = rows.windows(2).all(|pair| pair[1][1] > pair[0][1]) && rows.first()?[1] >= 0.0;
        let left_out_rms_n = rms(&mut left_out.into_iter());
        rises.then_some(Self { form, coefficients, rms_n, left_out_rms_n, rows })
    }

    /// The force of a sum of grey values, N.
    pub fn at(&self, sum_grey: f64) -> f64 {
        self.form.at(&self.coefficients, sum_grey)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::pipeline::view_of;
    use crate::scene::preset;

    fn points(law: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        (1..=8).map(|k| 1e5 + 4e5 * f64::from(k)).map(|m| [m, law(m)]).collect()
    }

    #[test]
    fn the_form_is_found_with_its_coefficients() {
        let is = |law: &dyn Fn(f64) -> f64, form, first: f64| {
            let found = ForceLaw::fit(&points(law)).unwrap();
            assert_eq!(found.form, form, "{found:?}");
            assert!((found.coefficients[0] / first - 1.0).abs() < 1e-6 && found.rms_n < 1e-9, "{found:?}");
            assert!((found.at(7e5) / law(7e5) - 1.0).abs() < 1e-9 && found.rows.len() == ROWS);
        };
        is(&|m| 2e-6 * m + 0.1, Form::Line, 0.1);
        is(&|m| 3e-9 * m.powf(1.4), Form::Power, 3e-9);
        is(&|m| 0.05 + 1e-7 * m + 3e-13 * m * m, Form::Parabola, 0.05);
    }

    /// A simpler form wins where presses scatter by more than it leaves; what is left out scatters more than what fits.
    #[test]
    fn scatter_is_told_and_not_fitted() {
        let mut some = points(|m| 2e-6 * m);
        some.iter_mut().enumerate().for_each(|(k, point)| point[1] *= if k % 2 == 0 { 1.01 } else { 0.99 });
        let found = ForceLaw::fit(&some).unwrap();
        assert_eq!(found.form, Form::Proportional, "{found:?}");
        // 1 % of forces of 4.2 N rms.
        assert!(found.left_out_rms_n > found.rms_n && (found.rms_n / 0.0415 - 1.0).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn presses_that_give_no_law_are_refused() {
        let error = |points: &[[f64; 2]]| ForceLaw::fit(points).unwrap_err();
        assert!(error(&points(|m| m)[..4]).contains("too few"));
        let mut falls = points(|m| m);
        falls[3][0] = falls[2][0] - 1.0;
        assert!(error(&falls).contains("does not rise"));
        falls[0][1] = 0.0;
        assert!(error(&falls).contains("no light or no force"));
    }

    /// Refraction shrinks the scale by 2.4 % to the edge: one factor lies between, and leaves that much.
    #[test]
    fn the_target_gives_a_scale_below_that_of_the_axis() {
        let scene = preset("tsis-paper").unwrap().scene;
        let view = view_of(&scene).unwrap();
        let found = scale(&view, scene.camera.pixels).unwrap();
        let share = found.mm_per_pixel / view.mm_per_pixel();
        assert!(share < 0.99 && share > 0.97, "{share}");
        assert!(found.dots > 100 && found.rms_mm > 0.01 && found.worst_mm < 0.5, "{found:?}");
    }
}
