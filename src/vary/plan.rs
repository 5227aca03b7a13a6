//! From variables, constraints and a design to points, and from a point to the text of its scene.

use super::columns::Columns;
use super::design::Units;
use super::distribution::{Source, written_out};
use super::kinds;
use super::{Design, Expression, KeyPath, Require, Scalar, Vary};
use crate::scene::Invalid;
use std::collections::{BTreeMap, BTreeSet};

/// All points.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    variables: Vec<Variable>,
    require: Vec<(Expression, Option<String>)>,
    units: Units,
    /// Rows of the design's table, by variable.
    table: Option<Vec<Vec<Option<Scalar>>>>,
    count: usize,
    /// Variables in an order in which each comes after those that it is computed from.
    order: Vec<usize>,
}

#[derive(Debug, Clone, PartialEq)]
struct Variable {
    name: String,
    keys: Vec<KeyPath>,
    source: Source,
}

/// A point: a value for every variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Its row, from 0.
    pub row: usize,
    /// A value for each variable, in the order of [`Plan::names`].
    pub values: Vec<Scalar>,
}

impl Plan {
    /// Checks that variables, constraints and design fit together. `table` is the text of the design's table, where it
    /// has one.
    ///
    /// # Errors
    /// The first rule that is broken, with its key in the sweep's file.
    pub fn new(vary: &[Vary], require: &[Require], design: &Design, table: Option<&str>) -> Result<Self, Invalid> {
        let mut variables = vary.iter().enumerate().map(variable).collect::<Result<Vec<_>, _>>()?;
        let columns = match (design, table) {
            (Design::Csv { .. }, Some(text)) => {
                Some(Columns::read(text).map_err(|why| Invalid::new("sweep.design.file", why))?)
            }
            (Design::Csv { .. }, None) => return Err(Invalid::new("sweep.design.file", "has no text")),
            _ => None,
        };
        if let Some(columns) = &columns {
            // A column that no entry names is a key of the scene.
            for name in &columns.names {
                if !variables.iter().any(|one| one.name == *name) {
                    let key = name.parse().map_err(|why| Invalid::new("sweep.design.file", why))?;
                    variables.push(Variable { name: name.clone(), keys: vec![key], source: Source::Column });
                }
            }
        }
        check_names(&variables)?;
        for (k, one) in variables.iter().enumerate() {
            let is_column = columns.as_ref().is_some_and(|columns| columns.names.contains(&one.name));
            let key = format!("vary[{k}]");
            match (&one.source, is_column, design) {
                (Source::Column, false, _) => {
                    let what = "has no values: give one of fixed, values, linear, log, uniform, log_uniform, normal, \
                                log_normal, choice and expression";
                    return Err(Invalid::new(key, what));
                }
                (Source::Column, true, _) => {}
                (_, true, _) => return Err(Invalid::new(key, "has values, and a column of the design's table too")),
                (Source::Drawn(_), _, Design::Grid {}) => {
                    let what = "is drawn, and a grid needs an axis: values, linear or log; or another design";
                    return Err(Invalid::new(key, what));
                }
                (source, _, Design::Csv { .. }) if source.is_free() => {
                    return Err(Invalid::new(key, "is drawn, and the design's table has no column for it"));
                }
                _ => {}
            }
        }
        let order = order(&variables)?;
        let read = |(k, one): (usize, &Require)| {
            let expression = one.expression.parse::<Expression>();
            let expression = expression.map_err(|why| {
                Invalid::new(format!("require[{k}].expression"), format!("{:?} {why}", one.expression))
            })?;
            known_names(&expression, &variables, &format!("require[{k}].expression"))?;
            Ok((expression, one.reason.clone().filter(|reason| !reason.trim().is_empty())))
        };
        let require = require.iter().enumerate().map(read).collect::<Result<Vec<_>, Invalid>>()?;
        all_change_something(&variables, &require)?;
        let lists: Vec<usize> = variables
            .iter()
            .filter(|one| one.source.is_free())
            .map(|one| match &one.source {
                Source::Listed(values) => values.len(),
                _ => 0,
            })
            .collect();
        draws_something(design, &lists)?;
        let (units, count) = design.units(&lists).map_err(|why| Invalid::new("sweep.design", why))?;
        let (table, count) = match columns {
            Some(columns) => {
                let rows = columns.of(variables.iter().map(|one| one.name.as_str()));
                let count = rows.len();
                (Some(rows), count)
            }
            None => (None, count),
        };
        Ok(Self { variables, require, units, table, count, order })
    }

