//! The rungs as text, CSV and JSON.

use crate::converge::{FAMILIES, Ladders, Rung, fitted_slope, pareto};
use crate::pages::PageError;
use crate::pages::facts::figure;
use serde_json::{Value, json};

/// Rungs of one family with what they are worth.
fn family<'a>(rungs: &'a [Rung], name: &str) -> Vec<(&'a Rung, bool)> {
    let members: Vec<&Rung> = rungs.iter().filter(|rung| rung.family == name).collect();
    let front = pareto(&members);
    members.into_iter().zip(front).collect()
}

/// Names of the series of a family, in their order.
pub fn series(members: &[&Rung]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for rung in members {
        if !names.contains(&rung.series) {
            names.push(rung.series.clone());
        }
    }
    names
}

/// What `--json` says.
pub fn json(name: &str, found: &Ladders) -> Value {
    let rung = |(rung, front): (&Rung, bool)| {
        let mut value = json!(rung);
        value["pareto"] = json!(front);
        value
    };
    let reference = |part: &Result<String, String>| match part {
        Ok(what) => json!(what),
        Err(why) => json!({"undefined": why}),
    };
    let (mut rungs, mut slopes) = (Vec::new(), Vec::new());
    for entry in FAMILIES {
        let members = family(&found.rungs, entry.name);
        let plain: Vec<&Rung> = members.iter().map(|(rung, _)| *rung).collect();
        for series in series(&plain) {
            let own: Vec<&Rung> = plain.iter().filter(|rung| rung.series == series).copied().collect();
            let slope = match fitted_slope(&own) {
                Some(slope) => json!(slope),
                None => json!({"undefined": "fewer than two rungs that differ in time and have an error"}),
            };
            slopes.push(json!({"family": entry.name, "series": series, "slope": slope}));
        }
        rungs.extend(members.into_iter().map(rung));
    }
    json!({
        "scene": name,
        "reference": {"light": reference(&found.light), "mechanics": reference(&found.mechanics)},
        "rungs": rungs,
        "slopes": slopes,
    })
}

/// All rungs as CSV.
pub fn csv(rungs: &[Rung]) -> Result<String, PageError> {
    let heading = "family,series,setting,level,quantity,error,error_low,error_high,seconds,repeats,default,pareto";
    let mut writer = csv::Writer::from_writer(Vec::new());
    let failed = |error: csv::Error| PageError::Table { file: "converge.csv", error: error.into() };
    writer.write_record(heading.split(',')).map_err(failed)?;
    for entry in FAMILIES {
        for (rung, front) in family(rungs, entry.name) {
            let level = rung.level.map_or_else(String::new, |level| level.to_string());
            let row = [
                rung.family.clone(),
                rung.series.clone(),
                rung.setting.clone(),
                level,
                rung.quantity.clone(),
                rung.error.value.to_string(),
                rung.error.low.to_string(),
                rung.error.high.to_string(),
                rung.seconds.to_string(),
                rung.repeats.to_string(),
                rung.is_default.to_string(),
                front.to_string(),
            ];
            writer.write_record(row).map_err(failed)?;
        }
    }
    let bytes = writer.into_inner().map_err(|error| failed(error.into_error().into()))?;
    String::from_utf8(bytes).map_err(|error| failed(std::io::Error::other(error).into()))
}

/// All rungs for reading.
pub fn text(name: &str, found: &Ladders, out: &str) -> String {
    let mut lines = vec![name.to_owned()];
    for (part, reference) in [("light", &found.light), ("mechanics", &found.mechanics)] {
        lines.push(match reference {
            Ok(what) => format!("  {part} against {what}"),
            Err(why) => format!("  {part}: {why}"),
        });
    }
    for entry in FAMILIES {
        let members = family(&found.rungs, entry.name);
        if members.is_empty() {
            continue;
        }
        lines.push(format!("{}:", entry.title));
        lines.extend(members.into_iter().map(|(rung, front)| {
            let error = &rung.error;
            let marks = [(front, ", on the front"), (rung.is_default, ", default")];
            let marks: String = marks.iter().filter(|(is, _)| *is).map(|(_, mark)| *mark).collect();
            format!(
                "  {:8} s  error {} ({} to {}) of the {}: {}, {}{marks}",
                figure(rung.seconds),
                figure(error.value),
                figure(error.low),
                figure(error.high),
                rung.quantity,
                rung.series,
                rung.setting
            )
        }));
    }
    lines.push(format!("folder: {out}"));
    lines.join("\n")
}
