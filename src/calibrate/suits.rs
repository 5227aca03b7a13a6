//! Whether a calibration suits a scene.

use super::FrameModel;
use super::estimates::short;
use super::model::Role;
use crate::scene::{Camera, LoadedScene, Scene, parse};
use crate::vary::KeyPath;
use serde_json::{Value, to_value};
use std::path::Path;

/// What may differ beside the unknowns. The sensor's extent, which pixels of a size make, may not.
const FREE: [&str; 9] = [
    "name",
    "description",
    "render",
    "press.depths_mm",
    "press.estimate_error",
    "press.resolution",
    "camera.pixels",
    "camera.pixel_pitch_um",
    "camera.sensor",
];
const EXTENT: &str = "pixels times pixel_pitch_um";

impl FrameModel {
    /// Whether frames of a scene are those of this sensor, with phantoms of this kind.
    ///
    /// # Errors
    /// Says what differs.
    pub fn suits(&self, loaded: &LoadedScene) -> Result<(), String> {
        let own = parse(&self.scene, Path::new("calibration")).map_err(|error| error.to_string())?;
        let (ours, theirs) = (self.bare(&own.scene)?, self.bare(&loaded.scene)?);
        if let Some(key) = difference(&ours, &theirs, "") {
            return Err(format!("it was learnt of a scene with another {key}"));
        }
        // What an inclusion is like is what is asked; all else that varied must be within what was learnt.
        let mut scene = to_value(&loaded.scene).map_err(|error| error.to_string())?;
        let unknowns = self.learnt.scored.unknowns.iter().zip(&self.keys).zip(&self.roles);
        for ((one, keys), _) in unknowns.filter(|(_, role)| **role == Role::Other) {
            let [low, high] = one.prior.bounds().map(|end| one.prior.value(end));
            for key in keys {
                let values = key.parse::<KeyPath>()?.values_in(&mut scene);
                let mut values = values.into_iter().filter_map(|value| value.as_f64());
                if let Some(value) = values.find(|value| !(low..=high).contains(value)) {
                    let learnt = format!("{} to {}", short(low), short(high));
                    return Err(format!("it was learnt of {key} from {learnt}, the scene has {value}"));
                }
            }
        }
        Ok(())
    }

    /// The camera that took frames of so many pixels, and the wavelength of its light, nm: that of a scene, else the
    /// calibration's own.
    ///
    /// # Errors
    /// Says why there is none.
    pub fn camera_of(&self, scene: Option<&LoadedScene>, [width, height]: [u32; 2]) -> Result<(Camera, f64), String> {
        if let Some(loaded) = scene {
            self.suits(loaded).map_err(|why| format!("the calibration does not suit: {why}"))?;
            return Ok((loaded.scene.camera.clone(), loaded.scene.light.wavelength_nm));
        }
        let own = self.camera([width, height]);
        own.ok_or_else(|| format!("{width} x {height} pixels do not fill the calibration's sensor"))
    }

    /// A scene without what may differ, with all its keys: those that a text leaves to their defaults count too.
    fn bare(&self, scene: &Scene) -> Result<Value, String> {
        let mut value = to_value(scene).map_err(|error| error.to_string())?;
        let extent = sensor_mm(&value);
        for key in FREE.into_iter().chain(self.keys.iter().flatten().map(String::as_str)) {
            key.parse::<KeyPath>()?.values_in(&mut value).into_iter().for_each(|value| *value = Value::Null);
        }
        if let Some(camera) = value["camera"].as_object_mut() {
            camera.insert(EXTENT.into(), extent.into());
        }
        Ok(value)
    }
}

/// Extent of the sensor, mm, to a thousandth.
fn sensor_mm(scene: &Value) -> Vec<f64> {
    let camera = &scene["camera"];
    let pitch = camera["pixel_pitch_um"].as_f64().unwrap_or(0.0);
    let extent = |pixels: &Value| (pixels.as_f64().unwrap_or(0.0) * pitch).round() * 1e-3;
    camera["pixels"].as_array().into_iter().flatten().map(extent).collect()
}

/// The first key that differs.
fn difference(a: &Value, b: &Value, at: &str) -> Option<String> {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            let mut keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            keys.find_map(|key| {
                let inner = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
                let [a, b] = [a, b].map(|table| table.get(key).unwrap_or(&Value::Null));
                difference(a, b, &inner)
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let mut inner = a.iter().zip(b).enumerate();
            inner.find_map(|(k, (a, b))| difference(a, b, &format!("{at}[{k}]")))
        }
        (a, b) if a.is_number() && a.as_f64() == b.as_f64() => None,
        (a, b) => (a != b).then(|| at.to_owned()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::calibrate::ready;
    use crate::scene::preset;

    fn without_nulls(value: &mut Value) {
        match value {
            Value::Object(table) => {
                table.retain(|_, inner| !inner.is_null());
                table.values_mut().for_each(without_nulls);
            }
            Value::Array(list) => list.iter_mut().for_each(without_nulls),
            _ => {}
        }
    }

    #[test]
    fn a_scene_suits_however_it_is_written_and_not_once_its_sensor_differs() {
        let model = ready().unwrap();
        let mut loaded = preset("phantom-size-8mm").unwrap();
        let mut all = to_value(&loaded.scene).unwrap();
        without_nulls(&mut all);
        let with_defaults = parse(&toml::to_string(&all).unwrap(), Path::new("all.toml")).unwrap();
        assert_eq!(with_defaults.scene, loaded.scene);
        assert_ne!(with_defaults.text, loaded.text);
        assert_eq!((model.suits(&loaded), model.suits(&with_defaults)), (Ok(()), Ok(())));
        // Changed in memory: the text stays as it was.
        loaded.scene.stack.layer[0].n = Some(1.45);
        assert!(model.suits(&loaded).unwrap_err().contains("stack.layer[0].n"));
    }

    #[test]
    fn all_places_of_a_key_must_be_within_what_was_learnt() {
        let mut model = ready().unwrap().clone();
        let mut loaded = preset("phantom-size-8mm").unwrap();
        let other = model.roles.iter().position(|role| *role == Role::Other).unwrap();
        // 5 mW are within what it was learnt of, as 5 kPa are.
        model.keys[other] = vec!["led[*].power_mw".into()];
        assert_eq!(model.suits(&loaded), Ok(()));
        loaded.scene.led[3].power_mw = Some(50.0);
        let why = model.suits(&loaded).unwrap_err();
        assert!(why.contains("led[*].power_mw") && why.ends_with("50"), "{why}");
    }
}
