//! The header of a plain EXR: one part, scan lines, flat, without loss.
//!
//! The exr crate sets no limits of its own: a header of a few bytes can ask it for any amount of memory. So the header
//! is read here, against [`limits`](super::limits), and the crate decompresses only chunks whose sizes are known.
//! Layout: openexr.com, "OpenEXR File Layout".

use exr::meta::attribute::{Compression, SampleType};

const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
const VERSION: u32 = 2;
/// Flags in the version field: tiles, long names, deep data, several parts.
const TILED: u32 = 1 << 9;
const LONG_NAMES: u32 = 1 << 10;
const DEEP: u32 = 1 << 11;
const MULTI_PART: u32 = 1 << 12;
/// The name of this program's attribute.
pub(super) const PROVENANCE: &str = "tirtouch";

/// Why a header is refused.
#[derive(Debug, PartialEq)]
pub(super) enum Refusal {
    Damaged(String),
    Unsupported(String),
    TooLarge { what: &'static str, found: u64, limit: u64 },
}

/// One channel, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channel {
    pub name: String,
    pub kind: SampleType,
}

/// What the header says.
#[derive(Debug)]
pub(super) struct Header {
    pub width: usize,
    pub height: usize,
    pub first_line: i32,
    pub compression: Compression,
    pub channels: Vec<Channel>,
    pub provenance: Option<String>,
    /// Bytes from the file's start to the table of chunks.
    pub length: usize,
}

fn damaged<T>(reason: &str) -> Result<T, Refusal> {
    Err(Refusal::Damaged(reason.into()))
}

fn unsupported<T>(reason: &str) -> Result<T, Refusal> {
    Err(Refusal::Unsupported(reason.into()))
}

