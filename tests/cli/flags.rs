//! Flags that commands share, as they arrive, and wrong ones.

use super::*;
use clap::Parser;
use tirtouch::cli::Common;
use tirtouch::scene::IntegratorChoice;

#[derive(Debug, Parser)]
#[command(allow_negative_numbers = true)]
struct Line {
    #[command(flatten)]
    common: Common,
}

fn parse(flags: &[&str]) -> Result<Common, String> {
    let line = std::iter::once(&"tirtouch").chain(flags);
    Line::try_parse_from(line).map(|line| line.common).map_err(|error| error.to_string())
}

#[test]
fn flags_arrive() {
    let common = parse(&["-o", "x", "--force", "--seed", "7", "--integrator", "map", "--seconds", "1e2"]).unwrap();
    assert_eq!(common.place.named("scene"), PathBuf::from("x"));
    assert_eq!(common.seed, Some(7));
    assert_eq!(common.integrator, Some(IntegratorChoice::Map));
    assert_eq!(common.seconds, Some(100.0));
    assert!(common.place.force && !common.talk.json);
    assert_eq!(parse(&[]).unwrap().place.named("scene"), PathBuf::from("out/scene"));
}

#[test]
fn numbers_that_make_no_sense_are_refused() {
    for flags in [
        ["--seconds", "0"],
        ["--seconds", "-1"],
        ["--seconds", "inf"],
        ["--target-error", "nan"],
        ["--target-error", "-0.1"],
        ["--spp", "0"],
        ["--spp", "-4"],
        ["--photons", "0"],
        ["--seed", "-1"],
        ["--seed", "4294967296"],
        ["--integrator", "bdpt"],
        ["--backend", "tpu"],
    ] {
        let refusal = parse(&flags).unwrap_err();
        assert!(refusal.contains(flags[0]), "{flags:?}: {refusal}");
    }
}

#[test]
fn budgets_exclude_each_other_and_fixed_samples() {
    for flags in [
        ["--seconds", "1", "--spp", "4"],
        ["--seconds", "1", "--photons", "4"],
        ["--seconds", "1", "--target-error", "0.1"],
        ["--target-error", "0.1", "--spp", "4"],
        ["--photons", "9", "--target-error", "0.1"],
    ] {
        assert!(parse(&flags).unwrap_err().contains("cannot be used with"), "{flags:?}");
    }
}

#[test]
fn flags_win_over_the_scene() {
    let scene = tirtouch::scene::Render { spp: 9, photons: Some(7), seed: 5, ..Default::default() };
    let settings = parse(&["--spp", "3"]).unwrap().settings(&scene);
    assert_eq!((settings.spp, settings.photons, settings.seed), (3, Some(7), 5));
}

#[test]
fn f64_goes_to_the_cpu_and_never_to_the_gpu() {
    assert!(!parse(&["--precision", "f64"]).unwrap().devices().unwrap().is_gpu());
    let refused = parse(&["--precision", "f64", "--backend", "gpu"]).unwrap().devices().err().unwrap();
    assert_eq!(refused.code(), 2);
}

#[test]
fn a_wrong_flag_is_one_line_without_the_usage() {
    let output = tirtouch(&["compare", "a", "b", "--levle", "1"]);
    let line = one_line(&output);
    assert_eq!(code(&output), 2);
    assert!(line.contains("'--levle'") && line.contains("'--level'"), "{line}");
    assert!(!line.contains("Usage") && !line.starts_with("error"), "{line}");
}

#[test]
fn missing_arguments_are_named() {
    let output = tirtouch(&["compare"]);
    let line = one_line(&output);
    assert!(code(&output) == 2 && line.contains("<A>") && line.contains("<B>"), "{line}");
}

#[test]
fn a_level_is_a_probability() {
    for (level, words) in [("0", "between 0 and 1"), ("1", "between 0 and 1"), ("1e-9", "a.exr")] {
        let output = tirtouch(&["compare", "a.exr", "b.exr", "--level", level]);
        assert!(code(&output) == 2 && one_line(&output).contains(words), "{output:?}");
    }
}

#[test]
fn json_is_seen_before_the_double_dash_only() {
    assert_eq!(json(&tirtouch(&["--wrong", "--json"]))["error"]["kind"], "usage");
    let output = tirtouch(&["compare", "--", "--json"]);
    assert!(code(&output) == 2 && output.stdout.is_empty(), "{output:?}");
}
