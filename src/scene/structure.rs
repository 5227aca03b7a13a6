//! Structure of a scene file: every table against the JSON schema of its type.
//!
//! Serde reads the same types, but through a buffer where a table is told by its `kind`: there it forgets the place of
//! a mistake, and beside a `kind` without fields it lets unknown keys pass. The schema is made from the same types, so
//! this check names key, line and what would be right, and refuses what serde would overlook.

use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A mistake of structure.
pub(super) struct Fault {
    pub kind: &'static str,
    pub key: String,
    pub message: String,
}

impl Fault {
    fn new(kind: &'static str, key: &str, message: String) -> Self {
        Self { kind, key: key.to_owned(), message }
    }
}

/// The mistakes in keys, types and finiteness of a whole scene document, in the order in which they are met.
pub(super) fn faults(document: &DeTable<'_>, schema: &Value) -> Vec<Fault> {
    let mut found = Vec::new();
    Walk { root: schema }.table("", document, schema, &mut found);
    found
}

struct Walk<'s> {
    root: &'s Value,
}

impl<'s> Walk<'s> {
    /// Follows references, and the present side of what may be absent.
    fn resolve(&self, mut schema: &'s Value) -> &'s Value {
        loop {
            let pointer = schema.get("$ref").and_then(Value::as_str).and_then(|r| r.strip_prefix('#'));
            let target = pointer.and_then(|p| self.root.pointer(p)).or_else(|| {
                let any = schema.get("anyOf")?.as_array()?;
                any.iter().find(|one| one.get("type").and_then(Value::as_str) != Some("null"))
            });
            match target {
                Some(inner) => schema = inner,
                None => return schema,
            }
        }
    }

    fn value(&self, key: &str, value: &Spanned<DeValue<'_>>, described: &'s Value, found: &mut Vec<Fault>) {
        let schema = self.resolve(described);
        match (schema.get("oneOf").and_then(Value::as_array), type_name(schema), value.get_ref()) {
            (Some(choices), _, value) => match self.choice(key, value, choices) {
                Ok(Some((table, schema))) => self.table(key, table, schema, found),
                Ok(None) => {}
                Err(fault) => found.push(fault),
            },
            (None, "object", DeValue::Table(table)) => self.table(key, table, schema, found),
            (None, "array", DeValue::Array(items)) => match self.plain(key, value.get_ref(), described) {
                Ok(()) => {
                    let item_schema = schema.get("items").unwrap_or(&Value::Null);
                    for (index, item) in items.iter().enumerate() {
                        self.value(&format!("{key}[{index}]"), item, item_schema, found);
                    }
                }
                Err(fault) => found.push(fault),
            },
            (None, _, value) => found.extend(self.plain(key, value, described).err()),
        }
    }

    /// A value that is no table; of a list its length.
    fn plain(&self, key: &str, value: &DeValue<'_>, described: &'s Value) -> Result<(), Fault> {
        let schema = self.resolve(described);
        let fits = match (type_name(schema), value) {
            ("array", DeValue::Array(items)) => {
                let length = |bound: &str| schema.get(bound).and_then(Value::as_u64);
                if length("minItems").is_some_and(|n| (items.len() as u64) < n)
                    || length("maxItems").is_some_and(|n| items.len() as u64 > n)
                {
                    let wanted = length("minItems").unwrap_or(0);
                    let message = format!("must have {wanted} values, has {}{}", items.len(), meaning(described));
                    return Err(Fault::new("wrong_type", key, message));
                }
                true
            }
            ("number", DeValue::Float(number)) => {
                if !number.as_str().parse().is_ok_and(f64::is_finite) {
                    let message = format!("must be a finite number, is {number}{}", meaning(described));
                    return Err(Fault::new("invalid_value", key, message));
                }
                true
            }
            ("number", DeValue::Integer(number)) => in_range(number, i64::MIN.into(), i64::MAX.into()),
            ("integer", DeValue::Integer(number)) => {
                let most = if schema.get("format").and_then(Value::as_str) == Some("uint32") {
                    u32::MAX.into()
                } else {
                    // Integers of a TOML file are signed 64-bit.
                    i64::MAX.into()
                };
                if !in_range(number, 0, most) {
                    let message = format!("must be a whole number from 0 to {most}, is {number}{}", meaning(described));
                    return Err(Fault::new("invalid_value", key, message));
                }
                true
            }
            ("string", DeValue::String(_)) | ("boolean", DeValue::Boolean(_)) => true,
            _ => also(schema, value),
        };
        if fits {
            return Ok(());
        }
        let message = format!("must be {}, is {}{}", wanted(schema), shown(value), meaning(described));
        Err(Fault::new("wrong_type", key, message))
    }

    fn table(&self, key: &str, table: &DeTable<'_>, schema: &'s Value, found: &mut Vec<Fault>) {
        let Some(properties) = schema.get("properties").and_then(Value::as_object) else {
            return;
        };
        let path = |name: &str| {
            if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") }
        };
        // A misspelt table would otherwise show first as what is missing or wrong elsewhere.
        let names: Vec<&str> = properties.keys().map(String::as_str).collect();
        let mut slips = Vec::new();
        for (name, _) in table {
            if !properties.contains_key(name.get_ref().as_ref()) {
                let meant = did_you_mean(name.get_ref(), &names);
                let message = format!("unknown key{meant}; the keys here are {}", names.join(", "));
                found.push(Fault::new("unknown_key", &path(name.get_ref()), message));
                slips.push(meant);
            }
        }
        for (name, value) in table {
            if let Some(property) = properties.get(name.get_ref().as_ref()) {
                let before = found.len();
                self.value(&path(name.get_ref()), value, property, found);
                // Where a table is misspelt, what it holds is not also missing in the right one.
                if slips.contains(&did_you_mean(name.get_ref(), &[name.get_ref()])) {
                    let inside = found.split_off(before);
                    found.extend(inside.into_iter().filter(|fault| fault.kind != "missing_key"));
                }
            }
        }
        let required = schema.get("required").and_then(Value::as_array).into_iter().flatten();
        for name in required.filter_map(Value::as_str) {
            // What is unknown may be what is missing.
            if slips.is_empty() && !table.iter().any(|(present, _)| present.get_ref() == name) {
                let property = properties.get(name).unwrap_or(&Value::Null);
                let message = format!("is missing; give {}{}", wanted(self.resolve(property)), meaning(property));
                found.push(Fault::new("missing_key", &path(name), message));
            }
        }
    }

    /// One of several names, or one of several tables told apart by one of their keys: `kind`, or `law` for materials.
    /// Of a table, it and what it must be.
    fn choice<'v, 't>(
        &self,
        key: &str,
        value: &'v DeValue<'t>,
        choices: &'s [Value],
    ) -> Result<Option<(&'v DeTable<'t>, &'s Value)>, Fault> {
        let names: Vec<&str> = choices.iter().filter_map(choice_name).collect();
        let tagged = choices.iter().any(|one| one.get("properties").is_some());
        let (key_of_name, name) = match value {
            DeValue::Table(table) if tagged => {
                let tag = tag(choices);
                let kind_key = format!("{key}.{tag}");
                match table.iter().find(|(present, _)| present.get_ref() == tag) {
                    Some((_, kind)) => (kind_key, kind.get_ref()),
                    None => {
                        let message = format!("is missing; give one of {}", quoted(&names));
                        return Err(Fault::new("missing_key", &kind_key, message));
                    }
                }
            }
            _ if tagged => {
                let example = names.first().unwrap_or(&"");
                let tag = tag(choices);
                let message = format!(
                    "must be a table with a {tag} ({}), is {}; for example {{ {tag} = \"{example}\" }}",
                    quoted(&names),
                    shown(value)
                );
                return Err(Fault::new("wrong_type", key, message));
            }
            _ => (key.to_owned(), value),
        };
        let chosen = choices.iter().find(|one| choice_name(one) == name.as_str());
        match (chosen, value) {
            (Some(schema), DeValue::Table(table)) if name.as_str().is_some() => Ok(Some((table, schema))),
            (Some(_), _) if name.as_str().is_some() => Ok(None),
            _ => {
                let hint = name.as_str().map(|name| did_you_mean(name, &names)).unwrap_or_default();
                let message = format!("must be one of {}, is {}{hint}", quoted(&names), shown(name));
                Err(Fault::new("invalid_value", &key_of_name, message))
            }
        }
    }
}

fn choice_name(choice: &Value) -> Option<&str> {
    choice_tag(choice).map(|(_, name)| name).or_else(|| choice.get("const")?.as_str())
}

/// The key that tells a table of a choice from the others, and its value there.
fn choice_tag(choice: &Value) -> Option<(&str, &str)> {
    let properties = choice.get("properties")?.as_object()?;
    properties.iter().find_map(|(key, property)| Some((key.as_str(), property.get("const")?.as_str()?)))
}

fn tag(choices: &[Value]) -> &str {
    choices.iter().find_map(choice_tag).map_or("kind", |(key, _)| key)
}

fn type_name(schema: &Value) -> &str {
    match schema.get("type") {
        Some(Value::String(name)) => name,
        Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).find(|n| *n != "null").unwrap_or(""),
        _ => "",
    }
}

