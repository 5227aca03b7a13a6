//! From a scene's touch to the shape of every interface.

use super::{Cap, HeightField, Mesh, Profile, Relief, Surface};
use crate::image_io::{Grid, grid_of};
use crate::scene::{Inner, Input, LoadedScene, Normals, Shape, read_mesh, read_pressure_table};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a scene's shape cannot be built.
#[derive(Debug, Error)]
pub enum SurfaceError {
    /// A file that the scene names cannot be used.
    #[error("{key}: {file}: {message}")]
    File {
        /// Key of the scene that names the file.
        key: String,
        /// The file.
        file: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// The shape does not fit the stack.
    #[error("{key}: {message}")]
    Shape {
        /// Key of the scene.
        key: &'static str,
        /// What is wrong, with the numbers.
        message: String,
    },
}

/// Shape of all interfaces of a validated scene that prescribes it.
///
/// # Errors
/// A scene that presses: its shape is that of the press, [`pressed_surface`](super::pressed_surface). A shape that does
/// not fit the stack, a file that cannot be used.
pub fn surface(loaded: &LoadedScene) -> Result<Surface, SurfaceError> {
    let scene = &loaded.scene;
    if scene.press.is_some() {
        let message = "a press gives this scene its shape: `pipeline::Session` presses it".into();
        return Err(SurfaceError::Shape { key: "press", message });
    }
    let share = shares(loaded);
    let footprint = scene.stack.footprint_mm;
    let points = scene.render.height_field_points as usize;
    let short =
        || SurfaceError::Shape { key: "touch.shape", message: "a height field needs at least 3 x 3 samples".into() };
    match &scene.touch.shape {
        Shape::Flat => Ok(Surface::Flat),
        &Shape::SphericalDent { depth_mm, radius_mm, center_mm } => {
            Ok(Surface::Cap { cap: Cap { center_mm, depth_mm, rim_mm: radius_mm }, share })
        }
        &Shape::GaussianDent { depth_mm, sigma_mm, center_mm } => {
            let height = |r: f64| -depth_mm * (-0.5 * (r / sigma_mm).powi(2)).exp();
            let profile = Profile::sample(points, footprint, center_mm, height).ok_or_else(short)?;
            fit(loaded, &profile, &share)?;
            Ok(Surface::Profiles(shared(&share, |s| profile.scaled(s))))
        }
        Shape::HeightMap { file, scale_mm } => {
            let grid = read_grid(loaded, file, "touch.shape.file")?;
            let samples: Vec<f64> = grid.values.iter().map(|v| v * scale_mm).collect();
            let field = HeightField::interpolate(grid.columns as usize, grid.rows as usize, footprint, &samples)
                .ok_or_else(short)?;
            fit(loaded, &field, &share)?;
            Ok(Surface::Fields(shared(&share, |s| field.scaled(s))))
        }
        Shape::Mesh { file, normals } => mesh(loaded, file, *normals),
    }
}

/// Share of the touched face's displacement that each interface carries: its height above the rigid lowest layer.
fn shares(loaded: &LoadedScene) -> Vec<f64> {
    let scene = &loaded.scene;
    let heights = scene.stack.interface_heights_mm();
    let (rigid, top) = match heights.len() {
        0..=2 => (0.0, heights.last().copied().unwrap_or(0.0)),
        n => (heights[1], heights[n - 1]),
    };
    let last = heights.len().saturating_sub(1);
    let share = |(i, z): (usize, &f64)| match scene.touch.inner {
        _ if i == last => 1.0,
        Inner::Flat => 0.0,
        Inner::Follow => ((z - rigid) / (top - rigid)).max(0.0),
    };
    heights.iter().enumerate().map(share).collect()
}

/// What each interface carries; `None` where that is nothing.
fn shared<T>(share: &[f64], scaled: impl Fn(f64) -> T) -> Vec<Option<T>> {
    share.iter().map(|&s| (s != 0.0).then(|| scaled(s))).collect()
}

/// Whether interfaces that carry their shares of a relief keep apart.
fn fit(loaded: &LoadedScene, relief: &impl Relief, share: &[f64]) -> Result<(), SurfaceError> {
    let heights = loaded.scene.stack.interface_heights_mm();
    let [low, high] = relief.range_mm();
    for i in 1..heights.len() {
        // The difference of two splines of one shape stays within its control points, so this test is exact for it.
        let thinnest = heights[i] - heights[i - 1] + (share[i] - share[i - 1]) * low;
        if thinnest <= 0.0 {
            return Err(SurfaceError::Shape {
                key: "touch.shape",
                message: format!(
                    "the interface at {} mm is pushed down by up to {:.4} mm, through the one at {} mm; press less deep, or let inner = \"follow\"",
                    heights[i],
                    -(share[i] * low).min(share[i] * high),
                    heights[i - 1]
                ),
            });
        }
    }
    Ok(())
}

fn mesh(loaded: &LoadedScene, file: &Path, normals: Normals) -> Result<Surface, SurfaceError> {
    let key = "touch.shape.file";
    let wrong = |message: String| SurfaceError::File { key: key.into(), file: loaded.files.resolve(file), message };
    let read = open(loaded, file, key, read_mesh)?;
    let mesh = Mesh::build(&read.vertices, &read.triangles, normals == Normals::Smooth)
        .ok_or_else(|| wrong("no usable triangle".into()))?;
    let scene = &loaded.scene;
    let heights = scene.stack.interface_heights_mm();
    let below = heights.len().checked_sub(2).and_then(|k| heights.get(k)).copied().unwrap_or(0.0);
    if mesh.low_mm <= below {
        return Err(wrong(format!("reaches down to {} mm, through the interface at {below} mm", mesh.low_mm)));
    }
    let [half_x, half_y] = scene.stack.footprint_mm.map(|f| 0.5 * f);
    let reach = |axis: usize, sign: f64| mesh.corners.iter().flatten().map(|p| p[axis] * sign).fold(f64::MIN, f64::max);
    let covers = |axis, half: f64| reach(axis, 1.0).min(reach(axis, -1.0)) >= half * (1.0 - 1e-9);
    if !(covers(0, half_x) && covers(1, half_y)) {
        return Err(wrong(format!("must span the footprint, {} x {} mm about the origin", 2.0 * half_x, 2.0 * half_y)));
    }
    Ok(Surface::Mesh(mesh))
}

/// A grid file of the scene with row 0 at negative y (files have it at positive y).
pub(super) fn read_grid(loaded: &LoadedScene, file: &Path, key: &'static str) -> Result<Grid, SurfaceError> {
    let mut grid = open(loaded, file, key, |input| grid_of(&input.path, &input.bytes))?;
    let columns = grid.columns.max(1) as usize;
    grid.values = grid.values.chunks(columns).rev().flatten().copied().collect();
    Ok(grid)
}

pub(super) fn read_table(loaded: &LoadedScene, file: &Path) -> Result<Vec<[f64; 2]>, SurfaceError> {
    open(loaded, file, "touch.contact.pressure.file", read_pressure_table)
}

/// What a reader makes of a file that the scene names at `key`.
fn open<T, E: std::fmt::Display>(
    loaded: &LoadedScene,
    file: &Path,
    key: &str,
    read: impl FnOnce(&Input) -> Result<T, E>,
) -> Result<T, SurfaceError> {
    let wrong = |message: String| SurfaceError::File { key: key.into(), file: loaded.files.resolve(file), message };
    let input = loaded.files.open(file).map_err(|error| wrong(error.to_string()))?;
    read(&input).map_err(|error| wrong(error.to_string()))
}
