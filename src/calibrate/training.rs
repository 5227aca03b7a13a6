//! Frames to learn from: the images that a sweep kept, each with its point.

use super::{Blocks, CalibrateError};
use crate::image_io::read_radiance;
use crate::infer::{Followed, Prior, Unknown};
use crate::output::Records;
use crate::sweep::{Format, Images, Kept, Loads, Record, Sweep};
use crate::vary::Vary;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// What a sweep's images hold.
pub struct Training {
    /// Its folder.
    pub folder: PathBuf,
    /// The sweep.
    pub sweep: Sweep,
    /// What was drawn.
    pub unknowns: Vec<Unknown>,
    /// Variables that the design draws, unknowns or not.
    pub free: usize,
    /// Points: a coordinate of each unknown.
    pub points: Vec<Vec<f64>>,
    /// Row of each in the sweep.
    pub rows: Vec<usize>,
    /// Depths that the loads stand for, mm: those of the base scene.
    pub depths_mm: Vec<f64>,
    /// How images are cut.
    pub blocks: Blocks,
    /// Mean radiance of each block, one load after the other, W/(m^2 sr).
    pub light: Vec<Vec<f64>>,
    /// Relative error of a pixel of each block, root mean square over points: ordered as `light`.
    pub errors: Vec<f64>,
    /// Logarithms of the forces of each point, N: of every load that takes one.
    pub forces: Vec<Vec<f64>>,
}

/// The sweep of a folder, one that keeps the radiance of all loads.
///
/// # Errors
/// A folder of another kind.
pub(crate) fn sweep_of(folder: &Path) -> Result<(Sweep, Records), CalibrateError> {
    let (sweep, records) = Sweep::of_folder(folder)?;
    let whole = |images: Images| images.format == Format::Exr && images.loads == Loads::All;
    if sweep.file.sweep.images.is_some_and(whole) {
        return Ok((sweep, records));
    }
    let why = "keeps no radiance of all loads: images = { format = \"exr\", loads = \"all\" }".to_owned();
    Err(CalibrateError::Unsuited { folder: folder.to_path_buf(), why })
}

impl Training {
    /// The same of some of its points alone, by their places.
    #[must_use]
    pub fn only(&self, holds: impl Fn(usize) -> bool) -> Self {
        fn those<T: Clone>(all: &[T], holds: impl Fn(usize) -> bool) -> Vec<T> {
            all.iter().enumerate().filter(|(k, _)| holds(*k)).map(|(_, one)| one.clone()).collect()
        }
        Self {
            points: those(&self.points, &holds),
            rows: those(&self.rows, &holds),
            light: those(&self.light, &holds),
            forces: those(&self.forces, &holds),
            folder: self.folder.clone(),
            sweep: self.sweep.clone(),
            unknowns: self.unknowns.clone(),
            depths_mm: self.depths_mm.clone(),
            errors: self.errors.clone(),
            ..*self
        }
    }

