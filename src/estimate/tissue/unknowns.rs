//! From unknowns to a tissue, and from a tissue to the features of its frames.

use super::{Question, TissueError};
use crate::mechanics::frames::scan::{Held, ScanError, ScanSetup, frames};
use crate::mechanics::frames::{Features, Frame, Frames, Reference, Settings, features};
use crate::mechanics::mesh::{Mesh, PhantomMesh, Star};
use crate::scene::{Elastic, InclusionBody, LoadedScan, PhantomBody, validate_scan};

/// Places of the unknowns in a point.
pub(super) const THICKNESS: usize = 0;
pub(super) const RADIUS: usize = 1;
pub(super) const STRENGTH: usize = 2;
pub(super) const MODULUS: usize = 3;
pub(super) const DEPTH: usize = 4;

/// Names of the unknowns in words, and as estimates.
pub(super) const WORDS: [&str; 5] = ["thickness", "radius", "contrast", "tissue's modulus", "depth"];
pub(super) const NAMES: [&str; 5] = ["thickness_mm", "radius_mm", "contrast", "tissue_youngs_kpa", "depth_mm"];

/// How far from the guess unknowns are sought: thickness, radius, modulus and depth as factors, the contrast itself.
const FACTORS: [[f64; 2]; 5] = [[0.5, 2.0], [0.4, 2.5], [0.0, 0.0], [0.02, 50.0], [0.4, 2.5]];
const CONTRASTS: [f64; 2] = [0.2, 60.0];

/// Fineness of the mesh on which tissues are sought, and of that which puts it right, over the scene's. Neither is the
/// scene's own, so that frames of a scene are not inverted on the mesh that they were made on.
const COARSE: f64 = 0.4;
const FINE: f64 = 1.1;

/// The mesh on which a tissue is scanned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum MeshOf<'a> {
    /// Its own, coarse.
    Coarse,
    /// Its own, fine.
    Fine,
    /// The coarse one of this tissue nearby, its nodes moved: features then differ as tissues do, not as meshes.
    Neighbour(&'a [f64]),
}

/// Thickness of a tissue, and centre height and radius of its inclusion, mm.
pub(super) struct Outline {
    pub thickness: f64,
    pub height: f64,
    pub radius: f64,
}

impl Outline {
    fn of(tissue: &PhantomMesh) -> Self {
        let inclusion = tissue.inclusions.first();
        let radius = inclusion.map_or(0.0, |one| match one.surface {
            Star::Ellipsoid { semi_axes_mm } => semi_axes_mm[0],
            Star::Mesh(_) => 0.0,
        });
        let height = inclusion.map_or(0.0, |one| one.center_mm[2]);
        Self { thickness: tissue.shape.height_mm(), height, radius }
    }

    /// Where a node of this tissue goes in another: the inclusion as a whole, the rest of the tissue stretched, and in
    /// the gap between the inclusion and the nearer face from one to the other.
    pub fn moved(&self, other: &Self, [x, z, y]: [f64; 3]) -> [f64; 3] {
        let (dx, dz) = (x, z - self.height);
        let gap = (self.height - self.radius).min(self.thickness - self.height - self.radius);
        let away = ((dx.hypot(dz) - self.radius) / gap).max(0.0);
        let (weight, scale) = ((1.0 - away).max(0.0), other.radius / self.radius);
        let whole = [scale * dx, other.height + scale * dz];
        let stretched = [x, z * other.thickness / self.thickness];
        [weight * whole[0] + (1.0 - weight) * stretched[0], weight * whole[1] + (1.0 - weight) * stretched[1], y]
    }
}

/// What is measured of the frames, and how frames of a tissue are made that compare with it.
#[derive(Clone)]
pub(super) struct Scanner<'a> {
    question: &'a Question<'a>,
    measured: &'a Frames,
    /// Force of each frame, N/mm; none where the depth is held.
    forces: Vec<f64>,
    guess: Guess,
}

#[derive(Clone)]
struct Guess {
    thickness_mm: f64,
    radius_mm: f64,
    depth_mm: f64,
    youngs_kpa: f64,
}

/// c = (k - 1)/(k + 1) of a contrast, and back.
pub(super) fn strength(contrast: f64) -> f64 {
    (contrast - 1.0) / (contrast + 1.0)
}

pub(super) fn contrast(strength: f64) -> f64 {
    (1.0 + strength) / (1.0 - strength)
}

