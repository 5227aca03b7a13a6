//! The three settings: what they share is everything but the strain operator and the weight of integration.

use super::element::{MAX_NODES, QuadraturePoint};

/// Setting of a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kinematics {
    /// Two dimensions (x, z), no strain along the third; per mm of depth.
    PlaneStrain,
    /// Two dimensions (r, z) around the axis r = 0; per full turn.
    Axisymmetric,
    /// Three dimensions.
    ThreeDimensional,
}

/// A material point: gradients of the shape functions in the reference configuration, and the weight of its volume.
#[derive(Debug, Clone)]
pub struct MaterialPoint {
    /// Gradient of each shape function, per mm.
    pub gradient: [[f64; 3]; MAX_NODES],
    /// Hoop strain per radial displacement of each node, N_a / R, per mm; 0 without a hoop.
    pub hoop: [f64; MAX_NODES],
    /// Reference position, mm.
    pub position: [f64; 3],
    /// Reference volume that the point stands for, mm^3 (mm^2 in plane strain).
    pub volume: f64,
}

impl Kinematics {
    /// Dimensions of its meshes.
    #[inline]
    pub fn dim(self) -> usize {
        match self {
            Self::PlaneStrain | Self::Axisymmetric => 2,
            Self::ThreeDimensional => 3,
        }
    }

    /// Weight of integration at a distance `r` from the axis: the length of the circle in axisymmetry.
    #[inline]
    pub fn weight(self, r: f64) -> f64 {
        match self {
            Self::Axisymmetric => std::f64::consts::TAU * r,
            Self::PlaneStrain | Self::ThreeDimensional => 1.0,
        }
    }

    /// The material point of a quadrature point in an element with these nodes; `None` where the element is inside out.
    #[inline]
    pub fn point(self, nodes: &[[f64; 3]], at: &QuadraturePoint) -> Option<MaterialPoint> {
        let dim = self.dim();
        let mut position = [0.0; 3];
        let mut jacobian = [[0.0; 3], [0.0; 3], [0.0, 0.0, 1.0]];
        if dim == 3 {
            jacobian[2][2] = 0.0;
        }
        for (a, node) in nodes.iter().enumerate() {
            for i in 0..dim {
                position[i] += at.shape.value[a] * node[i];
                for j in 0..dim {
                    jacobian[i][j] += node[i] * at.shape.gradient[a][j];
                }
            }
        }
        let (inverse, determinant) = invert(&jacobian)?;
        if determinant <= 0.0 {
            return None;
        }
        let mut point = MaterialPoint {
            gradient: [[0.0; 3]; MAX_NODES],
            hoop: [0.0; MAX_NODES],
            position,
            volume: at.weight * determinant * self.weight(position[0]),
        };
        for a in 0..nodes.len() {
            let local = &at.shape.gradient[a];
            for i in 0..dim {
                point.gradient[a][i] = (0..dim).map(|j| local[j] * inverse[j][i]).sum();
            }
            if self == Self::Axisymmetric {
                point.hoop[a] = at.shape.value[a] / position[0];
            }
        }
        Some(point)
    }
}

impl MaterialPoint {
    /// Gradient of the displacement with these nodal values (3 entries a node).
    #[inline]
    pub fn displacement_gradient(&self, dim: usize, displacement: &[[f64; 3]]) -> [[f64; 3]; 3] {
        let mut h = [[0.0; 3]; 3];
        for (a, u) in displacement.iter().enumerate() {
            for i in 0..dim {
                for j in 0..dim {
                    h[i][j] += u[i] * self.gradient[a][j];
                }
            }
            if dim == 2 {
                h[2][2] += self.hoop[a] * u[0];
            }
        }
        h
    }
}

/// Inverse and determinant of a 3 x 3 matrix; `None` where it is singular or not finite.
#[inline]
pub fn invert(m: &[[f64; 3]; 3]) -> Option<([[f64; 3]; 3], f64)> {
    let cofactor = cofactor(m);
    let determinant = (0..3).map(|j| m[0][j] * cofactor[0][j]).sum::<f64>();
    let inverse = [0, 1, 2].map(|i| [0, 1, 2].map(|j| cofactor[j][i] / determinant));
    (determinant != 0.0 && determinant.is_finite()).then_some((inverse, determinant))
}

/// Cofactor matrix: the derivative of the determinant.
#[inline]
pub fn cofactor(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let minor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| minor(i, j)))
}
