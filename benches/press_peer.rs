//! Presses that `benches/peers/compare_press.py` also gives to another program: one press, one line of JSON.
//!
//!     cargo run --release --example press_peer -- tied --law neo-hookean --press 1 --subdivision 2
//!     cargo run --release --example press_peer -- tied --law linear --off-axis 5 --layers 5,5,5 --subdivision 1
//!     cargo run --release --example press_peer -- hertz --rung 2 --mesh out/hertz-mesh.json
//!
//! `tied`: a rigid plate of radius 15 mm tied to a phantom (radius 30, height 25, 5 kPa, nu 0.499) with a ball of 8 mm
//! and 120 kPa, its top 5 mm deep. With `--off-axis` the ball lies beside the axis and the half y >= 0 is pressed in
//! three dimensions; with `--skin` a layer of another modulus covers the phantom's face; with `--layers` the plate is
//! the face of three soft layers on glass. `hertz`: a rigid ball of radius 400 mm pressed without friction into a half
//! space of 1 kPa so far that the contact's radius is 1 mm. `--mesh` writes the mesh for the other program.

use anyhow::{Context as _, Result, ensure};
use clap::{Args, Parser, Subcommand, ValueEnum};
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::time::Instant;
use tirtouch::mechanics::contact::{Contact, Counterpart, Grip, Profile};
use tirtouch::mechanics::element::PressureOrder;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{
    Boundary, Footprint, InclusionShape, Mesh, PhantomMesh, PhantomShape, Resolution, Star,
};
use tirtouch::mechanics::newton::{LinearSolver, Solver};
use tirtouch::mechanics::path::follow;
use tirtouch::mechanics::press::{
    Assembly, ContactPoint, Load, PressSettings, SensorBody, Setup, TIME_STEPS, contact_points, press,
};
use tirtouch::mechanics::problem::{Problem, Support};

#[derive(Parser)]
#[command(about = "One press that another program can repeat")]
struct Arguments {
    #[command(subcommand)]
    press: Press,
    /// Writes nodes (r, z) or (x, y, z), elements of 9 or 27 nodes and their regions.
    #[arg(long, global = true)]
    mesh: Option<PathBuf>,
}

#[derive(Subcommand)]
enum Press {
    /// A plate tied to a phantom with a ball in it.
    Tied(Tied),
    /// A rigid ball on a half space.
    Hertz {
        /// Elements in the contact measure 0.2 mm over this.
        #[arg(long, default_value_t = 2)]
        rung: usize,
        #[arg(long, default_value_t = 0.3)]
        nu: f64,
    },
}

#[derive(Args)]
struct Tied {
    #[arg(long, default_value = "neo-hookean")]
    law: LawName,
    /// Motion of the plate, mm.
    #[arg(long, default_value_t = 1.0)]
    press: f64,
    /// Divides every element along each axis; the default of a press is 2, in three dimensions 1.
    #[arg(long, default_value_t = 2)]
    subdivision: usize,
    /// Sizes of elements in parts of the default's.
    #[arg(long, default_value_t = 1.0)]
    scale: f64,
    /// Presses again on elements of twice the size to estimate the error.
    #[arg(long)]
    estimate: bool,
    #[arg(long, default_value_t = 0.499)]
    nu: f64,
    /// Distance of the ball from the axis along x, mm; three dimensions.
    #[arg(long)]
    off_axis: Option<f64>,
    /// Thickness, mm, and Young's modulus, kPa, of a layer on the phantom's touched face.
    #[arg(long, value_delimiter = ',')]
    skin: Option<Vec<f64>>,
    /// Young's moduli of a soft sensor's layers, kPa, the one on the glass first.
    #[arg(long, value_delimiter = ',')]
    layers: Option<Vec<f64>>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum LawName {
    Linear,
    NeoHookean,
}

/// Thicknesses of a soft sensor's layers, mm, the one on the glass first.
const LAYERS_MM: [f64; 3] = [5.0, 3.0, 2.0];
/// Elements in three dimensions, so large that the other program too can press their halves and thirds.
const SOLID: Resolution = Resolution {
    edge_mm: 0.3,
    contact_mm: 5.0,
    coarsest_mm: 14.0,
    growth: 2.0,
    inclusion_divisions: 1.0,
    ..Resolution::SOLID
};
/// Reach of the weight 1 - (r / reach)^2 under which the pressure in the middle is averaged, mm.
const MIDDLE_MM: f64 = 2.5;
/// Radius of the rigid ball, mm: the contact's is a 400th of it, as Hertz leaves out that points move sideways.
const BALL_MM: f64 = 400.0;
/// Distance of base and side, mm; the base stiffens by about 0.8 of the contact's radius over it.
const FAR_MM: f64 = 1200.0;
/// Radius of the part of the face that may touch, mm.
const REACH_MM: f64 = 1.4;

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let (mesh, figures) = match arguments.press {
        Press::Tied(asked) => tied(&asked.setup()?, asked.estimate)?,
        Press::Hertz { rung, nu } => hertz(rung, nu)?,
    };
    if let Some(path) = arguments.mesh {
        write_mesh(&mesh, &path)?;
    }
    println!("{figures}");
    Ok(())
}

