//! Whether readings of the same subjects agree: by an analysis of variance of a table of subjects (rows) and readers or
//! repeats (columns).

use super::distributions::{chi_square_quantile, f_quantile, normal_quantile};
use super::{StatisticsError, check_count, check_finite};
use crate::estimate::Value;

/// Mean squares of a table of `n` rows and `k` columns.
struct MeanSquares {
    n: f64,
    k: f64,
    rows: f64,
    columns: f64,
    error: f64,
    /// Of columns and error together: of the readings of a row about their mean.
    within: f64,
}

impl MeanSquares {
    fn of(table: &[Vec<f64>]) -> Result<Self, StatisticsError> {
        let first = table.first().map_or(&[][..], Vec::as_slice);
        check_count("rows", table.len(), 2)?;
        check_count("columns", first.len(), 2)?;
        let ragged = table.iter().position(|row| row.len() != first.len());
        let why = |row| format!("row {row} (from 0) is not as long as the first: give all subjects the same readings");
        ragged.map_or(Ok(()), |row| Err(StatisticsError::Impossible(why(row))))?;
        check_finite(table.iter().flatten().copied())?;
        // About one of the readings: what is the same in all is then exactly 0.
        let origin = first.first().copied().unwrap_or(0.0);
        let (n, k) = (table.len() as f64, first.len() as f64);
        let row_means: Vec<f64> = table.iter().map(|row| row.iter().map(|x| x - origin).sum::<f64>() / k).collect();
        let column = |j: usize| table.iter().filter_map(|row| row.get(j)).map(|x| x - origin).sum::<f64>() / n;
        let column_means: Vec<f64> = (0..first.len()).map(column).collect();
        let mean = row_means.iter().sum::<f64>() / n;
        let about_mean = |means: &[f64]| means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
        let rest = |row: &[f64], m: f64| -> f64 {
            row.iter().zip(&column_means).map(|(x, column)| (x - origin - m - column + mean).powi(2)).sum()
        };
        let error: f64 = table.iter().zip(&row_means).map(|(row, m)| rest(row, *m)).sum();
        let (rows, columns) = (k * about_mean(&row_means), n * about_mean(&column_means));
        let within = (columns + error) / (n * (k - 1.0));
        let error = error / ((n - 1.0) * (k - 1.0));
        check_finite([rows, columns, error]).map_err(|_| StatisticsError::Overflow)?;
        Ok(Self { n, k, rows: rows / (n - 1.0), columns: columns / (k - 1.0), error, within })
    }
}

/// The intraclass correlation ICC(A,1) of a table with a row a subject and a column a reader, with its 95 % interval.
///
/// The share of the variance of single readings that is of the subjects: two-way model, absolute agreement (McGraw &
/// Wong 1996, tables 4 and 7; ICC(2,1) of Shrout & Fleiss 1979). It falls where readers differ by a constant. Where all
/// readers agree exactly it is 1, from 1 to 1. Undefined where subjects do not differ.
///
/// # Errors
/// Fewer than two rows or columns; rows of different lengths; a number that is not finite or too large.
pub fn intraclass_correlation(table: &[Vec<f64>]) -> Result<Value, StatisticsError> {
    let MeanSquares { n, k, rows, columns, error, .. } = MeanSquares::of(table)?;
    let total = rows + (k - 1.0) * error + k / n * (columns - error);
    if total <= 0.0 {
        return Ok(Value::undefined("the subjects do not differ: there is no variance to agree on"));
    }
    let icc = (rows - error) / total;
    if columns == 0.0 && error == 0.0 {
        return Ok(Value::known(icc, 1.0, 1.0));
    }
    // Satterthwaite's degrees of freedom, with a and b of the paper times n (1 - ICC).
    let (a, b) = (k * icc * columns, (n * (1.0 - icc) + k * icc * (n - 1.0)) * error);
    let freedom = (a + b).powi(2) / (a * a / (k - 1.0) + b * b / ((n - 1.0) * (k - 1.0)));
    if freedom == 0.0 {
        return Ok(Value::undefined("the subjects differ so little that the degrees of freedom vanish"));
    }
    let [above, below] = [f_quantile(n - 1.0, freedom, 0.975), f_quantile(freedom, n - 1.0, 0.975)];
    let readers = k * columns + (k * n - k - n) * error;
    let low = n * (rows - above * error) / (above * readers + n * rows);
    let high = n * (below * rows - error) / (readers + n * below * rows);
    Ok(Value::known(icc, low, high))
}

/// How well readings of the same subject repeat, in their unit.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Repeatability {
    /// Standard error of measurement: the standard deviation of the readings of one subject.
    pub standard_error: Value,
    /// Smallest detectable change: two readings of an unchanged subject differ by less 19 times in 20.
    pub smallest_change: Value,
}

