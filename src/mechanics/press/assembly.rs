//! From the description of a press to its boundary value problem.

use super::{AssemblyError, SensorBody, Setup, tilt};
use crate::mechanics::contact::{Contact, Counterpart, Grip, Profile};
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::mesh::{Boundary, Facet, Footprint, Mesh, SensorMesh};
use crate::mechanics::problem::{Problem, Support};
use std::collections::HashSet;

/// A press as a problem; the load factor is the motion of the phantom's base in mm.
#[derive(Debug, Clone)]
pub struct Assembly {
    /// The problem. Its first contact is that of the touched face; where a soft sensor is tied, a second one is that of
    /// the face around it with the sensor's side wall.
    pub problem: Problem,
    /// Nodes of the phantom; the sensor's come after them.
    pub phantom_nodes: usize,
    /// Elements of the phantom; the sensor's come after them.
    pub phantom_elements: usize,
    /// Meshes of the bodies, phantom first.
    pub bodies: Vec<Mesh>,
}

/// How far beyond the sensor's edge the phantom's face may come into contact, as a share of the sensor's radius.
const MARGIN: f64 = 1.3;

/// The same of an indenter's footprint, where its profile lies as deep as it is pressed in. Contact ends at 0.6 to 0.7
/// of it on a half space; tissue that gives way nowhere but upwards rises to 1.41 times it at a ball, 1.5 at a cone.
const RAISED: f64 = 2.0;

impl Assembly {
    /// Meshes the bodies and brings them together.
    ///
    /// # Errors
    /// Geometry that cannot be meshed, a setting that is not supported.
    pub fn new(setup: &Setup) -> Result<Self, AssemblyError> {
        let (inclusions, layers) = (setup.phantom.inclusions.len(), setup.phantom.layers_mm.len());
        let (needed, given) = (1 + inclusions + layers, setup.phantom_materials.len());
        if given != needed {
            let message = format!(
                "the phantom, its {inclusions} inclusions and {layers} layers need {needed} materials, {given} given"
            );
            return Err(AssemblyError::Unsupported(message));
        }
        let flat = setup.kinematics != Kinematics::ThreeDimensional;
        let body = setup.body();
        let mut phantom = if flat { body.build_2d()? } else { body.build_3d()? };
        tilt::turn(setup, &mut phantom)?;
        let (phantom_nodes, phantom_elements) = (phantom.nodes.len(), phantom.element_count());
        let mut materials = setup.phantom_materials.clone();
        let mut bodies = vec![phantom.clone()];
        let mut supports = supports(&phantom, 0, setup.kinematics, Boundary::Base, -1.0);
        tilt::turn_base(setup, &phantom, &mut supports)?;
        let mut mesh = phantom;
        let mut wall = None;
        let pair = match &setup.sensor {
            SensorBody::Rigid { edge_radius_mm } => rigid(setup, &mesh, *edge_radius_mm)?,
            SensorBody::Indenter(profile) => indenter(setup, &mesh, profile)?,
            SensorBody::Layers { layers, edge_radius_mm } => {
                let sensor = SensorMesh {
                    footprint: setup.phantom.footprint,
                    layers_mm: layers.iter().map(|(thickness, _)| *thickness).collect(),
                    symmetry: setup.phantom.symmetry,
                    resolution: body.resolution,
                    edge_radius_mm: *edge_radius_mm,
                };
                let sensor = if flat { sensor.build_2d(Some(&body))? } else { sensor.build_3d(Some(&body))? };
                supports.extend(self::supports(
                    &sensor,
                    mesh.nodes.len() as u32,
                    setup.kinematics,
                    Boundary::Base,
                    0.0,
                ));
                let face = mesh.boundary_facets(Boundary::Touched).into_iter();
                let face: Vec<Facet> =
                    face.filter(|&facet| within(&mesh, facet, MARGIN * reach(setup) + setup.slide_mm())).collect();
                let first = append(&mut mesh, &sensor, materials.len() as u32);
                materials.extend(layers.iter().map(|(_, material)| material.clone()));
                let of_sensor = |boundary| {
                    let facets = sensor.boundary_facets(boundary).into_iter();
                    facets.map(|facet| Facet { element: facet.element + first, ..facet }).collect::<Vec<Facet>>()
                };
                let (touched, side) = (of_sensor(Boundary::Touched), of_sensor(Boundary::Side));
                let nodes = |facets: &[Facet]| facets.iter().map(|&facet| mesh.facet_nodes(facet)).collect();
                let pair = if setup.grip == Grip::Bonded {
                    // Where the bond ends the face folds up, and meets the sensor's side wall.
                    let beyond: Vec<Facet> = face.iter().copied().filter(|&f| !covered(setup, &mesh, f)).collect();
                    if !beyond.is_empty() {
                        wall = Some((beyond, Counterpart::Face(nodes(&side)), 1.0));
                    }
                    (touched, Counterpart::Face(nodes(&face)), -1.0)
                } else if flat {
                    // The softer face carries the pressure, and may wrap around the sensor's rim.
                    (face, Counterpart::Face(nodes(&[touched, side].concat())), 1.0)
                } else {
                    // In three dimensions the smaller face carries it: it costs less.
                    (touched, Counterpart::Face(nodes(&face)), -1.0)
                };
                bodies.push(sensor);
                pair
            }
        };
        let shear = face_shear_kpa(setup);
        let contact = |(facets, counterpart, side): (Vec<Facet>, Counterpart, f64), grip: Grip| {
            Contact::new(setup.kinematics, &mesh, &facets, counterpart, grip, shear, side)
        };
        let wall = wall.map(|pair| contact(pair, Grip::Frictionless));
        let contacts = std::iter::once(contact(pair, setup.grip)).chain(wall).collect();
        let problem = Problem {
            pressure: setup.pressure,
            supports,
            contacts,
            seconds_per_load: setup.seconds_per_mm,
            time_steps: setup.time_steps,
            stride: setup.stride_mm(),
            ..Problem::free(setup.kinematics, mesh, materials)
        };
        Ok(Self { problem, phantom_nodes, phantom_elements, bodies })
    }
}

