//! The scene files in prose, `docs/SCENES.md`, made from the descriptions in their JSON schema.

use super::schema;
use serde_json::Value;
use std::collections::VecDeque;

/// Longest line of the text, characters.
const LINE: usize = 118;
/// Longest default that is shown, characters; longer ones are tables whose keys have their own.
const SHOWN_DEFAULT: usize = 40;

const HEAD: &str = "\
# Scene files

Every key of a scene file (TOML), made from the descriptions that editors show: `tirtouch schema --markdown` writes
this text, `tirtouch schema` the JSON schema. `[]` stands for each table of a list: `stack.layer[].n` is `n` under
`[[stack.layer]]`. Unknown keys are refused. Files that a scene names are relative to its folder. `scenes/` has
examples.
";

/// A part of the schema, and where in the file it stands.
struct Part<'s> {
    schema: &'s Value,
    /// Name of its definition; the two kinds of scene file have none.
    definition: Option<&'s str>,
    title: String,
    paths: Vec<String>,
}

/// The reference of both kinds of scene file.
pub fn reference() -> String {
    let root = schema();
    let mut text = HEAD.to_owned();
    for part in parts(&root) {
        text.push_str(&part.text(&root));
    }
    text
}

/// Every part once, in the order in which a reader meets them; parts of both kinds of file stand with the first.
fn parts(root: &Value) -> Vec<Part<'_>> {
    let mut parts: Vec<Part> = Vec::new();
    let scan = root.pointer("/$defs/ScanScene").unwrap_or(&Value::Null);
    for (title, file) in [("Scene of a sensor", root), ("Scan scene", scan)] {
        let mut queue = VecDeque::from([(String::new(), None, file)]);
        while let Some((path, definition, described)) = queue.pop_front() {
            if definition.is_some()
                && let Some(known) = parts.iter_mut().find(|part| part.definition == definition)
            {
                // Both kinds of file may have it at one place.
                if known.title != format!("`{path}`") && !known.paths.contains(&path) {
                    known.paths.push(path);
                }
                continue;
            }
            for (key, property) in properties(described) {
                let (target, is_list) = match property.get("items") {
                    Some(items) => (items, true),
                    None => (property, false),
                };
                if let Some((name, inner)) = definition_of(root, target) {
                    let dot = if path.is_empty() { "" } else { "." };
                    let list = if is_list { "[]" } else { "" };
                    queue.push_back((format!("{path}{dot}{key}{list}"), Some(name), inner));
                }
            }
            let title = if path.is_empty() { title.to_owned() } else { format!("`{path}`") };
            parts.push(Part { schema: described, definition, title, paths: Vec::new() });
        }
    }
    parts
}

impl Part<'_> {
    fn text(&self, root: &Value) -> String {
        let mut text = format!("\n## {}\n\n", self.title);
        let mut lead = description(self.schema);
        if !self.paths.is_empty() {
            let paths: Vec<String> = self.paths.iter().map(|path| format!("`{path}`")).collect();
            lead.push_str(&format!(" Also at {}.", paths.join(", ")));
        }
        text.push_str(&wrapped(&lead, ""));
        match choices(self.schema) {
            [] => text.push_str(&keys(root, self.schema, "")),
            all => {
                text.push('\n');
                for choice in all {
                    text.push_str(&wrapped(&format!("- {}: {}", choice_name(choice), description(choice)), "  "));
                    text.push_str(&keys(root, choice, "  "));
                }
            }
        }
        text
    }
}

/// The keys of a table, required ones first.
fn keys(root: &Value, table: &Value, indent: &str) -> String {
    let required = |key: &str| {
        let mut names = table.get("required").and_then(Value::as_array).into_iter().flatten();
        names.any(|name| name.as_str() == Some(key))
    };
    let mut all: Vec<_> = properties(table).filter(|(_, property)| property.get("const").is_none()).collect();
    all.sort_by_key(|(key, _)| !required(key));
    let line = |(key, property): (&str, &Value)| {
        let mut what = kind(root, property);
        if required(key) {
            what.push_str(", required");
        } else if let Some(default) = shown_default(property) {
            what.push_str(&format!(", default `{default}`"));
        }
        wrapped(&format!("{indent}- `{key}` ({what}): {}", description(property)), &format!("{indent}  "))
    };
    let lines: String = all.into_iter().map(line).collect();
    if lines.is_empty() || !indent.is_empty() { lines } else { format!("\n{lines}") }
}

fn properties(schema: &Value) -> impl Iterator<Item = (&str, &Value)> {
    let tables = std::iter::once(schema).chain(choices(schema));
    tables.filter_map(|table| table.get("properties")?.as_object()).flatten().map(|(key, value)| (key.as_str(), value))
}

