use super::contact::*;
use super::kinematics::Kinematics;
use super::material::*;
use super::mesh::*;
use super::newton::Solver;
use super::problem::*;

pub fn grid(xs: &[f64], zs: &[f64]) -> Mesh {
    let (nx, nz) = (xs.len() - 1, zs.len() - 1);
    let mid = |v: &[f64], k: usize| if k % 2 == 0 { v[k / 2] } else { 0.5 * (v[k / 2] + v[k / 2 + 1]) };
    let w = 2 * nx + 1;
    let mut nodes = vec![];
    for j in 0..=2 * nz { for i in 0..=2 * nx { nodes.push([mid(xs, i), mid(zs, j), 0.0]); } }
    let mut elements = vec![]; let mut facets = vec![];
    for j in 0..nz { for i in 0..nx {
        for b in 0..3 { for a in 0..3 { elements.push(((2*j+b) * w + 2*i+a) as u32); } }
        let e = (j * nx + i) as u32;
        if j == 0 { facets.push(Facet { element: e, side: 2, boundary: Boundary::Touched }); }
        if j == nz - 1 { facets.push(Facet { element: e, side: 3, boundary: Boundary::Base }); }
        if i == 0 { facets.push(Facet { element: e, side: 0, boundary: Boundary::SymmetryX }); }
        if i == nx - 1 { facets.push(Facet { element: e, side: 1, boundary: Boundary::Side }); }
    } }
    Mesh { dim: 2, nodes, elements, region: vec![0; nx * nz], facets }
}

fn graded(a: f64, b: f64, n: usize, power: f64) -> Vec<f64> { (0..=n).map(|k| a + (b - a) * (k as f64 / n as f64).powf(power)).collect() }

fn press(nx: usize, law: Law, nu: f64, depth: f64, grip: Grip, steps: usize) {
    let mut xs = graded(0.0, 15.0, nx * 3 / 4, 0.8);
    xs.extend(graded(15.0, 30.0, nx / 4, 1.3).into_iter().skip(1));
    let zs = graded(0.0, 25.0, nx * 3 / 4, 1.25);
    let mesh = grid(&xs, &zs);
    let supports = base(&mesh, -depth);
    let facets: Vec<Facet> = mesh.facets.iter().copied().filter(|f| f.boundary == Boundary::Touched && mesh.facet_nodes(*f).iter().all(|&a| mesh.nodes[a as usize][0] <= 15.0 + 1e-9)).collect();
    let contact = Contact::new(Kinematics::Axisymmetric, &mesh, &facets, Counterpart::Rigid { profile: Profile::Flat, center: [0.0; 2] }, grip, law.shear_kpa(), 1.0);
    let problem = Problem { kinematics: Kinematics::Axisymmetric, mesh, materials: vec![Material::elastic(law, nu).unwrap()], supports, forces: vec![], contacts: vec![contact] };
    solve(&problem, steps, 1.0);
}

pub fn base(mesh: &Mesh, dz: f64) -> Vec<Support> {
    let mut supports = vec![];
    let mut seen = std::collections::HashSet::new();
    for f in &mesh.facets { for a in mesh.facet_nodes(*f) {
        if f.boundary == Boundary::Base { for c in 0..2 { if seen.insert((a, c)) { supports.push(Support { node: a, axis: c, displacement_mm: if c == 1 { dz } else { 0.0 } }); } } }
        if f.boundary == Boundary::SymmetryX && seen.insert((a, 0)) { supports.push(Support { node: a, axis: 0, displacement_mm: 0.0 }); }
    } }
    supports
}

