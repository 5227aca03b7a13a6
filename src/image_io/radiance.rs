//! `radiance.exr`: a film and where it comes from.
//!
//! One part of linear 32-bit float channels: `mean` and `variance` (of the mean), and for the edges of
//! [`crate::film::blocks::EDGES`] what the mean over the block of a pixel varies by, which neighbours that share
//! photons make more than their sum. One string attribute `tirtouch` of JSON. The exr crate writes attributes in hash
//! order, so there is only one: equal films give equal bytes.

use super::exr_chunks::with_exr;
use super::exr_header::PROVENANCE;
use super::{ImageError, limits};
use crate::film::{Correlation, Film, Parts};
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
    /// Seed of the tracer's stream, which that seed, the scene and what the image is for give.
    pub stream: Option<u32>,
    /// Seed of the noise of the camera frame that was made of it; none where there was no frame.
    pub sensor_seed: Option<u32>,
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
    /// The command that computed it, without what does not change the light.
    pub command: String,
    /// How much the film's cells move together; written from the film.
    pub correlation: Vec<Correlation>,
    /// Regions of its groups of replicates; written from the film.
    pub parts: Parts,
}

impl Provenance {
    /// Whether both images come from the same random numbers, replicate by replicate: of one seed, and with the same
    /// work.
    #[must_use]
    pub fn shares_random_numbers(&self, other: &Self) -> bool {
        let stream = |image: &Self| (image.stream.is_some(), image.stream.unwrap_or(image.seed));
        let work = |image: &Self| (image.spp, image.photons, image.replicates, image.integrator.clone());
        self.spp > 0 && stream(self) == stream(other) && work(self) == work(other)
    }

    /// Whether noise may be common though nothing shows how much of it. Images that do not name their stream have that
    /// of their seed and scene.
    #[must_use]
    pub fn may_share_random_numbers(&self, other: &Self) -> bool {
        let origin = |image: &Self| match image.stream {
            Some(stream) => (stream, String::new(), image.integrator.clone()),
            None => (image.seed, image.scene_sha256.clone(), image.integrator.clone()),
        };
        origin(self) == origin(other)
    }
}

/// Channels of the variances of blocks, in the order of [`crate::film::blocks::EDGES`].
const BLOCK_VARIANCES: [&str; 4] = ["variance_4x4", "variance_16x16", "variance_64x64", "variance_image"];

/// Writes `film` as an EXR. Of its replicates a few numbers are kept.
///
/// # Errors
/// When the film has no pixels, arrays that do not fit its size, or the file cannot be written.
pub fn write_radiance(path: &Path, film: &Film, provenance: &Provenance) -> std::result::Result<(), ImageError> {
    write_radiance_as(path, film, &film.variance, provenance)
}