    /// Points.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Names of the variables: columns of tables.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().map(|one| one.name.as_str())
    }

    /// Refuses two variables that set one place of a scene, however they spell it.
    ///
    /// # Errors
    /// The second of them.
    pub fn check_places(&self, base: &str) -> Result<(), Invalid> {
        let document = base.parse::<toml_edit::DocumentMut>();
        let document = document.map_err(|error| Invalid::new("sweep.scene", error.to_string()))?;
        let mut taken: BTreeMap<String, &str> = BTreeMap::new();
        for (k, one) in self.variables.iter().enumerate() {
            for key in &one.keys {
                for place in key.places(document.as_item()) {
                    let within = |inner: &str, outer: &str| {
                        inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
                    };
                    let clash = |other: &&String| within(&place, other) || within(other, &place);
                    if let Some(other) = taken.keys().find(clash) {
                        let what = format!("{key} varies {place}, which {} varies too", taken[other]);
                        return Err(Invalid::new(format!("vary[{k}].key"), what));
                    }
                    taken.insert(place, &one.name);
                }
            }
        }
        Ok(())
    }

    /// Keys of each variable.
    pub fn keys(&self) -> impl Iterator<Item = &[KeyPath]> {
        self.variables.iter().map(|one| one.keys.as_slice())
    }

    /// Places of the variables that the design draws, in the order of its dimensions.
    pub fn free(&self) -> Vec<usize> {
        (0..self.variables.len()).filter(|&k| self.variables[k].source.is_free()).collect()
    }

    /// Whether values of a variable have an order: all but lists of words.
    pub fn is_ordered(&self, variable: usize) -> bool {
        let mut listed = self.variables.get(variable).into_iter().flat_map(|one| one.source.listed());
        listed.all(|value| value.number().is_some())
    }

    /// A point of the unit cube: a coordinate for each variable that the design draws.
    pub fn unit(&self, row: usize) -> Vec<f64> {
        self.units.point(row)
    }

    /// A value for each variable, also where these break a constraint; none where not all of them have one.
    pub fn values(&self, row: usize) -> Vec<Scalar> {
        self.solved(row).ok().and_then(|values| values.into_iter().collect()).unwrap_or_default()
    }

    /// Whether some of its values may be no numbers: choices of kinds and names of files.
    pub fn has_words(&self) -> bool {
        let listed = self.variables.iter().flat_map(|one| one.source.listed());
        let cells = self.table.iter().flatten().flatten().flatten();
        listed.chain(cells).any(|value| value.number().is_none())
    }

    /// What a row has in place of numbers, as [`Self::values`].
    pub fn words(&self, row: usize) -> Vec<String> {
        let values = self.values(row);
        values.iter().filter(|value| value.number().is_none()).map(ToString::to_string).collect()
    }

    /// A point; a reason in place of the rest where it breaks a constraint, or a value cannot be computed.
    ///
    /// # Errors
    /// That reason.
    pub fn point(&self, row: usize) -> Result<Point, String> {
        let values = self.solved(row)?;
        let numbers = self.numbers(&values);
        for (expression, reason) in &self.require {
            let holds = expression.value(&numbers)?;
            if holds == 0.0 {
                return Err(reason.clone().unwrap_or_else(|| format!("{expression} does not hold")));
            }
        }
        drop(numbers);
        let whole: Option<Vec<Scalar>> = values.into_iter().collect();
        let values = whole.ok_or("the design's table has an empty cell in this row")?;
        Ok(Point { row, values })
    }

    /// What each variable is in a row, where the design says so.
    fn solved(&self, row: usize) -> Result<Vec<Option<Scalar>>, String> {
        let mut units = self.unit(row).into_iter();
        let mut values: Vec<Option<Scalar>> = (self.variables.iter().enumerate())
            .map(|(k, one)| match &one.source {
                Source::Fixed(value) => Some(value.clone()),
                Source::Derived(_) => None,
                Source::Column => self.table.as_ref().and_then(|table| table.get(row)?.get(k)?.clone()),
                source => source.at(units.next()?),
            })
            .collect();
        for &k in &self.order {
            let one = &self.variables[k];
            if let Source::Derived(expression) = &one.source {
                let value = expression.value(&self.numbers(&values)).map_err(|why| format!("{}: {why}", one.name))?;
                values[k] = Some(Scalar::Number(written_out(value, value)));
            }
        }
        Ok(values)
    }

    fn numbers<'v>(&'v self, values: &[Option<Scalar>]) -> BTreeMap<&'v str, f64> {
        let named = self.variables.iter().zip(values);
        named.filter_map(|(one, value)| Some((one.name.as_str(), value.as_ref()?.number()?))).collect()
    }

    /// The text of a point's scene: the base scene's, with the point's values in their places.
    ///
    /// # Errors
    /// A text that is no TOML, or a key that leads nowhere in it.
    pub fn scene_text(&self, base: &str, point: &Point) -> Result<String, Invalid> {
        let document = base.parse::<toml_edit::DocumentMut>();
        let mut document = document.map_err(|error| Invalid::new("sweep.scene", error.to_string()))?;
        for (k, (one, value)) in self.variables.iter().zip(&point.values).enumerate() {
            for key in &one.keys {
                let set = key.set(document.as_item_mut(), &value.to_toml());
                set.map_err(|why| Invalid::new(format!("vary[{k}].key"), why))?;
            }
        }
        kinds::leave_strangers_out(&mut document, base, self.keys().flatten());
        Ok(document.to_string())
    }
}

