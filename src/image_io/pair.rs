//! Two images of light that are to be compared.

use super::ImageError;
use super::radiance::{Provenance, read_radiance};
use crate::film::Film;
use crate::film::compare::{CompareError, Comparison, compare, compare_paired};
use std::path::Path;

/// Two images, with what is known of how they were made.
#[derive(Debug, Clone)]
pub struct Pair {
    /// The first, W/(m^2 sr).
    pub a: Film,
    /// The second, in the same unit.
    pub b: Film,
    origins: Option<[Provenance; 2]>,
}

impl Pair {
    /// Reads two images: each a radiance.exr, or a folder with one, or with mean.exr and variance.exr. `replicates`
    /// stand behind the variances of an image that does not say.
    ///
    /// # Errors
    /// As [`read_radiance`]; a folder that holds no image, images in different units.
    pub fn read(a: &Path, b: &Path, replicates: u32) -> Result<Self, ImageError> {
        let (first, origin) = read(a, replicates)?;
        let (second, other) = read(b, replicates)?;
        let origins = origin.zip(other).map(|(origin, other)| [origin, other]);
        if let Some([origin, other]) = origins.as_ref().filter(|[origin, other]| origin.unit != other.unit) {
            let reason = format!("its unit is {}, the first image's {}", other.unit, origin.unit);
            return Err(ImageError::Unsupported { path: b.into(), reason });
        }
        Ok(Self { a: first, b: second, origins })
    }

    /// Compares them by their variances, replicate by replicate where they are known to share random numbers; `level`
    /// is the chance of calling equal images different.
    ///
    /// # Errors
    /// Images that cannot be compared.
    pub fn compare(&self, level: f64) -> Result<Comparison, CompareError> {
        match self.origins.as_ref().is_some_and(|[origin, other]| origin.shares_random_numbers(other)) {
            true => compare_paired(&self.a, &self.b, level),
            false => compare(&self.a, &self.b, level),
        }
    }

    /// Whether they may share random numbers.
    pub fn may_share_random_numbers(&self) -> bool {
        self.origins.as_ref().is_some_and(|[origin, other]| origin.may_share_random_numbers(other))
    }
}

fn read(path: &Path, replicates: u32) -> Result<(Film, Option<Provenance>), ImageError> {
    // A folder that was rendered holds one beside its pictures.
    let inside = path.join("radiance.exr");
    if path.is_dir() && !inside.is_file() && !path.join("mean.exr").is_file() {
        let reason = "holds neither radiance.exr nor mean.exr and variance.exr".into();
        return Err(ImageError::Unsupported { path: path.into(), reason });
    }
    let (mut film, provenance) = read_radiance(if inside.is_file() { &inside } else { path })?;
    if film.replicates == 0 {
        film.replicates = replicates;
    }
    Ok((film, provenance))
}
