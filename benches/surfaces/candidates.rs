//! The two dents and the surfaces that stand for them.

use anyhow::{Context as _, Result};
use tirtouch::scene::{LoadedScene, preset};
use tirtouch::surface::{Cap, HeightField, Mesh, Profile, Surface};
use tirtouch::trace::Model;

/// A dent in closed form, 1 mm deep.
pub struct Dent {
    /// Name.
    pub name: &'static str,
    /// Standard deviation of a Gaussian, mm; otherwise the cap.
    pub sigma_mm: Option<f64>,
    /// Radius within which directions are compared, mm.
    pub reach_mm: f64,
}

/// The cap of `dent-cap`.
pub const CAP: Cap = Cap { center_mm: [0.0, 0.0], depth_mm: 1.0, rim_mm: 4.0 };

impl Dent {
    /// The dents of the study. The wide Gaussian is too shallow to send light from the LEDs to the camera; the narrow
    /// one is as steep (26 degrees) as the cap at its rim (28 degrees) and shows glints.
    pub fn all() -> [Self; 3] {
        // Compared where it is deeper than a hundredth of its depth.
        let gaussian =
            |name, sigma: f64| Self { name, sigma_mm: Some(sigma), reach_mm: sigma * (2.0 * 100f64.ln()).sqrt() };
        [
            Self { name: "spherical cap, radius 4 mm", sigma_mm: None, reach_mm: CAP.rim_mm },
            gaussian("Gaussian, sigma 2.5 mm", 2.5),
            gaussian("Gaussian, sigma 1.25 mm", 1.25),
        ]
    }

    /// Displacement and its gradient at a point, mm and mm/mm.
    pub fn height(&self, x: f64, y: f64) -> [f64; 3] {
        if let Some(sigma) = self.sigma_mm {
            let h = -(-(x * x + y * y) / (2.0 * sigma * sigma)).exp();
            return [h, -h * x / (sigma * sigma), -h * y / (sigma * sigma)];
        }
        let h = CAP.height_mm(x, y);
        let below_center = CAP.ball_radius_mm() - CAP.depth_mm - h;
        let inside = f64::from(x.hypot(y) < CAP.rim_mm);
        [h, inside * x / below_center, inside * y / below_center]
    }
}

/// A surface to be measured, in the scene.
pub struct Candidate {
    /// What it is.
    pub name: String,
    /// The scene with it.
    pub model: Model<f64>,
}

/// Surfaces of a dent, the reference first: the cap in closed form; for the Gaussian, which the tracer has no closed
/// form for, a height field of 1024 points, whose directions are exact to rounding.
pub fn candidates(dent: &Dent) -> Result<Vec<Candidate>> {
    let mut loaded = preset("dent-cap")?;
    loaded.scene.touch.shape = tirtouch::scene::Shape::Flat;
    let interfaces = loaded.scene.stack.interface_heights_mm().len();
    let mut share = vec![0.0; interfaces];
    share[interfaces - 1] = 1.0;
    let mut surfaces = match dent.sigma_mm {
        None => vec![("closed form".to_owned(), Surface::Cap { cap: CAP, share })],
        Some(_) => vec![("height field, 1024 points".to_owned(), field(&loaded, dent, 1024)?)],
    };
    for points in [64, 128, 256, 512] {
        let name = format!("height field about an axis, {points} points");
        surfaces.push((name, profile(&loaded, dent, points)?));
        surfaces.push((format!("height field, {points} points"), field(&loaded, dent, points)?));
    }
    for (smooth, name) in [(true, "smooth"), (false, "flat")] {
        for cells in [64, 128, 256] {
            surfaces.push((format!("mesh, {cells} cells, {name} normals"), mesh(&loaded, dent, cells, smooth)?));
        }
    }
    let build =
        |(name, surface): (String, Surface)| Ok(Candidate { name, model: Model::new(&loaded, &surface, None)? });
    surfaces.into_iter().map(build).collect()
}

fn field(loaded: &LoadedScene, dent: &Dent, points: usize) -> Result<Surface> {
    let field = HeightField::sample(points, loaded.scene.stack.footprint_mm, |x, y| dent.height(x, y)[0])
        .context("too few points")?;
    let mut fields = vec![None; loaded.scene.stack.interface_heights_mm().len() - 1];
    fields.push(Some(field));
    Ok(Surface::Fields(fields))
}

fn profile(loaded: &LoadedScene, dent: &Dent, points: usize) -> Result<Surface> {
    let profile = Profile::sample(points, loaded.scene.stack.footprint_mm, [0.0; 2], |r| dent.height(r, 0.0)[0])
        .context("too few points")?;
    let mut profiles = vec![None; loaded.scene.stack.interface_heights_mm().len() - 1];
    profiles.push(Some(profile));
    Ok(Surface::Profiles(profiles))
}

/// Two triangles for each cell of a lattice over the footprint.
fn mesh(loaded: &LoadedScene, dent: &Dent, cells: u32, smooth: bool) -> Result<Surface> {
    let top = loaded.scene.stack.interface_heights_mm().last().copied().context("no layers")?;
    let [width, height] = loaded.scene.stack.footprint_mm;
    let at = |k: u32, extent: f64| (f64::from(k) / f64::from(cells) - 0.5) * extent;
    let lattice = (0..=cells).flat_map(|row| (0..=cells).map(move |column| (at(column, width), at(row, height))));
    let vertices: Vec<[f64; 3]> = lattice.map(|(x, y)| [x, y, top + dent.height(x, y)[0]]).collect();
    let mut triangles = Vec::new();
    for k in (0..cells * (cells + 1)).filter(|k| k % (cells + 1) < cells) {
        let [a, b, c, d] = [k, k + 1, k + cells + 2, k + cells + 1];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    Ok(Surface::Mesh(Mesh::build(&vertices, &triangles, smooth).context("an empty mesh")?))
}
