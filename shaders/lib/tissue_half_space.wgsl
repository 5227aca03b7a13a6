// Tissue as a half space of isotropic scatterers (Chandrasekhar, Radiative Transfer, 1960): with the cosines mu within
// the tissue, radiance w/4 H(mu_i) H(mu_o) / (mu_i + mu_o) over that of a white Lambertian face leaves, 1 - sqrt(1 - w)
// H(mu_i) in all. 1/H is sqrt(1 - w) plus `h_terms`, a sum that the host writes into the text.

fn chandrasekhar_h(mu: f32) -> f32 { return 1.0 / (scene.h_floor + h_terms(mu)); }

// Share of light that leaves again.
fn returned(mu: f32) -> f32 { return 1.0 - scene.h_floor * chandrasekhar_h(mu); }

fn sent(mu_i: f32, mu_o: f32) -> f32 {
    return scene.quarter_albedo * chandrasekhar_h(mu_i) * chandrasekhar_h(mu_o) / (mu_i + mu_o);
}

// The weight of a path that survived and leaves by Lambert's law. It is 1 in the mean, so it is booked as roulette's.
fn weigh(mu_i: f32, mu_o: f32) {
    let before = path.weight;
    path.weight = before * sent(mu_i, mu_o) / returned(mu_i);
    book(BOOK_ROULETTE, units(before) - units(path.weight));
}

// What a photon leaves in the map, of its weight: what it sends towards the map's two directions.
fn map_shares(r: vec3f, mu: f32) -> vec2f {
    return (1.0 - r.x) * (scene.map_toward * chandrasekhar_h(mu) / (mu + scene.map_cosines));
}

// Exitance towards the cosine `mu_o`, times pi as a radiance, from the map's two numbers.
fn exitance_toward(xy: vec2f, map: vec2f, mu_o: f32) -> f32 {
    let both = mu_o + scene.map_cosines;
    let scale = chandrasekhar_h(mu_o) / (both.x * both.y);
    let parts = scene.map_between * scale * (mu_o - scene.map_cosines.yx);
    return max(dot(parts, map), 0.0);
}
