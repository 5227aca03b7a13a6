//! From pressure to the share of true contact.

use super::SurfaceError;
use crate::scene::{Contact, ContactLaw, LoadedScene, Pressure};

/// Share of true contact over the footprint, and where there is tissue at all.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactMap {
    /// Columns of the share grid; 0: the share is `uniform`.
    pub columns: usize,
    /// Rows of the share grid.
    pub rows: usize,
    /// Shares at cell centres, row-major, row 0 at negative y.
    pub share: Vec<f64>,
    /// Share everywhere, where there is no grid.
    pub uniform: f64,
    /// Where there is tissue; `None`: over the whole footprint.
    pub disc: Option<TissueDisc>,
}

/// Tissue within a circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TissueDisc {
    /// Centre, mm.
    pub center_mm: [f64; 2],
    /// Radius, mm.
    pub radius_mm: f64,
}

/// Cells of the share grid along the longer side of the footprint.
pub(super) const SHARE_CELLS: usize = 512;

impl ContactLaw {
    /// Share of true contact at a pressure, 0 to 1.
    pub fn share(self, pressure_kpa: f64) -> f64 {
        let p = pressure_kpa.max(0.0);
        match self {
            Self::Full => f64::from(p > 0.0),
            // Persson 2001 (J. Chem. Phys. 115, 3840): erf(sqrt 2 p / (E* h')).
            Self::Persson { reduced_modulus_kpa, rms_slope } => {
                statrs::function::erf::erf(std::f64::consts::SQRT_2 * p / (reduced_modulus_kpa * rms_slope))
            }
            Self::GreenwoodWilliamson { pressure_scale_kpa } => -(-p / pressure_scale_kpa).exp_m1(),
            Self::PerssonUnloading { reduced_modulus_kpa, rms_slope, peak_ratio, hold_kpa } => {
                let held = if p > 0.0 { (p + hold_kpa).min(p * peak_ratio) } else { 0.0 };
                Self::Persson { reduced_modulus_kpa, rms_slope }.share(held)
            }
        }
    }
}

/// The contact of a scene, or `None` where nothing touches.
///
/// # Errors
/// `Shape` where the pressure is that of a press, which [`pressed_contact`](super::pressed_contact) reads; `File` for a
/// table or map of pressure that cannot be used.
pub fn contact_map(loaded: &LoadedScene) -> Result<Option<ContactMap>, SurfaceError> {
    let Some(contact) = &loaded.scene.touch.contact else {
        return Ok(None);
    };
    if let Pressure::Press = contact.pressure {
        let message = "is that of the press, which has to be computed first".into();
        return Err(SurfaceError::Shape { key: "touch.contact.pressure", message });
    }
    if let Pressure::Disc { radius_mm, center_mm, pressure_kpa } = contact.pressure {
        return Ok(Some(ContactMap {
            columns: 0,
            rows: 0,
            share: Vec::new(),
            uniform: contact.law.share(pressure_kpa),
            disc: Some(TissueDisc { center_mm, radius_mm }),
        }));
    }
    share_grid(loaded, contact).map(Some)
}

fn share_grid(loaded: &LoadedScene, contact: &Contact) -> Result<ContactMap, SurfaceError> {
    let footprint = loaded.scene.stack.footprint_mm;
    let (columns, rows, pressure) = match &contact.pressure {
        Pressure::Map { file, scale_kpa } => {
            let grid = super::build::read_grid(loaded, file, "touch.contact.pressure.file")?;
            (grid.columns as usize, grid.rows as usize, grid.values.iter().map(|v| v * scale_kpa).collect())
        }
        analytic => {
            let profile = profile(loaded, analytic)?;
            let center = center_mm(analytic);
            sample(footprint, SHARE_CELLS, |x, y| profile((x - center[0]).hypot(y - center[1])))
        }
    };
    Ok(ContactMap {
        columns,
        rows,
        share: pressure.iter().map(|&p| contact.law.share(p)).collect(),
        uniform: 0.0,
        disc: None,
    })
}

/// A quantity at the middles of the cells of the share grid: columns, rows, values.
pub(super) fn sample(footprint: [f64; 2], cells: usize, at: impl Fn(f64, f64) -> f64) -> (usize, usize, Vec<f64>) {
    let longer = footprint[0].max(footprint[1]);
    let count = |extent: f64| ((cells as f64 * extent / longer).round() as usize).max(2);
    let (columns, rows) = (count(footprint[0]), count(footprint[1]));
    let place = |k: usize, n: usize, extent: f64| ((k as f64 + 0.5) / n as f64 - 0.5) * extent;
    let value = |k: usize| at(place(k % columns, columns, footprint[0]), place(k / columns, rows, footprint[1]));
    (columns, rows, (0..rows * columns).map(value).collect())
}

fn center_mm(pressure: &Pressure) -> [f64; 2] {
    match pressure {
        Pressure::Disc { center_mm, .. }
        | Pressure::Hertz { center_mm, .. }
        | Pressure::Gaussian { center_mm, .. }
        | Pressure::Table { center_mm, .. } => *center_mm,
        Pressure::Map { .. } | Pressure::Press => [0.0, 0.0],
    }
}

type Profile = Box<dyn Fn(f64) -> f64>;

/// Pressure in kPa against the distance from the centre in mm.
fn profile(loaded: &LoadedScene, pressure: &Pressure) -> Result<Profile, SurfaceError> {
    Ok(match *pressure {
        Pressure::Hertz { peak_kpa, radius_mm, base_kpa, .. } => {
            Box::new(move |r| base_kpa + peak_kpa * (1.0 - (r / radius_mm).powi(2)).max(0.0).sqrt())
        }
        Pressure::Gaussian { peak_kpa, sigma_mm, base_kpa, .. } => {
            Box::new(move |r| base_kpa + peak_kpa * (-0.5 * (r / sigma_mm).powi(2)).exp())
        }
        Pressure::Table { ref file, .. } => {
            let rows = super::build::read_table(loaded, file)?;
            Box::new(move |r| interpolate(&rows, r))
        }
        Pressure::Disc { .. } | Pressure::Map { .. } | Pressure::Press => Box::new(|_| 0.0),
    })
}

/// Linear between rows of (r, value); the first value inside, 0 beyond the last.
fn interpolate(rows: &[[f64; 2]], r: f64) -> f64 {
    let after = rows.partition_point(|row| row[0] <= r);
    match (after.checked_sub(1).and_then(|k| rows.get(k)), rows.get(after)) {
        (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (r - a[0]) / (b[0] - a[0]),
        (None, Some(first)) => first[1],
        (Some(last), None) if last[0] == r => last[1],
        _ => 0.0,
    }
}
