//! The report: one HTML file with everything inside, for screens of any width, light or dark.

use super::explore::{self, Explore, Points};
use super::ticks;
use crate::estimate::{Estimates, PaperEstimate, Value};
use crate::film::Ledger;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// A report to be written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Title of the page.
    pub title: String,
    /// One or two sentences: what was computed and what came out.
    pub summary: String,
    /// What was computed at a glance (adapter, integrator and why, seconds, samples), as name and value.
    pub facts: Vec<(String, String)>,
    /// The parts, in order.
    pub sections: Vec<Section>,
    /// Where the numbers come from (scene, hash, seed, version), as name and value.
    pub provenance: Vec<(String, String)>,
}

/// One part of a report.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Heading.
    pub title: String,
    /// What is in it, in order.
    pub items: Vec<Item>,
}

/// One thing in a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// A paragraph.
    Text(String),
    /// Something the reader must know.
    Warning(String),
    /// A picture as SVG text.
    Picture {
        /// The SVG.
        svg: String,
        /// What it shows, for those who cannot see it.
        alt: String,
        /// Caption below it.
        caption: String,
    },
    /// A table.
    Table(Table),
    /// Estimates: name, unit, value.
    Values(Vec<(String, String, Value)>),
    /// Where the light went.
    Ledger(Ledger),
    /// What answers to a pointer; it brings its own heading, in a section without one.
    Explore(Box<Explore>),
    /// Points to be gone through; with its own heading too.
    Points(Points),
}

/// A table of text.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Caption above it.
    pub caption: String,
    /// Headings with units.
    pub columns: Vec<String>,
    /// Rows of cells.
    pub rows: Vec<Vec<String>>,
}

impl Item {
    /// A picture.
    pub fn picture(svg: &str, alt: &str, caption: impl Into<String>) -> Self {
        Self::Picture { svg: svg.to_owned(), alt: alt.to_owned(), caption: caption.into() }
    }

    /// The paper's figures of one image as a table of values.
    pub fn from_paper(paper: &PaperEstimate) -> Self {
        let row = |name: &str, unit: &str, value: Value| (name.to_owned(), unit.to_owned(), value);
        Self::Values(vec![
            row("diameter d of the lit area", "px", paper.diameter_px.clone()),
            row("the same on the touched face", "mm", paper.diameter_mm.clone()),
            row("centroid, column", "px", paper.centroid_px.axis(0)),
            row("centroid, row", "px", paper.centroid_px.axis(1)),
            row("depth indicator h", "grey levels", paper.h_grey.clone()),
            row("sum M of grey values", "grey levels", paper.sum_grey.clone()),
        ])
    }

    /// Size, depth and modulus as a table of values.
    pub fn from_estimates(estimates: &Estimates) -> Self {
        let row = |name: &str, unit: &str, value: &Value| (name.to_owned(), unit.to_owned(), value.clone());
        Self::Values(vec![
            row("size", "mm", &estimates.size_mm),
            row("depth", "mm", &estimates.depth_mm),
            row("Young's modulus", "kPa", &estimates.youngs_kpa),
        ])
    }
}