pub fn solve(problem: &Problem, steps: usize, mean_radius: f64) -> (f64, f64) {
    let start = std::time::Instant::now();
    let mut solver = Solver::new(problem);
    let loads: Vec<f64> = (1..=steps).map(|k| k as f64 / steps as f64).collect();
    let state = match super::path::follow(&mut solver, problem.start(), &loads, &mut |_| true, &mut |_| ()) { Ok(s) => s, Err(e) => { println!("FAILED {e} iterations {}", solver.iterations); return (0.0, 0.0); } };
    let contact = &problem.contacts[0];
    let x = problem.positions(&state);
    let (gaps, _) = contact.gaps(Positions { reference: &problem.mesh.nodes, before: &x, now: &x }, &vec![0.0; contact.nodes.len()]);
    let mut force = 0.0;
    let (mut mean, mut area) = (0.0, 0.0);
    let up = problem.kinematics.dim() - 1;
    for ((gap, t), &node) in gaps.iter().zip(&state.traction[0]).zip(&contact.nodes) {
        let p = t.normal * gap.normal[up] + t.vector[up] * gap.area;
        force += p;
        if problem.mesh.nodes[node as usize][0] < mean_radius { mean += p; area += gap.area; }
    }
    println!("unknowns {} iterations {} symbolic {} seconds {:.2} force {:.5} N mean pressure {:.2} Pa", problem.unknowns(), solver.iterations, solver.symbolic, start.elapsed().as_secs_f64(), force * 1e-3, 1e3 * mean / area);
    (force * 1e-3, 1e3 * mean / area)
}

#[test]
fn tied_press() {
    let shear = 5.0 / (2.0 * 1.4999);
    for nx in [16, 32, 64] { press(nx, Law::Linear { shear_kpa: shear }, 0.4999, 1.0, Grip::Bonded, 1); }
    for nx in [16, 32, 64] { press(nx, Law::Linear { shear_kpa: shear }, 0.5, 1.0, Grip::Bonded, 1); }
    for nx in [16, 32, 64] { press(nx, Law::Linear { shear_kpa: shear }, 0.4999, 1.0, Grip::Frictionless, 1); }
    press(32, Law::NeoHookean { shear_kpa: shear }, 0.4999, 1.0, Grip::Bonded, 1);
    press(32, Law::NeoHookean { shear_kpa: shear }, 0.5, 4.0, Grip::Bonded, 4);
    press(32, Law::NeoHookean { shear_kpa: shear }, 0.5, 4.0, Grip::Bonded, 1);
    press(32, Law::NeoHookean { shear_kpa: shear }, 0.5, 4.0, Grip::Frictionless, 4);
}
#[test]
fn sliding() {}

fn geometric(first: f64, growth: f64, end: f64) -> Vec<f64> { let mut v = vec![]; let mut h = first; let mut x = 0.0; while x + h < end { x += h; v.push(x); h *= growth; } v.push(end); v }
#[test]
fn hertz() {
    for n in [10, 20] {
    let (radius, a, end) = (100.0, 1.0, 400.0);
    let h = a / n as f64;
    let mut xs: Vec<f64> = (0..=(3 * n / 2)).map(|k| k as f64 * h).collect();
    let last = *xs.last().unwrap();
    xs.extend(geometric(h, 1.0 + 3.0 / n as f64, end - last).iter().map(|x| x + last));
    let mut zs: Vec<f64> = (0..=(n)).map(|k| k as f64 * h).collect();
    let last = *zs.last().unwrap();
    zs.extend(geometric(h, 1.0 + 3.0 / n as f64, end - last).iter().map(|x| x + last));
    let mesh = grid(&xs, &zs);
    for (nu, law) in [(0.3, Law::Linear { shear_kpa: 1.0 / 2.6 }), (0.5, Law::Linear { shear_kpa: 1.0 / 3.0 })] {
    let estar = 1.0 / (1.0 - nu * nu);
    let delta = a * a / radius;
    let facets: Vec<Facet> = mesh.facets.iter().copied().filter(|f| f.boundary == Boundary::Touched && mesh.facet_nodes(*f).iter().all(|&k| mesh.nodes[k as usize][0] <= 1.5 * a + 1e-9)).collect();
    let contact = Contact::new(Kinematics::Axisymmetric, &mesh, &facets, Counterpart::Rigid { profile: Profile::Table((0..400).map(|k| { let s = k as f64 * 0.005; [s, s * s / 2.0 / radius] }).collect()), center: [0.0; 2] }, Grip::Frictionless, law.shear_kpa(), 1.0);
    let problem = Problem { kinematics: Kinematics::Axisymmetric, mesh: mesh.clone(), materials: vec![Material::elastic(law, nu).unwrap()], supports: base(&mesh, -delta), forces: vec![], contacts: vec![contact] };
    let (force, p) = solve(&problem, 1, 0.2);
    let f0 = 4.0 / 3.0 * estar * radius.sqrt() * delta.powf(1.5);
    println!("h {h} force/hertz {:.5} mean p/p0 {:.5}", force * 1e3 / f0, p * 1e-3 / (1.5 * f0 / std::f64::consts::PI / a / a * 0.9933));
    }
    }
}

