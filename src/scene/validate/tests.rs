#![allow(clippy::unwrap_used)]
use super::*;
use crate::scene::bad_scenes::{check, rule, text_of};
use crate::scene::locate::line_at;
use crate::scene::{parse, preset};
use std::path::Path;

#[test]
fn the_rules_of_name_light_and_stack_hold() {
    let glass = "thickness_mm = 2.0              # assumed\nn = 1.38";
    #[rustfmt::skip]
    let wrong = [
        rule("tsis-paper", "\"tsis-paper\"", "\"../up\" #!", "name", "plain folder name"),
        rule("tsis-paper", "\"tsis-paper\"", "\".hidden\" #!", "name", "plain folder name"),
        rule("tsis-paper", "\"tsis-paper\"", "\"\" #!", "name", "plain folder name"),
        rule("tsis-paper", "= 532.0", "= 100 #!", "light.wavelength_nm", "at least 200 and at most 2000"),
        rule("tsis-paper", "[30.0, 30.0]", "[30.0, 0] #!", "stack.footprint_mm[1]", "positive"),
        rule("flat-bonded", "{ kind = \"black\" }", "{ kind = \"mirror\", reflectance = 1.1 } #!", "stack.walls.reflectance", "at most 1"),
        rule("tsis-paper", "surround_n = 1.0", "surround_n = 0.9 #!", "stack.surround_n", "at least 1 and at most 4"),
        rule("tsis-paper", "thickness_mm = 3.0", "thickness_mm = -2 #!", "stack.layer[1].thickness_mm", "must be positive, is -2; for example 2.0"),
        rule("tsis-paper", "thickness_mm = 3.0", "thickness_mm = 0 #!", "stack.layer[1].thickness_mm", "must be positive"),
        rule("tsis-paper", "thickness_mm = 3.0", "thickness_mm = 9e-6 #!", "stack.layer[1].thickness_mm", "at least 0.00001"),
        rule("tsis-paper", "[[stack.layer]]                 # touch side first\nname = \"PDMS 1.41\"              # the hardest\nthickness_mm = 2.0", "[[stack.layer]] #!\nname = \"a\"\nthickness_mm = 999", "stack.layer", "at most 1000 mm thick together, are 1009"),
        rule("tsis-paper", "name = \"PDMS 1.40\"", "name = \"\" #!", "stack.layer[1].name", "printable"),
        rule("tsis-paper", "n = 1.40", "n = 0.99 #!", "stack.layer[1].n", "at least 1 and at most 4"),
        rule("tsis-paper", "n = 1.40", "n = 1.40 #!\nmaterial = \"n_bk7\"", "stack.layer[1].n", "not both"),
        rule("tsis-paper", glass, "thickness_mm = 2.0\nmaterial = \"glass\" #!", "stack.layer[3].material", "\"borofloat33\""),
        rule("tsis-paper", "n = 1.40", "n = 1.4\nabsorption_per_mm = -0.1 #!", "stack.layer[1].absorption_per_mm", "at least 0"),
        rule("rough", "rms_nm = 100.0, lobe_slope = 0.1 }", "rms_nm = 133.0, lobe_slope = 0.1 } #!", "stack.layer[0].upper_roughness.rms_nm", "microfacet"),
        rule("rough", "rms_nm = 100.0, lobe_slope = 0.1 }", "rms_nm = -1, lobe_slope = 0.1 } #!", "stack.layer[0].upper_roughness.rms_nm", "at least 0"),
        rule("rough", "rms_nm = 100.0, lobe_slope = 0.1 }", "rms_nm = 1, lobe_slope = 0 } #!", "stack.layer[0].upper_roughness.lobe_slope", "positive"),
        rule("rough", "surround_n = 1.0", "lower_roughness = { kind = \"microfacet\", alpha = 2 } #!\n", "stack.lower_roughness.alpha", "at most 1"),
        rule("microfacet", "alpha = 0.2 }", "alpha = 0 } #!", "stack.layer[0].upper_roughness.alpha", "at least 0.001"),
    ];
    wrong.iter().for_each(check);
}

#[test]
fn a_material_must_cover_the_wavelength() {
    let text =
        text_of("tsis-paper").replace("= 532.0", "= 900.0").replace("n = 1.40", "material = \"pdms_sylgard184\"");
    let error = parse(&text, Path::new("s.toml")).unwrap_err();
    assert_eq!(error.key.as_deref(), Some("stack.layer[1].material"));
    assert!(error.message.contains("from 350 to 700 nm"), "{error}");
}

