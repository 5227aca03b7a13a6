use super::super::svg::assert_well_formed;
use super::labels::spread;
use super::*;

fn paper_side() -> SideView {
    let layer = |name: &str, n, thickness_mm| SideLayer { name: name.into(), n, thickness_mm };
    let face = |z: f64, share: f64| {
        let dent = |x: f64| 2.0 * share * (-x * x / 18.0).exp();
        (0..=120).map(|i| f64::from(i) * 0.25 - 15.0).map(|x| [x, z - dent(x)]).collect::<Vec<_>>()
    };
    SideView {
        title: "Stack from the side".into(),
        subtitle: "section y = 0".into(),
        half_width_mm: 15.0,
        layers: vec![
            layer("PDMS, hardest", 1.41, 2.0),
            layer("PDMS, middle", 1.40, 3.0),
            layer("PDMS, softest", 1.39, 5.0),
            layer("glass", 1.38, 2.0),
        ],
        interfaces_mm: vec![face(12.0, 1.0), face(10.0, 0.8), face(7.0, 0.5), face(2.0, 0.0), face(0.0, 0.0)],
        surround_n: 1.0,
        view_edge_mm: vec![[0.0, -17.32], [10.0, 0.0], [10.8, 2.0], [12.7, 7.0], [13.8, 10.0], [14.5, 12.0]],
        leds: vec![
            SideLed { x_mm: -15.0, z_mm: 6.0, diameter_mm: 3.0 },
            SideLed { x_mm: 15.0, z_mm: 6.0, diameter_mm: 3.0 },
        ],
        contact_mm: vec![[-4.0, 4.0]],
        rays: vec![
            RayPolyline { points_mm: vec![[-15.0, 0.0, 6.0], [-3.0, 0.0, 0.0], [15.0, 0.0, 9.0]], fate: Fate::Guided },
            RayPolyline {
                points_mm: vec![[-15.0, 0.0, 5.5], [-1.0, 0.0, 10.1], [3.0, 0.0, 0.0], [6.0, 0.0, -8.0]],
                fate: Fate::Scattered,
            },
            RayPolyline {
                points_mm: vec![[15.0, 0.0, 6.5], [9.0, 0.0, 11.7], [7.0, 0.0, 15.0]],
                fate: Fate::EscapedTop,
            },
            RayPolyline {
                points_mm: vec![[15.0, 0.0, 6.0], [-2.0, 0.0, 0.0], [-15.0, 0.0, 4.0]],
                fate: Fate::Absorbed,
            },
        ],
    }
}

#[test]
fn side_view_labels_layers_and_counts_rays_by_fate() {
    let svg = side_view(&paper_side()).unwrap();
    assert_well_formed(&svg);
    for text in [
        "PDMS, softest",
        "n 1.39 · 5 mm",
        "guided (1)",
        "scattered by contact (1)",
        "tissue in contact",
        "5 mm, both axes",
    ] {
        assert!(svg.contains(&format!(">{text}<")), "{text}");
    }
    assert!(!svg.contains("escaped below"), "only fates that occur are in the legend");
}

#[test]
fn both_axes_have_one_scale() {
    let frame = Frame::new(&paper_side());
    let [x0, y0] = frame.at([0.0, 0.0]);
    let [x1, y1] = frame.at([1.0, 1.0]);
    assert!((x1 - x0 - (y0 - y1)).abs() < 1e-9);
}

#[test]
fn labels_keep_their_gap_their_order_and_their_places_where_they_can() {
    let placed = spread(&[100.0, 101.0, 102.0, 300.0], 36.0, 50.0);
    assert!(placed.windows(2).all(|p| p[1] - p[0] >= 36.0 - 1e-9), "{placed:?}");
    assert_eq!(placed[3], 300.0);
    // The cluster's mean stays at the wished mean.
    assert!((placed[..3].iter().sum::<f64>() / 3.0 - 101.0).abs() < 1e-9, "{placed:?}");
    assert_eq!(spread(&[10.0, 11.0], 36.0, 50.0), [50.0, 86.0]);
}

#[test]
fn thin_layers_are_labelled_without_overlap() {
    let mut view = paper_side();
    view.layers[1].thickness_mm = 1e-5;
    view.interfaces_mm[2] = view.interfaces_mm[1].clone();
    let svg = side_view(&view).unwrap();
    assert_well_formed(&svg);
    assert!(svg.contains("10 × 10⁻⁶ mm") || svg.contains("10.0 × 10⁻⁶ mm"), "thickness in full");
}

#[test]
fn bad_input_is_a_typed_error() {
    let with = |change: fn(&mut SideView)| {
        let mut view = paper_side();
        change(&mut view);
        side_view(&view).unwrap_err().to_string()
    };
    assert!(with(|v| v.half_width_mm = 0.0).contains("half width"));
    assert!(with(|v| drop(v.interfaces_mm.pop())).contains("one more than"));
    assert!(with(|v| v.rays[0].points_mm[1][2] = f64::NAN).contains("coordinate"));
}

#[test]
fn empty_stack_is_drawn() {
    let view = SideView {
        layers: vec![],
        interfaces_mm: vec![vec![]],
        view_edge_mm: vec![],
        leds: vec![],
        contact_mm: vec![],
        rays: vec![],
        ..paper_side()
    };
    assert_well_formed(&side_view(&view).unwrap());
}

#[test]
fn a_ray_is_drawn_up_to_the_edge_of_the_picture() {
    let inside = stack::within(&[[5.0, 5.0], [15.0, 5.0], [15.0, 8.0]], [0.0, 0.0, 10.0, 10.0]);
    assert_eq!(inside, [[5.0, 5.0], [10.0, 5.0]]);
    let kept = stack::within(&[[5.0, 5.0], [6.0, 7.0]], [0.0, 0.0, 10.0, 10.0]);
    assert_eq!(kept, [[5.0, 5.0], [6.0, 7.0]]);
}