/// Sensitivities are of what a design draws; a list of one value draws nothing.
fn draws_something(design: &Design, lists: &[usize]) -> Result<(), Invalid> {
    let is_of_sensitivity = matches!(design, Design::Morris { .. } | Design::Saltelli { .. });
    match lists.iter().all(|&length| length == 1) {
        true if is_of_sensitivity => {
            Err(Invalid::new("sweep.design", "draws nothing: no variable has more than one value"))
        }
        _ => Ok(()),
    }
}

fn variable((k, vary): (usize, &Vary)) -> Result<Variable, Invalid> {
    let at = |key: &str| format!("vary[{k}].{key}");
    let texts = vary.key.as_ref().map(|keys| keys.all()).unwrap_or_default();
    let keys = texts.iter().map(|text| text.parse::<KeyPath>()).collect::<Result<Vec<_>, _>>();
    let keys = keys.map_err(|why| Invalid::new(at("key"), why))?;
    let name = match (&vary.name, texts) {
        (Some(name), _) => {
            let mut letters = name.chars();
            let starts = letters.next().is_some_and(|c| c.is_alphabetic() || c == '_');
            if !starts || !letters.all(|c| c.is_alphanumeric() || c == '_') {
                let what = format!("must be letters, digits and _, and start with none of the digits, is {name:?}");
                return Err(Invalid::new(at("name"), what));
            }
            name.clone()
        }
        (None, [first, ..]) => first.clone(),
        (None, []) => return Err(Invalid::new(format!("vary[{k}]"), "has neither a key nor a name")),
    };
    let source = Source::of(vary).map_err(|why| Invalid::new(format!("vary[{k}]"), why))?;
    Ok(Variable { name, keys, source })
}

