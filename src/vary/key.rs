//! Paths to the keys of a scene: `stack.layer["PDMS 1.41"].n`, `led[*].power_mw`,
//! `phantom.inclusion[0].shape.diameter_mm`.

use serde_json::Value as Json;
use std::str::FromStr;
use toml_edit::{Array, ArrayOfTables, InlineTable, Item, TableLike, Value};

/// Most steps of a path.
const MOST_STEPS: usize = 32;

/// The path of a key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyPath {
    text: String,
    steps: Vec<Step>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Step {
    /// Key of a table.
    Key(String),
    /// Element of a list, from 0.
    Index(usize),
    /// Element of a list of tables, by its `name`.
    Named(String),
    /// All elements of a list.
    All,
}

impl FromStr for KeyPath {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = |what: &str| format!("{text:?} {what}; a key is as in stack.layer[0].n or led[*].power_mw");
        let mut steps = Vec::new();
        let mut rest = text;
        while !rest.is_empty() {
            if steps.len() == MOST_STEPS {
                return Err(wrong("has too many steps"));
            }
            if let Some(inside) = rest.strip_prefix('[') {
                let (step, length) = if let Some(quoted) = inside.strip_prefix('"') {
                    let end = quoted.find('"').ok_or_else(|| wrong("lacks a closing quote"))?;
                    (Step::Named(quoted[..end].to_owned()), end + 2)
                } else {
                    let end = inside.find(']').ok_or_else(|| wrong("lacks a ]"))?;
                    let step = match &inside[..end] {
                        "*" => Step::All,
                        index => Step::Index(index.parse().map_err(|_| wrong("has no number, name or * in its [ ]"))?),
                    };
                    (step, end)
                };
                if steps.is_empty() {
                    return Err(wrong("does not start with a name"));
                }
                steps.push(step);
                rest = inside[length..].strip_prefix(']').ok_or_else(|| wrong("lacks a ]"))?;
            } else {
                let name = match (rest.strip_prefix('.'), steps.is_empty()) {
                    (Some(name), false) => name,
                    (None, true) => rest,
                    _ => return Err(wrong("has names that no dot parts")),
                };
                let length = name.find(['.', '[']).unwrap_or(name.len());
                let (name, after) = name.split_at(length);
                let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
                if name.is_empty() || !name.chars().all(plain) {
                    return Err(wrong("has a name that no key can have"));
                }
                steps.push(Step::Key(name.to_owned()));
                rest = after;
            }
        }
        match steps.last() {
            None => Err(wrong("is empty")),
            Some(_) => Ok(Self { text: text.to_owned(), steps }),
        }
    }
}

impl std::fmt::Display for KeyPath {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

impl KeyPath {
    /// Sets the key in a scene's document, in all places that the path names. A key that the document leaves to its
    /// default is added to its table. Tables and lists of tables give way to tables and lists alone.
    ///
    /// # Errors
    /// When the path leads nowhere: an element that is not there, a table that is none.
    pub fn set(&self, document: &mut Item, value: &toml::Value) -> Result<(), String> {
        in_item(document, &self.steps, &written(value)).map_err(|why| format!("{self}: {why}"))
    }
}

impl KeyPath {
    /// A scene's text with the key set.
    ///
    /// # Errors
    /// As [`Self::set`]; a text that is no TOML.
    pub fn set_in(&self, text: &str, value: &toml::Value) -> Result<String, String> {
        let mut document = text.parse::<toml_edit::DocumentMut>().map_err(|error| error.to_string())?;
        self.set(document.as_item_mut(), value)?;
        Ok(document.to_string())
    }

    /// The places of a document that the path names, by number and not by name; none where it leads nowhere.
    pub fn places(&self, document: &Item) -> Vec<String> {
        let mut found = Vec::new();
        find(Some(document), &self.steps, String::new(), &mut found);
        found
    }

    /// Whether a document has it.
    pub(super) fn is_in(&self, document: &Item) -> bool {
        self.remove(&mut document.clone())
    }

    /// Removes the key from its table; whether it was there.
    pub(super) fn remove(&self, document: &mut Item) -> bool {
        match self.steps.split_last() {
            Some((Step::Key(name), table)) => from_item(document, table, name),
            _ => false,
        }
    }

    /// The values that the path names in a scene as JSON; none where it leads nowhere.
    pub fn values_in<'v>(&self, scene: &'v mut Json) -> Vec<&'v mut Json> {
        values(scene, &self.steps)
    }
}