#[test]
fn soft_sensor() {
    for n in [1] {
    let mut xs = graded(0.0, 15.0, 12 * n, 0.8);
    let inner = xs.clone();
    xs.extend(graded(15.0, 30.0, 6 * n, 1.3).into_iter().skip(1));
    let zs = graded(0.0, 25.0, 12 * n, 1.25);
    let tissue = grid(&xs, &zs);
    let mut down: Vec<f64> = graded(0.0, 2.0, 2 * n, 1.0);
    down.extend(graded(2.0, 5.0, 2 * n, 1.0).into_iter().skip(1));
    down.extend(graded(5.0, 10.0, 3 * n, 1.0).into_iter().skip(1));
    let down: Vec<f64> = down.iter().rev().map(|z| -z).collect();
    let sensor = grid(&inner, &down);
    let mut mesh = tissue.clone();
    let offset = mesh.nodes.len() as u32;
    let first = mesh.element_count() as u32;
    mesh.nodes.extend(&sensor.nodes);
    mesh.elements.extend(sensor.elements.iter().map(|a| a + offset));
    let sensor_region: Vec<u32> = (0..sensor.element_count()).map(|e| { let z = sensor.nodes[sensor.element(e)[4] as usize][1]; if z > -2.0 { 3 } else if z > -5.0 { 2 } else { 1 } }).collect();
    mesh.region.extend(&sensor_region);
    let nu = 0.4999;
    let mut supports = base(&tissue, -1.0);
    let mut seen = std::collections::HashSet::new();
    let mut slaves = vec![];
    for f in &sensor.facets {
        let shifted = Facet { element: f.element + first, ..*f };
        match f.boundary {
            Boundary::Base => slaves.push(shifted),
            Boundary::Touched => for a in sensor.facet_nodes(*f) { for c in 0..2 { if seen.insert((a, c)) { supports.push(Support { node: a + offset, axis: c, displacement_mm: 0.0 }); } } },
            Boundary::SymmetryX => for a in sensor.facet_nodes(*f) { if seen.insert((a, 0)) { supports.push(Support { node: a + offset, axis: 0, displacement_mm: 0.0 }); } },
            _ => {}
        }
    }
    let masters: Vec<Vec<u32>> = tissue.facets.iter().filter(|f| f.boundary == Boundary::Touched).map(|f| tissue.facet_nodes(*f)).collect();
    for (grip, linear) in [(Grip::Coulomb(0.1), true), (Grip::Coulomb(0.5), true),  (Grip::Coulomb(0.5), false), (Grip::Frictionless, false)] {
        let material = |e: f64| if linear { Material::linear(e, nu).unwrap() } else { Material::neo_hookean(e, nu).unwrap() };
        let depth = if linear { 1.0 } else { 4.0 };
        let mut supports = supports.clone();
        supports.iter_mut().for_each(|s| s.displacement_mm *= depth);
        let contact = Contact::new(Kinematics::Axisymmetric, &mesh, &slaves, Counterpart::Face(masters.clone()), grip, 5.0 / 3.0, -1.0);
        let problem = Problem { kinematics: Kinematics::Axisymmetric, mesh: mesh.clone(), materials: vec![material(5.0), material(15.0), material(30.0), material(60.0)], supports, forces: vec![], contacts: vec![contact] };
        println!("{grip:?} linear {linear}");
        solve(&problem, 1, 1.0);
    }
    }
}
