//! Rules of the press: it fits phantom and stack, and nothing else says what it computes.

use super::bounds::{ANY, NOT_NEGATIVE, POSITIVE, above, number};
use super::{Invalid, all, phantom, scan};
use crate::scene::{
    Dimensions, FaceOutline, Indenter, Inner, Interface, Phantom, PhantomBody, Press, PressStep, PressedSensor,
    Pressure, Scene, Shape, Stack,
};
use std::ops::Bound;

/// Depths or forces of a press; each is at least one solve.
const MAX_LEVELS: usize = 100;
/// Largest tilt about an axis, degrees: a rim of 60 degrees still meets the face with its arc.
const MOST_TILT_DEG: f64 = 15.0;
/// Room for rounding where two outlines touch, mm.
const TOUCHING_MM: f64 = 1e-9;

pub(super) fn check(scene: &Scene) -> Result<(), Invalid> {
    let own = scene.phantom.as_ref().map_or(Ok(()), phantom::check);
    // What presses leans on what is pressed.
    let pressing = if own.is_ok() { pressing(scene) } else { Ok(()) };
    all([own, pressing])
}

fn pressing(scene: &Scene) -> Result<(), Invalid> {
    let from_press = matches!(&scene.touch.contact, Some(contact) if contact.pressure == Pressure::Press);
    let (phantom, press) = match (&scene.phantom, &scene.press) {
        (Some(phantom), Some(press)) => (phantom, press),
        (Some(_), None) => {
            let message = "nothing presses it; add [press], for example with depths_mm = [1.0]";
            return Err(Invalid::new("phantom", message));
        }
        (None, Some(_)) => return Err(Invalid::new("press", "has nothing to press; add a [phantom]")),
        (None, None) if from_press => {
            let message = "kind \"press\" needs a [press] and a [phantom]; add them or give another kind";
            return Err(Invalid::new("touch.contact.pressure", message));
        }
        (None, None) => return Ok(()),
    };
    let friction = match press.interface {
        Interface::Coulomb { friction } => number("press.interface.friction", friction, above(0.0, 10.0, true), 0.5),
        _ => Ok(()),
    };
    let face = face(press, scene.stack.footprint_mm, phantom);
    let on_face = match (&face, &press.indenter) {
        (Ok(()), None) => all([edge(press, &scene.stack), dimensions(press, phantom, scene)]),
        (Ok(()), Some(_)) => dimensions(press, phantom, scene),
        (Err(_), _) => Ok(()),
    };
    all([
        touch(scene, from_press),
        load(press, phantom.shape.height_mm()),
        sensor(press, &scene.stack),
        press.indenter.as_ref().map_or(Ok(()), |one| indenter(press, one)),
        face,
        on_face,
        tilt(press),
        friction,
        number("press.resolution", press.resolution, 0.25..=16.0, 1.0),
    ])
}

/// An indenter of some shape, which is rigid, slides, has no other edge, and whose footprint is or can be told.
fn indenter(press: &Press, indenter: &Indenter) -> Result<(), Invalid> {
    let rule = |holds: bool, key: &str, message: &str| if holds { Ok(()) } else { Err(Invalid::new(key, message)) };
    scan::indenter("press.indenter", indenter)?;
    let told = press.footprint.is_some() || press.forces_n.is_none() || indenter.flat_face_mm().is_some();
    let steps = press.step.iter().enumerate();
    let steps = steps.filter_map(|(index, step)| Some((format!("press.step[{index}].depth_mm"), step.depth_mm?)));
    let depths = press.depths_mm.iter().flatten().enumerate();
    let depths = depths.map(|(index, &depth)| (format!("press.depths_mm[{index}]"), depth));
    all([
        rule(
            press.sensor == PressedSensor::Rigid,
            "press.indenter",
            "takes the sensor's place; add sensor = \"rigid\"",
        ),
        scan::slides("press.interface", press.interface),
        rule(press.edge_radius_mm.is_none(), "press.edge_radius_mm", "the indenter has its own edge; leave it out"),
        rule(
            told,
            "press.forces_n",
            "how deep they press is not known: give footprint, as wide as the indenter will be below the face; for \
             example footprint = { kind = \"round\", radius_mm = 6.0 }",
        ),
        steps.chain(depths).try_for_each(|(key, depth)| scan::above_middle(indenter, &key, depth)),
    ])
}