const STYLE: &str = "\
:root{color-scheme:light dark;--page:#f6f8fa;--card:#ffffff;--ink:#1f2328;--muted:#59636e;--hair:#d1d9e0;--accent:#0969da;--warn:#fff8c5;--warn-ink:#633c01}\
@media (prefers-color-scheme:dark){:root{--page:#0d1117;--card:#161b22;--ink:#e6edf3;--muted:#9da7b1;--hair:#30363d;--accent:#4493f8;--warn:#3a2d0b;--warn-ink:#f0d58a}}\
*{box-sizing:border-box}\
body{margin:0;overflow-wrap:break-word;background:var(--page);color:var(--ink);font:16px/1.55 system-ui,-apple-system,'Segoe UI','Helvetica Neue',Arial,sans-serif;font-variant-numeric:tabular-nums}\
main{max-width:58rem;margin:0 auto;padding:1.5rem 1rem 3rem}\
h1{font-size:1.75rem;line-height:1.2;margin:.5rem 0 .5rem;text-wrap:balance}\
h2{font-size:1.25rem;margin:2.5rem 0 .75rem;padding-bottom:.3rem;border-bottom:1px solid var(--hair)}\
.summary{font-size:1.1rem;color:var(--muted);margin:0 0 1.25rem;max-width:46rem}\
dl{display:grid;grid-template-columns:repeat(auto-fill,minmax(9rem,1fr));gap:.6rem;margin:0}\
dl>div{background:var(--card);border:1px solid var(--hair);border-radius:8px;padding:.55rem .8rem;min-width:0}\
dt{font-size:.78rem;color:var(--muted)}dd{margin:0;overflow-wrap:anywhere}\
dl.wide{grid-template-columns:1fr;gap:0;background:var(--card);border:1px solid var(--hair);border-radius:8px}\
dl.wide>div{display:grid;grid-template-columns:minmax(5.5rem,22%) 1fr;gap:1rem;border:0;border-radius:0;background:none}\
dl.wide>div+div{border-top:1px solid var(--hair)}dl.wide dt{font-size:.9rem}dl.wide dd{font-size:.9rem}\
figure{margin:1rem 0;background:var(--card);border:1px solid var(--hair);border-radius:8px;padding:.5rem}\
figure img{display:block;width:auto;max-width:100%;height:auto;margin:0 auto}\
figcaption{color:var(--muted);font-size:.9rem;padding:.4rem .6rem .3rem}\
.scroll{overflow-x:auto;background:var(--card);border:1px solid var(--hair);border-radius:8px;margin:1rem 0}\
table{border-collapse:collapse;width:100%;font-size:.93rem}\
caption{text-align:left;color:var(--muted);font-size:.9rem;padding:.6rem .8rem .2rem}\
th,td{text-align:left;padding:.45rem .8rem;border-top:1px solid var(--hair);vertical-align:baseline}\
thead th{border-top:0;font-weight:600;white-space:nowrap}tbody th{font-weight:400}\
td.whole{white-space:nowrap}td.number{text-align:right;white-space:nowrap}th.number{text-align:right}\
.undefined{color:var(--muted);font-style:italic}\
.bar{width:35%;min-width:5rem}.bar i{display:block;height:.6rem;border-radius:3px;background:var(--accent);min-width:1px}\
@media (max-width:40rem){figure{padding:.15rem}th,td{padding:.4rem .55rem}table{font-size:.86rem}thead th{white-space:normal}td.whole{white-space:normal}.bar{width:25%;min-width:3rem}\
table.wide,table.wide caption,table.wide tbody,table.wide tr{display:block}table.wide thead{display:none}\
table.wide tr{border-top:1px solid var(--hair);padding:.3rem 0}\
table.wide td{display:flex;justify-content:space-between;gap:1rem;border:0;padding:.12rem .55rem;text-align:right;white-space:normal}\
table.wide td::before{content:attr(data-label);color:var(--muted);text-align:left}}\
.warning{background:var(--warn);color:var(--warn-ink);border-radius:8px;padding:.6rem .9rem;margin:1rem 0}";

impl Report {
    /// The whole file.
    pub fn to_html(&self) -> String {
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    main {
                        header {
                            h1 { (self.title) }
                            @if !self.summary.is_empty() { p.summary { (self.summary) } }
                            @if !self.facts.is_empty() { (definitions(&self.facts, "")) }
                        }
                        @for section in &self.sections {
                            section {
                                @if !section.title.is_empty() { h2 { (section.title) } }
                                @for item in &section.items { (self::item(item)) }
                            }
                        }
                        @if !self.provenance.is_empty() {
                            footer {
                                h2 { "Provenance" }
                                (definitions(&self.provenance, "wide"))
                            }
                        }
                    }
                }
            }
        };
        page.into_string()
    }
}

fn definitions(pairs: &[(String, String)], class: &str) -> Markup {
    html! {
        dl class=[(!class.is_empty()).then_some(class)] {
            @for (name, value) in pairs { div { dt { (name) } dd { (value) } } }
        }
    }
}

fn item(item: &Item) -> Markup {
    match item {
        Item::Text(text) => html! { p { (text) } },
        Item::Warning(text) => html! { p.warning role="note" { strong { "Note: " } (text) } },
        Item::Picture { svg, alt, caption } => html! {
            figure {
                img alt=(alt) src={ "data:image/svg+xml," (PreEscaped(in_address(svg))) };
                @if !caption.is_empty() { figcaption { (caption) } }
            }
        },
        Item::Table(table) => text_table(table),
        Item::Values(values) => value_table(values),
        Item::Ledger(ledger) => ledger_table(ledger),
        Item::Explore(explore) => answering(explore::PAGE, "explore-data", &explore.json(), &explore::SCRIPTS),
        Item::Points(points) => {
            answering(explore::POINTS_PAGE, "points-data", &explore::in_page(points), &explore::POINTS_SCRIPTS)
        }
    }
}

