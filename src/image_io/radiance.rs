//! `radiance.exr`: a film and where it comes from.
//!
//! One part, two 32-bit float channels `mean` and `variance` (of the mean), linear, and one string attribute
//! `tirtouch` of JSON. The exr crate writes attributes in hash order, so there is only one: equal films give equal bytes.

use super::exr_chunks::with_exr;
use super::exr_header::PROVENANCE;
use super::{ImageError, limits};
use crate::film::{Film, Inflation};
use exr::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Where a radiance image comes from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// Unit of the mean.
    pub unit: String,
    /// Name of the scene.
    pub scene_name: String,
    /// SHA-256 of the scene file, hexadecimal.
    pub scene_sha256: String,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Camera paths per pixel.
    pub spp: u32,
    /// Photons sent from the LEDs.
    pub photons: u64,
    /// Independent replicates; written from the film.
    pub replicates: u32,
    /// Light-transport method.
    pub integrator: String,
    /// `gpu` or `cpu`.
    pub backend: String,
    /// The device that computed it.
    pub adapter: String,
    /// Version of this program.
    pub version: String,
    /// How the film's pixels hang together in blocks; written from the film.
    pub inflation: Vec<Inflation>,
}

/// Writes `film` as an EXR. Its blocks are kept as one inflation factor per level.
///
/// # Errors
/// When the film has no pixels, arrays that do not fit its size, or the file cannot be written.
pub fn write_radiance(path: &Path, film: &Film, provenance: &Provenance) -> std::result::Result<(), ImageError> {
    let refused = |reason: String| ImageError::Unsupported { path: path.into(), reason };
    let pixels = film.width as usize * film.height as usize;
    if pixels == 0 || film.mean.len() != pixels || film.variance.len() != pixels {
        return Err(refused("a film without pixels, or of another size than its arrays".into()));
    }
    limits::check_size(path, film.width.into(), film.height.into())?;
    let provenance = Provenance { replicates: film.replicates, inflation: film.inflation(), ..provenance.clone() };
    let json = serde_json::to_string(&provenance).map_err(|error| refused(error.to_string()))?;
    // EXR strings have no encoding: JSON escapes keep them ASCII.
    let mut ascii = String::with_capacity(json.len());
    for unit in json.encode_utf16() {
        match u8::try_from(unit) {
            Ok(byte) if byte.is_ascii() => ascii.push(byte.into()),
            _ => ascii.push_str(&format!("\\u{unit:04x}")),
        }
    }
    let text = Text::new_or_none(&ascii).ok_or_else(|| refused("provenance is not text".into()))?;
    let channel = |name: &str, values: &[f32]| AnyChannel::new(name, FlatSamples::F32(values.to_vec()));
    let channels =
        AnyChannels::sort([channel("mean", &film.mean), channel("variance", &film.variance)].into_iter().collect());
    let mut layer = Layer::new(
        (film.width as usize, film.height as usize),
        LayerAttributes::default(),
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing },
        channels,
    );
    layer.attributes.other.insert(Text::from(PROVENANCE), AttributeValue::Text(text));
    let mut bytes = std::io::Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
    written.map_err(|error| refused(error.to_string()))?;
    limits::write_file(path, bytes.get_ref())
}

/// Reads a film from a `radiance.exr`, or from a folder of `mean.exr` and `variance.exr` (variance of the mean), each of
/// one channel.
///
/// # Errors
/// When a file is missing, damaged, too large, lacks a channel or holds a value that is not finite.
pub fn read_radiance(path: &Path) -> std::result::Result<(Film, Option<Provenance>), ImageError> {
    if path.is_dir() {
        return read_folder(path).map(|film| (film, None));
    }
    let damaged = |reason: &str| ImageError::Damaged { path: path.into(), reason: reason.into() };
    with_exr(path, |file| {
        let find = |name: &str| {
            let found = file.header.channels.iter().position(|channel| channel.name == name);
            found.ok_or_else(|| {
                damaged(&format!("it has no channel `{name}`; a radiance.exr has `mean` and `variance`"))
            })
        };
        let (mean, variance) = (file.channel(find("mean")?)?, file.channel(find("variance")?)?);
        let size = [file.header.width, file.header.height];
        let provenance = match &file.header.provenance {
            None => None,
            Some(json) => Some(
                serde_json::from_str::<Provenance>(json)
                    .map_err(|error| damaged(&format!("its `{PROVENANCE}` attribute: {error}")))?,
            ),
        };
        let film = film(path, path, size, mean, variance)?;
        let Some(provenance) = provenance else {
            return Ok((film, None));
        };
        if provenance.inflation.iter().any(|entry| !(entry.factor.is_finite() && entry.factor >= 1.0)) {
            return Err(damaged("an inflation factor is below 1"));
        }
        let film = Film { replicates: provenance.replicates, ..film }.with_blocks(&provenance.inflation);
        Ok((film, Some(provenance)))
    })
}

fn read_folder(folder: &Path) -> std::result::Result<Film, ImageError> {
    let read = |name: &str| {
        let path = folder.join(name);
        let read = with_exr(&path, |file| Ok(([file.header.width, file.header.height], file.channel(0)?)));
        read.map(|(size, values)| (path, size, values))
    };
    let (mean_path, size, mean) = read("mean.exr")?;
    let (variance_path, other_size, variance) = read("variance.exr")?;
    if size != other_size {
        let reason = format!("{}x{} pixels, but mean.exr has {}x{}", other_size[0], other_size[1], size[0], size[1]);
        return Err(ImageError::Unsupported { path: variance_path, reason });
    }
    film(&mean_path, &variance_path, size, mean, variance)
}

fn film(
    mean_path: &Path,
    variance_path: &Path,
    [width, height]: [usize; 2],
    mean: Vec<f32>,
    variance: Vec<f32>,
) -> std::result::Result<Film, ImageError> {
    check_values(mean_path, width, &mean, "a finite mean", |value| value.is_finite())?;
    let right = "a finite variance of 0 or more";
    check_values(variance_path, width, &variance, right, |value| value.is_finite() && value >= 0.0)?;
    Ok(Film { width: width as u32, height: height as u32, mean, variance, ..Film::default() })
}

/// Refuses the first value that is not as it should be.
pub(super) fn check_values(
    path: &Path,
    width: usize,
    values: &[f32],
    right: &'static str,
    good: impl Fn(f32) -> bool,
) -> std::result::Result<(), ImageError> {
    match values.iter().position(|&value| !good(value)) {
        None => Ok(()),
        Some(index) => Err(ImageError::Value {
            path: path.into(),
            row: index / width + 1,
            column: index % width + 1,
            found: values.get(index).map_or_else(String::new, f32::to_string),
            right,
        }),
    }
}