/// Reads little-endian values off a slice.
pub(super) struct Bytes<'a> {
    pub rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Refusal> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            return damaged("it ends too early");
        };
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Refusal> {
        let taken = self.take(N)?;
        taken.try_into().or_else(|_| damaged("it ends too early"))
    }

    pub fn i32(&mut self) -> Result<i32, Refusal> {
        self.array().map(i32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Result<u64, Refusal> {
        self.array().map(u64::from_le_bytes)
    }

    fn u8(&mut self) -> Result<u8, Refusal> {
        self.array().map(|[byte]| byte)
    }

    /// A length, which must not be negative.
    pub fn length(&mut self) -> Result<usize, Refusal> {
        usize::try_from(self.i32()?).or_else(|_| damaged("a length is negative"))
    }

    /// A null-terminated name of at most 255 bytes.
    fn name(&mut self) -> Result<String, Refusal> {
        let Some(end) = self.rest.iter().take(256).position(|&byte| byte == 0) else {
            return damaged("a name does not end");
        };
        let name = self.take(end)?;
        self.take(1)?;
        Ok(String::from_utf8_lossy(name).into_owned())
    }
}

/// Reads the header at the start of `file`.
pub(super) fn read(file: &[u8]) -> Result<Header, Refusal> {
    let mut bytes = Bytes { rest: file };
    if bytes.take(4)? != MAGIC {
        return damaged("it does not start like an EXR");
    }
    let version = u32::from_le_bytes(bytes.array()?);
    if version & 0xff != VERSION || version & !(0xff | TILED | LONG_NAMES | DEEP | MULTI_PART) != 0 {
        return unsupported("an EXR of another version than 2");
    }
    if version & (TILED | DEEP | MULTI_PART) != 0 {
        return unsupported("an EXR of tiles, deep data or several parts; write one flat part of scan lines");
    }
    let (mut window, mut compression, mut channels, mut provenance) = (None, None, None, None);
    loop {
        let name = bytes.name()?;
        if name.is_empty() {
            break;
        }
        let kind = bytes.name()?;
        let length = bytes.length()?;
        let mut value = Bytes { rest: bytes.take(length)? };
        match (name.as_str(), kind.as_str()) {
            ("dataWindow", "box2i") => window = Some(read_window(&mut value)?),
            ("compression", "compression") => compression = Some(read_compression(value.u8()?)?),
            ("channels", "chlist") => channels = Some(read_channels(&mut value)?),
            ("type", "string") if value.rest != b"scanlineimage" => {
                return unsupported("an EXR that is not of scan lines");
            }
            (PROVENANCE, "string") => provenance = String::from_utf8(value.rest.to_vec()).ok(),
            _ => {}
        }
    }
    let ([width, height], first_line) = window.map_or_else(|| damaged("its data window is missing"), Ok)?;
    Ok(Header {
        width,
        height,
        first_line,
        compression: compression.map_or_else(|| damaged("its compression is missing"), Ok)?,
        channels: channels.map_or_else(|| damaged("its channels are missing"), Ok)?,
        provenance,
        length: file.len() - bytes.rest.len(),
    })
}

/// Columns and rows of the data window, and the number of its first line.
fn read_window(value: &mut Bytes) -> Result<([usize; 2], i32), Refusal> {
    use super::limits::{DIMENSION, PIXELS};
    let [left, top, right, bottom] = [value.i32()?, value.i32()?, value.i32()?, value.i32()?];
    let extent = |low: i32, high: i32| {
        let extent = i64::from(high) - i64::from(low) + 1;
        u64::try_from(extent).ok().filter(|&extent| extent > 0)
    };
    let (Some(width), Some(height)) = (extent(left, right), extent(top, bottom)) else {
        return damaged("its data window is empty");
    };
    let numbers = [
        ("the width", width, DIMENSION),
        ("the height", height, DIMENSION),
        ("the number of pixels", width.saturating_mul(height), PIXELS),
    ];
    for (what, found, limit) in numbers {
        if found > limit {
            return Err(Refusal::TooLarge { what, found, limit });
        }
    }
    Ok(([width as usize, height as usize], top))
}

fn read_compression(code: u8) -> Result<Compression, Refusal> {
    match code {
        0 => Ok(Compression::Uncompressed),
        1 => Ok(Compression::RLE),
        2 => Ok(Compression::ZIP1),
        3 => Ok(Compression::ZIP16),
        4 => Ok(Compression::PIZ),
        5..=9 => unsupported("an EXR of lossy compression (PXR24, B44 or DWA); write it with ZIP, PIZ or none"),
        _ => unsupported("an EXR of unknown compression; write it with ZIP, PIZ or none"),
    }
}

fn read_channels(value: &mut Bytes) -> Result<Vec<Channel>, Refusal> {
    let mut channels = Vec::new();
    loop {
        let name = value.name()?;
        if name.is_empty() {
            break;
        }
        let kind = match value.i32()? {
            0 => SampleType::U32,
            1 => SampleType::F16,
            2 => SampleType::F32,
            _ => return damaged("a channel is of unknown type"),
        };
        value.take(4)?; // perceptual linearity and padding
        if [value.i32()?, value.i32()?] != [1, 1] {
            return unsupported("an EXR of subsampled channels; write every channel at full resolution");
        }
        channels.push(Channel { name, kind });
    }
    match channels.len() as u64 {
        0 => damaged("it has no channel"),
        found if found > super::limits::CHANNELS => {
            let limit = super::limits::CHANNELS;
            Err(Refusal::TooLarge { what: "the number of channels", found, limit })
        }
        _ => Ok(channels),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn attribute(name: &str, kind: &str, value: &[u8]) -> Vec<u8> {
        let length = (value.len() as i32).to_le_bytes();
        [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &length, value].concat()
    }

    fn channel(name: &str, sampling: i32) -> Vec<u8> {
        let numbers = [2_i32.to_le_bytes(), [0; 4], sampling.to_le_bytes(), 1_i32.to_le_bytes()].concat();
        [name.as_bytes(), b"\0", &numbers].concat()
    }

    fn file(version: u32, window: [i32; 4], compression: u8, channels: &[u8]) -> Vec<u8> {
        let window: Vec<u8> = window.iter().flat_map(|number| number.to_le_bytes()).collect();
        let channels = [channels, b"\0"].concat();
        let attributes = [
            attribute("channels", "chlist", &channels),
            attribute("compression", "compression", &[compression]),
            attribute("dataWindow", "box2i", &window),
        ];
        [&MAGIC[..], &version.to_le_bytes(), &attributes.concat(), b"\0"].concat()
    }

    #[test]
    fn a_plain_header_is_understood() {
        let bytes = file(2, [-3, -2, 4, 5], 3, &channel("mean", 1));
        let header = read(&bytes).unwrap();
        assert_eq!((header.width, header.height, header.first_line), (8, 8, -2));
        assert_eq!(header.compression, Compression::ZIP16);
        assert_eq!(header.channels, [Channel { name: "mean".into(), kind: SampleType::F32 }]);
        assert_eq!(header.length, bytes.len());
    }

    #[test]
    fn sizes_beyond_the_limits_are_refused_before_anything_is_allocated() {
        let one = channel("mean", 1);
        let windows = [[0, 0, i32::MAX, 0], [i32::MIN, 0, i32::MAX, 0], [0, 0, 0, 16_384], [0, 0, 16_383, 16_383]];
        for window in windows {
            let refused = read(&file(2, window, 3, &one)).unwrap_err();
            assert!(matches!(refused, Refusal::TooLarge { .. }), "{window:?}: {refused:?}");
        }
        let many: Vec<u8> = (0..17).flat_map(|number| channel(&format!("c{number}"), 1)).collect();
        assert!(matches!(read(&file(2, [0, 0, 7, 7], 3, &many)), Err(Refusal::TooLarge { found: 17, .. })));
        assert!(matches!(read(&file(2, [0, 0, -1, 7], 3, &one)), Err(Refusal::Damaged(_))));
    }

    #[test]
    fn kinds_that_are_not_read_are_named() {
        let one = channel("mean", 1);
        let plain = [0, 0, 7, 7];
        for bytes in [
            file(2 | TILED, plain, 3, &one),
            file(2 | MULTI_PART, plain, 3, &one),
            file(2 | DEEP, plain, 3, &one),
            file(3, plain, 3, &one),
            file(2, plain, 9, &one),
            file(2, plain, 3, &channel("chroma", 2)),
        ] {
            assert!(matches!(read(&bytes), Err(Refusal::Unsupported(_))));
        }
    }
}
