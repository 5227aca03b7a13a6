//! JSON schema of the scene file, for editors and for the structure check.

use super::Scene;

/// The JSON schema (2020-12) of a scene file, made from the types that read it.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Scene).to_value()
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
            for (key, property) in properties.iter().filter(|(key, _)| *key != "kind") {
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
}
