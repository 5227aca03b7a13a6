//! Corners of hexahedra moved until no element is folded.
//!
//! Each corner of each element has a Jacobian J and one that it aims at, W. The energy of A = J inv(W) is
//! |A|^2 / (3 chi^(2/3)) + lambda (D^2 + 1) / (2 chi) with D = det A: the first measures shape, the second size. chi
//! stands in for D; it is positive whatever D is and goes over to D as elements unfold (Garanzha et al. 2021,
//! Foldover-free maps in 50 lines of code). L-BFGS finds its least.

/// Coordinates of a corner that may move.
pub(super) type Free = [bool; 3];

type Matrix = [[f64; 3]; 3];

/// Weight of size against shape.
const SIZE: f64 = 0.05;

/// Rounds of a smaller and smaller regularisation, and steps in each.
const ROUNDS: usize = 12;
const STEPS: usize = 60;

/// Steps that lower the energy by less than this share are not worth their time.
const LEAST_GAIN: f64 = 1e-5;

/// Pairs of steps and changes of gradient that L-BFGS keeps.
const MEMORY: usize = 8;

/// An element by its corners.
#[derive(Clone)]
pub(super) struct Hex {
    /// Its corners; bits of a corner's number are its places along the axes.
    pub corners: [u32; 8],
    /// Inverse of the Jacobian that each corner aims at.
    pub aims: [Matrix; 8],
}

impl Hex {
    /// An element that aims at its own shape, its edges along `axis` times `share`.
    pub fn new(corners: [u32; 8], points: &[[f64; 3]], share: f64, axis: usize) -> Self {
        let at = corners.map(|node| points[node as usize]);
        let aims = std::array::from_fn(|corner| {
            let mut columns = edges(&at, corner);
            columns[axis] = columns[axis].map(|x| share * x);
            inverse(columns)
        });
        Self { corners, aims }
    }
}

/// Edges from a corner along the axes, as columns.
fn edges(at: &[[f64; 3]; 8], corner: usize) -> Matrix {
    std::array::from_fn(|axis| {
        let (low, high) = (corner & !(1 << axis), corner | 1 << axis);
        std::array::from_fn(|i| at[high][i] - at[low][i])
    })
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Inverse of a matrix given by columns, as rows.
fn inverse([a, b, c]: Matrix) -> Matrix {
    let rows = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = dot(&a, &rows[0]);
    rows.map(|row| row.map(|x| x / determinant))
}

/// J inv(W) by columns: the k-th is the sum of J's columns times inv(W)'s entries in row j, column k.
fn deformation(columns: &Matrix, aim: &Matrix) -> Matrix {
    std::array::from_fn(|k| std::array::from_fn(|i| (0..3).map(|j| columns[j][i] * aim[j][k]).sum()))
}

fn determinant([a, b, c]: &Matrix) -> f64 {
    dot(a, &cross(*b, *c))
}

/// The energy of one corner, and its derivative by A.
fn energy(a: &Matrix, regular: f64) -> (f64, Matrix) {
    let d = determinant(a);
    let root = (regular * regular + d * d).sqrt();
    let chi = if d >= 0.0 { 0.5 * (d + root) } else { 0.5 * regular * regular / (root - d) };
    let slope = chi / root;
    let square: f64 = a.iter().flatten().map(|x| x * x).sum();
    let power = chi.powf(-2.0 / 3.0);
    let value = square * power / 3.0 + SIZE * (d * d + 1.0) / (2.0 * chi);
    let by_d = -2.0 / 9.0 * square * power / chi * slope + SIZE * (d / chi - (d * d + 1.0) * slope / (2.0 * chi * chi));
    let cofactor = [cross(a[1], a[2]), cross(a[2], a[0]), cross(a[0], a[1])];
    let by_a = std::array::from_fn(|k| std::array::from_fn(|i| 2.0 / 3.0 * power * a[k][i] + by_d * cofactor[k][i]));
    (value, by_a)
}

/// The elements with a corner that may move, and the unknowns.
struct Patch<'a> {
    hexes: Vec<&'a Hex>,
    /// Unknown of each coordinate of each corner, if it may move.
    unknown: Vec<[Option<u32>; 3]>,
    points: Vec<[f64; 3]>,
}

