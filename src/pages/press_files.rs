//! Files and pictures of a press.

use super::PageError;
use super::facts::load_name;
use super::press_vtu::write_vtu;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::press::{ContactPoint, Load, PressStep, Pressed, element_pressure, is_judged};
use crate::output::OutputFolder;
use crate::pipeline::setting;
use crate::report::{AxisName, ColorScale, Curve, CurvePlot, CurveStyle, Raster, curve_plot, false_color};
use crate::report::{MeshBody, MeshPicture, MeshValues, mesh_picture};
use crate::surface::pressed::pressure_map;
use std::fmt::Write;

/// The pictures of a press, as SVG.
pub struct PressPictures {
    /// Deformed mesh; none in three dimensions.
    pub mesh: Option<String>,
    /// Contact pressure along r, or over the face in three dimensions.
    pub pressure: String,
}

/// Writes contact.csv, deformed.vtu and deformed.pvd, and the pictures.
pub fn write_press(
    name: &str,
    pressed: &Pressed,
    lift_mm: f64,
    folder: &OutputFolder,
) -> Result<PressPictures, PageError> {
    folder.write("contact.csv", &contact_csv(pressed))?;
    write_vtu(pressed, lift_mm, folder)?;
    let pictures = pictures(name, pressed)?;
    if let Some(mesh) = &pictures.mesh {
        folder.write("mesh.svg", mesh)?;
    }
    folder.write("pressure.svg", &pictures.pressure)?;
    Ok(pictures)
}

/// All loads below one another, nodes of the touched face by place.
fn contact_csv(pressed: &Pressed) -> String {
    let solid = pressed.setup.kinematics == Kinematics::ThreeDimensional;
    let (place, moved) = match solid {
        true => ("x_mm,y_mm", "displacement_x_mm,displacement_y_mm,displacement_z_mm"),
        false => ("r_mm", "displacement_r_mm,displacement_z_mm"),
    };
    let in_steps = matches!(pressed.setup.load, Load::Path(_));
    let load = if in_steps { "step,depth_mm,slide_x_mm,slide_y_mm" } else { "depth_mm" };
    let mut csv = format!("{load},{place},pressure_kpa,shear_kpa,gap_mm,{moved}\n");
    for (number, step) in (1..).zip(&pressed.steps) {
        let [x, y] = step.slide_mm;
        let load = if in_steps { format!("{number},{},{x},{y}", step.depth_mm) } else { step.depth_mm.to_string() };
        for point in &step.points {
            let numbers =
                |v: [f64; 3], count: usize| v[..count].iter().map(|c| format!("{c:.9e}")).collect::<Vec<_>>().join(",");
            let dim = if solid { 3 } else { 2 };
            let _ = writeln!(
                csv,
                "{load},{},{:.9e},{:.9e},{:.9e},{}",
                numbers(point.reference_mm, dim - 1),
                point.pressure_kpa,
                point.shear_kpa,
                point.gap_mm,
                numbers(point.displacement_mm, dim)
            );
        }
    }
    csv
}

fn pictures(name: &str, pressed: &Pressed) -> Result<PressPictures, PageError> {
    let last = pressed.steps.last();
    let solid = pressed.setup.kinematics == Kinematics::ThreeDimensional;
    let mesh = match last.filter(|_| !solid) {
        Some(step) => Some(mesh(name, pressed, step)?),
        None => None,
    };
    let pressure = match last.filter(|_| solid) {
        Some(step) => map(name, pressed, step)?,
        None => curves(name, pressed)?,
    };
    Ok(PressPictures { mesh, pressure })
}

fn mesh(name: &str, pressed: &Pressed, step: &PressStep) -> Result<String, PageError> {
    let values = element_pressure(&pressed.assembly.problem, &step.state);
    let (mut node, mut value) = (0, 0);
    let bodies = pressed.assembly.bodies.iter().map(|mesh| {
        let (first_node, first_value) = (node, value);
        (node, value) = (node + mesh.nodes.len(), value + mesh.elements.len());
        MeshBody {
            mesh,
            displacement_mm: &step.state.displacement[first_node..node],
            values: MeshValues::ElementNode(&values[first_value..value]),
        }
    });
    let bodies = bodies.collect();
    Ok(mesh_picture(&MeshPicture {
        title: &format!("{name}: pressed by {}", load_name(step)),
        subtitle: &format!("phantom above, sensor below · {} · deformation to scale", setting(&pressed.setup)),
        bodies,
        values: AxisName { quantity: "pressure", unit: "kPa" },
        range: None,
        horizontal: "x",
        mirrored: true,
        view_mm: None,
    })?)
}

