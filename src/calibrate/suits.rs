//! Whether a calibration suits a scene.

use super::FrameModel;
use super::estimates::short;
use super::model::Role;
use crate::scene::{Camera, LoadedScene, Scene, parse};
use crate::vary::KeyPath;
use std::path::Path;

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
        let scene = serde_json::to_value(&loaded.scene).map_err(|error| error.to_string())?;
        let at = |key: &str| scene.pointer(&format!("/{}", key.replace(['.', '['], "/").replace(']', "")))?.as_f64();
        let others = self.learnt.scored.unknowns.iter().zip(&self.keys).zip(&self.roles);
        let others = others.filter(|(_, role)| **role == Role::Other);
        let mut outside =
            others.flat_map(|((one, keys), _)| keys.iter().map(move |key| (one, key))).filter_map(|(one, key)| {
                let [low, high] = one.prior.bounds().map(|end| one.prior.value(end));
                let value = at(key).filter(|value| !(low..=high).contains(value))?;
                Some(format!("it was learnt of {key} from {} to {}, the scene has {value}", short(low), short(high)))
            });
        outside.next().map_or(Ok(()), Err)
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

    /// A scene without what may differ, as it would be written with all its keys: those that a text leaves to their
    /// defaults count too.
    fn bare(&self, scene: &Scene) -> Result<toml::Value, String> {
        let text = toml::to_string(scene).map_err(|error| error.to_string())?;
        let document = text.parse::<toml_edit::DocumentMut>();
        let mut document = document.map_err(|error| error.to_string())?;
        for key in self.keys.iter().flatten() {
            let path = key.parse::<KeyPath>()?;
            path.set(document.as_item_mut(), &toml::Value::Float(1.0))?;
        }
        let table = document.to_string().parse::<toml::Table>().map_err(|error| error.to_string())?;
        let mut value = toml::Value::Table(table);
        let sensor_mm = sensor_mm(&value);
        for key in ["name", "description", "render"] {
            remove(&mut value, &[key]);
        }
        for key in ["depths_mm", "estimate_error", "resolution"] {
            remove(&mut value, &["press", key]);
        }
        for key in ["pixels", "pixel_pitch_um", "sensor"] {
            remove(&mut value, &["camera", key]);
        }
        if let Some(camera) = value.get_mut("camera").and_then(toml::Value::as_table_mut) {
            camera.insert("pixels times pixel_pitch_um".into(), toml::Value::Array(sensor_mm));
        }
        Ok(value)
    }
}

/// Extent of the sensor, mm, to a thousandth.
fn sensor_mm(scene: &toml::Value) -> Vec<toml::Value> {
    let camera = scene.get("camera");
    let pitch = camera.and_then(|camera| camera.get("pixel_pitch_um")).and_then(number).unwrap_or(0.0);
    let pixels = camera.and_then(|camera| camera.get("pixels")).and_then(toml::Value::as_array);
    let extent = |pixels: &toml::Value| (number(pixels).unwrap_or(0.0) * pitch).round() * 1e-3;
    pixels.into_iter().flatten().map(|pixels| toml::Value::Float(extent(pixels))).collect()
}

fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|v| v as f64))
}

fn remove(value: &mut toml::Value, path: &[&str]) {
    if let ([last], Some(table)) = (path, value.as_table_mut()) {
        table.remove(*last);
    } else if let [first, rest @ ..] = path
        && let Some(inner) = value.get_mut(*first)
    {
        remove(inner, rest);
    }
}

/// The first key that differs.
fn difference(a: &toml::Value, b: &toml::Value, at: &str) -> Option<String> {
    match (a, b) {
        (toml::Value::Table(a), toml::Value::Table(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            let inner = |key: &String| if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
            let mut keys = keys.filter_map(|key| match (a.get(key), b.get(key)) {
                (Some(a), Some(b)) => difference(a, b, &inner(key)),
                _ => Some(inner(key)),
            });
            keys.next()
        }
        (toml::Value::Array(a), toml::Value::Array(b)) if a.len() == b.len() => {
            let mut inner = a.iter().zip(b).enumerate();
            inner.find_map(|(k, (a, b))| difference(a, b, &format!("{at}[{k}]")))
        }
        (a, b) if number(a).is_some() && number(a) == number(b) => None,
        (a, b) => (a != b).then(|| at.to_owned()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::calibrate::ready;
    use crate::scene::preset;

    #[test]
    fn a_scene_suits_however_it_is_written_and_not_once_its_sensor_differs() {
        let model = ready().unwrap();
        let mut loaded = preset("phantom-size-8mm").unwrap();
        let with_defaults = parse(&toml::to_string(&loaded.scene).unwrap(), Path::new("all.toml")).unwrap();
        assert_ne!(with_defaults.text, loaded.text);
        assert_eq!((model.suits(&loaded), model.suits(&with_defaults)), (Ok(()), Ok(())));
        // Changed in memory: the text stays as it was.
        loaded.scene.stack.layer[0].n = Some(1.45);
        assert!(model.suits(&loaded).unwrap_err().contains("stack.layer[0].n"));
    }
}