fn from_item(item: &mut Item, table: &[Step], name: &str) -> bool {
    match (item, table) {
        (Item::Table(inside), _) => from_table(inside, table, name),
        (Item::ArrayOfTables(tables), [Step::Index(k), rest @ ..]) => {
            tables.get_mut(*k).is_some_and(|inside| from_table(inside, rest, name))
        }
        (Item::Value(value), _) => from_value(value, table, name),
        _ => false,
    }
}

fn from_table(inside: &mut dyn TableLike, table: &[Step], name: &str) -> bool {
    match table {
        [] => inside.remove(name).is_some(),
        [Step::Key(key), rest @ ..] => inside.get_mut(key).is_some_and(|item| from_item(item, rest, name)),
        _ => false,
    }
}

fn from_value(value: &mut Value, table: &[Step], name: &str) -> bool {
    match (value, table) {
        (Value::InlineTable(inside), _) => from_table(inside, table, name),
        (Value::Array(list), [Step::Index(k), rest @ ..]) => {
            list.get_mut(*k).is_some_and(|value| from_value(value, rest, name))
        }
        _ => false,
    }
}

fn values<'v>(value: &'v mut Json, steps: &[Step]) -> Vec<&'v mut Json> {
    let [step, rest @ ..] = steps else { return vec![value] };
    match (step, value) {
        (Step::Key(name), Json::Object(table)) => {
            table.get_mut(name).map_or_else(Vec::new, |inside| values(inside, rest))
        }
        (step, Json::Array(list)) => {
            let name = |k: usize| Some(list.get(k)?.get("name")?.as_str()?.to_owned());
            let found = places(step, list.len(), name).unwrap_or_default();
            let elements = list.iter_mut().enumerate().filter(|(k, _)| found.contains(k));
            elements.flat_map(|(_, element)| values(element, rest)).collect()
        }
        _ => Vec::new(),
    }
}

fn find(item: Option<&Item>, steps: &[Step], at: String, found: &mut Vec<String>) {
    let [step, rest @ ..] = steps else { return found.push(at) };
    if let Step::Key(name) = step {
        // What the document leaves to its default has a place too.
        let dot = if at.is_empty() { "" } else { "." };
        let inside = item.and_then(Item::as_table_like).and_then(|table| table.get(name));
        return find(inside, rest, format!("{at}{dot}{name}"), found);
    }
    let elements: Vec<Item> = match item {
        Some(Item::ArrayOfTables(tables)) => tables.iter().map(|table| Item::Table(table.clone())).collect(),
        Some(Item::Value(Value::Array(list))) => list.iter().map(|value| Item::Value(value.clone())).collect(),
        _ => return,
    };
    let name = |k: usize| elements.get(k)?.as_table_like()?.get("name")?.as_str().map(str::to_owned);
    for k in places(step, elements.len(), name).unwrap_or_default() {
        find(elements.get(k), rest, format!("{at}[{k}]"), found);
    }
}

/// Whole numbers up to this are exact as f64 and as integers.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// As it stands in a document. A whole number is written without a point, so that it fits keys that count.
fn written(value: &toml::Value) -> Value {
    match value {
        toml::Value::String(text) => text.as_str().into(),
        toml::Value::Integer(whole) => (*whole).into(),
        toml::Value::Float(number) if number.fract() == 0.0 && number.abs() <= EXACT => (*number as i64).into(),
        toml::Value::Float(number) => (*number).into(),
        toml::Value::Boolean(flag) => (*flag).into(),
        toml::Value::Datetime(time) => time.to_string().into(),
        toml::Value::Array(items) => Value::Array(items.iter().map(written).collect()),
        toml::Value::Table(table) => {
            Value::InlineTable(table.iter().map(|(key, value)| (key.as_str(), written(value))).collect::<InlineTable>())
        }
    }
}

fn in_item(item: &mut Item, steps: &[Step], value: &Value) -> Result<(), String> {
    if steps.is_empty() && item.is_array_of_tables() && value.is_array() {
        *item = Item::Value(value.clone());
        return Ok(());
    }
    match item {
        Item::Value(inside) => in_value(inside, steps, value),
        Item::ArrayOfTables(tables) => in_tables(tables, steps, value),
        Item::Table(table) => in_table(table, steps, value),
        Item::None => Err("is not there".into()),
    }
}

fn in_value(item: &mut Value, steps: &[Step], value: &Value) -> Result<(), String> {
    match (item, steps) {
        (item, []) => {
            let decor = item.decor().clone();
            *item = value.clone();
            *item.decor_mut() = decor;
            Ok(())
        }
        (Value::InlineTable(table), steps) => in_table(table, steps, value),
        (Value::Array(list), [step, rest @ ..]) => {
            let places = places(step, list.len(), |k| list_name(list, k))?;
            places.into_iter().try_for_each(|k| match list.get_mut(k) {
                Some(item) => in_value(item, rest, value),
                None => Ok(()),
            })
        }
        (_, [Step::Key(name), ..]) => Err(format!("there is a value and no table where {name} is looked for")),
        _ => Err("there is no list where one is looked for".into()),
    }
}