/// Touched facets of the phantom and the rigid sensor's profile.
fn rigid(setup: &Setup, mesh: &Mesh, edge_radius_mm: f64) -> Result<(Vec<Facet>, Counterpart, f64), AssemblyError> {
    let center = [0.0; 2];
    let touched = mesh.boundary_facets(Boundary::Touched).into_iter();
    if setup.grip == Grip::Bonded {
        let facets = touched.filter(|&facet| covered(setup, mesh, facet)).collect();
        return Ok((facets, Counterpart::Rigid { profile: Profile::Flat, center }, 1.0));
    }
    let Footprint::Round { radius_mm } = setup.phantom.footprint else {
        let message = "a rigid rectangular sensor can only be tied; give it soft layers or a round footprint";
        return Err(AssemblyError::Unsupported(message.into()));
    };
    let profile = Profile::RoundedFlat { flat_mm: radius_mm - edge_radius_mm, edge_radius_mm };
    let facets = touched.filter(|&facet| within(mesh, facet, MARGIN * radius_mm + setup.slide_mm())).collect();
    Ok((facets, Counterpart::Rigid { profile, center }, 1.0))
}

/// Facets of the phantom that an indenter may touch, and its profile.
fn indenter(setup: &Setup, mesh: &Mesh, profile: &Profile) -> Result<(Vec<Facet>, Counterpart, f64), AssemblyError> {
    if setup.grip == Grip::Bonded {
        return Err(AssemblyError::Unsupported("a face that sticks from the start cannot wrap an indenter".into()));
    }
    let touched = mesh.boundary_facets(Boundary::Touched).into_iter();
    let reach = RAISED * reach(setup) + setup.slide_mm();
    let facets = touched.filter(|&facet| within(mesh, facet, reach)).collect();
    Ok((facets, Counterpart::Rigid { profile: profile.clone(), center: [0.0; 2] }, 1.0))
}