/// Writes `film` with other variances in the file: of pixels without light, what bounds the light that was missed
/// there.
///
/// # Errors
/// As [`write_radiance`].
pub fn write_radiance_as(
    path: &Path,
    film: &Film,
    variances: &[f32],
    provenance: &Provenance,
) -> std::result::Result<(), ImageError> {
    let refused = |reason: String| ImageError::Unsupported { path: path.into(), reason };
    let pixels = film.width as usize * film.height as usize;
    if pixels == 0 || film.mean.len() != pixels || variances.len() != pixels || film.variance.len() != pixels {
        return Err(refused("a film without pixels, or of another size than its arrays".into()));
    }
    limits::check_size(path, film.width.into(), film.height.into())?;
    let provenance = Provenance {
        replicates: film.replicates,
        correlation: film.correlation.clone(),
        parts: film.parts.clone(),
        ..provenance.clone()
    };
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
    let of_blocks = film.block_variance_images();
    let blocks = BLOCK_VARIANCES.iter().zip(&of_blocks).map(|(name, values)| channel(name, values));
    let pixels = [channel("mean", &film.mean), channel("variance", variances)];
    let channels = AnyChannels::sort(pixels.into_iter().chain(blocks).collect());
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

/// Reads a film, with the variances that its replicates had, from a `radiance.exr`, or from a folder of `mean.exr` and
/// `variance.exr` (variance of the mean), each of one channel.
///
/// # Errors
/// When a file is missing, damaged, too large, lacks a channel or holds a value that is not finite.
pub fn read_radiance(path: &Path) -> std::result::Result<(Film, Option<Provenance>), ImageError> {
    if path.is_dir() {
        return read_folder(path).map(|film| (film, None));
    }
    let damaged = |reason: &str| ImageError::Damaged { path: path.into(), reason: reason.into() };
    with_exr(path, |file| {
        let place = |name: &str| file.header.channels.iter().position(|channel| channel.name == name);
        let find = |name: &str| {
            place(name).ok_or_else(|| {
                damaged(&format!("it has no channel `{name}`; a radiance.exr has `mean` and `variance`"))
            })
        };
        let blocks: Option<Vec<usize>> = BLOCK_VARIANCES.iter().map(|name| place(name)).collect();
        let wanted = [find("mean")?, find("variance")?].into_iter().chain(blocks.into_iter().flatten());
        let mut channels = file.channels(&wanted.collect::<Vec<_>>())?.into_iter();
        let (mean, variance) = (channels.next().unwrap_or_default(), channels.next().unwrap_or_default());
        let size = [file.header.width, file.header.height];
        let provenance = match &file.header.provenance {
            None => None,
            Some(json) => Some(
                serde_json::from_str::<Provenance>(json)
                    .map_err(|error| damaged(&format!("its `{PROVENANCE}` attribute: {error}")))?,
            ),
        };
        let mut film = film(path, path, size, mean, variance)?;
        let Some(provenance) = provenance else {
            return Ok((film, None));
        };
        // What stands for pixels without light bounds what was missed there; replicates of nothing have no variance.
        let pixels = film.variance.iter_mut().zip(&film.mean);
        pixels.filter(|(_, mean)| **mean == 0.0).for_each(|(variance, _)| *variance = 0.0);
        film.samples = provenance.spp;
        if let Some(reason) = fault(&provenance) {
            return Err(damaged(reason));
        }
        let film = Film { replicates: provenance.replicates, ..film };
        let blocks: Vec<Vec<f32>> = channels.collect();
        if blocks.is_empty() {
            let reason = "it is of an earlier version, without the variances of its blocks; render it again".into();
            return Err(ImageError::Unsupported { path: path.into(), reason });
        }
        for values in &blocks {
            check_values(path, size[0], values, A_VARIANCE, is_variance)?;
        }
        let film = film.with_block_variance_images(&blocks);
        let film = film.ok_or_else(|| damaged("the variance of a block is not the same in all its pixels"))?;
        let (correlation, parts) = (provenance.correlation.clone(), provenance.parts.clone());
        Ok((Film { correlation, parts, ..film }, Some(provenance)))
    })
}

/// What in a header cannot be.
fn fault(provenance: &Provenance) -> Option<&'static str> {
    let share = |value: f64| value > 0.0 && value <= 1.0;
    if !provenance.correlation.iter().all(|entry| share(entry.pairs) && share(entry.triples)) {
        return Some("a correlation is not within 0 and 1");
    }
    (!provenance.parts.is_whole()).then_some("the regions of its replicates are not of their number")
}

const A_VARIANCE: &str = "a finite variance of 0 or more";

