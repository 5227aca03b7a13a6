//! A press for ParaView: deformed.vtu of the last load, those before it, and deformed.pvd, which lists them all.

use super::PageError;
use crate::mechanics::mesh::Whole;
use crate::mechanics::press::{PressStep, Pressed, element_least_jacobian, element_pressure, element_stress};
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
    let problem = &pressed.assembly.problem;
    let meshes: Vec<_> = wholes.iter().map(|whole| &whole.mesh).collect();
    let mut vtu = Vtu::of_bodies(&meshes, lift_mm)?;
    let (mut first_node, mut first_element) = (0, 0);
    let (mut nodes, mut elements) = (Vec::new(), Vec::new());
    for (whole, part) in wholes.iter().zip(&pressed.assembly.bodies) {
        nodes.extend(whole.nodes.iter().map(|&(node, signs)| (first_node + node as usize, signs)));
        elements.extend(whole.elements.iter().map(|&(element, signs)| (first_element + element as usize, signs)));
        (first_node, first_element) = (first_node + part.nodes.len(), first_element + part.element_count());
    }
    let moved = |&(node, signs): &(usize, [f64; 3])| [0, 1, 2].map(|i| signs[i] * step.state.displacement[node][i]);
    vtu.point_vectors("displacement_mm", &nodes.iter().map(moved).collect::<Vec<_>>())?;
    let mut contact = vec![[0.0; 2]; problem.mesh.nodes.len()];
    for point in &step.points {
        contact[point.node as usize] = [point.pressure_kpa, point.shear_kpa];
    }
    for (k, name) in ["contact_pressure_kpa", "contact_shear_kpa"].into_iter().enumerate() {
        let values = nodes.iter().map(|&(node, _)| contact[node][k]).collect();
        vtu.point_field(name, 1, Values::Float(values))?;
    }
    let size = problem.mesh.element_size();
    let pressure = element_pressure(problem, &step.state);
    let mean: Vec<f64> = pressure.chunks(size).map(|nodes| nodes.iter().sum::<f64>() / size as f64).collect();
    let least = element_least_jacobian(problem, &step.state);
    for (name, values) in [("pressure_kpa", mean), ("least_jacobian", least)] {
        let values = elements.iter().map(|&(element, _)| values[element]).collect();
        vtu.cell_field(name, 1, Values::Float(values))?;
    }
    let stress = element_stress(problem, &step.state);
    // VTK's order: xx, yy, zz, xy, yz, xz. In two dimensions the mesh's axes are x (or r), z, and y (or the hoop's).
    let [x, y, z] = if problem.mesh.dim == 2 { [0, 2, 1] } else { [0, 1, 2] };
    let order = [[x, x], [y, y], [z, z], [x, y], [y, z], [x, z]];
    let values = elements.iter().flat_map(|&(element, signs)| {
        let stress = stress[element];
        order.map(|[i, j]| if i == j { stress[i][j] } else { signs[i] * signs[j] * stress[i][j] })
    });
    vtu.cell_field("stress_kpa", 6, Values::Float(values.collect()))?;
    Ok(vtu)
}
