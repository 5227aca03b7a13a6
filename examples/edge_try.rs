//! try
use tirtouch::mechanics::contact::Grip;
use tirtouch::mechanics::from_scene::press_setup;
use tirtouch::mechanics::press::*;
use tirtouch::scene::preset;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let f = |k: usize| a[k].parse::<f64>().unwrap();
    let mut s = press_setup(&preset("phantom-size-8mm").unwrap()).unwrap();
    if let SensorBody::Layers { edge_radius_mm, .. } = &mut s.sensor { *edge_radius_mm = f(1); }
    s.grip = match f(2) { m if m < 0.0 => Grip::Bonded, 0.0 => Grip::Frictionless, m => Grip::Coulomb(m) };
    s.load = Load::Depths(a[3].split(',').map(|d| d.parse().unwrap()).collect());
    if let Some(sub) = a.get(4) { s.phantom.resolution.subdivision = sub.parse().unwrap(); }
    let mut seen = 0.0;
    let t = std::time::Instant::now();
    let done = press(&s, PressSettings { estimate_error: false }, &mut |st| { if st.done != seen && std::env::var("V").is_ok() { println!("  done {:.4} at {:.1} s", st.done, t.elapsed().as_secs_f64()); } seen = st.done; true });
    let (p, e) = match done { Ok(p) => (p, String::new()), Err(PressError::Stopped { cause, reached }) => (*reached, cause.to_string()), Err(e) => { println!("{e}"); return } };
    let forces: Vec<String> = p.steps.iter().map(|s| format!("{:.4}@{} peak {:.3}", s.force_n, s.depth_mm, s.peak_pressure_kpa)).collect();
    println!("re {} mu {} : {:?} it {} {:.1}s unk {} | {}", a[1], a[2], forces, p.iterations, p.seconds, p.unknowns, e);
    println!("quality {:?}", p.assembly.bodies[1].quality());
    if std::env::var("P").is_ok() { if let Some(s) = p.steps.last() { for q in s.points.iter().filter(|q| q.reference_mm[0] > 13.5) {
        println!("{:.4} {:.4}  p {:.3} s {:.3} gap {:.5} u {:.4} {:.4}", q.reference_mm[0], q.reference_mm[1], q.pressure_kpa, q.shear_kpa, q.gap_mm, q.displacement_mm[0], q.displacement_mm[1]); } } }
}
