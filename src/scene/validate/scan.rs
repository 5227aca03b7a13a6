//! Rules of a scan: the indenter and its frames stay over the tissue.

use super::bounds::{ANY, NOT_NEGATIVE, POSITIVE, above, number, whole};
use super::shape::extension;
use super::stack::MAX_EXTENT_MM;
use super::{Invalid, all};
use crate::scene::{Indenter, Interface, PhantomBody, Scan, ScanScene};

pub(super) fn check(scene: &ScanScene) -> Result<(), Invalid> {
    let scan = &scene.scan;
    let PhantomBody::Block { size_mm, height_mm } = &scene.phantom.shape else {
        let message = "a scan is a plane section and needs a block; for example kind = \"block\"";
        return Err(Invalid::new("phantom.shape.kind", message));
    };
    let in_plane = all(scene.phantom.inclusion.iter().enumerate().map(|(index, inclusion)| {
        let key = format!("phantom.inclusion[{index}].center_mm[1]");
        number(&key, inclusion.center_mm[1], 0.0..=0.0, 0.0)
    }));
    let window = scan
        .window_mm
        .map_or(Ok(()), |window| number("scan.window_mm", window, above(0.0, scan.frame_half_width_mm, true), 8.0));
    let friction = match scan.interface {
        Interface::Coulomb { friction } => number("scan.interface.friction", friction, above(0.0, 10.0, true), 0.5),
        _ => Ok(()),
    };
    let width = number("scan.frame_half_width_mm", scan.frame_half_width_mm, POSITIVE, 15.0);
    let positions = positions(scan);
    let over_tissue = match (&width, &positions) {
        (Ok(()), Ok(())) => all([frames_fit(scan, size_mm[0] / 2.0), window]),
        _ => Ok(()),
    };
    let indenter = indenter("scan.indenter", &scan.indenter);
    let depth = if indenter.is_ok() { depth(scan, *height_mm) } else { Ok(()) };
    all([
        in_plane,
        indenter,
        depth,
        positions,
        width,
        over_tissue,
        whole("scan.frame_points", scan.frame_points.into(), 5..=10_000, 121),
        slides("scan.interface", scan.interface),
        friction,
        number("scan.resolution", scan.resolution, 0.25..=16.0, 1.0),
    ])
}

fn depth(scan: &Scan, height_mm: f64) -> Result<(), Invalid> {
    number("scan.depth_mm", scan.depth_mm, POSITIVE, 5.0)?;
    if scan.depth_mm >= height_mm {
        let message = format!("must be below the tissue's height of {height_mm}, is {}", scan.depth_mm);
        return Err(Invalid::new("scan.depth_mm", message));
    }
    above_middle(&scan.indenter, "scan.depth_mm", scan.depth_mm)
}

/// A round indenter stays above the tissue by half.
pub(super) fn above_middle(indenter: &Indenter, key: &str, depth_mm: f64) -> Result<(), Invalid> {
    match indenter {
        Indenter::Round { radius_mm } if depth_mm >= *radius_mm => {
            Err(Invalid::new(key, format!("must be below the indenter's radius of {radius_mm}, is {depth_mm}")))
        }
        _ => Ok(()),
    }
}

/// A face that wraps an indenter slides on it.
pub(super) fn slides(key: &str, interface: Interface) -> Result<(), Invalid> {
    if interface == Interface::Tied {
        let message = "a face that sticks from the start cannot wrap an indenter; take frictionless or coulomb";
        return Err(Invalid::new(key, message));
    }
    Ok(())
}

fn positions(scan: &Scan) -> Result<(), Invalid> {
    let positions = scan.positions_mm;
    all([
        number("scan.positions_mm.from", positions.from, ANY, -20.0),
        number("scan.positions_mm.to", positions.to, ANY, 20.0),
        whole("scan.positions_mm.count", positions.count.into(), 2..=1000, 41),
    ])?;
    if positions.to <= positions.from {
        let message = format!("must be above from ({}), is {}", positions.from, positions.to);
        return Err(Invalid::new("scan.positions_mm.to", message));
    }
    Ok(())
}

fn frames_fit(scan: &Scan, room: f64) -> Result<(), Invalid> {
    let reach = scan.positions_mm.from.abs().max(scan.positions_mm.to.abs()) + scan.frame_half_width_mm;
    if reach > room {
        let message = format!(
            "the outermost frame reaches {reach} mm from the middle, over the tissue's side at {room} mm; make the \
             block wider or the frames narrower"
        );
        return Err(Invalid::new("scan.frame_half_width_mm", message));
    }
    Ok(())
}

/// Lengths that are some, and a table that is one; `at` is the indenter's own key.
pub(super) fn indenter(at: &str, indenter: &Indenter) -> Result<(), Invalid> {
    let key = |name: &str| format!("{at}.{name}");
    match indenter {
        Indenter::Round { radius_mm } => number(&key("radius_mm"), *radius_mm, above(0.0, MAX_EXTENT_MM, true), 20.0),
        Indenter::RoundedFlat { flat_mm, edge_radius_mm } => {
            let flat = number(&key("flat_mm"), *flat_mm, NOT_NEGATIVE, 5.0);
            all([flat, number(&key("edge_radius_mm"), *edge_radius_mm, above(0.0, MAX_EXTENT_MM, true), 1.0)])
        }
        Indenter::Table { file } => extension(&key("file"), file, &["csv"]),
    }
}
