//! The trend of a Gaussian process: all monomials up to the second degree.

/// Monomials of `d` variables up to the second degree.
pub(super) fn terms(d: usize) -> usize {
    (d + 1) * (d + 2) / 2
}

/// The monomials at a place: 1, x_i, x_i x_j with j >= i.
pub(super) fn monomials(place: &[f64]) -> Vec<f64> {
    let mut all = Vec::with_capacity(terms(place.len()));
    all.push(1.0);
    all.extend_from_slice(place);
    for (i, x) in place.iter().enumerate() {
        all.extend(place.iter().skip(i).map(|y| x * y));
    }
    all
}

/// Sum of the monomials at a place, each times its factor.
pub(super) fn sum(place: &[f64], factors: &[f64]) -> f64 {
    let mut factors = factors.iter();
    let mut with = |value: f64| factors.next().map_or(0.0, |factor| factor * value);
    let linear: f64 = with(1.0) + place.iter().map(|x| with(*x)).sum::<f64>();
    let squares = place.iter().enumerate().map(|(i, x)| x * place.iter().skip(i).map(|y| with(*y)).sum::<f64>());
    linear + squares.sum::<f64>()
}

/// Slopes of the monomials at a place: of each, one along every variable.
pub(super) fn slopes(place: &[f64]) -> Vec<Vec<f64>> {
    let d = place.len();
    let along = |i: usize| (0..d).map(move |k| if k == i { 1.0 } else { 0.0 });
    let mut all = Vec::with_capacity(terms(d));
    all.push(vec![0.0; d]);
    all.extend((0..d).map(|i| along(i).collect()));
    for i in 0..d {
        all.extend((i..d).map(|j| along(i).zip(along(j)).map(|(a, b)| a * place[j] + b * place[i]).collect()));
    }
    all
}
