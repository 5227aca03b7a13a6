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
        (plan(&[vary("1d", "x.d", |v| v.fixed = Some(Scalar::Flag(true)))], &[], sobol()), "vary[0].name", "letters"),
        (plan(&[vary("max", "x.d", |v| v.fixed = Some(Scalar::Flag(true)))], &[], sobol()), "vary[0].name", "function"),
        (
            plan(&[Vary { values: numbers(&[1.0]), ..Vary::default() }], &[], sobol()),
            "vary[0]",
            "neither a key nor a name",
        ),
        (plan(&[vary("d", "x..d", |_| {})], &[], sobol()), "vary[0].key", "no key can have"),
        (plan(&[drawn(), vary("e", "", |v| v.uniform = Some([0.0, 1.0]))], &[], sobol()), "vary[1]", "changes nothing"),
        (plan(&[named], &["w == 1"], sobol()), "require[0].expression", "not always a number: it may be black"),
    ] {
        let found = found.unwrap_err();
        assert!(found.key == key && found.message.contains(said), "{found}");
    }
}