impl Patch<'_> {
    fn place(&mut self, x: &[f64]) {
        for (point, unknown) in self.points.iter_mut().zip(&self.unknown) {
            for i in 0..3 {
                if let Some(k) = unknown[i] {
                    point[i] = x[k as usize];
                }
            }
        }
    }

    /// Energy and gradient.
    fn evaluate(&mut self, x: &[f64], regular: f64, gradient: &mut [f64]) -> f64 {
        self.place(x);
        gradient.fill(0.0);
        let mut sum = 0.0;
        for hex in &self.hexes {
            let at = hex.corners.map(|node| self.points[node as usize]);
            for corner in 0..8 {
                let a = deformation(&edges(&at, corner), &hex.aims[corner]);
                let (value, by_a) = energy(&a, regular);
                sum += value;
                for axis in 0..3 {
                    // By the edge along the axis: the sum over k of the k-th column times inv(W)'s row of the axis.
                    for i in 0..3 {
                        let slope: f64 = (0..3).map(|k| by_a[k][i] * hex.aims[corner][axis][k]).sum();
                        for (end, sign) in [(corner | 1 << axis, slope), (corner & !(1 << axis), -slope)] {
                            if let Some(k) = self.unknown[hex.corners[end] as usize][i] {
                                gradient[k as usize] += sign;
                            }
                        }
                    }
                }
            }
        }
        sum
    }

    /// Smallest determinant of a corner's A.
    fn least(&mut self, x: &[f64]) -> f64 {
        self.place(x);
        let mut least = f64::INFINITY;
        for hex in &self.hexes {
            let at = hex.corners.map(|node| self.points[node as usize]);
            for corner in 0..8 {
                least = least.min(determinant(&deformation(&edges(&at, corner), &hex.aims[corner])));
            }
        }
        least
    }
}

/// Moves the free coordinates of `points`.
pub(super) fn untangle(points: &mut [[f64; 3]], hexes: &[Hex], free: &[Free]) {
    let mut count = 0;
    let mut unknown = vec![[None; 3]; points.len()];
    let mut x = Vec::new();
    for (node, free) in free.iter().enumerate() {
        for i in (0..3).filter(|&i| free[i]) {
            unknown[node][i] = Some(count);
            x.push(points[node][i]);
            count += 1;
        }
    }
    let moves = |hex: &&Hex| hex.corners.iter().any(|&node| unknown[node as usize].iter().any(Option::is_some));
    let mut patch =
        Patch { hexes: hexes.iter().filter(moves).collect(), unknown: unknown.clone(), points: points.to_vec() };
    for _ in 0..ROUNDS {
        let least = patch.least(&x);
        let regular = if least > 0.0 { 1e-9 } else { (1e-12 + 0.04 * least * least).sqrt().max(1e-3) };
        descend(&mut patch, &mut x, regular);
        if least > 0.0 {
            break;
        }
    }
    patch.place(&x);
    points.copy_from_slice(&patch.points);
}

/// Steps of L-BFGS (Nocedal and Wright, algorithm 7.4) that each lower the energy.
fn descend(patch: &mut Patch, x: &mut Vec<f64>, regular: f64) {
    let mut gradient = vec![0.0; x.len()];
    let mut value = patch.evaluate(x, regular, &mut gradient);
    let mut pairs: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    for _ in 0..STEPS {
        let direction = direction(&gradient, &pairs);
        let slope = dot(&direction, &gradient);
        let mut step = 1.0;
        if pairs.is_empty() {
            let longest = direction.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
            step = 0.05 / longest.max(1e-30);
        }
        let mut next = (Vec::new(), value, vec![0.0; x.len()]);
        let mut lower = false;
        for _ in 0..30 {
            next.0 = x.iter().zip(&direction).map(|(x, d)| x + step * d).collect();
            next.1 = patch.evaluate(&next.0, regular, &mut next.2);
            lower = next.1 <= value + 1e-4 * step * slope;
            if lower {
                break;
            }
            step *= 0.5;
        }
        if !lower {
            break;
        }
        let moved: Vec<f64> = next.0.iter().zip(x.iter()).map(|(a, b)| a - b).collect();
        let turned: Vec<f64> = next.2.iter().zip(&gradient).map(|(a, b)| a - b).collect();
        let gain = value - next.1;
        (*x, value, gradient) = next;
        if dot(&moved, &turned) > 0.0 {
            pairs.push((moved, turned));
            if pairs.len() > MEMORY {
                pairs.remove(0);
            }
        }
        if gain < LEAST_GAIN * value {
            break;
        }
    }
}

