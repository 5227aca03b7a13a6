//! The hash that the tracer's random numbers start from; `random.wgsl` has the same.

use super::constants::{PCG_FACTOR, PCG_SUMMAND};

/// pcg3d of Jarzynski and Olano (2020).
pub fn pcg3d(v: [u32; 3]) -> [u32; 3] {
    let mut v = v.map(|x| x.wrapping_mul(PCG_FACTOR).wrapping_add(PCG_SUMMAND));
    let mix = |v: &mut [u32; 3]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[2]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
    };
    mix(&mut v);
    v = v.map(|x| x ^ (x >> 16));
    mix(&mut v);
    v
}
