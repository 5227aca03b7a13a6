//! Curves of the extreme cases.

use crate::output::OutputFolder;
use crate::pages::PageError;
use crate::report::{AxisName, Curve, CurvePlot, CurveStyle, LogPlot, LogPoint, LogSeries, LogStyle};
use crate::report::{curve_plot, log_plot};
use crate::stability::{Context, DriftSample, Sample, Tracer, about_critical, drift_curve, pressure_errors};

/// Writes all pictures.
pub fn write(context: &Context, folder: &OutputFolder) -> Result<(), PageError> {
    folder.write("reflectance.svg", &reflectance(context)?)?;
    folder.write("reflectance_error.svg", &reflectance_error(context)?)?;
    folder.write("drift.svg", &drift(context)?)?;
    Ok(folder.write("pressure.svg", &pressure()?)?)
}

/// Reflectance within a tenth of a milliradian of the critical angle of a small step.
fn reflectance(context: &Context) -> Result<String, PageError> {
    let offsets: Vec<f64> = (-100..=20).map(|k| 1e-6 * f64::from(k)).collect();
    let mut curves = Vec::new();
    for (k, tracer) in context.tracers.iter().enumerate() {
        let samples = about_critical(tracer, [1.411, 1.41], &offsets)?;
        if curves.is_empty() {
            let points = samples.iter().map(|s| [1e6 * s.off_rad, s.exact]).collect();
            let name = "exact (f64)".into();
            curves.push(Curve { name, points, band: Vec::new(), style: CurveStyle::Line });
        }
        let points =
            samples.iter().skip(k).step_by(context.tracers.len()).map(|s| [1e6 * s.off_rad, s.found]).collect();
        curves.push(Curve { name: tracer.name().into(), points, band: Vec::new(), style: CurveStyle::Points });
    }
    Ok(curve_plot(&CurvePlot {
        title: "Reflectance next to the critical angle",
        subtitle: "index 1.411 to 1.41, unpolarised",
        x: AxisName { quantity: "angle of incidence less the critical angle", unit: "urad" },
        y: AxisName { quantity: "reflectance", unit: "" },
        curves,
        highest: None,
        from_zero: true,
    })?)
}

/// Its error from 1e-1 to 1e-7 rad below the critical angle, for several steps of the index.
fn reflectance_error(context: &Context) -> Result<String, PageError> {
    let (mut series, mut allowed) = (Vec::new(), Vec::new());
    let sizes: Vec<f64> = (0..=240).map(|k| 10f64.powf(-1.0 - f64::from(k) / 40.0)).collect();
    let offsets: Vec<f64> = sizes.iter().map(|s| -s).collect();
    let tracer = context.tracers.first().copied().unwrap_or_else(Tracer::twin);
    for [n_i, n_t] in [[1.41, 1.0], [1.41, 1.40], [1.411, 1.41]] {
        let samples = about_critical(&tracer, [n_i, n_t], &offsets)?;
        let points = |y: fn(&Sample) -> f64| samples.iter().map(|s| LogPoint::plain([-s.off_rad, y(s)])).collect();
        let found = points(|s| (s.found - s.exact).abs());
        series.push(LogSeries { name: format!("{n_i} to {n_t}"), points: found, style: LogStyle::Points });
        allowed.push(LogSeries {
            name: format!("allowed, {n_i} to {n_t}"),
            points: points(|s| s.allowed),
            style: LogStyle::Dashed,
        });
    }
    series.extend(allowed);
    Ok(log_plot(&LogPlot {
        title: "Error of the reflectance next to the critical angle",
        subtitle: tracer.name(),
        x: AxisName { quantity: "critical angle less the angle of incidence", unit: "rad" },
        y: AxisName { quantity: "error of the reflectance", unit: "" },
        mark: "",
        series,
    })?)
}

/// Drift of the momentum's length against bounces.
fn drift(context: &Context) -> Result<String, PageError> {
    let most = if context.quick { 2_000 } else { 10_000 };
    let mut series = Vec::new();
    for tracer in &context.tracers {
        let samples = drift_curve(tracer, most)?;
        for (name, dented) in [("planes", false), ("a dent of 1 um", true)] {
            let drift = |s: &DriftSample| if dented { s.dented } else { s.planes };
            let points = samples.iter().map(|s| LogPoint::plain([f64::from(s.bounces), drift(s)])).collect();
            let name = format!("{}, {name}", tracer.name());
            series.push(LogSeries { name, points, style: LogStyle::Joined });
        }
    }
    let line = |y: [f64; 2]| [[1.0, y[0]], [f64::from(most), y[1]]].map(LogPoint::plain).to_vec();
    let ulp = 0.5 * f64::from(f32::EPSILON);
    let walk = line([ulp, ulp * f64::from(most).sqrt()]);
    series.push(LogSeries { name: "random walk of half ulps".into(), points: walk, style: LogStyle::Dashed });
    series.push(LogSeries { name: "allowed".into(), points: line([1e-3; 2]), style: LogStyle::Dashed });
    Ok(log_plot(&LogPlot {
        title: "Drift of the optical momentum",
        subtitle: "a guided ray between mirror walls, without loss",
        x: AxisName { quantity: "bounces", unit: "" },
        y: AxisName { quantity: "largest drift of |p| / n", unit: "" },
        mark: "",
        series,
    })?)
}

/// Error of the mean stress up to incompressibility.
fn pressure() -> Result<String, PageError> {
    let ratios: Vec<f64> = (0..=24).map(|k| 0.5 * (1.0 - 10f64.powf(-0.25 * f64::from(k)))).collect();
    let mut series = Vec::new();
    for rung in [2, 4] {
        let samples = pressure_errors(rung, &ratios)?;
        let points = samples.iter().map(|s| LogPoint::plain([1.0 - 2.0 * s.poisson, s.pressure_error])).collect();
        let name = format!("{} elements across", 2 * rung);
        series.push(LogSeries { name, points, style: LogStyle::Joined });
    }
    Ok(log_plot(&LogPlot {
        title: "Error of the pressure up to incompressibility",
        subtitle: "thick sphere under inner pressure; mean stress, rms over the volume",
        x: AxisName { quantity: "1 − 2 ν", unit: "" },
        y: AxisName { quantity: "error, as a share", unit: "" },
        mark: "",
        series,
    })?)
}
