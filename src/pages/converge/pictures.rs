//! Error against run time, one picture a family.

use super::table::series;
use crate::converge::{FAMILIES, Family, Rung, pareto};
use crate::pages::PageError;
use crate::report::{AxisName, LogPlot, LogPoint, LogSeries, LogStyle, log_plot};

/// Name and text of each picture: one for each quantity of a family, the first without its name.
pub fn draw(name: &str, rungs: &[Rung]) -> Result<Vec<(String, String)>, PageError> {
    let mut pictures = Vec::new();
    for family in FAMILIES {
        let members: Vec<&Rung> = rungs.iter().filter(|rung| rung.family == family.name).collect();
        let mut quantities: Vec<&str> = Vec::new();
        for rung in &members {
            if !quantities.contains(&rung.quantity.as_str()) {
                quantities.push(&rung.quantity);
            }
        }
        for (k, quantity) in quantities.iter().enumerate() {
            let own: Vec<&Rung> = members.iter().filter(|rung| rung.quantity == *quantity).copied().collect();
            let suffix = if k == 0 { String::new() } else { format!("_{quantity}") };
            let file = format!("converge_{}{suffix}.svg", family.name).replace(' ', "_");
            pictures.push((file, picture(name, &family, quantity, &own)?));
        }
    }
    Ok(pictures)
}

fn picture(name: &str, family: &Family, quantity: &str, members: &[&Rung]) -> Result<String, PageError> {
    let names = series(members);
    let mut drawn = Vec::new();
    for series in &names {
        let own = members.iter().filter(|rung| rung.series == *series);
        let points = own.map(|rung| LogPoint {
            at: [rung.seconds, rung.error.value],
            bar: Some([rung.error.low, rung.error.high]),
            label: label(rung),
            marked: rung.is_default,
        });
        drawn.push(LogSeries { name: series.clone(), points: points.collect(), style: LogStyle::Points });
    }
    drawn.push(front(members));
    // Through the last point of the first series.
    let anchor = drawn.first().and_then(|series| series.points.last()).map(|point| point.at);
    let spread = members
        .iter()
        .map(|rung| rung.seconds)
        .fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], s| [low.min(s), high.max(s)]);
    if let (Some([x, y]), [low, high]) = (anchor.filter(|[_, y]| *y > 0.0), spread) {
        drawn.extend(family.slopes.iter().map(|(slope, why)| LogSeries {
            name: (*why).into(),
            points: [low, high].map(|t| LogPoint::plain([t, y * (t / x).powf(*slope)])).to_vec(),
            style: LogStyle::Dashed,
        }));
    }
    let subtitle = format!("{name}: {}; {quantity}; 95 % bars; arrows: at most", family.title);
    Ok(log_plot(&LogPlot {
        title: "Error against run time",
        subtitle: &subtitle,
        x: AxisName { quantity: "run time", unit: "s" },
        y: AxisName { quantity: "relative error", unit: "" },
        mark: "default settings",
        series: drawn,
    })?)
}

/// The settings of a rung in a word or two.
fn label(rung: &Rung) -> String {
    match rung.level {
        Some(level) if level >= 1e4 => format!("{:.0}k", 1e-3 * level),
        Some(level) => format!("{level}"),
        None => String::new(),
    }
}

/// What no other rung beats in both.
fn front(members: &[&Rung]) -> LogSeries {
    let front = pareto(members);
    let mut best: Vec<&Rung> = members.iter().zip(front).filter(|(_, on)| *on).map(|(rung, _)| *rung).collect();
    best.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let points = best.iter().map(|rung| LogPoint::plain([rung.seconds, rung.error.bound()])).collect();
    LogSeries { name: "Pareto front".into(), points, style: LogStyle::Line }
}