    /// Reads the folder of a sweep that kept the radiance of all loads.
    ///
    /// # Errors
    /// A folder of another kind, an image that cannot be read.
    pub fn read(folder: &Path) -> Result<Self, CalibrateError> {
        let (sweep, records) = sweep_of(folder)?;
        let unsuited = |why: &str| CalibrateError::Unsuited { folder: folder.to_path_buf(), why: why.to_owned() };
        let scene = &sweep.base.scene;
        let press = scene.press.as_ref().ok_or_else(|| unsuited("presses nothing"))?;
        let depths_mm = press.depths_mm.clone().ok_or_else(|| unsuited("presses to no depths_mm"))?;
        let pixels = scene.camera.pixels;
        let blocks =
            Blocks::of(pixels).ok_or_else(|| unsuited("has a camera whose pixels fall into no equal blocks"))?;
        let free = sweep.plan.free();
        let drawn: Vec<(usize, Unknown)> =
            free.iter().filter_map(|&k| Some((k, unknown(sweep.file.vary.get(k)?)?))).collect();
        let kept: Vec<_> = sweep.kept(&records).filter(|(_, record)| record.images.len() == depths_mm.len()).collect();
        if kept.is_empty() {
            return Err(unsuited("has no point that is done"));
        }
        let images = kept.par_iter().map(|(row, record)| {
            let of_load = |kept: &Kept| point_image(&sweep, &records, *row, &kept.file, blocks);
            record.images.iter().map(of_load).collect::<Result<Vec<_>, CalibrateError>>()
        });
        let images = images.collect::<Result<Vec<_>, CalibrateError>>()?;
        let (light, squares): (Vec<Vec<f64>>, Vec<Vec<f64>>) = images
            .into_iter()
            .map(|loads| {
                let (means, squares): (Vec<_>, Vec<_>) = loads.into_iter().unzip();
                (means.concat(), squares.concat())
            })
            .unzip();
        let errors = own_errors(&squares);
        let coordinates = |record: &Record| -> Vec<f64> {
            let values = drawn.iter().filter_map(|(k, _)| record.values.get(*k)?.number());
            drawn.iter().zip(values).map(|((_, unknown), value)| unknown.prior.coordinate(value)).collect()
        };
        let points = kept.iter().map(|(_, record)| coordinates(record)).collect();
        let forces = |record: &Record| -> Vec<f64> {
            record.images.iter().filter_map(Kept::force_n).filter(|force_n| *force_n > 0.0).map(f64::ln).collect()
        };
        let forces = kept.iter().map(|(_, record)| forces(record)).collect();
        let rows = kept.iter().map(|(row, _)| *row).collect();
        let unknowns = drawn.into_iter().map(|(_, unknown)| unknown).collect();
        Ok(Self {
            folder: folder.to_path_buf(),
            free: free.len(),
            unknowns,
            points,
            rows,
            depths_mm,
            blocks,
            light,
            errors,
            forces,
            sweep,
        })
    }
}

/// Each block's own error, root mean square over points: of the square of its relative error at each.
fn own_errors(squares: &[Vec<f64>]) -> Vec<f64> {
    let mean = |place: usize| squares.iter().filter_map(|point| point.get(place)).sum::<f64>() / squares.len() as f64;
    (0..squares.first().map_or(0, Vec::len)).map(|place| mean(place).sqrt()).collect()
}

/// Means over blocks of an image of a point, and the square of a pixel's error in each as a share of its mean.
fn point_image(
    sweep: &Sweep,
    records: &Records,
    row: usize,
    file: &str,
    blocks: Blocks,
) -> Result<(Vec<f64>, Vec<f64>), CalibrateError> {
    let split = sweep.file.sweep.images.map_or("", |images| images.split(row));
    let path = records.folder().join(split).join(file);
    let (film, _) = read_radiance(&path)?;
    let pixels = [film.width, film.height];
    if pixels != sweep.base.scene.camera.pixels {
        let why = format!("{} has {} x {} pixels, its scene others", path.display(), film.width, film.height);
        return Err(CalibrateError::Unsuited { folder: records.folder().to_path_buf(), why });
    }
    let means = |of: &[f32]| blocks.means(&of.iter().map(|&v| f64::from(v)).collect::<Vec<_>>(), pixels);
    let (mean, variance) = (means(&film.mean), means(&film.variance));
    let square = |(mean, variance): (&f64, &f64)| if *mean > 0.0 { variance / (mean * mean) } else { 0.0 };
    let squares = mean.iter().zip(&variance).map(square).collect();
    Ok((mean, squares))
}

/// What was drawn, as an unknown; none where the variable is not drawn from a distribution.
fn unknown(vary: &Vary) -> Option<Unknown> {
    let name = vary.name.clone().or_else(|| vary.key.as_ref().and_then(|key| key.all().first().cloned()))?;
    let prior = match (vary.uniform, vary.log_uniform) {
        (Some([low, high]), _) => Prior::Uniform { low, high },
        (_, Some([low, high])) => Prior::LogUniform { low, high },
        (None, None) => return None,
    };
    Some(Unknown { name, prior, followed: Followed::Coordinate })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One block that is now and then far noisier says nothing of the others.
    #[test]
    fn each_block_has_its_own_error() {
        let errors = own_errors(&[vec![1e-4, 1e-4, 4e-4], vec![1e-4, 1.0, 4e-4]]);
        let expected = [0.01, 0.50005f64.sqrt(), 0.02];
        assert!(
            errors.iter().zip(expected).all(|(error, expected)| (error / expected - 1.0).abs() < 1e-12),
            "{errors:?}"
        );
    }
}