/// Names and keys are each used once.
fn check_names(variables: &[Variable]) -> Result<(), Invalid> {
    let (mut names, mut keys) = (BTreeSet::new(), BTreeSet::new());
    for (k, one) in variables.iter().enumerate() {
        if !names.insert(one.name.as_str()) {
            return Err(Invalid::new(format!("vary[{k}].name"), format!("{} stands there twice", one.name)));
        }
        let is_function = crate::vary::FUNCTIONS.iter().any(|(function, _)| *function == one.name);
        if is_function || ["and", "or"].contains(&one.name.as_str()) {
            let what = if is_function { "a function" } else { "an operator" };
            return Err(Invalid::new(format!("vary[{k}].name"), format!("{} is {what} of expressions", one.name)));
        }
        for key in &one.keys {
            if !keys.insert(key.to_string()) {
                return Err(Invalid::new(format!("vary[{k}].key"), format!("{key} varies twice")));
            }
        }
    }
    Ok(())
}

/// What an expression names are variables, of numbers.
fn known_names(expression: &Expression, variables: &[Variable], key: &str) -> Result<(), Invalid> {
    for name in expression.names() {
        let Some(one) = variables.iter().find(|one| one.name == name) else {
            let names: Vec<&str> = variables.iter().map(|one| one.name.as_str()).collect();
            return Err(Invalid::new(key, format!("{name} is no variable; there are {}", names.join(", "))));
        };
        if let Some(value) = one.source.listed().iter().find(|value| value.number().is_none()) {
            return Err(Invalid::new(key, format!("{name} is not always a number: it may be {value}")));
        }
    }
    Ok(())
}

/// A variable without a key is of use to expressions alone.
fn all_change_something(variables: &[Variable], require: &[(Expression, Option<String>)]) -> Result<(), Invalid> {
    let derived = variables.iter().filter_map(|one| match &one.source {
        Source::Derived(expression) => Some(expression),
        _ => None,
    });
    let expressions = derived.chain(require.iter().map(|(expression, _)| expression));
    let used: BTreeSet<String> = expressions.flat_map(|one| one.names().into_iter().map(str::to_owned)).collect();
    match variables.iter().enumerate().find(|(_, one)| one.keys.is_empty() && !used.contains(&one.name)) {
        None => Ok(()),
        Some((k, one)) => {
            let what = format!("{} has no key, and no expression uses it: it changes nothing", one.name);
            Err(Invalid::new(format!("vary[{k}]"), what))
        }
    }
}

/// Derived variables, each after what it is computed from.
fn order(variables: &[Variable]) -> Result<Vec<usize>, Invalid> {
    let mut order = Vec::new();
    let mut left: Vec<usize> = Vec::new();
    for (k, one) in variables.iter().enumerate() {
        if let Source::Derived(expression) = &one.source {
            known_names(expression, variables, &format!("vary[{k}].expression"))?;
            left.push(k);
        }
    }
    while !left.is_empty() {
        let waits = |k: &usize| match &variables[*k].source {
            Source::Derived(expression) => {
                let names = expression.names();
                left.iter().any(|other| names.contains(&variables[*other].name.as_str()))
            }
            _ => false,
        };
        let (stay, ready): (Vec<usize>, Vec<usize>) = left.iter().partition(|k| waits(k));
        if ready.is_empty() {
            let names: Vec<&str> = stay.iter().map(|&k| variables[k].name.as_str()).collect();
            let what = format!("is computed in a circle: {}", names.join(", "));
            return Err(Invalid::new(format!("vary[{}].expression", stay[0]), what));
        }
        order.extend(ready);
        left = stay;
    }
    Ok(order)
}

#[cfg(test)]
#[path = "plan_tests.rs"]
#[allow(clippy::unwrap_used)]
mod tests;