fn sensor(press: &Press, stack: &Stack) -> Result<(), Invalid> {
    if press.sensor == PressedSensor::Deformable && stack.layer.iter().all(|layer| layer.elastic.is_none()) {
        let message = "no layer of the stack has elastic, so none can deform; give it, or sensor = \"rigid\"";
        return Err(Invalid::new("press.sensor", message));
    }
    Ok(())
}

/// Shape and pressure of the touched face come from the press alone.
fn touch(scene: &Scene, from_press: bool) -> Result<(), Invalid> {
    let rule = |holds: bool, key: &str, message: &str| if holds { Ok(()) } else { Err(Invalid::new(key, message)) };
    let flat = scene.touch.shape == Shape::Flat;
    let follows = scene.touch.inner == Inner::Follow;
    let pressed = scene.touch.contact.is_none() || from_press;
    all([
        rule(flat, "touch.shape", "the press gives the shape; leave it out or use kind = \"flat\""),
        rule(follows, "touch.inner", "the press moves the inner interfaces; leave it out"),
        rule(pressed, "touch.contact.pressure", "the press gives the pressure; use pressure = { kind = \"press\" }"),
    ])
}

fn load(press: &Press, phantom_height_mm: f64) -> Result<(), Invalid> {
    all([amount(press, phantom_height_mm), number("press.hold_s", press.hold_s, NOT_NEGATIVE, 10.0), speed(press)])
}

/// Depths or forces, ascending, or steps.
fn amount(press: &Press, phantom_height_mm: f64) -> Result<(), Invalid> {
    match (&press.depths_mm, &press.forces_n, press.step.as_slice()) {
        (Some(depths), None, []) => {
            ascending("press.depths_mm", depths, 1.0)?;
            if let Some(deepest) = depths.last().filter(|deepest| **deepest >= phantom_height_mm) {
                let message = format!("must be below the phantom's height of {phantom_height_mm}, reach {deepest}");
                return Err(Invalid::new("press.depths_mm", message));
            }
            Ok(())
        }
        (None, Some(forces), []) => ascending("press.forces_n", forces, 0.5),
        (None, None, []) => {
            let message = "give depths_mm, forces_n or [[press.step]]; for example depths_mm = [1.0, 2.0, 4.0]";
            Err(Invalid::new("press.depths_mm", message))
        }
        (None, None, steps) => self::steps(press, steps, phantom_height_mm),
        (Some(_), Some(_), _) => {
            let message = "give depths_mm or forces_n, not both; for example depths_mm = [1.0, 2.0, 4.0]";
            Err(Invalid::new("press.forces_n", message))
        }
        _ => Err(Invalid::new("press.step", "give steps, depths_mm or forces_n, one of them")),
    }
}

/// Steps that go somewhere or stay for a while, above the base.
fn steps(press: &Press, steps: &[PressStep], phantom_height_mm: f64) -> Result<(), Invalid> {
    if steps.len() > MAX_LEVELS {
        return Err(Invalid::new("press.step", format!("must have at most {MAX_LEVELS} steps, has {}", steps.len())));
    }
    if press.hold_s != 0.0 {
        return Err(Invalid::new("press.hold_s", "goes with depths_mm or forces_n; give hold_s of each step"));
    }
    for (index, step) in steps.iter().enumerate() {
        let key = |name: &str| format!("press.step[{index}].{name}");
        if let Some(depth) = step.depth_mm {
            let below = (Bound::Included(0.0), Bound::Excluded(phantom_height_mm));
            number(&key("depth_mm"), depth, below, 1.0)?;
        }
        for (axis, &slide) in step.slide_mm.iter().flatten().enumerate() {
            number(&key(&format!("slide_mm[{axis}]")), slide, ANY, 1.0)?;
        }
        number(&key("hold_s"), step.hold_s, NOT_NEGATIVE, 10.0)?;
        if step.hold_s > 0.0 && press.rate_mm_per_s.is_none() {
            let message = "without press.rate_mm_per_s the press is slow and nothing is left to relax; give it";
            return Err(Invalid::new(key("hold_s"), message));
        }
        if step.depth_mm.is_none() && step.slide_mm.is_none() && step.hold_s == 0.0 {
            let message = "changes nothing; give depth_mm, slide_mm or hold_s";
            return Err(Invalid::new(format!("press.step[{index}]"), message));
        }
    }
    if press.tilt_deg != [0.0; 2] && press.interface == Interface::Tied {
        let message = "a tied phantom has turned all the way at the last of depths_mm; give depths_mm, not steps";
        return Err(Invalid::new("press.tilt_deg", message));
    }
    Ok(())
}

