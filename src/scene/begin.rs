//! What a scene of one's own begins as.

use super::LoadedScene;

/// A scene to begin with.
#[derive(Debug)]
pub struct Beginning {
    /// What it is called.
    pub kind: &'static str,
    /// What it holds.
    pub holds: &'static str,
    /// The preset that it is at first.
    pub preset: &'static str,
    /// The keys that a user is likely to change, each with a question.
    pub questions: &'static [(&'static str, &'static str)],
}

const INDEX: (&str, &str) = ("stack.layer[0].n", "index of refraction of the touched layer");

const SENSOR: Beginning =
    Beginning { kind: "sensor", holds: "A sensor that nothing touches", preset: "flat-bonded", questions: &[INDEX] };
const DENT: Beginning = Beginning {
    kind: "dent",
    holds: "A sensor with a dent of a given shape",
    preset: "dent-cap",
    questions: &[INDEX, ("touch.shape.depth_mm", "depth of the dent, mm")],
};
const CONTACT: Beginning = Beginning {
    kind: "contact",
    holds: "A sensor that tissue touches in a disc",
    preset: "contact-disc",
    questions: &[INDEX, ("touch.contact.pressure.radius_mm", "radius of the disc, mm")],
};
/// A phantom with an inclusion: what most will want.
pub const PHANTOM: Beginning = Beginning {
    kind: "phantom",
    holds: "A phantom with an inclusion, pressed on the sensor",
    preset: "phantom-size-8mm",
    questions: &[
        ("phantom.inclusion[0].shape.diameter_mm", "diameter of the inclusion, mm"),
        ("phantom.inclusion[0].depth_mm", "its depth, from the touched face to its top, mm"),
        ("phantom.inclusion[0].material.youngs_kpa", "its Young's modulus, kPa"),
        ("phantom.material.youngs_kpa", "Young's modulus of the tissue around it, kPa"),
        INDEX,
    ],
};
/// All of them.
pub const BEGINNINGS: &[&Beginning] = &[&SENSOR, &DENT, &CONTACT, &PHANTOM];

impl Beginning {
    /// That of a kind.
    pub fn of(kind: &str) -> Option<&'static Self> {
        BEGINNINGS.iter().find(|one| one.kind == kind).copied()
    }

    /// The text of a scene that began so under another name, without what its file said of where its numbers come from;
    /// `schema` is the file by which an editor knows its keys.
    pub fn text(&self, loaded: &LoadedScene, name: &str, schema: &str) -> String {
        let preset = self.preset;
        let mut in_head = true;
        let body = loaded.text.lines().skip_while(|line| line.starts_with('#') || line.trim().is_empty());
        let body = body.filter(|line| {
            in_head &= !line.starts_with('[');
            !(in_head && ["name =", "description ="].iter().any(|key| line.starts_with(key)))
        });
        let body: String = body.flat_map(|line| [line, "\n"]).collect();
        format!(
            "#:schema {schema}\n\
             # Begun as preset:{preset}. Keys name their units; `tirtouch schema --markdown` explains each.\n\
             name = \"{name}\"\n\
             description = \"Begun as {preset}.\"\n\n{}",
            body.trim_start()
        )
    }
}

/// Whether a name can be that of a scene and of its file.
///
/// # Errors
/// Says what such a name is like.
pub fn check_name(name: &str) -> Result<(), &'static str> {
    let plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    match name.is_empty() || name.starts_with(['.', '-']) || !name.chars().all(plain) {
        true => Err("a name has letters, digits, - _ and . and begins with neither - nor ."),
        false => Ok(()),
    }
}