/// The direction of L-BFGS.
fn direction(gradient: &[f64], pairs: &[(Vec<f64>, Vec<f64>)]) -> Vec<f64> {
    let mut q: Vec<f64> = gradient.iter().map(|g| -g).collect();
    let mut alphas = Vec::new();
    for (moved, turned) in pairs.iter().rev() {
        let alpha = dot(moved, &q) / dot(moved, turned);
        q.iter_mut().zip(turned).for_each(|(q, y)| *q -= alpha * y);
        alphas.push(alpha);
    }
    if let Some((moved, turned)) = pairs.last() {
        let scale = dot(moved, turned) / dot(turned, turned);
        q.iter_mut().for_each(|q| *q *= scale);
    }
    for ((moved, turned), alpha) in pairs.iter().zip(alphas.iter().rev()) {
        let beta = dot(turned, &q) / dot(moved, turned);
        q.iter_mut().zip(moved).for_each(|(q, s)| *q += (alpha - beta) * s);
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKEWED: Matrix = [[1.1, 0.2, -0.1], [0.3, 0.8, 0.1], [-0.2, 0.1, 1.3]];

    fn by_differences(regular: f64, turned: f64) -> f64 {
        let a = SKEWED.map(|column| [turned * column[0], column[1], column[2]]);
        let (_, by_a) = energy(&a, regular);
        let mut worst = 0.0_f64;
        for k in 0..3 {
            for i in 0..3 {
                let at = |step: f64| {
                    let mut moved = a;
                    moved[k][i] += step;
                    energy(&moved, regular).0
                };
                worst = worst.max((by_a[k][i] - (at(1e-5) - at(-1e-5)) / 2e-5).abs());
            }
        }
        worst
    }

    #[test]
    fn the_energy_has_the_derivative_it_claims() {
        assert!(by_differences(1e-9, 1.0) < 1e-8);
        // Turned inside out, as far as the regularisation is for.
        assert!(by_differences(0.5, -1.0) < 1e-6);
    }

    /// Corners of a cube of 3 x 3 x 3 elements, the inner ones moved by `by` at random; what they go back to, off their
    /// places at most.
    fn back(by: f64, free: bool) -> f64 {
        let node = |i: usize, j: usize, k: usize| (i + 4 * j + 16 * k) as u32;
        let straight: Vec<[f64; 3]> = (0..64).map(|n| [n % 4, n / 4 % 4, n / 16].map(|i| i as f64)).collect();
        let cell = |n: usize| {
            let at = [n % 3, n / 3 % 3, n / 9];
            let corner = |c: usize| node(at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2 & 1));
            Hex::new(std::array::from_fn(corner), &straight, 1.0, 0)
        };
        let hexes: Vec<Hex> = (0..27).map(cell).collect();
        let inner: Vec<bool> = straight.iter().map(|at| at.iter().all(|&x| x > 0.0 && x < 3.0)).collect();
        let mut points = straight.clone();
        let mut state = 1_u32;
        for (point, _) in points.iter_mut().zip(&inner).filter(|(_, inner)| **inner) {
            for x in point.iter_mut() {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *x += by * (f64::from(state >> 8) / f64::from(1 << 23) - 1.0);
            }
        }
        let free: Vec<Free> = inner.into_iter().map(|inner| [inner && free; 3]).collect();
        untangle(&mut points, &hexes, &free);
        points.iter().flatten().zip(straight.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn tangled_corners_find_back_to_a_grid_of_cubes() {
        assert!(back(1.5, true) < 0.02, "{}", back(1.5, true));
        assert!(back(1.5, false) > 0.5);
    }
}