fn speed(press: &Press) -> Result<(), Invalid> {
    match press.rate_mm_per_s {
        Some(_) if press.forces_n.is_some() => {
            let message = "goes with depths_mm: the speed of a press by force is not known; leave it out";
            Err(Invalid::new("press.rate_mm_per_s", message))
        }
        Some(rate) => number("press.rate_mm_per_s", rate, POSITIVE, 1.0),
        None if press.hold_s > 0.0 => {
            let message = "without rate_mm_per_s the press is slow and nothing is left to relax; give rate_mm_per_s";
            Err(Invalid::new("press.hold_s", message))
        }
        None => Ok(()),
    }
}

fn ascending(key: &str, values: &[f64], example: f64) -> Result<(), Invalid> {
    if values.is_empty() || values.len() > MAX_LEVELS {
        let message =
            format!("must have from 1 to {MAX_LEVELS} values, has {}; for example [{example:?}]", values.len());
        return Err(Invalid::new(key, message));
    }
    let mut before = 0.0;
    for (index, &value) in values.iter().enumerate() {
        let key = format!("{key}[{index}]");
        number(&key, value, POSITIVE, example)?;
        if value <= before {
            return Err(Invalid::new(key, format!("must ascend, is {value} after {before}")));
        }
        before = value;
    }
    Ok(())
}

/// A tilt within what contact between two faces follows, and a base whose turn is known.
fn tilt(press: &Press) -> Result<(), Invalid> {
    for (axis, &angle) in press.tilt_deg.iter().enumerate() {
        number(&format!("press.tilt_deg[{axis}]"), angle, -MOST_TILT_DEG..=MOST_TILT_DEG, 1.0)?;
    }
    if press.tilt_deg != [0.0; 2] && press.interface == Interface::Tied && press.forces_n.is_some() {
        let message = "a tied phantom has turned all the way at the last of depths_mm; give depths_mm, not forces_n";
        return Err(Invalid::new("press.tilt_deg", message));
    }
    Ok(())
}

/// The touched face lies within the stack's footprint, if that presses, and under the phantom. Of an indenter without a
/// footprint the axis does.
fn face(press: &Press, footprint_mm: [f64; 2], phantom: &Phantom) -> Result<(), Invalid> {
    let (half, names) = match press.footprint {
        Some(FaceOutline::Rectangle { .. }) if press.indenter.is_some() => {
            let message = "that of an indenter is round; for example { kind = \"round\", radius_mm = 6.0 }";
            return Err(Invalid::new("press.footprint", message));
        }
        Some(FaceOutline::Round { radius_mm }) => ([radius_mm; 2], ["press.footprint.radius_mm"; 2]),
        Some(FaceOutline::Rectangle { half_widths_mm }) => {
            (half_widths_mm, ["press.footprint.half_widths_mm[0]", "press.footprint.half_widths_mm[1]"])
        }
        None => (footprint_mm.map(|extent| extent / 2.0), ["press.footprint"; 2]),
    };
    for axis in 0..2 {
        number(&format!("press.offset_mm[{axis}]"), press.offset_mm[axis], ANY, 1.0)?;
        number(names[axis], half[axis], POSITIVE, 15.0)?;
        let room = if press.indenter.is_some() { f64::INFINITY } else { footprint_mm[axis] / 2.0 };
        if half[axis] > room + TOUCHING_MM {
            let message = format!("must be at most {room} to lie within stack.footprint_mm, is {}", half[axis]);
            return Err(Invalid::new(names[axis], message));
        }
    }
    let outline = press.footprint.unwrap_or(match press.indenter {
        Some(_) => FaceOutline::Round { radius_mm: 0.0 },
        None => FaceOutline::Rectangle { half_widths_mm: half },
    });
    let over = if press.offset_mm == [0.0; 2] { "press.footprint" } else { "press.offset_mm" };
    below_phantom(&outline, press.offset_mm, phantom, over)?;
    for (index, slide) in press.step.iter().enumerate().filter_map(|(index, step)| Some((index, step.slide_mm?))) {
        let place = [0, 1].map(|axis| press.offset_mm[axis] + slide[axis]);
        below_phantom(&outline, place, phantom, &format!("press.step[{index}].slide_mm"))?;
    }
    Ok(())
}

