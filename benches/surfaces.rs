//! Which representation of a deformed face gives the least image error at equal time?
//!
//!     cargo run --release --example surfaces -- out/surfaces
//!
//! Dents in the touched face of `dent-cap`: its spherical cap, which has a crease at the rim, and Gaussians, which have
//! none. Each is traced as a closed form (the cap), as B-spline height fields and as meshes, in alternating rounds of
//! one process; all rounds use the same random numbers, so that images differ by the surface alone. Writes
//! `surfaces.csv` and prints the table for docs/decisions/surfaces.md. Takes about 10 minutes on 2 cores.

#[path = "surfaces/candidates.rs"]
mod candidates;
#[path = "surfaces/direction.rs"]
mod direction;
#[path = "surfaces/image.rs"]
mod image;
mod statistics;

use anyhow::{Context as _, Result};
use candidates::{Dent, candidates};
use direction::Errors;
use image::{ImageError, SPP};
use std::path::PathBuf;

/// One line of the table.
struct Row {
    dent: &'static str,
    surface: String,
    directions: Errors,
    image: ImageError,
}

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("out/surfaces"), PathBuf::from);
    let rounds = std::env::args().nth(2).map_or(Ok(8), |n| n.parse()).context("the second argument is rounds")?;
    std::fs::create_dir_all(&folder)?;
    let mut rows = Vec::new();
    for dent in Dent::all() {
        let candidates = candidates(&dent)?;
        let images = image::errors(&dent, &candidates, rounds)?;
        for (candidate, image) in candidates.iter().zip(images.rows) {
            let directions = direction::errors(&dent, &candidate.model);
            rows.push(Row { dent: dent.name, surface: candidate.name.clone(), directions, image });
        }
        println!("{}: {}, {rounds} rounds of {SPP} paths per pixel\n", dent.name, images.adapter);
        print_table(&rows, dent.name);
    }
    write_csv(&rows, &folder.join("surfaces.csv"))
}

fn print_table(rows: &[Row], dent: &str) {
    println!("| surface | paths/s | ratio | direction error, rms | off the rim | in f32 | bias of 4-pixel blocks |");
    println!("|---|---|---|---|---|---|---|");
    for Row { surface, directions: d, image, .. } in rows.iter().filter(|row| row.dent == dent) {
        println!(
            "| {surface} | {:.2e} | {:.2} | {:.1e} | {:.1e} | {:.1e} | {:.2} ± {:.2} % |",
            image.paths_per_second,
            image.speed_ratio,
            d.all,
            d.off_rim,
            d.off_rim_f32,
            100.0 * image.bias.value,
            100.0 * image.bias.error
        );
    }
    println!(
        "\nError of 4-pixel blocks, noise and bias, in the time that the first row needs for so many paths per pixel:\n"
    );
    println!("| surface | 64 | 1024 | 16384 | mean of the image |");
    println!("|---|---|---|---|---|");
    for Row { surface, image, .. } in rows.iter().filter(|row| row.dent == dent) {
        let [short, medium, long] = image.total.map(|t| 100.0 * t);
        let mean = image.mean_bias;
        println!(
            "| {surface} | {short:.2} % | {medium:.2} % | {long:.2} % | {:+.3} ± {:.3} % |",
            100.0 * mean.value,
            100.0 * mean.error
        );
    }
    println!();
}

fn write_csv(rows: &[Row], path: &std::path::Path) -> Result<()> {
    let mut out = csv::Writer::from_path(path)?;
    out.write_record([
        "dent",
        "surface",
        "paths_per_second",
        "speed_ratio",
        "direction_rms_rad",
        "direction_rms_off_rim_rad",
        "direction_rms_off_rim_f32_rad",
        "block_bias",
        "block_bias_error",
        "mean_bias",
        "mean_bias_error",
        "error_64",
        "error_1024",
        "error_16384",
    ])?;
    for Row { dent, surface, directions: d, image } in rows {
        let mut record = vec![(*dent).to_owned(), surface.clone()];
        let [short, medium, long] = image.total;
        let numbers = [
            image.paths_per_second,
            image.speed_ratio,
            d.all,
            d.off_rim,
            d.off_rim_f32,
            image.bias.value,
            image.bias.error,
            image.mean_bias.value,
            image.mean_bias.error,
            short,
            medium,
            long,
        ];
        record.extend(numbers.map(|v| format!("{v:e}")));
        out.write_record(record)?;
    }
    out.flush()?;
    Ok(())
}
