//! Deformed meshes as a VTU file (XML UnstructuredGrid of VTK, for ParaView).
//!
//! Points are the undeformed places; the displacement is a vector field, so that ParaView's "Warp By Vector" shows any
//! share of it. Quadratic elements are written as such (VTK types 28 and 29). In two dimensions the first axis (x or r)
//! becomes VTK's x, z stays z and y is 0: a section lies in a three-dimensional scene where it belongs. Arrays are
//! base64 of little-endian numbers with a 64-bit length before each, so the file is plain XML and small enough.
//! Format: "VTK File Formats for VTK 4.2 and later", Kitware.

use crate::mechanics::mesh::Mesh;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Lattice node (first axis fastest) at each place of VTK_BIQUADRATIC_QUAD: corners around, edges around, middle.
const QUAD_ORDER: [usize; 9] = [0, 2, 8, 6, 1, 5, 7, 3, 4];
/// The same for VTK_TRIQUADRATIC_HEXAHEDRON: 8 corners; 4 edges below, 4 above, 4 upright; the faces at -x, +x, -y, +y,
/// -z, +z; the middle. The faces are as VTK's code numbers them (vtkTriQuadraticHexahedron.cxx, `HexFaces`); the list
/// in that class's documentation begins with another face.
const HEXAHEDRON_ORDER: [usize; 27] =
    [0, 2, 8, 6, 18, 20, 26, 24, 1, 5, 7, 3, 19, 23, 25, 21, 9, 11, 17, 15, 12, 14, 10, 16, 4, 22, 13];

/// Values of a field, one tuple for each point or cell.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers, all finite.
    Float(Vec<f64>),
    /// Labels.
    Integer(Vec<i32>),
}

/// A named field.
#[derive(Debug, Clone, PartialEq)]
struct Field {
    name: String,
    components: usize,
    values: Values,
}

/// A file in the making.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Vtu {
    points: Vec<[f64; 3]>,
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    types: Vec<u8>,
    point_data: Vec<Field>,
    cell_data: Vec<Field>,
    /// Whether each point comes from a mesh in two dimensions.
    planar: Vec<bool>,
}

/// What cannot be written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VtuError {
    /// A field has not one tuple for each point or cell.
    #[error("field {name:?} has {values} values, needs {needed}")]
    Length {
        /// Name of the field.
        name: String,
        /// How many it has.
        values: usize,
        /// How many it must have.
        needed: usize,
    },
    /// A field or the points hold a number that is not finite.
    #[error("field {0:?} holds a number that is not finite")]
    NotFinite(String),
    /// An element names a node that the mesh does not have, or a mesh is not in 2 or 3 dimensions.
    #[error("body {0}: elements do not fit its nodes")]
    Mesh(usize),
}

impl Vtu {
    /// The undeformed bodies, lifted by `lift_mm` (the height of the touched face in the scene), with the cell data
    /// `body` (0, 1, ... in order) and `region`.
    ///
    /// # Errors
    /// Where an element names a node that is not there, or a coordinate is not finite.
    pub fn of_bodies(bodies: &[&Mesh], lift_mm: f64) -> Result<Self, VtuError> {
        let mut vtu = Self::default();
        let (mut body, mut region) = (Vec::new(), Vec::new());
        for (i, mesh) in bodies.iter().enumerate() {
            vtu.add_cells(mesh).ok_or(VtuError::Mesh(i))?;
            vtu.planar.resize(vtu.planar.len() + mesh.nodes.len(), mesh.dim == 2);
            vtu.points.extend(mesh.nodes.iter().map(|&node| spatial(node, mesh.dim == 2)));
            body.resize(body.len() + mesh.element_count(), i as i32);
            region.extend(mesh.region.iter().map(|&r| r as i32));
        }
        for point in &mut vtu.points {
            point[2] += lift_mm;
        }
        if vtu.points.as_flattened().iter().any(|v| !v.is_finite()) {
            return Err(VtuError::NotFinite("points".to_owned()));
        }
        vtu.cell_field("body", 1, Values::Integer(body))?;
        vtu.cell_field("region", 1, Values::Integer(region))?;
        Ok(vtu)
    }

    /// Appends a mesh's cells in VTK's order; its points come after those that are there.
    fn add_cells(&mut self, mesh: &Mesh) -> Option<()> {
        let (order, kind): (&[usize], u8) = match mesh.dim {
            2 => (&QUAD_ORDER, 28),
            3 => (&HEXAHEDRON_ORDER, 29),
            _ => return None,
        };
        if mesh.elements.len() != mesh.element_count() * order.len() {
            return None;
        }
        let first = self.points.len() as i64;
        for nodes in mesh.elements.chunks_exact(order.len()) {
            for &place in order {
                let node = nodes[place];
                mesh.nodes.get(node as usize)?;
                self.connectivity.push(first + i64::from(node));
            }
            self.offsets.push(self.connectivity.len() as i64);
            self.types.push(kind);
        }
        Some(())
    }

