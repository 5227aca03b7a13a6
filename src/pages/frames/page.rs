//! The report of frames.

use super::pictures::Pictures;
use super::{Reading, rounded, said, tissue};
use crate::figure::Figure;
use crate::pages::facts::figure;
use crate::pages::truth::truth_table;
use crate::report::{Item, Report, Section, Table};

/// Makes the report.
pub fn report(reading: &Reading, pictures: &Pictures) -> Report {
    let source = &reading.source;
    let mut sections = vec![frames(reading, pictures), features(reading, pictures)];
    sections.extend(reading.tissue.as_ref().map(|tissue| tissue::section(tissue, &reading.source)));
    if let (Some(computed), Some(svg)) = (&source.computed, &pictures.pressed) {
        let caption = "Pressure within the tissue; the indenter comes from below, the rigid base is above.";
        let rows = computed.facts().into_iter().map(|(name, value)| vec![name, value]).collect();
        let columns = ["figure", "value"].map(str::to_owned).to_vec();
        let table = Table { caption: "How it was computed".to_owned(), columns, rows };
        let mut items = vec![Item::picture(svg, "deformed mesh with pressure", caption), Item::Table(table)];
        items.extend(truth_table(&source.truth));
        sections.push(Section { title: "Mechanics".to_owned(), items });
    }
    Report {
        title: format!("tirtouch: {}", source.name),
        summary: format!("{} {} frames: {}.", source.description, reading.features.len(), reading.ranges()),
        facts: cards(reading),
        sections,
        provenance: source.provenance.clone(),
    }
}

fn cards(reading: &Reading) -> Vec<(String, String)> {
    let card = |name: &str, value: String| (name.to_owned(), value);
    let f = &reading.features[reading.shown];
    let mut cards = vec![
        card("frames", reading.features.len().to_string()),
        card("shown frame", format!("{} mm", figure(f.position_mm))),
        card("its peak", said(&f.peak_kpa, "kPa")),
        card("its base", said(&f.base_kpa, "kPa")),
        card("its width", said(&f.fwhm_mm, "mm")),
    ];
    if let Some(computed) = &reading.source.computed {
        cards.push(card("unknowns", computed.scanned.unknowns.to_string()));
        cards.push(card("time", format!("{} s", figure(computed.scanned.seconds))));
    }
    cards
}

fn frames(reading: &Reading, pictures: &Pictures) -> Section {
    let mut items = vec![
        Item::picture(
            &pictures.frames,
            "frames in false colour",
            "Each frame is a horizontal stripe (figure 5 of Galea and Howe).",
        ),
        Item::picture(
            &pictures.frame,
            "one frame with its parabola",
            format!("One frame with its fit (their figure 4). The reference is {}.", reading.source.reference_name()),
        ),
    ];
    items.extend(reading.notes().into_iter().map(Item::Warning));
    Section { title: "Frames".to_owned(), items }
}

fn features(reading: &Reading, pictures: &Pictures) -> Section {
    let cell = |feature: &Figure| match feature.value() {
        Some(value) => figure(value),
        None => "undefined".to_owned(),
    };
    let rows = reading.features.iter().map(|f| {
        let features = [&f.peak_kpa, &f.base_kpa, &rounded(&f.center_mm), &f.fwhm_mm, &rounded(&f.eccentricity)];
        std::iter::once(figure(f.position_mm)).chain(features.map(cell)).collect()
    });
    let columns = ["position (mm)", "peak (kPa)", "base (kPa)", "centre (mm)", "width (mm)", "eccentricity"];
    let table = Table {
        caption: "Features of every frame".to_owned(),
        columns: columns.map(str::to_owned).to_vec(),
        rows: rows.collect(),
    };
    let text = format!(
        "The parabola is fitted over {}. Peak and centre are its vertex, the width is its full width at half of the \
         peak, the base is the raw pressure at the ends of the window. Eccentricity is the asymmetry of what the \
         inclusion adds, from -1 (all left) to 1 (all right), compared with {}.",
        reading.window_text(),
        reading.source.reference_name()
    );
    let items = vec![
        Item::Text(text),
        Item::picture(&pictures.pressure, "peak and base against position", "Peak and base."),
        Item::picture(&pictures.width, "width against position", "Width."),
        Item::picture(&pictures.eccentricity, "eccentricity against position", "Eccentricity."),
        Item::Table(table),
    ];
    Section { title: "Features".to_owned(), items }
}