/// Whether the touched face lies below a phantom that is moved to a place.
fn below_phantom(face: &FaceOutline, place_mm: [f64; 2], phantom: &Phantom, key: &str) -> Result<(), Invalid> {
    let over = |reach: f64, room: f64| {
        let message =
            format!("the touched face reaches {reach} mm from the axis, over the phantom's side at {room} mm");
        Err(Invalid::new(key, message))
    };
    match &phantom.shape {
        PhantomBody::Cylinder { radius_mm, .. } => {
            let reach = farthest_mm(face, place_mm);
            if reach > radius_mm + TOUCHING_MM { over(reach, *radius_mm) } else { Ok(()) }
        }
        PhantomBody::Block { size_mm, .. } => {
            let half = face.half_widths_mm();
            let room = |axis: usize| size_mm[axis] / 2.0 - place_mm[axis].abs();
            match (0..2).find(|&axis| half[axis] > room(axis) + TOUCHING_MM) {
                Some(axis) => over(half[axis], room(axis)),
                None => Ok(()),
            }
        }
    }
}

/// Farthest point of a face from the axis of a phantom that is moved, mm.
fn farthest_mm(face: &FaceOutline, offset_mm: [f64; 2]) -> f64 {
    let [x, y] = offset_mm.map(f64::abs);
    match face {
        FaceOutline::Round { radius_mm } => radius_mm + x.hypot(y),
        FaceOutline::Rectangle { half_widths_mm } => (half_widths_mm[0] + x).hypot(half_widths_mm[1] + y),
    }
}

/// The rim's radius fits the touched face and the layer that carries it.
fn edge(press: &Press, stack: &Stack) -> Result<(), Invalid> {
    let key = "press.edge_radius_mm";
    let (radius, rigid) = (press.edge_radius_mm(stack), press.sensor == PressedSensor::Rigid);
    if rigid && press.interface != Interface::Tied && radius == 0.0 {
        let message =
            "must be positive where a rigid sensor slides: no elements resolve its sharp edge; for example 0.5";
        return Err(Invalid::new(key, message));
    }
    number(key, radius, NOT_NEGATIVE, 0.5)?;
    let room = press.largest_edge_radius_mm(stack);
    if radius > room {
        let message = format!("must be at most {room:.3}, a third of the touched face's half width, is {radius}");
        return Err(Invalid::new(key, message));
    }
    let top = stack.layer.iter().find(|layer| layer.elastic.is_some()).filter(|_| !rigid);
    if let Some(layer) = top.filter(|layer| radius > layer.thickness_mm) {
        let thickness = layer.thickness_mm;
        let message = format!("must be at most {thickness}, the thickness of the topmost soft layer, is {radius}");
        return Err(Invalid::new(key, message));
    }
    Ok(())
}

fn dimensions(press: &Press, phantom: &Phantom, scene: &Scene) -> Result<(), Invalid> {
    match press.asymmetry(phantom, &scene.stack) {
        Some(why) if press.dimensions == Dimensions::Two => {
            Err(Invalid::new("press.dimensions", format!("two needs bodies of revolution, and {why}; use \"auto\"")))
        }
        _ => Ok(()),
    }
}
