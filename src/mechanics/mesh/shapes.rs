//! Bodies with a closed-form answer: patches, a quarter of a shell, Cook's membrane.
//!
//! A layer under a punch (Hayes), a half space under a sphere (Hertz) and an inclusion in an infinite body (Eshelby)
//! are a [`super::PhantomMesh`] with the contact's edge as footprint.

use super::builder::{Builder, between_planes, cells};
use super::error::positive;
use super::{Boundary, Mesh, MeshError};

/// The unit square or cube in `divisions` elements along each axis, interior nodes moved at random.
///
/// Corners move by up to `distortion` of an element's length along each axis; 0.3 cannot fold. The nodes between them
/// follow, so that edges stay straight, and then move by up to `bend` of that length. The same `seed` gives the same
/// mesh.
///
/// # Errors
/// No divisions, too many, or a mesh that the moves fold.
pub fn patch(dim: usize, divisions: usize, distortion: f64, bend: f64, seed: u64) -> Result<Mesh, MeshError> {
    let dim = dim.clamp(2, 3);
    let n = positive("the divisions of a patch", divisions as f64)?;
    let counts = [divisions, divisions, if dim == 3 { divisions } else { 1 }];
    let mut builder = Builder::new(dim);
    builder.expect_elements(counts.iter().fold(1, |all: usize, &count| all.saturating_mul(count)))?;
    let moved = |index: [usize; 3], share: f64, axis: usize| {
        let inside = (0..dim).all(|i| index[i] > 0 && index[i] < 2 * divisions);
        if inside { share / n * random(seed, [index[0], index[1], index[2], axis]) } else { 0.0 }
    };
    let corner = |index: [usize; 3], axis: usize| index[axis] as f64 / (2.0 * n) + moved(index, distortion, axis);
    let node = |index: [usize; 3]| {
        let between = (0..3).any(|i| index[i] % 2 == 1);
        std::array::from_fn(|axis| {
            if axis >= dim {
                return 0.0;
            }
            // The mean over the ends along each axis on which the node is a middle; where it is not, both ends are it.
            let end =
                |i: usize, k: usize| if k >> i & 1 == 0 { index[i] - index[i] % 2 } else { index[i] + index[i] % 2 };
            let mean = (0..8).map(|k| corner([end(0, k), end(1, k), end(2, k)], axis)).sum::<f64>() / 8.0;
            mean + if between { moved(index, bend, axis) } else { 0.0 }
        })
    };
    for cell in cells(counts) {
        builder.add(0, |local| node([0, 1, 2].map(|i| 2 * cell[i] + local[i])));
    }
    builder.finish(between_planes(dim, 1.0, 0.0, [false; 2]))
}

/// A number in (-1, 1) that depends on the seed and the index alone (the finaliser of SplitMix64).
fn random(seed: u64, index: [usize; 4]) -> f64 {
    let mut state = seed;
    for part in index {
        state = state.wrapping_add(part as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
        state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^= state >> 31;
    }
    (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// A quarter of an annulus, or of a spherical shell in axisymmetry: x >= 0, z >= 0, inner face `Touched`, outer face
/// `Side`, the plane z = 0 `Base` (to be held along z alone), x = 0 `SymmetryX`.
///
/// # Errors
/// Radii not positive or not ascending, no divisions, too many.
pub fn shell(inner_mm: f64, outer_mm: f64, radial: usize, angular: usize) -> Result<Mesh, MeshError> {
    positive("the inner radius of a shell", inner_mm)?;
    positive("the thickness of a shell", outer_mm - inner_mm)?;
    let mut builder = Builder::new(2);
    grid(&mut builder, [radial, angular], |s, t| {
        // Radii in equal ratios: the stress falls off with a power of r.
        let radius = if s == 1.0 { outer_mm } else { inner_mm * (outer_mm / inner_mm).powf(s) };
        let angle = t * std::f64::consts::FRAC_PI_2;
        let (sin, cos) = if t == 1.0 { (1.0, 0.0) } else { angle.sin_cos() };
        [radius * sin, radius * cos, 0.0]
    })?;
    let middle = 0.5 * (inner_mm + outer_mm);
    builder.finish(|face| {
        if face.iter().all(|node| node[0] == 0.0) {
            Boundary::SymmetryX
        } else if face.iter().all(|node| node[1] == 0.0) {
            Boundary::Base
        } else if face.iter().all(|node| node[0].hypot(node[1]) < middle) {
            Boundary::Touched
        } else {
            Boundary::Side
        }
    })
}

/// Cook's membrane: the trapezoid (0, 0), (48, 44), (48, 60), (0, 44) mm; the clamped left edge is `Base`, the loaded
/// right one `Touched`.
///
/// # Errors
/// No divisions, or too many.
pub fn cook(divisions: usize) -> Result<Mesh, MeshError> {
    let mut builder = Builder::new(2);
    grid(&mut builder, [divisions; 2], |s, t| [48.0 * s, 44.0 * s * (1.0 - t) + (44.0 + 16.0 * s) * t, 0.0])?;
    builder.finish(|face| {
        let at = |x: f64| face.iter().all(|node| node[0] == x);
        if at(0.0) {
            Boundary::Base
        } else if at(48.0) {
            Boundary::Touched
        } else {
            Boundary::Side
        }
    })
}

/// Adds the image of the unit square.
fn grid(builder: &mut Builder, counts: [usize; 2], map: impl Fn(f64, f64) -> [f64; 3]) -> Result<(), MeshError> {
    for count in counts {
        positive("the divisions of a shape", count as f64)?;
    }
    builder.expect_elements(counts[0].saturating_mul(counts[1]))?;
    for cell in cells([counts[0], counts[1], 1]) {
        let along = |axis: usize, local: usize| (2 * cell[axis] + local) as f64 / (2 * counts[axis]) as f64;
        builder.add(0, |local| map(along(0, local[0]), along(1, local[1])));
    }
    Ok(())
}