#[test]
fn counts_of_layers_and_leds_are_limited() {
    let many = |name: &str, table: &str, body: &str, count: usize| {
        let mut text =
            text_of(name).replace("[camera]", &format!("{}[camera]", format!("[[{table}]]\n{body}\n").repeat(count)));
        text.push('\n');
        parse(&text, Path::new("s.toml")).map_err(|error| error.key)
    };
    let layer = "name = \"x\"\nthickness_mm = 1.0\nn = 1.4";
    assert!(many("flat-bonded", "stack.layer", layer, 28).is_ok());
    assert_eq!(many("flat-bonded", "stack.layer", layer, 29), Err(Some("stack.layer".to_owned())));
    let led = "wall = \"+x\"\nheight_mm = 1.0\ndiameter_mm = 0.1\nmount = { kind = \"bonded\" }\npower_mw = 1.0";
    assert_eq!(many("flat-bonded", "led", led, 61), Err(Some("led".to_owned())));
}

#[test]
fn empty_lists_of_layers_and_leds_are_refused() {
    let mut scene = preset("flat-bonded").unwrap().scene;
    scene.led.clear();
    assert_eq!(validate(&scene).unwrap_err().key, "led");
    scene.stack.layer.clear();
    assert_eq!(validate(&scene).unwrap_err().key, "stack.layer");
}

#[test]
fn the_rules_of_leds_hold() {
    let first = "wall = \"+x\"\nheight_mm = 6.0\ndiameter_mm = 3.0\n";
    let bonded = "mount = { kind = \"bonded\" }\nradiance_w_per_m2_sr = 1.0\npattern = { kind = \"lambertian\" }\n\n[[led]]\nwall = \"-x\"";
    #[rustfmt::skip]
    let wrong = [
        rule("flat-bonded", first, "wall = \"+x\"\nheight_mm = 1.4 #!\ndiameter_mm = 3.0\n", "led[0].height_mm", "from 1.5 to 10.5, is 1.4"),
        rule("flat-bonded", first, "wall = \"+x\"\nheight_mm = 6.0\nalong_mm = 13.6 #!\ndiameter_mm = 3.0\n", "led[0].along_mm", "from -13.5 to 13.5, is 13.6"),
        rule("flat-bonded", first, "wall = \"+x\"\nheight_mm = 6.0\ndiameter_mm = 12.1 #!\n", "led[0].diameter_mm", "at most 12"),
        rule("flat-bonded", first, "wall = \"+x\"\nheight_mm = 6.0\ndiameter_mm = 0 #!\n", "led[0].diameter_mm", "positive"),
        rule("flat-bonded", bonded, "mount = { kind = \"air\" } #!\nradiance_w_per_m2_sr = 1.0\n[[led]]\nwall = \"-x\"", "led[0].mount", "clear walls only"),
        rule("flat-bonded", bonded, "mount = { kind = \"bonded\" }\nradiance_w_per_m2_sr = 0 #!\n[[led]]\nwall = \"-x\"", "led[0].radiance_w_per_m2_sr", "positive"),
        rule("flat-bonded", bonded, "mount = { kind = \"bonded\" }\nradiance_w_per_m2_sr = 1\npower_mw = 1 #!\n[[led]]\nwall = \"-x\"", "led[0].power_mw", "not both"),
        rule("flat-bonded", "[[led]]\nwall = \"+x\"\nheight_mm = 6.0\ndiameter_mm = 3.0\nmount = { kind = \"bonded\" }\nradiance_w_per_m2_sr = 1.0", "[[led]] #!\nwall = \"+x\"\nheight_mm = 6.0\ndiameter_mm = 3.0\nmount = { kind = \"bonded\" }", "led[0].power_mw", "give power_mw or"),
        rule("flat-bonded", bonded, "mount = { kind = \"bonded\" }\nradiance_w_per_m2_sr = 1.0\n[[led]] #!\nwall = \"+x\"", "led[1].along_mm", "overlaps led[0]"),
        rule("flat-bonded", bonded, "mount = { kind = \"bonded\" }\nradiance_w_per_m2_sr = 1.0\npattern = { kind = \"cosine_power\", half_power_deg = 90 } #!\n[[led]]\nwall = \"-x\"", "led[0].pattern.half_power_deg", "below 90"),
        rule("tsis-paper", "power_mw = 5.0  ", "power_mw = -5.0 #!", "led[0].power_mw", "positive"),
        rule("tsis-paper", "= 71.989", "= 90.1 #!", "led[0].cutoff_half_angle_deg", "at most 90"),
        rule("tsis-paper", "gap_mm = 0.0 }", "gap_mm = -0.1 } #!", "led[0].mount.gap_mm", "at least 0"),
    ];
    wrong.iter().for_each(check);
}