/// A picture's text as part of an address in double quotes: a quarter shorter than in base64.
fn in_address(svg: &str) -> String {
    let mut address = String::with_capacity(svg.len() + svg.len() / 8);
    for letter in svg.chars() {
        match letter {
            '"' => address.push_str("%22"),
            '#' => address.push_str("%23"),
            '%' => address.push_str("%25"),
            '&' => address.push_str("%26"),
            // Addresses lose line breaks, and one is a space here.
            '\n' => address.push(' '),
            _ => address.push(letter),
        }
    }
    address
}

/// A skeleton, what it is filled with, and what fills it.
fn answering(skeleton: &str, id: &str, content: &str, scripts: &[&str]) -> Markup {
    html! {
        (PreEscaped(skeleton))
        style { (PreEscaped(explore::STYLE)) }
        script type="application/json" id=(id) { (PreEscaped(content)) }
        @for script in scripts { script { (PreEscaped(script)) } }
    }
}

/// Columns that a telephone has room for; rows of wider tables stand there as lists of name and value.
const PHONE_COLUMNS: usize = 3;

fn text_table(table: &Table) -> Markup {
    let numeric = |column: usize| {
        let mut cells = table.rows.iter().filter_map(|row| row.get(column)).peekable();
        cells.peek().is_some() && cells.all(|cell| starts_as_number(cell))
    };
    let class = |column: usize| numeric(column).then_some("number");
    let is_wide = table.columns.len() > PHONE_COLUMNS;
    let label = |column: usize| table.columns.get(column).map(String::as_str).unwrap_or_default();
    html! {
        div.scroll {
            table class=[is_wide.then_some("wide")] {
                @if !table.caption.is_empty() { caption { (table.caption) } }
                thead { tr { @for (i, name) in table.columns.iter().enumerate() { th scope="col" class=[class(i)] { (name) } } } }
                tbody {
                    @for row in &table.rows {
                        tr { @for (i, cell) in row.iter().enumerate() { td class=[class(i)] data-label=[is_wide.then(|| label(i))] { (cell) } } }
                    }
                }
            }
        }
    }
}

fn starts_as_number(cell: &str) -> bool {
    cell.trim_start_matches(['−', '-', '+']).starts_with(|c: char| c.is_ascii_digit())
}

fn value_table(values: &[(String, String, Value)]) -> Markup {
    html! {
        div.scroll {
            table {
                thead { tr { th scope="col" { "Quantity" } th scope="col" { "Value" } th scope="col" { "95 % interval" } } }
                tbody {
                    @for (name, unit, value) in values {
                        tr {
                            th scope="row" { (name) }
                            @match value {
                                Value::Known { value, low, high } => {
                                    @let (value, range) = ticks::interval(*value, *low, *high);
                                    td.whole { (value) " " (unit) }
                                    td.whole { (range) }
                                }
                                Value::Undefined { reason } => { td.undefined colspan="2" { "undefined: " (reason) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn ledger_table(ledger: &Ledger) -> Markup {
    let rows = [
        ("absorbed", ledger.absorbed),
        ("escaped through the touched side", ledger.escaped_top),
        ("escaped towards the camera side", ledger.escaped_bottom),
        ("escaped through the walls", ledger.escaped_sides),
        ("detected", ledger.detected),
        ("terminated by a cap", ledger.terminated),
        ("Russian roulette (0 on average)", ledger.roulette),
        ("residual", ledger.residual),
    ];
    html! {
        div.scroll {
            table {
                caption { "Shares of the power sent out by the LEDs (emitted: " (ticks::short(ledger.emitted)) ")" }
                thead { tr { th scope="col" { "Where it went" } th.number scope="col" { "Share" } th scope="col" aria-hidden="true" {} } }
                tbody {
                    @for (name, share) in rows {
                        tr {
                            th scope="row" { (name) }
                            td.number { (ticks::short(share)) }
                            td.bar aria-hidden="true" {
                                @if share > 0.0 { i style={ "width:" (format!("{:.2}", 100.0 * share.min(1.0))) "%" } {} }
                            }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
#[path = "html_tests.rs"]
mod tests;