    /// Adds vectors at the points (all bodies' nodes in order) in the axes of the mesh, such as `displacement_mm`.
    ///
    /// # Errors
    /// Where there is not one for each point, or a number is not finite.
    pub fn point_vectors(&mut self, name: &str, vectors: &[[f64; 3]]) -> Result<(), VtuError> {
        let turned = vectors.iter().zip(&self.planar).flat_map(|(&v, &planar)| spatial(v, planar));
        let mut values: Vec<f64> = turned.collect();
        // A surplus is not cut off in silence.
        values.resize(3 * vectors.len(), 0.0);
        self.point_field(name, 3, Values::Float(values))
    }

    /// Adds a field at the points.
    ///
    /// # Errors
    /// As of [`Vtu::point_vectors`].
    pub fn point_field(&mut self, name: &str, components: usize, values: Values) -> Result<(), VtuError> {
        let field = checked(name, components, values, self.points.len())?;
        self.point_data.push(field);
        Ok(())
    }

    /// Adds a field of the cells (all bodies' elements in order), such as `pressure_kpa` or `min_jacobian`.
    ///
    /// # Errors
    /// As of [`Vtu::point_vectors`].
    pub fn cell_field(&mut self, name: &str, components: usize, values: Values) -> Result<(), VtuError> {
        let field = checked(name, components, values, self.types.len())?;
        self.cell_data.push(field);
        Ok(())
    }

    /// The file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let (points, cells) = (self.points.len(), self.types.len());
        let mut xml = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">\n"
        );
        fields(&mut xml, "PointData", &self.point_data);
        fields(&mut xml, "CellData", &self.cell_data);
        xml.push_str("<Points>\n");
        let places = self.points.as_flattened().iter().flat_map(|v| v.to_le_bytes());
        array(&mut xml, "Float64", "Points", 3, places.collect());
        xml.push_str("</Points>\n<Cells>\n");
        let longs = |values: &[i64]| values.iter().flat_map(|v| v.to_le_bytes()).collect();
        array(&mut xml, "Int64", "connectivity", 1, longs(&self.connectivity));
        array(&mut xml, "Int64", "offsets", 1, longs(&self.offsets));
        array(&mut xml, "UInt8", "types", 1, self.types.clone());
        xml.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
        xml.into_bytes()
    }
}

/// Mesh axes to VTK's: (x, z, 0) of a plane to (x, 0, z).
fn spatial([a, b, c]: [f64; 3], planar: bool) -> [f64; 3] {
    if planar { [a, 0.0, b] } else { [a, b, c] }
}

fn checked(name: &str, components: usize, values: Values, tuples: usize) -> Result<Field, VtuError> {
    let (count, finite) = match &values {
        Values::Float(v) => (v.len(), v.iter().all(|v| v.is_finite())),
        Values::Integer(v) => (v.len(), true),
    };
    if components.checked_mul(tuples) != Some(count) {
        let needed = components.saturating_mul(tuples);
        return Err(VtuError::Length { name: name.to_owned(), values: count, needed });
    }
    if !finite {
        return Err(VtuError::NotFinite(name.to_owned()));
    }
    Ok(Field { name: name.to_owned(), components, values })
}

fn fields(xml: &mut String, element: &str, fields: &[Field]) {
    xml.push_str(&format!("<{element}>\n"));
    for field in fields {
        match &field.values {
            Values::Float(v) => {
                let bytes = v.iter().flat_map(|v| v.to_le_bytes()).collect();
                array(xml, "Float64", &field.name, field.components, bytes);
            }
            Values::Integer(v) => {
                let bytes = v.iter().flat_map(|v| v.to_le_bytes()).collect();
                array(xml, "Int32", &field.name, field.components, bytes);
            }
        }
    }
    xml.push_str(&format!("</{element}>\n"));
}

/// One array: the count of its bytes and the bytes, in base64.
fn array(xml: &mut String, kind: &str, name: &str, components: usize, bytes: Vec<u8>) {
    let mut data = (bytes.len() as u64).to_le_bytes().to_vec();
    data.extend(bytes);
    let name = maud::Render::render(name).into_string();
    let data = STANDARD.encode(data);
    xml.push_str(&format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">{data}</DataArray>\n"
    ));
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