/// Whether a value is of a later one of several types.
fn also(schema: &Value, value: &DeValue<'_>) -> bool {
    let types = schema.get("type").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str).skip(1);
    types.into_iter().any(|name| {
        matches!(
            (name, value),
            ("string", DeValue::String(_)) | ("boolean", DeValue::Boolean(_)) | ("array", DeValue::Array(_))
        )
    })
}

fn in_range(number: &toml::de::DeInteger<'_>, least: i128, most: i128) -> bool {
    i128::from_str_radix(number.as_str(), number.radix()).is_ok_and(|n| (least..=most).contains(&n))
}

/// What a schema wants, in words.
fn wanted(schema: &Value) -> String {
    if let Some(choices) = schema.get("oneOf").and_then(Value::as_array) {
        let names: Vec<&str> = choices.iter().filter_map(choice_name).collect();
        let tagged = choices.iter().any(|one| one.get("properties").is_some());
        let lead = if tagged { format!("a table with a {} of", tag(choices)) } else { "one of".to_owned() };
        return format!("{lead} {}", quoted(&names));
    }
    match type_name(schema) {
        "object" => "a table",
        "array" => match schema.get("minItems") {
            Some(count) => return format!("a list of {count} values"),
            None => "a list",
        },
        "number" => "a number",
        "integer" => "a whole number",
        "boolean" => "true or false",
        _ => "a string",
    }
    .to_owned()
}

/// The documentation of a key, as the end of a message.
fn meaning(schema: &Value) -> String {
    match schema.get("description").and_then(Value::as_str) {
        Some(text) => format!(" ({})", text.trim_end_matches('.').replace('\n', " ")),
        None => String::new(),
    }
}

/// A value as a message shows it; long ones by their type alone.
fn shown(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) if text.chars().count() <= 40 => format!("{:?}", text.as_ref()),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(flag) => flag.to_string(),
        DeValue::String(_) => "a long string".to_owned(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
        DeValue::Datetime(_) => "a date".to_owned(),
    }
}

fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

/// The nearest right name, when the wrong one looks like a slip of it.
fn did_you_mean(wrong: &str, names: &[&str]) -> String {
    // Jaro-Winkler above 0.8 is the threshold clap uses for its own hints.
    names
        .iter()
        .map(|name| (strsim::jaro_winkler(wrong, name), name))
        .filter(|(likeness, _)| *likeness > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| format!(" (did you mean {name}?)"))
        .unwrap_or_default()
}