fn youngs_kpa(material: &Elastic) -> f64 {
    match material {
        Elastic::Linear { youngs_kpa, .. } | Elastic::NeoHookean { youngs_kpa, .. } => *youngs_kpa,
        _ => f64::NAN,
    }
}

fn with_youngs(material: &mut Elastic, kpa: f64) {
    if let Elastic::Linear { youngs_kpa, .. } | Elastic::NeoHookean { youngs_kpa, .. } = material {
        *youngs_kpa = kpa;
    }
}

impl<'a> Scanner<'a> {
    pub fn new(measured: &'a Frames, question: &'a Question<'a>) -> Result<Self, TissueError> {
        let phantom = &question.scene.scene.phantom;
        let inclusion = phantom.inclusion.first();
        let radius_mm = inclusion.and_then(|one| one.shape.semi_axes_mm()).map_or(f64::NAN, |semi| semi[0]);
        let guess = Guess {
            thickness_mm: phantom.shape.height_mm(),
            radius_mm,
            depth_mm: inclusion.map_or(f64::NAN, |one| one.depth_mm),
            youngs_kpa: youngs_kpa(&phantom.material),
        };
        let forces = match question.by_force {
            true => forces(measured, question.noise_kpa)?,
            false => Vec::new(),
        };
        Ok(Self { question, measured, forces, guess })
    }

    /// How many unknowns there are.
    pub fn unknowns(&self) -> usize {
        if self.question.free_depth { 5 } else { 4 }
    }

    /// The range of each unknown, in its coordinate.
    pub fn ranges(&self) -> Vec<[f64; 2]> {
        let guess =
            [self.guess.thickness_mm, self.guess.radius_mm, f64::NAN, self.guess.youngs_kpa, self.guess.depth_mm];
        let range = |k: usize| match k {
            STRENGTH => CONTRASTS.map(strength),
            k => FACTORS[k].map(|factor| (factor * guess[k]).ln()),
        };
        (0..self.unknowns()).map(range).collect()
    }

    /// Unknowns that change a scan: the tissue's modulus only scales it, where the depth is known.
    pub fn is_scanned(&self, unknown: usize) -> bool {
        unknown != MODULUS || self.question.by_force
    }

    /// Pressures of a scan times this are those of the tissue's modulus.
    pub fn scale(&self, point: &[f64]) -> f64 {
        point[MODULUS].exp() / self.guess.youngs_kpa
    }

    /// Frames of a tissue with the guessed modulus; the reason where there is no such tissue, or none pressed so.
    pub fn scan(
        &self,
        point: &[f64],
        mesh: MeshOf,
        observe: &(dyn Fn() -> bool + Sync),
    ) -> Result<Result<Frames, String>, TissueError> {
        let scanned = self.on_mesh(point, mesh).and_then(|(setup, mesh)| {
            let scale = self.scale(point);
            let forces: Vec<f64> = self.forces.iter().map(|force| force / scale).collect();
            let held = if forces.is_empty() { Held::Depth } else { Held::Force(&forces) };
            Ok(frames(&setup, &mesh, held, observe)?)
        });
        match scanned {
            Ok(frames) => Ok(Ok(frames)),
            Err(TissueError::NoStart(why)) => Ok(Err(why)),
            Err(TissueError::Scan(
                error @ (ScanError::Mesh(_) | ScanError::Position { .. } | ScanError::Force { .. }),
            )) => Ok(Err(error.to_string())),
            Err(error) => Err(error),
        }
    }

    /// The same with all forces larger by a share.
    pub fn pressed_harder(&self, share: f64) -> Self {
        Self { forces: self.forces.iter().map(|force| force * (1.0 + share)).collect(), ..self.clone() }
    }

    /// The same tissue with the modulus at which the scene's depth has the frames' forces, taken together; the reason
    /// where it cannot be pressed so deep.
    pub fn as_stiff(
        &self,
        point: &[f64],
        observe: &(dyn Fn() -> bool + Sync),
    ) -> Result<Result<Vec<f64>, String>, TissueError> {
        let by_depth = Self { forces: Vec::new(), ..self.clone() };
        Ok(by_depth.scan(point, MeshOf::Coarse, observe)?.map(|frames| {
            let made: f64 = frames.as_slice().iter().map(force).sum();
            let mut point = point.to_vec();
            point[MODULUS] = (self.guess.youngs_kpa * self.forces.iter().sum::<f64>() / made).ln();
            point
        }))
    }

