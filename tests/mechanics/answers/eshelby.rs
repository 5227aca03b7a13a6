//! A sphere of contrast k in a far uniaxial strain, incompressible: the strain inside is uniform and
//! 1/(1 + 0.4 (k - 1)) of the far one (Eshelby, Proc. R. Soc. A 241, 1957).

use super::{Answer, Solved, held_around};
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::problem::Problem;
use tirtouch::mechanics::read_out::samples;
use tirtouch::stability::inclusions::{FAR, far_mesh};

/// Solves with a far strain of 1 along the axis.
pub fn solve(rung: usize, contrast: f64) -> Solved {
    let mesh = far_mesh(rung).unwrap();
    let supports = held_around(&mesh, far);
    // The axis belongs to the boundary, but along it the body is free.
    let free = |x: [f64; 3]| x[0] == 0.0 && x[1] > 0.0 && x[1] < 2.0 * FAR;
    let supports = supports.into_iter().filter(|s| s.axis == 0 || !free(mesh.nodes[s.node as usize])).collect();
    let materials = vec![Material::linear(1.0, 0.5).unwrap(), Material::linear(contrast, 0.5).unwrap()];
    let kinematics = Kinematics::Axisymmetric;
    let problem = Problem { supports, ..Problem::free(kinematics, mesh, materials) };
    Solved::new(problem, &[1.0]).unwrap()
}

/// The far displacement.
pub fn far(x: [f64; 3]) -> [f64; 3] {
    [-0.5 * x[0], x[1] - FAR, 0.0]
}

/// Mean axial strain in the sphere, and its rms spread as a share of the mean.
pub fn strain_inside(solved: &Solved) -> [f64; 2] {
    let mut sums = [0.0; 3];
    for e in (0..solved.problem.mesh.element_count()).filter(|&e| solved.problem.mesh.region[e] == 1) {
        for sample in samples(&solved.problem, &solved.state, e).unwrap() {
            let strain = sample.deformation[1][1] - 1.0;
            sums[0] += sample.volume;
            sums[1] += sample.volume * strain;
            sums[2] += sample.volume * strain * strain;
        }
    }
    let mean = sums[1] / sums[0];
    [mean, (sums[2] / sums[0] - mean * mean).max(0.0).sqrt() / mean.abs()]
}

pub fn strain(rung: usize, contrast: f64) -> Answer {
    let solved = solve(rung, contrast);
    let [mean, spread] = strain_inside(&solved);
    let exact = 1.0 / (1.0 + 0.4 * (contrast - 1.0));
    solved.answer(vec![("inside / far", mean, exact), ("spread, rms", spread, 0.0)])
}
