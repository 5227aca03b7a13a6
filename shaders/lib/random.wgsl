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
    path.number = (b << 14u) + a;
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

// Uniform in [0, 1), 24 bits, and even over the paths of a seed: a coordinate of point `path.number` of Sobol's
// sequence, scrambled. `src/trace/launch.rs` writes the points and says whose they are.
fn even_draw(point: u32, scramble: u32) -> f32 {
    var y = point;
    y ^= y * 0x3d20adeau;
    y = (y + scramble) * ((scramble >> 16u) | 1u);
    y ^= y * 0x05526c56u;
    y ^= y * 0x53a22864u;
    return f32(reverseBits(y) >> 8u) * 5.9604644775390625e-8;
}