fn in_tables(tables: &mut ArrayOfTables, steps: &[Step], value: &Value) -> Result<(), String> {
    let [step, rest @ ..] = steps else { return Err("is a list of tables and no single value".into()) };
    let name = |k: usize| tables.get(k).and_then(|table| table.get("name")).and_then(Item::as_str).map(str::to_owned);
    let places = places(step, tables.len(), name)?;
    places.into_iter().try_for_each(|k| match tables.get_mut(k) {
        Some(table) => in_table(table, rest, value),
        None => Ok(()),
    })
}

fn in_table(table: &mut dyn TableLike, steps: &[Step], value: &Value) -> Result<(), String> {
    let [step, rest @ ..] = steps else {
        let entries = value.as_inline_table().ok_or("is a table and no single value")?;
        table.clear();
        for (key, value) in entries {
            table.insert(key, Item::Value(value.clone()));
        }
        return Ok(());
    };
    let Step::Key(name) = step else { return Err("there is a table and no list".into()) };
    if let Some(item) = table.get_mut(name) {
        return in_item(item, rest, value);
    }
    if rest.iter().any(|step| !matches!(step, Step::Key(_))) {
        return Err(format!("there is no list {name}"));
    }
    let mut item = match rest {
        [] => Item::Value(value.clone()),
        // Without a header of its own a table would end the one that it stands in.
        _ => Item::Value(Value::InlineTable(Default::default())),
    };
    if !rest.is_empty() {
        in_item(&mut item, rest, value)?;
    }
    table.insert(name, item);
    Ok(())
}

fn list_name(list: &Array, k: usize) -> Option<String> {
    let name = list.get(k)?.as_inline_table()?.get("name")?.as_str()?;
    Some(name.to_owned())
}

