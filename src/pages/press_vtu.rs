//! A press for ParaView: deformed.vtu of the last load, those before it, and deformed.pvd, which lists them all.

use super::PageError;
use crate::mechanics::mesh::Whole;
use crate::mechanics::press::{ContactPoint, PressStep, Pressed};
use crate::mechanics::press::{element_least_jacobian, element_pressure, element_stress};
use crate::mechanics::problem::{Problem, State};
use crate::output::OutputFolder;
use crate::report::{Values, Vtu, VtuError};
use std::fmt::Write;

/// Writes the whole bodies at each load.
pub fn write_vtu(pressed: &Pressed, lift_mm: f64, folder: &OutputFolder) -> Result<(), PageError> {
    let wholes: Vec<Whole> =
        pressed.assembly.bodies.iter().map(|mesh| mesh.whole(pressed.setup.phantom.symmetry)).collect();
    let count = pressed.steps.len();
    let mut list = String::new();
    for (number, step) in (1..).zip(&pressed.steps) {
        let name = if number == count { "deformed.vtu".to_owned() } else { format!("deformed_{number}.vtu") };
        let vtu = vtu(pressed, step, &wholes, lift_mm).map_err(|error| PageError::Vtu { file: name.clone(), error })?;
        folder.write_bytes(&name, &vtu.to_bytes())?;
        let _ = writeln!(list, "<DataSet timestep=\"{number}\" part=\"0\" file=\"{name}\"/>");
    }
    if count == 0 {
        return Ok(());
    }
    let head = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n";
    Ok(folder.write("deformed.pvd", &format!("{head}<Collection>\n{list}</Collection>\n</VTKFile>\n"))?)
}

fn vtu(pressed: &Pressed, step: &PressStep, wholes: &[Whole], lift_mm: f64) -> Result<Vtu, VtuError> {
    let meshes: Vec<_> = wholes.iter().map(|whole| &whole.mesh).collect();
    let (mut first_node, mut first_element) = (0, 0);
    let (mut nodes, mut elements) = (Vec::new(), Vec::new());
    for (whole, part) in wholes.iter().zip(&pressed.assembly.bodies) {
        nodes.extend(whole.nodes.iter().map(|&(node, signs)| (first_node + node as usize, signs)));
        elements.extend(whole.elements.iter().map(|&(element, signs)| (first_element + element as usize, signs)));
        (first_node, first_element) = (first_node + part.nodes.len(), first_element + part.element_count());
    }
    let mut vtu = Vtu::of_bodies(&meshes, lift_mm)?;
    let solved = Solved { problem: &pressed.assembly.problem, state: &step.state, points: &step.points };
    solved.fields(&mut vtu, &nodes, &elements)?;
    Ok(vtu)
}

/// A state in balance, as files for ParaView tell it.
pub(super) struct Solved<'a> {
    pub problem: &'a Problem,
    pub state: &'a State,
    /// Nodes of the touched face.
    pub points: &'a [ContactPoint],
}

/// A node or an element of the problem, and the signs of its mirror image.
type Image = (usize, [f64; 3]);

impl Solved<'_> {
    /// The file of the problem's own mesh.
    pub fn vtu(&self) -> Result<Vtu, VtuError> {
        let images = |count: usize| (0..count).map(|k| (k, [1.0; 3])).collect::<Vec<_>>();
        let mesh = &self.problem.mesh;
        let mut vtu = Vtu::of_bodies(&[mesh], 0.0)?;
        self.fields(&mut vtu, &images(mesh.nodes.len()), &images(mesh.element_count()))?;
        Ok(vtu)
    }

    /// Adds displacements, contact, pressure and stress at the images of the problem's nodes and elements.
    fn fields(&self, vtu: &mut Vtu, nodes: &[Image], elements: &[Image]) -> Result<(), VtuError> {
        let Self { problem, state, points } = self;
        let moved = |&(node, signs): &Image| [0, 1, 2].map(|i| signs[i] * state.displacement[node][i]);
        vtu.point_vectors("displacement_mm", &nodes.iter().map(moved).collect::<Vec<_>>())?;
        let mut contact = vec![[0.0; 2]; problem.mesh.nodes.len()];
        for point in *points {
            contact[point.node as usize] = [point.pressure_kpa, point.shear_kpa];
        }
        for (k, name) in ["contact_pressure_kpa", "contact_shear_kpa"].into_iter().enumerate() {
            let values = nodes.iter().map(|&(node, _)| contact[node][k]).collect();
            vtu.point_field(name, 1, Values::Float(values))?;
        }
        let size = problem.mesh.element_size();
        let pressure = element_pressure(problem, state);
        let mean: Vec<f64> = pressure.chunks(size).map(|nodes| nodes.iter().sum::<f64>() / size as f64).collect();
        let least = element_least_jacobian(problem, state);
        for (name, values) in [("pressure_kpa", mean), ("least_jacobian", least)] {
            let values = elements.iter().map(|&(element, _)| values[element]).collect();
            vtu.cell_field(name, 1, Values::Float(values))?;
        }
        let stress = element_stress(problem, state);
        // VTK's order: xx, yy, zz, xy, yz, xz. In two dimensions the mesh's axes are x (or r), z, and the third: y, or
        // the hoop's.
        let [x, y, z] = if problem.mesh.dim == 2 { [0, 2, 1] } else { [0, 1, 2] };
        let order = [[x, x], [y, y], [z, z], [x, y], [y, z], [x, z]];
        let values = elements.iter().flat_map(|&(element, signs)| {
            let stress = stress[element];
            order.map(|[i, j]| if i == j { stress[i][j] } else { signs[i] * signs[j] * stress[i][j] })
        });
        vtu.cell_field("stress_kpa", 6, Values::Float(values.collect()))
    }
}
