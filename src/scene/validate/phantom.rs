//! Rules of the phantom: its layers fit into it, its inclusions lie inside it and apart, each in one layer.

use super::bounds::{ANY, NOT_NEGATIVE, POSITIVE, above, number};
use super::elastic;
use super::shape::extension;
use super::stack::MAX_EXTENT_MM;
use super::{Invalid, all};
use crate::scene::{DepthTo, Inclusion, InclusionBody, Phantom, PhantomBody};

/// Inclusions of a phantom; each asks for a mesh of its own.
const MAX_INCLUSIONS: usize = 32;
/// Layers of a phantom, the least thickness of one and of what is left below them, mm, and the room that an inclusion
/// needs to a layer's face, in units of half its height: elements between would be too flat.
const MAX_LAYERS: usize = 16;
const LEAST_LAYER_MM: f64 = 1e-3;
const LEAST_GAP: f64 = 0.005;
/// Room for rounding where an inclusion touches a face or another inclusion, mm.
const TOUCHING_MM: f64 = 1e-9;
/// Directions in which an ellipse's distance from the axis is looked at; it is then known to 1e-5 of its size.
const DIRECTIONS: usize = 1024;

pub(super) fn check(phantom: &Phantom) -> Result<(), Invalid> {
    let size = |name: &str, value: f64, example: f64| {
        number(&format!("phantom.shape.{name}"), value, above(0.0, MAX_EXTENT_MM, true), example)
    };
    let sides = match &phantom.shape {
        PhantomBody::Cylinder { radius_mm, .. } => size("radius_mm", *radius_mm, 30.0),
        PhantomBody::Block { size_mm, .. } => {
            all([size("size_mm[0]", size_mm[0], 60.0), size("size_mm[1]", size_mm[1], 60.0)])
        }
    };
    let body = all([sides, size("height_mm", phantom.shape.height_mm(), 25.0)]);
    let material = elastic::check("phantom.material", &phantom.material);
    let layers = layers(phantom);
    // Where the body is wrong, no place in it is right.
    let inside = if body.is_ok() && layers.is_ok() { inclusions(phantom) } else { Ok(()) };
    all([body, material, layers, inside])
}

fn layers(phantom: &Phantom) -> Result<(), Invalid> {
    if phantom.layer.len() > MAX_LAYERS {
        let message = format!("must have at most {MAX_LAYERS} layers, has {}", phantom.layer.len());
        return Err(Invalid::new("phantom.layer", message));
    }
    let height = phantom.shape.height_mm();
    let mut depth = 0.0;
    all(phantom.layer.iter().enumerate().map(|(index, layer)| {
        let key = format!("phantom.layer[{index}]");
        let thickness = number(&format!("{key}.thickness_mm"), layer.thickness_mm, LEAST_LAYER_MM..height, 2.0);
        depth += layer.thickness_mm;
        let room = if thickness.is_ok() && depth > height - LEAST_LAYER_MM {
            let message = format!(
                "reaches {depth} mm deep, and the phantom of {height} mm has no room for its own material below; make \
                 the layers thinner, or give the lowest as phantom.material"
            );
            Err(Invalid::new(format!("{key}.thickness_mm"), message))
        } else {
            thickness
        };
        all([room, elastic::check(&format!("{key}.material"), &layer.material)])
    }))
}

/// Whether an inclusion from one depth to another, mm, lies in one layer.
fn within_layer(key: &str, phantom: &Phantom, [top, bottom]: [f64; 2]) -> Result<(), Invalid> {
    let mut face = 0.0;
    let least = LEAST_GAP * 0.5 * (bottom - top);
    for (index, layer) in phantom.layer.iter().enumerate() {
        face += layer.thickness_mm;
        if top < face + least - TOUCHING_MM && face - least + TOUCHING_MM < bottom {
            let message = format!(
                "the inclusion reaches from {top} to {bottom} mm deep, across the lower face of phantom.layer[{index}] \
                 at {face} mm or nearer to it than {least} mm; an inclusion lies in one layer"
            );
            return Err(Invalid::new(format!("{key}.depth_mm"), message));
        }
    }
    Ok(())
}

