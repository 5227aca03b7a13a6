//! The press: nonlinear finite elements of phantom, inclusion and sensor in contact.
//!
//! Lengths are mm and stresses kPa, so forces are mN. The undeformed touched face is the plane z = 0; tissue lies above
//! it (z > 0), the sensor below. In two dimensions the axes are (x, z) in plane strain and (r, z) in axisymmetry; z is
//! always the last one.

pub mod contact;
pub mod element;
pub mod frames;
pub mod from_scene;
pub mod kinematics;
pub mod material;
pub mod memory;
pub mod mesh;
pub mod multigrid;
pub mod newton;
pub mod ordering;
pub mod path;
pub mod press;
pub mod problem;
pub mod read_out;
pub mod solid;
pub mod sparse;