fn choices(schema: &Value) -> &[Value] {
    schema.get("oneOf").and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// `kind = "disc"` of a table among several, `"auto"` of a name among several.
fn choice_name(choice: &Value) -> String {
    let tag = properties(choice).find_map(|(key, property)| Some(format!("`{key} = {}`", property.get("const")?)));
    tag.or_else(|| Some(format!("`{}`", choice.get("const")?))).unwrap_or_default()
}

/// The definition that a property refers to, through the absent side of what may be absent.
fn definition_of<'s>(root: &'s Value, property: &'s Value) -> Option<(&'s str, &'s Value)> {
    let any = property.get("anyOf").and_then(Value::as_array).into_iter().flatten();
    let pointer = std::iter::once(property).chain(any).find_map(|one| one.get("$ref")?.as_str()?.strip_prefix('#'))?;
    Some((pointer, root.pointer(pointer)?))
}

/// What a value is, in words.
fn kind(root: &Value, property: &Value) -> String {
    if let Some((_, inner)) = definition_of(root, property) {
        let all = choices(inner);
        return match all.iter().any(|choice| choice.get("const").is_some()) {
            true => format!("one of {}", all.iter().map(choice_name).collect::<Vec<_>>().join(" ")),
            false => "table".to_owned(),
        };
    }
    let name = match property.get("type") {
        Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).find(|name| *name != "null"),
        one => one.and_then(Value::as_str),
    };
    match name.unwrap_or_default() {
        "array" => {
            let count = property.get("minItems").map_or_else(String::new, |count| format!(" of {count}"));
            let item = property.get("items").map(|items| kind(root, items)).unwrap_or_default();
            format!("list{count}: {item}")
        }
        "integer" => "whole number".to_owned(),
        "boolean" => "true or false".to_owned(),
        "object" => "table".to_owned(),
        other => other.to_owned(),
    }
}

/// The default as TOML, where it is short and its description does not say it.
fn shown_default(property: &Value) -> Option<String> {
    let default = property.get("default").filter(|default| !default.is_null())?;
    let text = toml_text(default)?;
    (text.len() <= SHOWN_DEFAULT && !description(property).contains("Default:")).then_some(text)
}

fn toml_text(value: &Value) -> Option<String> {
    match value {
        Value::Array(items) => {
            Some(format!("[{}]", items.iter().map(toml_text).collect::<Option<Vec<_>>>()?.join(", ")))
        }
        Value::Object(table) => {
            let pair = |(key, value): (&String, &Value)| Some(format!("{key} = {}", toml_text(value)?));
            Some(format!("{{ {} }}", table.iter().map(pair).collect::<Option<Vec<_>>>()?.join(", ")))
        }
        Value::Null => None,
        plain => Some(plain.to_string()),
    }
}

fn description(schema: &Value) -> String {
    let text = schema.get("description").and_then(Value::as_str).unwrap_or_default();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A paragraph in lines of at most [`LINE`] characters, those after the first indented.
fn wrapped(text: &str, indent: &str) -> String {
    let lead: String = text.chars().take_while(|c| *c == ' ').collect();
    let mut lines = vec![lead];
    for word in text.split_whitespace() {
        let last = lines.last().map_or("", String::as_str);
        let is_new = last.trim().is_empty();
        if !is_new && last.chars().count() + 1 + word.chars().count() > LINE {
            lines.push(indent.to_owned());
        }
        if let Some(last) = lines.last_mut() {
            if !last.trim().is_empty() {
                last.push(' ');
            }
            last.push_str(word);
        }
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_in_docs_is_that_of_the_schema() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/SCENES.md");
        let kept = std::fs::read_to_string(path).unwrap();
        assert!(kept == reference(), "docs/SCENES.md: write it anew by `tirtouch schema --markdown > docs/SCENES.md`");
    }

    #[test]
    fn every_key_of_every_table_is_in_the_reference_on_lines_that_fit() {
        let (root, text) = (schema(), reference());
        assert!(text.lines().all(|line| line.chars().count() <= 120));
        let tables = root["$defs"].as_object().unwrap().values().chain([&root]);
        for (key, property) in tables.flat_map(properties) {
            let tag = property.get("const").map(|name| format!("`{key} = {name}`"));
            let wanted = tag.unwrap_or_else(|| format!("- `{key}` ("));
            assert!(text.contains(&wanted), "{wanted}");
        }
        // What one definition gives to several places is told once, and the places are.
        assert_eq!(text.matches("`law = \"yeoh\"`").count(), 1);
        assert!(text.contains("Also at") && text.contains("## Scan scene"));
    }
}