impl Repeatability {
    /// Of a table with a row a subject and a column a repeat.
    ///
    /// The standard error is the root of the mean square within subjects (Bland & Altman 1996, BMJ 313:744): what
    /// differs from repeat to repeat in all subjects is a part of it. Its 95 % interval is that of chi-square, for
    /// normal errors of one size. The smallest change is 1.96 sqrt(2) standard errors (de Vet et al. 2006).
    ///
    /// # Errors
    /// Fewer than two rows or columns; rows of different lengths; a number that is not finite or too large.
    pub fn of(table: &[Vec<f64>]) -> Result<Self, StatisticsError> {
        let MeanSquares { n, k, within, .. } = MeanSquares::of(table)?;
        let freedom = n * (k - 1.0);
        let end = |share| (within * freedom / chi_square_quantile(freedom, share)).sqrt();
        let standard_error = Value::known(within.sqrt(), end(0.975), end(0.025));
        let smallest_change = standard_error.scaled(normal_quantile(0.975) * std::f64::consts::SQRT_2);
        Ok(Self { standard_error, smallest_change })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::numbers;

    /// Table 2 of Shrout & Fleiss (1979).
    const JUDGES: [[f64; 4]; 6] = [
        [9.0, 2.0, 5.0, 8.0],
        [6.0, 1.0, 3.0, 2.0],
        [8.0, 4.0, 6.0, 8.0],
        [7.0, 1.0, 2.0, 6.0],
        [10.0, 5.0, 6.0, 9.0],
        [6.0, 2.0, 4.0, 7.0],
    ];

    fn table(of: impl Fn(usize, f64) -> f64) -> Vec<Vec<f64>> {
        JUDGES.iter().map(|row| row.iter().enumerate().map(|(j, &x)| of(j, x)).collect()).collect()
    }

    fn close(found: &Value, pinned: [f64; 3]) {
        let found = numbers(found);
        assert!(found.iter().zip(pinned).all(|(found, pinned)| (found - pinned).abs() < 1e-10), "{found:?} {pinned:?}");
    }

    /// pingouin 0.7.0: `intraclass_corr(data, 'row', 'judge', 'x')`, unrounded, its ICC(A,1); the paper says 0.29.
    #[test]
    fn icc_is_that_of_pingouin() {
        let icc = intraclass_correlation(&table(|_, x| x)).unwrap();
        close(&icc, [0.289_763_779_528, 0.018_786_513_375, 0.761_084_369_649]);
        // The first judge marks 8 lower and so agrees less.
        let moved = table(|judge, x| if judge == 0 { x - 8.0 } else { x });
        close(&intraclass_correlation(&moved).unwrap(), [0.210_285_714_286, 0.008_068_675_512, 0.678_495_245_148]);
    }

    /// statsmodels 0.15.0: root of `ols('x ~ C(row)', data).fit().mse_resid`; SciPy 1.17.1: `stats.chi2.ppf`.
    #[test]
    fn repeatability_is_that_of_statsmodels() {
        let found = Repeatability::of(&table(|_, x| x)).unwrap();
        close(&found.standard_error, [2.502_776_236_280, 1.891_129_342_040, 3.701_166_906_551]);
        close(&found.smallest_change, [6.937_214_314_704, 5.241_846_774_945, 10.258_922_740_690]);
        let half = Repeatability::of(&table(|_, x| 0.5 * x)).unwrap();
        assert_eq!(half.standard_error, found.standard_error.scaled(0.5));
    }

    #[test]
    fn a_reader_that_is_off_agrees_less_and_shuffled_subjects_do_not_agree() {
        let icc = |table: &[Vec<f64>]| intraclass_correlation(table).unwrap().best().copied().unwrap();
        let alike = |offset: f64| table(|judge, x| x + if judge > 0 { offset } else { 0.0 });
        assert!(icc(&alike(9.0)) < icc(&alike(0.0)));
        let same = |shift: usize| -> Vec<Vec<f64>> {
            (0..6).map(|row| vec![JUDGES[row][0], JUDGES[(row + shift) % 6][0]]).collect()
        };
        assert!((icc(&same(0)) - 1.0).abs() < 1e-14 && icc(&same(1)) < 0.1);
    }

    #[test]
    fn tables_that_tell_nothing_are_undefined_or_refused() {
        assert_eq!(intraclass_correlation(&vec![vec![0.1; 3]; 5]).unwrap().best(), None);
        assert_eq!(intraclass_correlation(&[vec![1.0, 2.0], vec![2.0, 1.0]]).unwrap().best(), None);
        assert_eq!(numbers(&Repeatability::of(&vec![vec![0.1; 3]; 5]).unwrap().standard_error), [0.0; 3]);
        let ragged = intraclass_correlation(&[vec![1.0, 2.0], vec![1.0]]).unwrap_err();
        assert!(ragged.to_string().starts_with("row 1 (from 0)"));
        assert_eq!(Repeatability::of(&[vec![1e200, 1.0], vec![2.0, 0.0]]), Err(StatisticsError::Overflow));
        assert!(Repeatability::of(&[vec![1.0], vec![2.0]]).is_err() && Repeatability::of(&[]).is_err());
    }
}