/// Shear modulus of the softer of the two faces, kPa. What lies deeper does not matter to the contact: an inclusion a
/// million times softer would make the tangent's spring too weak to close the gap.
fn face_shear_kpa(setup: &Setup) -> f64 {
    let top = match &setup.sensor {
        SensorBody::Rigid { .. } | SensorBody::Indenter(_) => None,
        SensorBody::Layers { layers, .. } => layers.last().map(|(_, material)| material),
    };
    let faces = setup.touched_material().into_iter().chain(top);
    faces.map(|material| material.law.shear_kpa()).fold(f64::INFINITY, f64::min)
}

fn reach(setup: &Setup) -> f64 {
    match setup.phantom.footprint {
        Footprint::Round { radius_mm } => radius_mm,
        Footprint::Rectangle { half_widths_mm: [x, y] } if setup.kinematics.dim() == 3 => x.hypot(y),
        Footprint::Rectangle { half_widths_mm } => half_widths_mm[0],
    }
}

/// Whether a facet lies within a distance of the axis.
fn within(mesh: &Mesh, facet: Facet, distance: f64) -> bool {
    mesh.facet_nodes(facet).iter().all(|&a| across(mesh, a) <= distance * (1.0 + 1e-9))
}

/// Distance of a node from the axis.
fn across(mesh: &Mesh, node: u32) -> f64 {
    let x = mesh.nodes[node as usize];
    if mesh.dim == 3 { x[0].hypot(x[1]) } else { x[0].abs() }
}

/// Whether a facet lies under the sensor.
fn covered(setup: &Setup, mesh: &Mesh, facet: Facet) -> bool {
    match setup.phantom.footprint {
        Footprint::Rectangle { half_widths_mm } if mesh.dim == 3 => mesh.facet_nodes(facet).iter().all(|&a| {
            let x = mesh.nodes[a as usize];
            (0..2).all(|i| x[i].abs() <= half_widths_mm[i] * (1.0 + 1e-9))
        }),
        _ => within(mesh, facet, reach(setup)),
    }
}

/// Supports of one body: its base moves along z with the load (`along_z` per mm), symmetry planes slide.
pub fn supports(mesh: &Mesh, first: u32, kinematics: Kinematics, base: Boundary, along_z: f64) -> Vec<Support> {
    let dim = kinematics.dim();
    let mut held = HashSet::new();
    let mut supports = Vec::new();
    let mut hold = |node: u32, axis: usize, displacement_mm: f64| {
        if held.insert((node, axis)) {
            supports.push(Support { node: node + first, axis, displacement_mm });
        }
    };
    for node in mesh.boundary_nodes(base) {
        (0..dim - 1).for_each(|axis| hold(node, axis, 0.0));
        hold(node, dim - 1, along_z);
    }
    mesh.boundary_nodes(Boundary::SymmetryX).into_iter().for_each(|node| hold(node, 0, 0.0));
    mesh.boundary_nodes(Boundary::SymmetryY).into_iter().for_each(|node| hold(node, 1, 0.0));
    supports
}

/// Adds a body to a mesh, its regions from `first_region`; the number of its first element.
fn append(mesh: &mut Mesh, body: &Mesh, first_region: u32) -> u32 {
    let (nodes, elements) = (mesh.nodes.len() as u32, mesh.element_count() as u32);
    mesh.nodes.extend(&body.nodes);
    mesh.elements.extend(body.elements.iter().map(|a| a + nodes));
    mesh.region.extend(body.region.iter().map(|region| region + first_region));
    mesh.facets.extend(body.facets.iter().map(|facet| Facet { element: facet.element + elements, ..*facet }));
    elements
}
