use super::super::raster::tests::{blob, raster};
use super::super::{ColorScale, false_color};
use super::*;

fn report() -> Report {
    let values = blob(1.0);
    let svg = false_color("Radiance", &raster(&values), ColorScale::Auto).unwrap();
    let ledger = Ledger { emitted: 1.0, absorbed: 0.7, escaped_bottom: 0.2, escaped_top: 0.1, ..Default::default() };
    let values = vec![
        ("size".to_owned(), "mm".to_owned(), Value::known(7.9, 7.5, 8.4)),
        ("depth".to_owned(), "mm".to_owned(), Value::undefined("no <model>")),
    ];
    Report {
        title: "A & B".into(),
        summary: "What was computed.".into(),
        facts: vec![("integrator".into(), "splat".into())],
        sections: vec![Section {
            title: "Results".into(),
            items: vec![
                Item::Text("text".into()),
                Item::Warning("saturated".into()),
                Item::Picture { svg, alt: "a \"blob\"".into(), caption: "caption".into() },
                Item::Table(Table {
                    caption: String::new(),
                    columns: vec!["layer".into(), "acceptance (degrees)".into()],
                    rows: vec![vec!["glass".into(), "71.989".into()]],
                }),
                Item::Values(values),
                Item::Ledger(ledger),
            ],
        }],
        provenance: vec![("seed".into(), "1".into())],
    }
}

#[test]
fn report_is_one_escaped_page_without_outside_references() {
    let html = report().to_html();
    assert!(html.starts_with("<!DOCTYPE html><html lang=\"en\">"));
    assert!(html.contains("<title>A &amp; B</title>") && html.contains("alt=\"a &quot;blob&quot;\""));
    assert!(html.contains("undefined: no &lt;model&gt;"));
    let html = html.replace("xmlns=%22http://www.w3.org/2000/svg%22", "");
    assert!(!html.contains("http"), "nothing is fetched");
}

#[test]
fn picture_comes_back_from_the_page_as_it_was() {
    let report = report();
    let html = report.to_html();
    let data = html.split("data:image/svg+xml,").nth(1).unwrap().split('"').next().unwrap();
    let Item::Picture { svg, .. } = &report.sections[0].items[2] else { panic!("no picture") };
    assert!(!data.contains(['\n', '#', '&']), "these would change or end the address");
    let byte = |part: &str| char::from(u8::from_str_radix(&part[..2], 16).unwrap()).to_string() + &part[2..];
    let mut parts = data.split('%');
    let decoded = parts.next().unwrap().to_owned() + &parts.map(byte).collect::<String>();
    assert_eq!(decoded, svg.replace('\n', " "));
}

#[test]
fn columns_of_numbers_are_aligned_right_and_names_left() {
    let html = report().to_html();
    assert!(html.contains(r#"<td class="number">71.989</td>"#) && html.contains("<td>glass</td>"));
}

#[test]
fn empty_report_is_a_page_without_empty_parts() {
    let html = Report { title: "t".into(), ..Default::default() }.to_html();
    assert!(!html.contains("<dl") && !html.contains("Provenance"));
}

#[test]
fn rows_of_wide_tables_name_their_cells_for_narrow_screens() {
    let texts = |count: usize| (0..count).map(|i| format!("c{i}")).collect::<Vec<_>>();
    let page = |count: usize| {
        let table = Table { caption: String::new(), columns: texts(count), rows: vec![texts(count)] };
        let section = Section { title: "t".into(), items: vec![Item::Table(table)] };
        Report { sections: vec![section], ..Default::default() }.to_html()
    };
    assert!(!page(3).contains("data-label=") && !page(3).contains("<table class"));
    let wide = page(4);
    assert!(wide.contains(r#"<table class="wide">"#) && wide.contains(r#"<td data-label="c3">c3</td>"#), "{wide}");
}