fn inclusions(phantom: &Phantom) -> Result<(), Invalid> {
    let inclusions = &phantom.inclusion;
    if inclusions.len() > MAX_INCLUSIONS {
        let message = format!("must have at most {MAX_INCLUSIONS} inclusions, has {}", inclusions.len());
        return Err(Invalid::new("phantom.inclusion", message));
    }
    let one = |(index, one): (usize, &Inclusion)| {
        let key = format!("phantom.inclusion[{index}]");
        inclusion(&key, one, phantom)?;
        for (other_index, other) in inclusions.iter().enumerate().take(index) {
            if overlap(one, other) {
                let message = format!("overlaps phantom.inclusion[{other_index}]; move them apart");
                return Err(Invalid::new(key, message));
            }
        }
        Ok(())
    };
    all(inclusions.iter().enumerate().map(one))
}

fn inclusion(key: &str, one: &Inclusion, phantom: &Phantom) -> Result<(), Invalid> {
    let size = match &one.shape {
        InclusionBody::Sphere { diameter_mm } => {
            number(&format!("{key}.shape.diameter_mm"), *diameter_mm, above(0.0, MAX_EXTENT_MM, true), 8.0)
        }
        InclusionBody::Ellipsoid { semi_axes_mm } => all(semi_axes_mm.iter().enumerate().map(|(axis, semi)| {
            let key = format!("{key}.shape.semi_axes_mm[{axis}]");
            number(&key, *semi, above(0.0, MAX_EXTENT_MM, true), 4.0)
        })),
        InclusionBody::Mesh { file, scale } => all([
            extension(&format!("{key}.shape.file"), file, &["obj", "stl", "ply"]),
            number(&format!("{key}.shape.scale"), *scale, POSITIVE, 1.0),
        ]),
    };
    let center = |axis: usize| number(&format!("{key}.center_mm[{axis}]"), one.center_mm[axis], ANY, 0.0);
    let depth = number(&format!("{key}.depth_mm"), one.depth_mm, NOT_NEGATIVE, 5.0);
    let place = all([size, depth, center(0), center(1)]);
    let inside = if place.is_ok() { within(key, one, phantom) } else { Ok(()) };
    all([place, inside, elastic::check(&format!("{key}.material"), &one.material)])
}

fn within(key: &str, one: &Inclusion, phantom: &Phantom) -> Result<(), Invalid> {
    // A mesh is not read yet; the finite-element mesh refuses one that sticks out.
    let Some(semi) = one.shape.semi_axes_mm() else {
        return Ok(());
    };
    let center = one.center_depth_mm(semi[2]);
    all([
        within_height(key, one, semi[2], phantom.shape.height_mm()),
        within_layer(key, phantom, [center - semi[2], center + semi[2]]),
        within_sides(key, one, semi, &phantom.shape),
    ])
}

fn within_height(key: &str, one: &Inclusion, half_height: f64, phantom_height: f64) -> Result<(), Invalid> {
    let sticks_out = |face: &str, by: f64, because: String| {
        let message = format!("the inclusion sticks out of the {face} by {by} mm: {because}");
        Err(Invalid::new(format!("{key}.depth_mm"), message))
    };
    let center = one.center_depth_mm(half_height);
    if center < half_height - TOUCHING_MM {
        let because = format!("depth to centre {center} mm is less than its half height {half_height} mm");
        return sticks_out("touched face", half_height - center, because);
    }
    let bottom = center + half_height;
    if bottom > phantom_height + TOUCHING_MM {
        let to = match one.depth_to {
            DepthTo::Top => format!("depth to top {} mm and height {} mm", one.depth_mm, 2.0 * half_height),
            DepthTo::Center => format!("depth to centre {} mm and half height {half_height} mm", one.depth_mm),
        };
        let because = format!("{to} are more than the phantom's height {phantom_height} mm");
        return sticks_out("base", bottom - phantom_height, because);
    }
    Ok(())
}