fn curves(name: &str, pressed: &Pressed) -> Result<String, PageError> {
    let curve = |step: &PressStep| {
        let points = drawn_pressure(pressed, step);
        Curve { name: load_name(step), points, band: Vec::new(), style: CurveStyle::Line }
    };
    Ok(curve_plot(&CurvePlot {
        title: &format!("{name}: contact pressure"),
        subtitle: "on the deformed touched face; the edge of a tied or sharp contact is singular",
        x: AxisName { quantity: "distance from the axis", unit: "mm" },
        y: AxisName { quantity: "pressure", unit: "kPa" },
        curves: pressed.steps.iter().map(curve).collect(),
        highest: Some(most_shown_kpa(pressed)).filter(|highest| *highest > 0.0),
        from_zero: true,
    })?)
}

/// Highest contact pressure that is drawn, kPa: the singular edge would press all else to the floor.
pub(super) fn most_shown_kpa(pressed: &Pressed) -> f64 {
    1.6 * pressed.steps.iter().map(|step| step.peak_pressure_kpa).fold(0.0, f64::max)
}

/// Contact pressure along the deformed face as it is drawn: places, mm, and pressures, kPa.
///
/// Towards a singular edge the nodes of quadratic elements lie in turn above and below the pressure. There each is
/// drawn as its mean with its neighbours, which leaves what is smooth where it was; contact.csv has the nodes' own.
pub(super) fn drawn_pressure(pressed: &Pressed, step: &PressStep) -> Vec<[f64; 2]> {
    let pressures: Vec<f64> = step.points.iter().map(|point| point.pressure_kpa).collect();
    let drawn = |(k, point): (usize, &ContactPoint)| {
        let place = point.reference_mm[0] + point.displacement_mm[0];
        let own = is_judged(&pressed.setup, point);
        [place, if own { point.pressure_kpa } else { mean_with_neighbours(&pressures, k) }]
    };
    step.points.iter().enumerate().map(drawn).collect()
}

/// Mean of a value of a row, twice, and its one or two neighbours.
fn mean_with_neighbours(values: &[f64], k: usize) -> f64 {
    let beside = [k.checked_sub(1), Some(k), Some(k), Some(k + 1)];
    let beside: Vec<f64> = beside.into_iter().flatten().filter_map(|k| values.get(k).copied()).collect();
    beside.iter().sum::<f64>() / beside.len() as f64
}

/// Cells along the longer side of the pressure's picture in three dimensions.
const MAP_CELLS: usize = 256;

fn map(name: &str, pressed: &Pressed, step: &PressStep) -> Result<String, PageError> {
    let reach = pressed.setup.phantom.footprint.half_widths_mm();
    let (columns, rows, mut values) = pressure_map(pressed, step, reach.map(|half| 2.0 * half), MAP_CELLS);
    values = values.chunks(columns).rev().flatten().copied().collect();
    let raster = Raster {
        width: columns,
        height: rows,
        values: &values,
        quantity: "pressure",
        unit: "kPa",
        mm_per_pixel: Some(2.0 * reach[0] / columns as f64),
    };
    Ok(false_color(&format!("{name}: contact pressure at {}", load_name(step)), &raster, ColorScale::Linear)?)
}

#[cfg(test)]
mod tests {
    use super::mean_with_neighbours;

    #[test]
    fn a_mean_with_neighbours_drops_what_goes_up_and_down_and_keeps_a_slope() {
        let values: Vec<f64> = (0..8).map(|k| 3.0 + 0.5 * f64::from(k) + if k % 2 == 0 { 2.0 } else { -2.0 }).collect();
        for k in 1..7 {
            assert!((mean_with_neighbours(&values, k) - (3.0 + 0.5 * k as f64)).abs() < 1e-12, "{k}");
        }
        assert!((mean_with_neighbours(&values, 0) - (2.0 * 5.0 + 1.5) / 3.0).abs() < 1e-12);
        assert!((mean_with_neighbours(&values, 7) - (2.0 * 4.5 + 8.0) / 3.0).abs() < 1e-12);
    }
}
