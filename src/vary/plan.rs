//! From variables, constraints and a design to points, and from a point to the text of its scene.

use super::columns::Columns;
use super::design::Units;
use super::distribution::{Source, written_out};
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
            Ok((expression, one.reason.clone()))
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
        Ok(document.to_string())
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
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::vary::{Keys, Range};

    fn vary(name: &str, key: &str, change: impl FnOnce(&mut Vary)) -> Vary {
        let mut one = Vary { name: Some(name.into()), ..Vary::default() };
        if !key.is_empty() {
            one.key = Some(Keys::One(key.into()));
        }
        change(&mut one);
        one
    }

    fn numbers(values: &[f64]) -> Option<Vec<Scalar>> {
        Some(values.iter().map(|&v| Scalar::Number(v)).collect())
    }

    fn top() -> Vary {
        vary("n_top", "stack.layer[0].n", |v| v.values = numbers(&[1.41, 1.42]))
    }

    fn below() -> Vary {
        vary("n_below", "stack.layer[1].n", |v| v.expression = Some("n_top - step".into()))
    }

    fn step() -> Vary {
        vary("step", "", |v| v.linear = Some(Range { from: 0.0, to: 0.02, points: 3 }))
    }

    fn plan(vary: &[Vary], require: &[&str], design: Design) -> Result<Plan, Invalid> {
        let require: Vec<_> = require.iter().map(|text| Require { expression: (*text).into(), reason: None }).collect();
        Plan::new(vary, &require, &design, Some("n_top,n_below\n1.4,1.39\n1.5,\n"))
    }

    #[test]
    fn points_are_scenes_of_their_own() {
        let plan = plan(&[below(), top(), step()], &["n_below > 1.395"], Design::Grid {}).unwrap();
        assert_eq!(plan.count(), 6);
        let point = plan.point(1).unwrap();
        assert_eq!(point.values.iter().map(|v| v.number().unwrap()).collect::<Vec<_>>(), [1.41 - 0.01, 1.41, 0.01]);
        assert_eq!(plan.point(2).unwrap_err(), "n_below > 1.395 does not hold");
        let base = "[[stack.layer]]\nn = 1.0 # top\n[[stack.layer]]\nn = 2.0\n";
        let text = plan.scene_text(base, &point).unwrap();
        assert_eq!(text, "[[stack.layer]]\nn = 1.41 # top\n[[stack.layer]]\nn = 1.4\n");
        let error = plan.scene_text("[stack]\n", &point).unwrap_err();
        assert_eq!(error.key, "vary[0].key");
    }

    #[test]
    fn a_table_gives_its_columns() {
        let bare = vary("n_top", "stack.layer[0].n", |_| {});
        let file = || Design::Csv { file: "points.csv".into() };
        let below = vary("n_below", "stack.layer[1].n", |_| {});
        let found = plan(&[bare.clone(), below.clone()], &[], file()).unwrap();
        assert_eq!((found.count(), found.point(0).unwrap().values), (2, numbers(&[1.4, 1.39]).unwrap()));
        assert!(found.point(1).unwrap_err().contains("empty cell"));
        for (table, said) in [("n_top,n_top\n1,2\n", "two columns n_top"), ("n_top\n1\nnan\n", "nan in row 1")] {
            let found = Plan::new(std::slice::from_ref(&bare), &[], &file(), Some(table)).unwrap_err();
            assert!(found.message.contains(said), "{found}");
        }
        // Numpy's head; what begins with the same sign elsewhere is a cell.
        let found = Plan::new(&[], &[], &file(), Some("# name,stack.layer[0].n\n#1,1.4\nb,1.5\n")).unwrap();
        assert_eq!((found.count(), found.words(0), found.has_words()), (2, vec!["#1".to_owned()], true));
        assert!(!Plan::new(&[], &[], &file(), Some("# stack.layer[0].n\n1.4\n")).unwrap().has_words());
        // A column without an entry is a key.
        let found = plan(&[bare], &[], file()).unwrap();
        assert_eq!(found.names().collect::<Vec<_>>(), ["n_top", "n_below"]);
        assert!(plan(&[top(), below], &[], file()).unwrap_err().message.contains("column of the design's table too"));
    }

    #[test]
    fn a_point_that_breaks_a_constraint_has_values() {
        let plan = plan(&[below(), top(), step()], &["n_below > 1.395"], Design::Grid {}).unwrap();
        assert!(plan.point(2).is_err());
        assert_eq!(Some(plan.values(2)), numbers(&[1.41 - 0.02, 1.41, 0.02]));
    }

    #[test]
    fn an_expression_has_the_value_that_one_would_write() {
        let below = vary("n_below", "stack.layer[1].n", |v| v.expression = Some("n_top - 0.05".into()));
        let plan = plan(&[below, top()], &[], Design::Grid {}).unwrap();
        assert_eq!([Some(plan.values(0)), Some(plan.values(1))], [numbers(&[1.36, 1.41]), numbers(&[1.37, 1.42])]);
    }

    #[test]
    fn a_place_varies_once_however_it_is_spelt() {
        let base = "[[led]]\nx = 1\n[[led]]\nx = 2\n[stack]\n[[stack.layer]]\nname = 'top'\nn = 1\n";
        let check = |one: &str, other: &str| {
            let one = vary("a", one, |v| v.uniform = Some([1.0, 2.0]));
            let other = vary("b", other, |v| v.uniform = Some([1.0, 2.0]));
            plan(&[one, other], &[], Design::Sobol { points: 8, seed: 0 }).unwrap().check_places(base)
        };
        for (one, other) in [
            ("stack.layer[0].n", "stack.layer[\"top\"].n"),
            ("led[0].x", "led[*].x"),
            ("led[*].x", "led[1].x"),
            ("stack", "stack.layer[0].n"),
            ("camera.sensor.gain", "camera.sensor"),
        ] {
            let found = check(one, other).unwrap_err();
            assert!(found.key == "vary[1].key" && found.message.contains("which a varies too"), "{found}");
        }
        check("led[0].x", "led[1].x").unwrap();
        check("led[0].x", "led[0].x_mm").unwrap();
    }

    #[test]
    fn what_does_not_fit_together_is_told_with_its_key() {
        let drawn = || vary("d", "x.d", |v| v.uniform = Some([1.0, 2.0]));
        let circle = [
            vary("a", "x.a", |v| v.expression = Some("b + 1".into())),
            vary("b", "x.b", |v| v.expression = Some("a + 1".into())),
        ];
        let sobol = || Design::Sobol { points: 8, seed: 0 };
        let named = vary("w", "x.walls", |v| v.choice = Some(vec![Scalar::Text("black".into()), Scalar::Number(1.0)]));
        for (found, key, said) in [
            (plan(&[drawn()], &[], Design::Grid {}), "vary[0]", "a grid needs an axis"),
            (plan(&[vary("d", "x.d", |_| {})], &[], sobol()), "vary[0]", "has no values"),
            (plan(&[drawn(), drawn()], &[], sobol()), "vary[1].name", "twice"),
            (
                plan(&[drawn(), vary("e", "x.d", |v| v.fixed = Some(Scalar::Flag(true)))], &[], sobol()),
                "vary[1].key",
                "varies twice",
            ),
            (plan(&circle, &[], sobol()), "vary[0].expression", "in a circle: a, b"),
            (plan(&[below(), top()], &[], Design::Grid {}), "vary[0].expression", "step is no variable"),
            (plan(&[top()], &["n_tip > 1"], Design::Grid {}), "require[0].expression", "there are n_top"),
            (plan(&[top()], &["n_top >"], Design::Grid {}), "require[0].expression", "ends where"),
            (
                plan(&[vary("1d", "x.d", |v| v.fixed = Some(Scalar::Flag(true)))], &[], sobol()),
                "vary[0].name",
                "letters",
            ),
            (
                plan(&[vary("max", "x.d", |v| v.fixed = Some(Scalar::Flag(true)))], &[], sobol()),
                "vary[0].name",
                "function",
            ),
            (
                plan(&[Vary { values: numbers(&[1.0]), ..Vary::default() }], &[], sobol()),
                "vary[0]",
                "neither a key nor a name",
            ),
            (plan(&[vary("d", "x..d", |_| {})], &[], sobol()), "vary[0].key", "no key can have"),
            (
                plan(&[drawn(), vary("e", "", |v| v.uniform = Some([0.0, 1.0]))], &[], sobol()),
                "vary[1]",
                "changes nothing",
            ),
            (plan(&[named], &["w == 1"], sobol()), "require[0].expression", "not always a number: it may be black"),
        ] {
            let found = found.unwrap_err();
            assert!(found.key == key && found.message.contains(said), "{found}");
        }
    }
}