    fn on_mesh(&self, point: &[f64], mesh: MeshOf) -> Result<(ScanSetup, Mesh), TissueError> {
        let fineness = if mesh == MeshOf::Fine { FINE } else { COARSE };
        let setup = |point: &[f64]| {
            let loaded = self.tissue(point);
            validate_scan(&loaded.scene).map_err(|broken| TissueError::NoStart(broken.to_string()))?;
            let mut setup = ScanSetup::from_scene(&loaded)?;
            setup.tissue.resolution = setup.tissue.resolution.finer(fineness);
            setup.positions_mm = self.measured.as_slice().iter().map(|frame| frame.position_mm).collect();
            setup.places_mm = self.measured.as_slice().first().map(|frame| frame.x_mm.clone()).unwrap_or_default();
            Ok::<_, TissueError>(setup)
        };
        let this = setup(point)?;
        let mesh = match mesh {
            MeshOf::Neighbour(from) => {
                let neighbour = setup(from)?;
                let mut mesh = neighbour.tissue.build_2d().map_err(ScanError::from)?;
                let (from, to) = (Outline::of(&neighbour.tissue), Outline::of(&this.tissue));
                mesh.nodes.iter_mut().for_each(|node| *node = from.moved(&to, *node));
                mesh
            }
            _ => this.tissue.build_2d().map_err(ScanError::from)?,
        };
        Ok((this, mesh))
    }

    /// The scene of a tissue, with the guessed modulus.
    fn tissue(&self, point: &[f64]) -> LoadedScan {
        let mut loaded = self.question.scene.clone();
        let (phantom, scan) = (&mut loaded.scene.phantom, &mut loaded.scene.scan);
        if let PhantomBody::Block { height_mm, .. } = &mut phantom.shape {
            *height_mm = point[THICKNESS].exp();
        }
        if let Some(inclusion) = phantom.inclusion.first_mut() {
            inclusion.shape = InclusionBody::Sphere { diameter_mm: 2.0 * point[RADIUS].exp() };
            with_youngs(&mut inclusion.material, self.guess.youngs_kpa * contrast(point[STRENGTH]));
            if let Some(depth) = point.get(DEPTH) {
                inclusion.depth_mm = depth.exp();
            }
        }
        // Windows are the question's.
        scan.window_mm = None;
        let frames = self.measured.as_slice();
        if let (Some(first), Some(last)) = (frames.first(), frames.last()) {
            scan.positions_mm.from = first.position_mm;
            scan.positions_mm.to = last.position_mm;
            scan.frame_half_width_mm = first.x_mm.iter().fold(0.0, |far: f64, x| far.max(x.abs()));
        }
        loaded
    }

    /// Features of frames that were scanned with the guessed modulus, were it that of the point.
    pub fn features(&self, frames: &Frames, point: &[f64]) -> Result<Vec<Features>, TissueError> {
        let scale = self.scale(point);
        let scaled = |frame: &Frame| Frame {
            pressure_kpa: frame.pressure_kpa.iter().map(|p| scale * p).collect(),
            ..frame.clone()
        };
        let frames = Frames::new(frames.as_slice().iter().map(scaled).collect())?;
        Ok(features(&frames, Reference::Farthest, &self.settings())?)
    }

    /// How features are taken.
    pub fn settings(&self) -> Settings {
        Settings {
            window_mm: self.question.window_mm,
            contact_above_kpa: self.question.noise_kpa,
            ..Settings::default()
        }
    }
}

/// Force of a frame, N per mm of the indenter's length.
pub(super) fn force(frame: &Frame) -> f64 {
    let (x, p) = (&frame.x_mm, &frame.pressure_kpa);
    1e-3 * x.windows(2).zip(p.windows(2)).map(|(x, p)| 0.5 * (x[1] - x[0]) * (p[0] + p[1])).sum::<f64>()
}

/// Force of each frame.
fn forces(frames: &Frames, noise_kpa: f64) -> Result<Vec<f64>, TissueError> {
    let whole = |frame: &Frame| {
        let ends = [frame.pressure_kpa.first(), frame.pressure_kpa.last()];
        match ends.into_iter().flatten().any(|p| *p > noise_kpa) {
            true => Err(TissueError::Cut { position_mm: frame.position_mm }),
            false if force(frame) <= 0.0 => Err(TissueError::NoForce { position_mm: frame.position_mm }),
            false => Ok(force(frame)),
        }
    };
    frames.as_slice().iter().map(whole).collect()
}