impl Tied {
    fn material(&self, youngs_kpa: f64) -> Result<Material> {
        Ok(match self.law {
            LawName::Linear => Material::linear(youngs_kpa, self.nu),
            LawName::NeoHookean => Material::neo_hookean(youngs_kpa, self.nu),
        }?)
    }

    fn setup(&self) -> Result<Setup> {
        let solid = self.off_axis.is_some();
        let center_mm = [self.off_axis.unwrap_or(0.0), 0.0, 9.0];
        let base = if solid { SOLID } else { Resolution::PLANE };
        Ok(Setup {
            kinematics: if solid { Kinematics::ThreeDimensional } else { Kinematics::Axisymmetric },
            pressure: PressureOrder::Linear,
            phantom: PhantomMesh {
                shape: PhantomShape::Cylinder { radius_mm: 30.0, height_mm: 25.0 },
                inclusions: vec![InclusionShape { center_mm, surface: Star::Ellipsoid { semi_axes_mm: [4.0; 3] } }],
                footprint: Footprint::Round { radius_mm: 15.0 },
                symmetry: [!solid, true],
                resolution: Resolution { subdivision: self.subdivision, ..base.scaled(self.scale) },
                offset_mm: [0.0; 2],
                layers_mm: self.skin.iter().flatten().take(1).copied().collect(),
            },
            phantom_materials: [5.0, 120.0]
                .iter()
                .chain(self.skin.iter().flatten().skip(1))
                .map(|&youngs| self.material(youngs))
                .collect::<Result<_>>()?,
            sensor: self.sensor()?,
            grip: Grip::Bonded,
            load: Load::Depths(vec![self.press]),
            seconds_per_mm: None,
            hold_s: 0.0,
            time_steps: TIME_STEPS,
            tilt_deg: [0.0; 2],
        })
    }

    fn sensor(&self) -> Result<SensorBody> {
        let Some(layers) = &self.layers else {
            return Ok(SensorBody::Rigid { edge_radius_mm: 0.5 });
        };
        ensure!(layers.len() == LAYERS_MM.len(), "{} layers, {} moduli", LAYERS_MM.len(), layers.len());
        let layers =
            LAYERS_MM.into_iter().zip(layers).map(|(thickness, &youngs)| Ok((thickness, self.material(youngs)?)));
        Ok(SensorBody::Layers { layers: layers.collect::<Result<_>>()?, edge_radius_mm: 0.0 })
    }
}

fn tied(setup: &Setup, estimate: bool) -> Result<(Mesh, Value)> {
    let pressed = press(setup, PressSettings { estimate_error: estimate, ..PressSettings::default() }, &mut |_| true)?;
    let step = pressed.steps.last().context("no depth was reached")?;
    let Assembly { problem, .. } = pressed.assembly;
    let dim = problem.kinematics.dim();
    let touched: Vec<_> = step.points.iter().map(|p| (&p.reference_mm[..dim - 1], p.force_mn, p.area_mm2)).collect();
    let wall = contact_points(&problem, 1, &step.state).iter().map(|p| p.pressure_kpa).fold(0.0, f64::max);
    let figures = json!({
        "dofs": pressed.unknowns,
        "elements": problem.mesh.element_count(),
        "seconds": pressed.seconds,
        "iterations": pressed.iterations,
        "factor_mib": pressed.factor_mib,
        "force_n": step.force_n,
        "middle_kpa": (dim == 2).then(|| middle(&step.points)),
        "wall_kpa": wall,
        "touched": touched,
        "estimated_force_error": step.error.map(|error| error.force),
        "estimated_pressure_error": step.error.map(|error| error.rms),
        "estimate_seconds": pressed.error_seconds,
    });
    Ok((problem.mesh, figures))
}

