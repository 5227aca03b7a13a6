//! JSON schemas of the scene files, for editors and for the structure check.

use super::{ScanScene, Scene};
use schemars::SchemaGenerator;

/// The JSON schema (2020-12) of a sensor's scene file, made from the types that read it.
///
/// That of a scan scene is its definition `#/$defs/ScanScene`, so that one printed schema serves both kinds of file.
pub fn schema() -> serde_json::Value {
    let mut generator = SchemaGenerator::default();
    // Registered as a definition; the reference to it is not needed.
    let _reference = generator.subschema_for::<ScanScene>();
    generator.into_root_schema_for::<Scene>().to_value()
}

/// The JSON schema (2020-12) of a scan scene file.
pub fn scan_schema() -> serde_json::Value {
    schemars::schema_for!(ScanScene).to_value()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::PRESETS;
    use serde_json::Value;

    #[test]
    fn every_top_level_key_of_every_preset_is_in_the_schema() {
        let schema = schema();
        let properties = schema["properties"].as_object().unwrap();
        for (name, text) in PRESETS {
            let document: toml::Table = text.parse().unwrap();
            for key in document.keys() {
                assert!(properties.contains_key(key), "{name}: {key}");
            }
        }
    }

    /// Every table refuses unknown keys, and every key says what it means: editors show both.
    fn check_tables(at: &str, value: &Value) {
        if let Some(properties) = value.get("properties").and_then(Value::as_object) {
            assert_eq!(value["additionalProperties"], Value::Bool(false), "{at}");
            for (key, property) in properties.iter().filter(|(key, _)| !["kind", "law"].contains(&key.as_str())) {
                assert!(property.get("description").is_some(), "{at}.{key}");
            }
        }
        match value {
            Value::Object(map) => map.iter().for_each(|(key, inner)| check_tables(&format!("{at}/{key}"), inner)),
            Value::Array(items) => items.iter().for_each(|inner| check_tables(at, inner)),
            _ => {}
        }
    }

    #[test]
    fn every_table_is_closed_and_every_key_is_described() {
        check_tables("", &schema());
    }

    #[test]
    fn the_schema_of_scan_scenes_is_in_that_of_scenes() {
        let (both, scan) = (schema(), scan_schema());
        assert_eq!(both["$defs"]["ScanScene"]["properties"], scan["properties"]);
        assert!(scan["properties"]["scan"].is_object());
    }
}