fn is_variance(value: f32) -> bool {
    value.is_finite() && value >= 0.0
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
    check_values(variance_path, width, &variance, A_VARIANCE, is_variance)?;
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::film::{BlockAccumulator, BlockLevel};

    /// Eight replicates in which pairs of neighbours move together.
    fn film() -> Film {
        let mut sums = BlockAccumulator::new(24, 18);
        for replicate in 0..8_usize {
            let pixel = |index: usize| 1.0 + ((index / 2 + 1) * (replicate + 3) * 7919 % 101) as f64 * 1e-3;
            sums.add(&(0..24 * 18).map(pixel).collect::<Vec<_>>()).unwrap();
        }
        sums.finish()
    }

    fn provenance() -> Provenance {
        let text = |text: &str| text.to_owned();
        Provenance {
            unit: text("W/(m^2 sr)"),
            scene_name: text("Fühler \u{1f600} \"x\""),
            scene_sha256: text("00ff"),
            seed: 7,
            stream: Some(77),
            spp: 64,
            photons: 1_000_000,
            integrator: text("splat"),
            backend: text("cpu"),
            adapter: text("twin"),
            version: text("0.1.0"),
            ..Provenance::default()
        }
    }

    #[test]
    fn a_film_comes_back_with_its_origin() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("radiance.exr");
        let film = film();
        write_radiance(&path, &film, &provenance()).unwrap();
        let (read, origin) = read_radiance(&path).unwrap();
        assert_eq!((read.width, read.height, read.replicates), (24, 18, 8));
        assert_eq!((&read.mean, &read.variance), (&film.mean, &film.variance));
        let (correlation, parts) = (film.correlation.clone(), film.parts.clone());
        assert_eq!(origin, Some(Provenance { replicates: 8, correlation, parts, ..provenance() }));
        assert_eq!((read.correlation, read.parts), (film.correlation, film.parts));
        let variances = |levels: Vec<BlockLevel>| levels.into_iter().map(|level| level.variance).collect::<Vec<_>>();
        assert_eq!(variances(read.blocks), variances(film.blocks));
    }

    #[test]
    fn the_header_of_a_large_image_is_short() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("radiance.exr");
        let mut sums = BlockAccumulator::new(700, 500);
        for replicate in 0..31 {
            let pixel = |k: u32| f64::from(k % 700 * (replicate + 3) % 101) + 1.0;
            sums.add(&(0..700 * 500).map(pixel).collect::<Vec<_>>()).unwrap();
        }
        write_radiance(&path, &sums.finish(), &provenance()).unwrap();
        let (_, origin) = read_radiance(&path).unwrap();
        let json = serde_json::to_string(&origin.unwrap()).unwrap();
        assert!(json.len() < 3000, "{} bytes: {json}", json.len());
    }

    #[test]
    fn headers_that_cannot_be_are_refused() {
        let film = film();
        let whole = Provenance { correlation: film.correlation.clone(), parts: film.parts.clone(), ..provenance() };
        assert_eq!(fault(&whole), None);
        let with = |change: &dyn Fn(&mut Provenance)| {
            let mut changed = whole.clone();
            change(&mut changed);
            fault(&changed)
        };
        assert!(with(&|p| p.correlation[0].pairs = 2.0).is_some());
        assert!(with(&|p| p.correlation[0].triples = f64::NAN).is_some());
        assert!(with(&|p| _ = p.parts.radiance.pop()).is_some());
    }

    #[test]
    fn equal_films_give_equal_bytes() {
        let place = tempfile::tempdir().unwrap();
        let write = |name: &str| {
            let path = place.path().join(name);
            write_radiance(&path, &film(), &provenance()).unwrap();
            std::fs::read(path).unwrap()
        };
        let first = write("0.exr");
        for other in ["1.exr", "2.exr", "3.exr"] {
            assert!(write(other) == first);
        }
    }

    #[test]
    fn images_of_earlier_versions_are_refused_by_name() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("radiance.exr");
        let json = serde_json::to_string(&provenance()).unwrap().replace(|c: char| !c.is_ascii(), "?");
        let channel = |name: &str| AnyChannel::new(name, FlatSamples::F32(vec![1.0; 40]));
        let channels = AnyChannels::sort([channel("mean"), channel("variance")].into_iter().collect());
        let (blocks, line_order) = (Blocks::ScanLines, LineOrder::Increasing);
        let encoding = Encoding { compression: Compression::ZIP16, blocks, line_order };
        let mut layer = Layer::new((8, 5), LayerAttributes::default(), encoding, channels);
        let text = Text::new_or_none(&json).unwrap();
        layer.attributes.other.insert(Text::from(PROVENANCE), AttributeValue::Text(text));
        Image::from_layer(layer).write().to_file(&path).unwrap();
        let refused = read_radiance(&path).unwrap_err();
        assert!(matches!(&refused, ImageError::Unsupported { reason, .. } if reason.contains("earlier")), "{refused}");
    }

    #[test]
    fn the_exr_crate_reads_what_is_written() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("radiance.exr");
        write_radiance(&path, &film(), &provenance()).unwrap();
        let meta = exr::meta::MetaData::read_from_file(&path, true).unwrap();
        assert_eq!(meta.headers.len(), 1);
        let names: Vec<String> = meta.headers[0].channels.list.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["mean", "variance", "variance_16x16", "variance_4x4", "variance_64x64", "variance_image"]);
        assert_eq!(meta.headers[0].own_attributes.other.len(), 1);
    }

    #[test]
    fn a_folder_of_mean_and_variance_is_a_film() {
        let place = tempfile::tempdir().unwrap();
        let write = |name: &str, compression: Compression, value: f32| {
            let channel = AnyChannel::new("Y", FlatSamples::F32(vec![value; 40]));
            let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
            let channels = AnyChannels::sort(std::iter::once(channel).collect());
            let layer = Layer::new((8, 5), LayerAttributes::default(), encoding, channels);
            Image::from_layer(layer).write().to_file(place.path().join(name)).unwrap();
        };
        write("mean.exr", Compression::PIZ, 2.0);
        assert!(matches!(read_radiance(place.path()), Err(ImageError::Read { .. })), "variance.exr is missing");
        write("variance.exr", Compression::ZIP16, 0.25);
        let (film, origin) = read_radiance(place.path()).unwrap();
        assert_eq!((film.mean, film.variance), (vec![2.0; 40], vec![0.25; 40]));
        assert_eq!((film.replicates, origin), (0, None));
        write("variance.exr", Compression::ZIP16, -1.0);
        assert!(matches!(read_radiance(place.path()), Err(ImageError::Value { row: 1, column: 1, .. })));
    }

    #[test]
    fn values_that_are_not_finite_are_refused_with_their_place() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("radiance.exr");
        let mut film = film();
        film.mean[24 * 2 + 5] = f32::NAN;
        write_radiance(&path, &film, &provenance()).unwrap();
        assert!(matches!(read_radiance(&path), Err(ImageError::Value { row: 3, column: 6, .. })));
    }

    #[test]
    fn a_place_that_cannot_be_written_is_an_error() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("missing/radiance.exr");
        assert!(matches!(write_radiance(&path, &film(), &provenance()), Err(ImageError::Write { .. })));
        let short = Film { height: 19, ..film() };
        assert!(matches!(write_radiance(&path, &short, &provenance()), Err(ImageError::Unsupported { .. })));
    }
}
