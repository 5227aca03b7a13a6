// Counter-based random numbers: a hash of (seed, path, draw), bit-equal to the CPU twin.
// Keys by pcg3d (Jarzynski and Olano 2020); draws by the two-round multiply-xorshift mix of Wellons' `lowbias32`.

fn pcg3d(v0: vec3u) -> vec3u {
    var v = v0 * 1664525u + 1013904223u;
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    return v;
}

fn start_random(a: u32, b: u32) {
    path.key = pcg3d(vec3u(run.seed, a, b)).xy;
    path.draws = 0u;
    path.place = reverseBits((b << 14u) + a);
}

// Uniform in [0, 1), 24 bits.
fn draw() -> f32 {
    var h = path.key.x + path.draws * 0x9e3779b9u;
    path.draws += 1u;
    h ^= h >> 16u; h *= 0x21f0aaadu;
    h ^= h >> 15u; h += path.key.y; h *= 0xd35a2d97u;
    h ^= h >> 15u;
    return f32(h >> 8u) * 5.9604644775390625e-8;
}

// Uniform in [0, 1), 24 bits, and even over the paths of a seed: the coordinate with generator z of a rank-1 lattice
// sequence (Hickernell, Hong, L'Ecuyer and Lemieux, SIAM J. Sci. Comput. 22, 1117, 2000) with a random shift (Cranley
// and Patterson 1976). Paths (a, b) are numbered a + 2^14 b. The generators 1, 761135, 257481, 617715, 488567, 94035
// were found component by component for 2^10 to 2^18 points; `random.rs` tests them, and gives the shifts.
fn even_draw(z: u32, shift: u32) -> f32 {
    let h = path.place * z + shift;
    return f32(h >> 8u) * 5.9604644775390625e-8;
}
