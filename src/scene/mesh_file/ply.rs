//! PLY, text and binary little-endian: `x y z` of the vertices and the index lists of the faces; all other elements and
//! properties are passed over.

use super::TriangleMesh;
use crate::scene::data_file::Defect;

/// Header lines; scanners write a dozen.
const MAX_HEADER_LINES: usize = 1000;

pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, Defect> {
    let (header, mut body) = header(bytes)?;
    let mut mesh = TriangleMesh::default();
    let mut row = Row::default();
    for element in &header {
        // Without properties an element takes no bytes, and its count no bound.
        let count = if element.properties.is_empty() { 0 } else { element.count };
        for index in 0..count {
            let read = body.row(element, &mut row).ok_or_else(|| "ends or is no number".to_owned());
            let added = read.and_then(|()| match element.name.as_str() {
                "vertex" => mesh.add_vertex(row.position).map(|_| ()),
                "face" => mesh.add_polygon(&row.corners),
                _ => Ok(()),
            });
            added.map_err(|message| Defect::new(None, format!("{} {index}: {message}", element.name)))?;
        }
    }
    Ok(mesh)
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

struct Property {
    name: String,
    /// Type of the length, where it is a list.
    length: Option<Number>,
    number: Number,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }
}

/// What the mesh takes from one row of an element.
#[derive(Default)]
struct Row {
    position: [f64; 3],
    corners: Vec<u32>,
}

enum Body<'b> {
    Text(Box<dyn Iterator<Item = &'b [u8]> + 'b>),
    Binary(&'b [u8]),
}

impl Body<'_> {
    fn row(&mut self, element: &Element, row: &mut Row) -> Option<()> {
        *row = Row { position: [f64::NAN; 3], corners: std::mem::take(&mut row.corners) };
        row.corners.clear();
        for property in &element.properties {
            match property.length {
                None => {
                    let value = self.number(property.number)?;
                    let axis = ["x", "y", "z"].iter().position(|axis| *axis == property.name);
                    if let Some(coordinate) = axis.and_then(|axis| row.position.get_mut(axis)) {
                        *coordinate = value;
                    }
                }
                Some(length) => {
                    let length = whole(self.number(length)?)?;
                    let corners = matches!(property.name.as_str(), "vertex_indices" | "vertex_index");
                    for _ in 0..length {
                        let value = self.number(property.number)?;
                        if corners {
                            row.corners.push(whole(value)?);
                        }
                    }
                }
            }
        }
        Some(())
    }

    fn number(&mut self, number: Number) -> Option<f64> {
        match self {
            Self::Text(words) => std::str::from_utf8(words.next()?).ok()?.parse().ok(),
            Self::Binary(bytes) => Some(match number {
                Number::I8 => f64::from(i8::from_le_bytes(take(bytes)?)),
                Number::U8 => f64::from(u8::from_le_bytes(take(bytes)?)),
                Number::I16 => f64::from(i16::from_le_bytes(take(bytes)?)),
                Number::U16 => f64::from(u16::from_le_bytes(take(bytes)?)),
                Number::I32 => f64::from(i32::from_le_bytes(take(bytes)?)),
                Number::U32 => f64::from(u32::from_le_bytes(take(bytes)?)),
                Number::F32 => f64::from(f32::from_le_bytes(take(bytes)?)),
                Number::F64 => f64::from_le_bytes(take(bytes)?),
            }),
        }
    }
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}

fn whole(value: f64) -> Option<u32> {
    (value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value)).then_some(value as u32)
}

fn header(bytes: &[u8]) -> Result<(Vec<Element>, Body<'_>), Defect> {
    let mut elements: Vec<Element> = Vec::new();
    let mut is_text = None;
    let mut rest = bytes;
    for line in 1..=MAX_HEADER_LINES {
        let end = rest.iter().position(|&byte| byte == b'\n');
        let Some((content, after)) = end.and_then(|end| Some((rest.get(..end)?, rest.get(end + 1..)?))) else {
            break;
        };
        rest = after;
        let content = String::from_utf8_lossy(content);
        let words: Vec<&str> = content.split_whitespace().collect();
        let wrong = |message: &str| Defect::new(line, format!("{message}, is {:?}", content.trim()));
        if line == 1 && words != ["ply"] {
            break;
        }
        match words.as_slice() {
            ["format", "ascii", _] => is_text = Some(true),
            ["format", "binary_little_endian", _] => is_text = Some(false),
            ["format", ..] => {
                return Err(wrong("the format must be ascii or binary_little_endian"));
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| wrong("an element must be a name and a count"))?;
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            ["property", definition @ ..] => {
                let property =
                    property(definition).ok_or_else(|| wrong("a property must be a known type and a name"))?;
                match elements.last_mut() {
                    Some(element) => element.properties.push(property),
                    None => return Err(wrong("a property must follow its element")),
                }
            }
            ["end_header"] => {
                let text = is_text.ok_or_else(|| wrong("the format must come before the end of the header"))?;
                let words = rest.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
                return Ok((elements, if text { Body::Text(Box::new(words)) } else { Body::Binary(rest) }));
            }
            _ => {}
        }
    }
    Err(Defect::new(None, "is no PLY file: it must begin with ply and have a header up to end_header"))
}

fn property(words: &[&str]) -> Option<Property> {
    let (length, number, name) = match words {
        ["list", length, number, name] => (Some(Number::named(length)?), number, name),
        [number, name] => (None, number, name),
        _ => return None,
    };
    Some(Property { name: (*name).to_owned(), length, number: Number::named(number)? })
}
