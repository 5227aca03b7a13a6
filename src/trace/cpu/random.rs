//! Twin of `random.wgsl`: counter-based random numbers, equal bit for bit; launches are even, on a lattice whose
//! generators matter (docs/decisions/launch.md).

use super::Path;
use crate::trace::model::Real;

/// pcg3d of Jarzynski and Olano (2020).
pub fn pcg3d(v: [u32; 3]) -> [u32; 3] {
    let mut v = v.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
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

/// Shift of the launch's lattice along the coordinate with generator `z`, in units of 2^-32.
pub fn shift(seed: u32, z: u32) -> u32 {
    pcg3d([seed, z, 0x6c61_7474])[0]
}

impl<T: Real> Path<'_, T> {
    /// Starts the random numbers of path (a, b) of a seed.
    pub fn start_random(&mut self, seed: u32, a: u32, b: u32) {
        let key = pcg3d([seed, a, b]);
        self.key = [key[0], key[1]];
        self.draws = 0;
        self.place = (b << 14).wrapping_add(a).reverse_bits();
        self.seed = seed;
    }

    /// Uniform in [0, 1), 24 bits, and even over the paths of a seed: the coordinate with generator `z` of a rank-1
    /// lattice sequence with a random shift. Paths (a, b) are numbered a + 2^14 b.
    pub fn even_draw(&mut self, z: u32) -> T {
        let h = self.place.wrapping_mul(z).wrapping_add(shift(self.seed, z));
        T::of(f64::from(h >> 8) * 5.960_464_477_539_063e-8)
    }

    /// Uniform in [0, 1), 24 bits.
    pub fn draw(&mut self) -> T {
        let mut h = self.key[0].wrapping_add(self.draws.wrapping_mul(0x9e37_79b9));
        self.draws = self.draws.wrapping_add(1);
        h = (h ^ (h >> 16)).wrapping_mul(0x21f0_aaad);
        h = (h ^ (h >> 15)).wrapping_add(self.key[1]).wrapping_mul(0xd35a_2d97);
        h ^= h >> 15;
        T::of(f64::from(h >> 8) * 5.960_464_477_539_063e-8)
    }
}

#[cfg(test)]
mod tests {
    use crate::trace::constants::*;

    /// Generators of the launch.
    const GENERATORS: [u32; 6] =
        [LATTICE_LED, LATTICE_RADIUS, LATTICE_TURN, LATTICE_POLAR, LATTICE_AZIMUTH, LATTICE_SIDE];

    /// The mean square error over all shifts, in the worst case of a function space with product weights of 0.7 (Dick,
    /// Kuo and Sloan, Acta Numerica 22, 133, 2013, section 5), is below that of random points; in few coordinates, far
    /// below.
    #[test]
    fn the_lattice_of_launches_beats_random_points() {
        let weight = 0.7 * 2.0 * std::f64::consts::PI.powi(2);
        for (coordinates, share) in [(2, 2e-3), (4, 0.1), (6, 0.6)] {
            for exponent in [14u32, 16, 18] {
                let points = 1u32 << exponent;
                let product = |k: u32| -> f64 {
                    let x = |z: u32| f64::from(k.reverse_bits().wrapping_mul(z)) / 4_294_967_296.0;
                    let factor = |z: &u32| 1.0 + weight * (x(*z) * (x(*z) - 1.0) + 1.0 / 6.0);
                    GENERATORS[..coordinates].iter().map(factor).product()
                };
                let lattice = (0..points).map(product).sum::<f64>() / f64::from(points) - 1.0;
                let random = ((1.0 + weight / 6.0).powi(coordinates as i32) - 1.0) / f64::from(points);
                assert!(lattice < share * random, "{coordinates} coordinates, 2^{exponent}: {lattice:e} {random:e}");
            }
        }
    }
}
