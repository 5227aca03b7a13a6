use tirtouch::mechanics::contact::*;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::*;
use tirtouch::mechanics::newton::Solver;
use tirtouch::mechanics::path::follow;
use tirtouch::mechanics::press::*;
use tirtouch::mechanics::problem::*;

fn phantom(soft: bool, linear: bool, depths: &[f64], grip: Grip, halved: bool) -> Setup {
    let material = |youngs: f64| if linear { Material::linear(youngs, 0.4999).unwrap() } else { Material::neo_hookean(youngs, 0.4999).unwrap() };
    let mut s = Setup {
        kinematics: Kinematics::Axisymmetric,
        phantom: PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: 30.0, height_mm: 25.0 },
            inclusions: vec![],
            footprint: Footprint::Round { radius_mm: 15.0 },
            symmetry: [true, true],
            resolution: Resolution::PLANE,
        },
        phantom_materials: vec![material(5.0)],
        sensor: if soft { SensorBody::Layers([(5.0, 15.0), (3.0, 30.0), (2.0, 60.0)].map(|(h, e)| (h, material(e))).to_vec()) } else { SensorBody::Rigid { edge_radius_mm: 0.5 } },
        grip,
        load: Load::Depths(depths.to_vec()),
        seconds_per_mm: None,
        hold_s: 0.0,
    };
    if halved { s.phantom.resolution = Resolution::PLANE.halved(); }
    s
}

fn round(depth: f64, grip: Grip, radius: f64) {
    let mesh = PhantomMesh {
        shape: PhantomShape::Cylinder { radius_mm: 8.0*radius, height_mm: 6.0*radius },
        inclusions: vec![],
        footprint: Footprint::Round { radius_mm: 1.2 * radius },
        symmetry: [true, false],
        resolution: Resolution { edge_mm: 0.1*radius, contact_mm: 0.1*radius, coarsest_mm: radius, growth: 0.3, inclusion_divisions: 4.0, subdivision: 1 },
    }.build_2d().unwrap();
    let material = Material::neo_hookean(5.0, 0.4999).unwrap();
    let mut facets = mesh.boundary_facets(Boundary::Touched);
    facets.retain(|f| mesh.facet_nodes(*f).iter().all(|&a| mesh.nodes[a as usize][0].abs() <= 1.5 * radius));
    let h = 6.0*radius;
    let k = Kinematics::Axisymmetric;
    let contact = Contact::new(k, &mesh, &facets, Counterpart::Rigid { profile: Profile::Round { radius_mm: radius }, center: [0.0; 2] }, grip, material.law.shear_kpa(), 1.0);
    let mut supports = vec![];
    for (n, x) in mesh.nodes.iter().enumerate() {
        let base = x[1] > h * 0.9999;
        if x[0] == 0.0 || base { supports.push(Support { node: n as u32, axis: 0, displacement_mm: 0.0 }); }
        if base { supports.push(Support { node: n as u32, axis: 1, displacement_mm: -depth }); }
    }
    let problem = Problem { kinematics: k, mesh, materials: vec![material], supports, forces: vec![], contacts: vec![contact], seconds_per_load: None };
    let mut solver = Solver::new(&problem);
    let t = std::time::Instant::now();
    match follow(&mut solver, problem.start(), &[1.0], &mut |_| true) {
        Ok(s) => { let f: f64 = contact_points(&problem, 0, &s).iter().map(|p| p.force_mn).sum(); println!("round {grip:?}: F {f:.5} mN, {} it, {:.1} s", solver.iterations, t.elapsed().as_secs_f64()); }
        Err(e) => println!("round {grip:?}: {e}, {} it", solver.iterations),
    }
}

fn main() {
    let a: Vec<String> = std::env::args().collect();
    let grip = |s: &str| match s { "tied" => Grip::Bonded, "free" => Grip::Frictionless, m => Grip::Coulomb(m.parse().unwrap()) };
    match a[1].as_str() {
        "flat" => {
            let depths: Vec<f64> = a[6].split(',').map(|d| d.parse().unwrap()).collect();
            for g in a[5].split(',') {
                let setup = phantom(a[2] == "soft", a[3] == "linear", &depths, grip(g), a[4] == "half");
                match press(&setup, PressSettings { estimate_error: false }, &mut |_| true) {
                    Ok(p) => println!("{g}: F {:?}, {} it, {:.1} s", p.steps.iter().map(|s| s.force_n).collect::<Vec<_>>(), p.iterations, p.seconds),
                    Err(PressError::Stopped { cause, reached }) => println!("{g}: {cause} reached {:?} it {}", reached.steps.iter().map(|s| s.force_n).collect::<Vec<_>>(), reached.iterations),
                    Err(e) => println!("{e}"),
                }
            }
        }
        _ => for g in a[2].split(',') { round(a[3].parse().unwrap(), grip(g), 2.0) },
    }
}