#[test]
fn discs_may_touch_edges_and_each_other() {
    let mut scene = preset("flat-bonded").unwrap().scene;
    scene.led[1].wall = scene.led[0].wall;
    scene.led[0].height_mm = 1.5;
    scene.led[1].height_mm = 4.5;
    assert_eq!(validate(&scene), Ok(()));
    scene.led[1].height_mm = 4.49;
    assert_eq!(validate(&scene).unwrap_err().key, "led[1].along_mm");
}

#[test]
fn the_rules_of_the_camera_hold() {
    #[rustfmt::skip]
    let wrong = [
        rule("tsis-paper", "[1392, 1042]", "[0, 1042] #!", "camera.pixels[0]", "from 1 to 8192"),
        rule("tsis-paper", "[1392, 1042]", "[1392, 8193] #!", "camera.pixels[1]", "from 1 to 8192"),
        rule("tsis-paper", "[1392, 1042]", "[8192, 8192] #!", "camera.pixels", "at most 64000000"),
        rule("tsis-paper", "pixel_pitch_um = 4.65", "pixel_pitch_um = 0 #!", "camera.pixel_pitch_um", "positive"),
        rule("tsis-paper", "view_angle_deg = 60.0", "view_angle_deg = 179 #!", "camera.view_angle_deg", "below 179"),
        rule("tsis-paper", "distance_mm = 17.32", "distance_mm = -1 #!", "camera.distance_mm", "inside the glass"),
        rule("tsis-paper", "distance_mm = 17.32", "distance_mm = 0 #!", "camera.distance_mm", "inside the glass"),
        rule("tsis-paper", "{ kind = \"pinhole\" }", "{ kind = \"thin_lens\", focus_mm = 0 } #!", "camera.lens.focus_mm", "positive"),
        rule("tsis-paper", "f_number = 2.8", "f_number = 0.5 #!", "camera.sensor.f_number", "above 0.5"),
        rule("tsis-paper", "exposure_ms = 10.0", "exposure_ms = 0 #!", "camera.sensor.exposure_ms", "positive"),
        rule("tsis-paper", "quantum_efficiency = 0.47", "quantum_efficiency = 47 #!", "camera.sensor.quantum_efficiency", "at most 1"),
        rule("tsis-paper", "full_well_e = 15000.0", "full_well_e = 0 #!", "camera.sensor.full_well_e", "positive"),
        rule("tsis-paper", "read_noise_e = 9.0", "read_noise_e = -9 #!", "camera.sensor.read_noise_e", "at least 0"),
        rule("tsis-paper", "dark_current_e_per_s = 1.0", "dark_current_e_per_s = -1 #!", "camera.sensor.dark_current_e_per_s", "at least 0"),
        rule("tsis-paper", "bit_depth = 8", "bit_depth = 17 #!", "camera.sensor.bit_depth", "from 8 to 16"),
        rule("tsis-paper", "black_level = 0.0", "black_level = 255 #!", "camera.sensor.black_level", "below 255"),
        rule("tsis-paper", "black_level = 0.0", "vignetting_corner_loss = 1.5 #!", "camera.sensor.vignetting_corner_loss", "at most 1"),
        rule("tsis-paper", "black_level = 0.0", "ambient_w_per_m2_sr = -1 #!", "camera.sensor.ambient_w_per_m2_sr", "at least 0"),
    ];
    wrong.iter().for_each(check);
}