/// Mean of the pressure on the undeformed face under the weight 1 - (r / reach)^2, kPa; linear between nodes, Simpson's
/// rule on a hundred parts.
fn middle(points: &[ContactPoint]) -> f64 {
    let rows: Vec<[f64; 2]> =
        points.iter().filter(|p| p.area_mm2 > 0.0).map(|p| [p.reference_mm[0], p.force_mn / p.area_mm2]).collect();
    let pressure = |r: f64| {
        let after = rows.partition_point(|row| row[0] < r).clamp(1, rows.len() - 1);
        let ([r0, p0], [r1, p1]) = (rows[after - 1], rows[after]);
        p0 + (r - r0) / (r1 - r0) * (p1 - p0)
    };
    let parts = 100;
    let (mut whole, mut weights) = (0.0, 0.0);
    for k in 0..=2 * parts {
        let r = MIDDLE_MM * f64::from(k) / f64::from(2 * parts);
        let simpson = if k == 0 || k == 2 * parts { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
        let weight = simpson * r * (1.0 - (r / MIDDLE_MM).powi(2));
        whole += weight * pressure(r);
        weights += weight;
    }
    whole / weights
}

fn hertz(rung: usize, nu: f64) -> Result<(Mesh, Value)> {
    let start = Instant::now();
    let kinematics = Kinematics::Axisymmetric;
    let mesh = PhantomMesh {
        shape: PhantomShape::Cylinder { radius_mm: FAR_MM, height_mm: FAR_MM },
        inclusions: Vec::new(),
        footprint: Footprint::Round { radius_mm: REACH_MM },
        symmetry: [true, false],
        resolution: Resolution {
            edge_mm: 0.2,
            ring_share: 1.0,
            contact_mm: 0.2,
            coarsest_mm: 0.4 * FAR_MM,
            growth: 0.5,
            rim_mm: 0.0,
            rim_divisions: 1.0,
            inclusion_divisions: 4.0,
            subdivision: rung,
        },
        offset_mm: [0.0; 2],
        layers_mm: Vec::new(),
    }
    .build_2d()?;
    let material = Material::linear(1.0, nu)?;
    let reached = |a: &u32| mesh.nodes[*a as usize][0] <= REACH_MM * (1.0 + 1e-9);
    let facets: Vec<_> = mesh
        .boundary_facets(Boundary::Touched)
        .into_iter()
        .filter(|facet| mesh.facet_nodes(*facet).iter().all(reached))
        .collect();
    let ball = Counterpart::Rigid { profile: Profile::Round { radius_mm: BALL_MM }, center: [0.0; 2] };
    let contact = Contact::new(kinematics, &mesh, &facets, ball, Grip::Frictionless, material.law.shear_kpa(), 1.0);
    let problem = Problem {
        supports: held(&mesh, 1.0 / BALL_MM),
        contacts: vec![contact],
        ..Problem::free(kinematics, mesh, vec![material])
    };
    let mut solver = Solver::new(&problem, LinearSolver::Direct);
    let state = follow(&mut solver, problem.start(), &mut None, &[1.0], &mut |_| true)?;
    let iterations = solver.iterations;
    drop(solver);
    let seconds = start.elapsed().as_secs_f64();
    let points = contact_points(&problem, 0, &state);
    let rows: Vec<[f64; 2]> = points.iter().map(|point| [point.reference_mm[0], point.pressure_kpa]).collect();
    let modulus = 1.0 / (1.0 - nu * nu);
    let figures = json!({
        "dofs": problem.unknowns(),
        "seconds": seconds,
        "iterations": iterations,
        "force_mn": points.iter().map(|point| point.force_mn).sum::<f64>(),
        "hertz_force_mn": 4.0 / 3.0 * modulus / BALL_MM,
        "hertz_pressure_kpa": 2.0 * modulus / (PI * BALL_MM),
        "size_mm": 0.2 / rung as f64,
        "pressures": rows,
    });
    Ok((problem.mesh, figures))
}

/// The axis held against r; the base held against r and moved towards the ball.
fn held(mesh: &Mesh, depth_mm: f64) -> Vec<Support> {
    let base = FAR_MM * (1.0 - 1e-12);
    let numbered = || (0u32..).zip(&mesh.nodes);
    let radial = numbered().filter(|(_, x)| x[0] == 0.0 || x[1] >= base);
    let along = numbered().filter(|(_, x)| x[1] >= base);
    radial
        .map(|(node, _)| Support { node, axis: 0, displacement_mm: 0.0 })
        .chain(along.map(|(node, _)| Support { node, axis: 1, displacement_mm: -depth_mm }))
        .collect()
}

fn write_mesh(mesh: &Mesh, path: &Path) -> Result<()> {
    let nodes: Vec<&[f64]> = mesh.nodes.iter().map(|x| &x[..mesh.dim]).collect();
    let elements: Vec<&[u32]> = (0..mesh.element_count()).map(|e| mesh.element(e)).collect();
    let text = json!({ "nodes": nodes, "elements": elements, "region": mesh.region }).to_string();
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
