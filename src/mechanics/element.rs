//! The element: biquadratic or triquadratic displacement, discontinuous linear pressure (Q2/P-1).
//!
//! Displacement and geometry share the 3^dim Lagrange functions on the lattice {-1, 0, 1}. The pressure is linear in
//! the reference coordinates of space, not of the element, which keeps its order on distorted elements (Boffi and
//! Gastaldi 2002, Numer. Math. 92, 23). The pair is stable at the incompressible limit (Girault and Raviart 1986). So
//! is that with constant pressures, but of lower order.

use std::sync::LazyLock;

/// Nodes of the largest element.
pub const MAX_NODES: usize = 27;
/// Pressure functions of the largest element.
pub const MAX_PRESSURES: usize = 4;

/// Order of an element's pressure, and with it of the element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PressureOrder {
    /// Constant (Q2/P0): displacements of second order, stresses of first.
    Constant,
    /// Linear (Q2/P-1): displacements of third order, stresses of second.
    #[default]
    Linear,
}

impl PressureOrder {
    /// Number of pressure functions of an element.
    pub fn functions(self, dim: usize) -> usize {
        match self {
            Self::Constant => 1,
            Self::Linear => dim + 1,
        }
    }
}

/// A function of one coordinate and its derivative, for the three Lagrange functions on {-1, 0, 1}.
pub fn lagrange(xi: f64) -> [[f64; 2]; 3] {
    [[0.5 * xi * (xi - 1.0), xi - 0.5], [1.0 - xi * xi, -2.0 * xi], [0.5 * xi * (xi + 1.0), xi + 0.5]]
}

/// Gauss-Legendre points and weights on [-1, 1]: three points, exact to degree 5.
pub const GAUSS_3: [[f64; 2]; 3] =
    [[-0.774_596_669_241_483_4, 5.0 / 9.0], [0.0, 8.0 / 9.0], [0.774_596_669_241_483_4, 5.0 / 9.0]];

/// Values and local gradients of the shape functions at a local point.
#[derive(Debug, Clone)]
pub struct ShapeFunctions {
    /// Values.
    pub value: [f64; MAX_NODES],
    /// Gradients with respect to the local coordinates.
    pub gradient: [[f64; 3]; MAX_NODES],
}

impl ShapeFunctions {
    /// The 3^dim functions at a local point.
    pub fn at(dim: usize, xi: [f64; 3]) -> Self {
        let lines = [lagrange(xi[0]), lagrange(xi[1]), lagrange(xi[2])];
        let mut shape = Self { value: [0.0; MAX_NODES], gradient: [[0.0; 3]; MAX_NODES] };
        for a in 0..3usize.pow(dim as u32) {
            let part = |axis: usize, derivative: usize| {
                if axis < dim { lines[axis][a / 3usize.pow(axis as u32) % 3][derivative] } else { 1.0 }
            };
            shape.value[a] = part(0, 0) * part(1, 0) * part(2, 0);
            shape.gradient[a] = [0, 1, 2].map(|axis| match axis {
                _ if axis >= dim => 0.0,
                0 => part(0, 1) * part(1, 0) * part(2, 0),
                1 => part(0, 0) * part(1, 1) * part(2, 0),
                _ => part(0, 0) * part(1, 0) * part(2, 1),
            });
        }
        shape
    }
}

/// A quadrature point of the reference element.
#[derive(Debug, Clone)]
pub struct QuadraturePoint {
    /// ShapeFunctions functions there.
    pub shape: ShapeFunctions,
    /// Weight.
    pub weight: f64,
}

/// The 3^dim Gauss points of an element.
pub fn quadrature(dim: usize) -> &'static [QuadraturePoint] {
    static POINTS: LazyLock<[Vec<QuadraturePoint>; 3]> = LazyLock::new(|| [1, 2, 3].map(gauss_points));
    &POINTS[dim - 1]
}

fn gauss_points(dim: usize) -> Vec<QuadraturePoint> {
    (0..3usize.pow(dim as u32))
        .map(|q| {
            let mut xi = [0.0; 3];
            let mut weight = 1.0;
            for (axis, coordinate) in xi.iter_mut().enumerate().take(dim) {
                let [at, w] = GAUSS_3[q / 3usize.pow(axis as u32) % 3];
                *coordinate = at;
                weight *= w;
            }
            QuadraturePoint { shape: ShapeFunctions::at(dim, xi), weight }
        })
        .collect()
}