#[test]
fn the_rules_of_dents_hold() {
    let dent = "depth_mm = 5.0, radius_mm = 10.0 }";
    let cap = "depth_mm = 1.0, radius_mm = 4.0 }";
    let whole_cap = "{ kind = \"spherical_dent\", depth_mm = 1.0, radius_mm = 4.0 }";
    #[rustfmt::skip]
    let wrong = [
        // 10 mm of PDMS lie above the rigid glass.
        rule("tsis-dent", dent, "depth_mm = 10.0, radius_mm = 12.0 } #!", "touch.shape.depth_mm", "below 10 (what lies above the rigid"),
        rule("tsis-dent", dent, "depth_mm = 0, radius_mm = 10.0 } #!", "touch.shape.depth_mm", "positive"),
        rule("tsis-dent", dent, "depth_mm = 5.0, radius_mm = 4.9 } #!", "touch.shape.depth_mm", "overhang"),
        rule("tsis-dent", dent, "depth_mm = 5.0, radius_mm = 15.1 } #!", "touch.shape.radius_mm", "at most 15"),
        rule("tsis-dent", dent, "depth_mm = 5.0, radius_mm = 10.0, center_mm = [0, 5.1] } #!", "touch.shape.center_mm[1]", "at least -5 and at most 5"),
        rule("dent-cap", cap, "depth_mm = 2.0, radius_mm = 4.0 } #!", "touch.shape.depth_mm", "below 2 (the top layer"),
        rule("dent-cap", whole_cap, "{ kind = \"gaussian_dent\", depth_mm = 1.0, sigma_mm = 0 } #!", "touch.shape.sigma_mm", "positive"),
        // At 3.2 sigma a dent of 1 mm still is 6 um deep at the wall.
        rule("dent-cap", whole_cap, "{ kind = \"gaussian_dent\", depth_mm = 1.0, sigma_mm = 4.7 } #!", "touch.shape.sigma_mm", "flat at the wall, 15 mm"),
        rule("dent-cap", whole_cap, "{ kind = \"gaussian_dent\", depth_mm = 1.0, sigma_mm = 1, center_mm = [16, 0] } #!", "touch.shape.center_mm[0]", "at most 15"),
        rule("dent-cap", whole_cap, "{ kind = \"height_map\", file = \"a.tif\", scale_mm = 1 } #!", "touch.shape.file", ".exr or .png or .csv"),
        rule("dent-cap", whole_cap, "{ kind = \"mesh\", file = \"a.gltf\" } #!", "touch.shape.file", ".obj or .stl or .ply"),
    ];
    wrong.iter().for_each(check);
}

#[test]
fn dents_just_inside_their_limits_are_allowed() {
    for (from, to) in [
        ("depth_mm = 1.0, radius_mm = 4.0", "depth_mm = 1.99, radius_mm = 15.0"),
        ("\"spherical_dent\", depth_mm = 1.0, radius_mm = 4.0", "\"gaussian_dent\", depth_mm = 1.0, sigma_mm = 4.28"),
        // 3.2 sigma, but 0.6 um deep at the wall.
        ("\"spherical_dent\", depth_mm = 1.0, radius_mm = 4.0", "\"gaussian_dent\", depth_mm = 0.1, sigma_mm = 4.7"),
    ] {
        let text = text_of("dent-cap");
        assert!(text.contains(from));
        let parsed = parse(&text.replacen(from, to, 1), Path::new("s.toml"));
        assert!(parsed.is_ok(), "{to}: {}", parsed.unwrap_err());
    }
}

#[test]
fn a_single_layer_holds_the_dent_within_itself() {
    let mut scene = preset("tsis-dent").unwrap().scene;
    scene.stack.layer.truncate(1);
    scene.stack.layer[0].thickness_mm = 12.0;
    assert_eq!(validate(&scene), Ok(()));
    scene.stack.layer[0].thickness_mm = 5.0;
    scene.led.iter_mut().for_each(|led| led.height_mm = 2.5);
    assert_eq!(validate(&scene).unwrap_err().key, "touch.shape.depth_mm");
}

