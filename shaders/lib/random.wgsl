// Counter-based random numbers: a hash of (seed, path, draw), bit-equal to the CPU twin.
// Keys by pcg3d (Jarzynski and Olano 2020); draws by the two-round multiply-xorshift mix of Wellons' `lowbias32`.

fn pcg3d(v0: vec3u) -> vec3u {
    var v = v0 * PCG_FACTOR + PCG_SUMMAND;
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    return v;
}

fn start_random(a: u32, b: u32) {
    path.key = pcg3d(vec3u(run.seed, a, b)).xy;
    path.draws = 0u;
    path.number = (b << ROUND_BITS) + a;
}

// Uniform in [0, 1), 24 bits.
fn draw() -> f32 {
    var h = path.key.x + path.draws * DRAW_STEP;
    path.draws += 1u;
    h ^= h >> 16u; h *= DRAW_FIRST;
    h ^= h >> 15u; h += path.key.y; h *= DRAW_SECOND;
    h ^= h >> 15u;
    return f32(h >> 8u) * OF_24_BITS;
}

// Uniform in [0, 1), 24 bits, and even over the paths of a seed: a coordinate of point `path.number` of Sobol's
// sequence, scrambled. `src/trace/launch.rs` writes the points and says whose they are.
fn even_draw(point: u32, scramble: u32) -> f32 {
    var y = point;
    y ^= y * SCRAMBLE_FIRST;
    y = (y + scramble) * ((scramble >> 16u) | 1u);
    y ^= y * SCRAMBLE_SECOND;
    y ^= y * SCRAMBLE_LAST;
    return f32(reverseBits(y) >> 8u) * OF_24_BITS;
}
