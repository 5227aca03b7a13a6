// Tissue of a given diffuse reflectance: it returns the same share of all light, alike in all directions.

fn returned(mu: f32) -> f32 { return scene.tissue_albedo; }
fn sent(mu_i: f32, mu_o: f32) -> f32 { return scene.tissue_albedo; }
fn weigh(mu_i: f32, mu_o: f32) {}

// What a photon leaves in the map, of its weight: what would enter through true contact and through the gap.
fn map_shares(r: vec3f, mu: f32) -> vec2f { return 1.0 - r.yz; }

// Exitance from the map's two numbers.
fn exitance_toward(xy: vec2f, map: vec2f, mu_o: f32) -> f32 {
    if (SPREADING) { return map.x; }
    let share = contact_share(xy);
    let reentry = mix(scene.reentry_gap, scene.reentry_contact, share);
    return scene.tissue_albedo * mix(map.y, map.x, share) / (1.0 - scene.tissue_albedo * reentry);
}