#[test]
fn the_rules_of_contact_hold() {
    let disc = "{ kind = \"disc\", radius_mm = 4.0, pressure_kpa = 1.0 }";
    let law = "law = { kind = \"full\" }";
    let r = "diffuse_reflectance = 0.5";
    #[rustfmt::skip]
    let wrong = [
        rule("contact-disc", disc, "{ kind = \"disc\", radius_mm = 15.5, pressure_kpa = 1.0 } #!", "touch.contact.pressure.radius_mm", "at most 15"),
        rule("contact-disc", disc, "{ kind = \"disc\", radius_mm = 4.0, center_mm = [-12, 0], pressure_kpa = 1.0 } #!", "touch.contact.pressure.center_mm[0]", "at least -11"),
        rule("contact-disc", disc, "{ kind = \"disc\", radius_mm = 4.0, pressure_kpa = -1.0 } #!", "touch.contact.pressure.pressure_kpa", "at least 0"),
        rule("contact-disc", disc, "{ kind = \"hertz\", peak_kpa = -1, radius_mm = 4.0 } #!", "touch.contact.pressure.peak_kpa", "at least 0"),
        rule("contact-disc", disc, "{ kind = \"hertz\", peak_kpa = 1, radius_mm = 0 } #!", "touch.contact.pressure.radius_mm", "positive"),
        rule("contact-disc", disc, "{ kind = \"gaussian\", peak_kpa = 1, sigma_mm = 2, base_kpa = -1 } #!", "touch.contact.pressure.base_kpa", "at least 0"),
        rule("contact-disc", disc, "{ kind = \"gaussian\", peak_kpa = 1, sigma_mm = 0 } #!", "touch.contact.pressure.sigma_mm", "positive"),
        rule("contact-disc", disc, "{ kind = \"table\", file = \"a.txt\" } #!", "touch.contact.pressure.file", ".csv"),
        rule("contact-disc", disc, "{ kind = \"table\", file = \"a.csv\", center_mm = [0, 16] } #!", "touch.contact.pressure.center_mm[1]", "at most 15"),
        rule("contact-disc", disc, "{ kind = \"map\", file = \"a.exr\", scale_kpa = 0 } #!", "touch.contact.pressure.scale_kpa", "positive"),
        rule("contact-disc", law, "law = { kind = \"persson\", reduced_modulus_kpa = 0, rms_slope = 1 } #!", "touch.contact.law.reduced_modulus_kpa", "positive"),
        rule("contact-disc", law, "law = { kind = \"persson\", reduced_modulus_kpa = 1, rms_slope = 0 } #!", "touch.contact.law.rms_slope", "positive"),
        rule("contact-disc", law, "law = { kind = \"greenwood_williamson\", pressure_scale_kpa = 0 } #!", "touch.contact.law.pressure_scale_kpa", "positive"),
        rule("contact-disc", law, "law = { kind = \"persson_unloading\", reduced_modulus_kpa = 1, rms_slope = 1, peak_ratio = 0.9, hold_kpa = 0 } #!", "touch.contact.law.peak_ratio", "at least 1"),
        rule("contact-disc", law, "law = { kind = \"persson_unloading\", reduced_modulus_kpa = 1, rms_slope = 1, peak_ratio = 1, hold_kpa = -1 } #!", "touch.contact.law.hold_kpa", "at least 0"),
        rule("contact-disc", "tissue]\nn = 1.41", "tissue]\nn = 0.5 #!\n", "touch.contact.tissue.n", "at least 1"),
        rule("contact-disc", r, "diffuse_reflectance = 1.1 #!", "touch.contact.tissue.diffuse_reflectance", "at most 1"),
        rule("contact-disc", r, "diffuse_reflectance = 0.5 #!\nabsorption_per_mm = 1", "touch.contact.tissue.diffuse_reflectance", "not both"),
        rule("contact-disc", r, "reduced_scattering_per_mm = 0 #!\nabsorption_per_mm = 1", "touch.contact.tissue.reduced_scattering_per_mm", "positive"),
        rule("contact-disc", r, "reduced_scattering_per_mm = 1\nabsorption_per_mm = -1 #!", "touch.contact.tissue.absorption_per_mm", "at least 0"),
        rule("contact-disc", r, "diffuse_reflectance = 0.5\nspread_mm = -1 #!", "touch.contact.tissue.spread_mm", "at least 0"),
    ];
    wrong.iter().for_each(check);
    for (has, lacks) in [
        ("reduced_scattering_per_mm", "absorption_per_mm"),
        ("absorption_per_mm", "reduced_scattering_per_mm"),
        ("spread_mm", "diffuse_reflectance"),
    ] {
        let text = text_of("contact-disc").replace(r, &format!("{has} = 1"));
        let error = parse(&text, Path::new("s.toml")).unwrap_err();
        assert_eq!(error.key.unwrap(), format!("touch.contact.tissue.{lacks}"));
        let header = text.find("[touch.contact.tissue]").unwrap();
        assert_eq!(error.line, Some(line_at(&text, header)));
    }
}

#[test]
fn the_rules_of_rendering_hold() {
    let end = "lens = { kind = \"pinhole\" }";
    #[rustfmt::skip]
    let wrong = [
        rule("dent-cap", end, "[render]\nspp = 0 #!", "render.spp", "from 1 to 16777216"),
        rule("dent-cap", end, "[render]\nphotons = 0 #!", "render.photons", "from 1"),
        rule("dent-cap", end, "[render]\nmap_texel_mm = 0 #!", "render.map_texel_mm", "positive"),
        rule("dent-cap", end, "[render]\nmap_texel_mm = 0.007 #!", "render.map_texel_mm", "4096 texels"),
        rule("dent-cap", end, "[render]\nheight_field_points = 15 #!", "render.height_field_points", "from 16 to 2048"),
        rule("dent-cap", end, "[render]\nintegrator = \"splat\" #!", "render.integrator", "flat"),
    ];
    wrong.iter().for_each(check);
}