fn within_sides(key: &str, one: &Inclusion, semi: [f64; 3], body: &PhantomBody) -> Result<(), Invalid> {
    let [x, y] = one.center_mm;
    let sticks_out = |key: String, by: f64, reach: f64, room: f64| {
        let message = format!(
            "the inclusion sticks out of the phantom's side by {by} mm: it reaches {reach} mm from the axis, the \
             phantom {room} mm"
        );
        Err(Invalid::new(key, message))
    };
    match body {
        PhantomBody::Cylinder { radius_mm, .. } => {
            let reach = (0..DIRECTIONS)
                .map(|k| {
                    let (sin, cos) = (std::f64::consts::TAU * k as f64 / DIRECTIONS as f64).sin_cos();
                    (x + semi[0] * cos).hypot(y + semi[1] * sin)
                })
                .fold(0.0, f64::max);
            if reach > radius_mm + TOUCHING_MM {
                return sticks_out(format!("{key}.center_mm"), reach - radius_mm, reach, *radius_mm);
            }
        }
        PhantomBody::Block { size_mm, .. } => {
            for axis in 0..2 {
                let (reach, room) = (one.center_mm[axis].abs() + semi[axis], size_mm[axis] / 2.0);
                if reach > room + TOUCHING_MM {
                    return sticks_out(format!("{key}.center_mm[{axis}]"), reach - room, reach, room);
                }
            }
        }
    }
    Ok(())
}

/// Whether two ellipsoids share more than a point. Meshes are left to the finite-element mesh.
fn overlap(one: &Inclusion, other: &Inclusion) -> bool {
    let (Some(a), Some(b)) = (one.shape.semi_axes_mm(), other.shape.semi_axes_mm()) else {
        return false;
    };
    let center = |inclusion: &Inclusion, semi: [f64; 3]| {
        [inclusion.center_mm[0], inclusion.center_mm[1], inclusion.center_depth_mm(semi[2])]
    };
    let (from, to) = (center(one, a), center(other, b));
    // Scaled along the axes so that the second becomes the unit ball, the first stays an ellipsoid.
    let scaled = std::array::from_fn(|i| a[i] / b[i]);
    let point = std::array::from_fn(|i| (to[i] - from[i]) / b[i]);
    let smallest = b.into_iter().fold(f64::INFINITY, f64::min);
    distance_to_ellipsoid(point, scaled) < 1.0 - TOUCHING_MM / smallest
}

/// Distance from a point to an ellipsoid about the origin, 0 inside.
///
/// The nearest point is a^2 y/(a^2 + t) along each axis, with the root t >= 0 of sum (a y/(a^2 + t))^2 = 1 (Eberly,
/// "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid", 2013).
fn distance_to_ellipsoid(point: [f64; 3], semi: [f64; 3]) -> f64 {
    let outside = |t: f64| (0..3).map(|i| (semi[i] * point[i] / (semi[i].powi(2) + t)).powi(2)).sum::<f64>() > 1.0;
    if !outside(0.0) {
        return 0.0;
    }
    // There the sum is at most |a y|^2/t^2 = 1.
    let mut range = [0.0, (0..3).map(|i| (semi[i] * point[i]).powi(2)).sum::<f64>().sqrt()];
    // Each turn halves the range: 100 are more than the digits of a number.
    for _ in 0..100 {
        let middle = 0.5 * (range[0] + range[1]);
        range[usize::from(!outside(middle))] = middle;
    }
    (0..3).map(|i| (point[i] * range[1] / (semi[i].powi(2) + range[1])).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_to_an_ellipsoid_is_right_on_its_axes_and_for_a_sphere() {
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(close(distance_to_ellipsoid([5.0, 0.0, 0.0], [2.0, 1.0, 3.0]), 3.0));
        assert!(close(distance_to_ellipsoid([0.0, 0.0, -4.0], [2.0, 1.0, 3.0]), 1.0));
        assert!(close(distance_to_ellipsoid([2.0, 3.0, 6.0], [2.0; 3]), 5.0));
        assert_eq!(distance_to_ellipsoid([1.0, 0.5, 0.0], [2.0, 1.0, 3.0]), 0.0);
        // The point one unit along the outward normal of the ellipse at 45 degrees.
        let (a, b, s) = (3.0_f64, 2.0_f64, 0.5_f64.sqrt());
        let (nx, ny) = (s / a, s / b);
        let length = nx.hypot(ny);
        assert!(close(distance_to_ellipsoid([a * s + nx / length, b * s + ny / length, 0.0], [a, b, 1.0]), 1.0));
    }
}