/// The places in a list that a step names.
fn places(step: &Step, count: usize, name: impl Fn(usize) -> Option<String>) -> Result<Vec<usize>, String> {
    match step {
        Step::All if count == 0 => Err("[*] is of an empty list".into()),
        Step::All => Ok((0..count).collect()),
        Step::Index(k) if *k < count => Ok(vec![*k]),
        Step::Index(k) => Err(format!("[{k}] is not there: the list has {count} elements, from [0]")),
        Step::Named(wanted) => {
            let found: Vec<usize> = (0..count).filter(|&k| name(k).as_ref() == Some(wanted)).collect();
            match found.len() {
                0 => {
                    let names: Vec<String> = (0..count).filter_map(name).map(|name| format!("{name:?}")).collect();
                    let names = if names.is_empty() { "none has a name".to_owned() } else { names.join(", ") };
                    Err(format!("no element is named {wanted:?}; there: {names}"))
                }
                1 => Ok(found),
                several => Err(format!("{several} elements are named {wanted:?}; give a number")),
            }
        }
        Step::Key(name) => Err(format!("there is a list where the key {name} is looked for; [0], [*] or [\"name\"]")),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SCENE: &str = "name = 'a' # a comment\n\n[stack]\nsize = { x = 1.0, y = 2 }\n[[stack.layer]]\nname = \"PDMS 1.41\"\n\
                         n = 1.41 # measured\n[[stack.layer]]\nname = 'glass'\nn = 1.5\n[[led]]\npower_mw = 1\n[[led]]\n\
                         power_mw = 2\n[list]\npixels = [4, 3]\n";

    fn set(path: &str, value: f64) -> Result<String, String> {
        let mut document: toml_edit::DocumentMut = SCENE.parse().unwrap();
        path.parse::<KeyPath>()?.set(document.as_item_mut(), &toml::Value::Float(value))?;
        Ok(document.to_string())
    }

    #[test]
    fn only_what_is_named_changes() {
        for (path, from, to) in [
            ("stack.layer[\"PDMS 1.41\"].n", "n = 1.41 #", "n = 1.42 #"),
            ("stack.layer[1].n", "n = 1.5\n", "n = 1.42\n"),
            ("list.pixels[0]", "[4, 3]", "[1.42, 3]"),
            ("stack.size.y", "y = 2 }", "y = 1.42 }"),
        ] {
            assert_eq!(set(path, 1.42).unwrap(), SCENE.replace(from, to), "{path}");
        }
        let all = set("led[*].power_mw", 7.0).unwrap();
        assert_eq!(all, SCENE.replace("power_mw = 1", "power_mw = 7").replace("power_mw = 2", "power_mw = 7"));
    }

    #[test]
    fn values_are_those_that_setting_changes() {
        let read = |text: &str| serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap();
        for (path, wanted) in [
            ("stack.layer[\"PDMS 1.41\"].n", &[1.41][..]),
            ("stack.layer[*].n", &[1.41, 1.5]),
            ("led[*].power_mw", &[1.0, 2.0]),
            ("list.pixels[1]", &[3.0]),
            ("stack.layer[2].n", &[]),
            ("stack.layer.n", &[]),
            ("led[1].power_mw.x", &[]),
        ] {
            let mut scene = read(SCENE);
            let values = path.parse::<KeyPath>().unwrap().values_in(&mut scene);
            assert_eq!(values.iter().map(|value| value.as_f64().unwrap()).collect::<Vec<_>>(), wanted, "{path}");
            values.into_iter().for_each(|value| *value = 7.into());
            assert_eq!(scene, read(&set(path, 7.0).unwrap_or(SCENE.to_owned())), "{path}");
        }
    }

    #[test]
    fn what_was_left_to_its_default_is_added_where_it_belongs() {
        let read = |text: String| text.parse::<toml::Table>().unwrap();
        assert_eq!(read(set("stack.layer[0].v", 3.0).unwrap())["stack"]["layer"][0]["v"].as_integer(), Some(3));
        assert_eq!(read(set("render.spp", 64.0).unwrap())["render"]["spp"].as_integer(), Some(64));
        assert_eq!(read(set("stack.size.z.w", 0.5).unwrap())["stack"]["size"]["z"]["w"].as_float(), Some(0.5));
        assert_eq!(read(set("seed", 1e300).unwrap())["seed"].as_float(), Some(1e300));
    }

    #[test]
    fn lists_and_tables_take_the_place_of_lists_and_tables() {
        let set = |path: &str, value: &str| {
            let mut document: toml_edit::DocumentMut = SCENE.parse().unwrap();
            let value = format!("v = {value}").parse::<toml::Table>().unwrap().remove("v").unwrap();
            path.parse::<KeyPath>().unwrap().set(document.as_item_mut(), &value)?;
            Ok::<_, String>(document.to_string().parse::<toml::Table>().unwrap())
        };
        let before: toml::Table = SCENE.parse().unwrap();
        let pixels = set("list.pixels", "[64.0, 48]").unwrap();
        assert_eq!(pixels["list"]["pixels"].as_array().unwrap(), &[64.into(), 48.into()]);
        assert_eq!(set("stack.layer", "[{ name = 'a', n = 1.4 }]").unwrap()["stack"]["layer"][0]["n"], 1.4.into());
        assert_eq!(set("stack.size", "{ x = 3 }").unwrap()["stack"]["size"], toml::toml! { x = 3 }.into());
        let all = set("led[*]", "{ power_mw = 7 }").unwrap();
        assert_eq!(all["led"][1], toml::toml! { power_mw = 7 }.into());
        assert_eq!(set("stack", "{ a = 1 }").unwrap()["stack"], toml::toml! { a = 1 }.into());
        // All else stays.
        assert!(before.iter().all(|(key, value)| key == "led" || all[key] == *value));
        assert!(set("led[*]", "[1]").unwrap_err().contains("is a table"));
        assert!(set("led", "{ power_mw = 7 }").unwrap_err().contains("a list of tables"));
    }

    #[test]
    fn a_path_that_leads_nowhere_says_why() {
        for (path, said) in [
            ("stack.layer[2].n", "has 2 elements"),
            ("stack.layer[\"gel\"].n", "there: \"PDMS 1.41\", \"glass\""),
            ("stack.layer.n", "there is a list where the key n"),
            ("name.x", "a value and no table"),
            ("name[0]", "no list"),
            ("stack", "is a table"),
            ("led", "a list of tables"),
            ("wall[0].n", "no list wall"),
            ("list.pixels[x]", "number, name or *"),
            ("", "is empty"),
            ("[0]", "does not start with a name"),
            ("a..b", "no key can have"),
            ("a[\"b]", "lacks a closing quote"),
            ("a[0", "lacks a ]"),
            ("a[0]b", "no dot parts"),
        ] {
            let found = set(path, 1.0).unwrap_err();
            assert!(found.contains(said), "{path}: {found}");
        }
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "[a-z.\\[\\]\"*0-9é ]{0,30}") {
            let _ = set(&text, 1.0);
        }
    }
}
