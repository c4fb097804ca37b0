//! SVG: well-formed, in range, labelled without overlaps.

use octolux::report::plot::{Curve, Guide, Plot, Point, Scale};

fn log_plot(points: &[(f64, f64)]) -> Plot {
    Plot::new("T", ("x", Scale::Log), ("y", Scale::Log)).curve(Curve::line("c", points.iter().copied()))
}

/// Every opened element is closed, in order.
pub fn assert_balanced(xml: &str) {
    let mut open: Vec<String> = Vec::new();
    for tag in xml.split('<').skip(1) {
        let tag = &tag[..tag.find('>').expect("a tag ends")];
        let name: String = tag.trim_start_matches('/').chars().take_while(|c| c.is_ascii_alphanumeric()).collect();
        if tag.starts_with('/') {
            assert_eq!(open.pop().as_deref(), Some(name.as_str()), "{tag}");
        } else if !tag.ends_with('/') && !tag.starts_with('!') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

/// The numbers that follow `key="`.
fn attribute(svg: &str, element: &str, key: &str) -> Vec<f64> {
    let start = format!("<{element} ");
    let elements = svg.split(&start).skip(1);
    elements
        .filter_map(|e| e[..e.find('>')?].split(&format!("{key}=\"")).nth(1)?.split('"').next()?.parse().ok())
        .collect()
}

/// (x, y, text) of all labels.
fn labels(svg: &str) -> Vec<(f64, f64, String)> {
    let parts = svg.split("<text ").skip(1);
    parts
        .map(|part| {
            let number = |key: &str| part.split(&format!("{key}=\"")).nth(1).unwrap().split('"').next().unwrap();
            let text = part[part.find('>').unwrap() + 1..].split('<').next().unwrap().to_owned();
            (number("x").parse().unwrap(), number("y").parse().unwrap(), text)
        })
        .collect()
}

#[test]
fn points_on_a_log_log_line_are_drawn_on_a_straight_line() {
    let points: Vec<_> = (0..6).map(|i| 4f64.powi(i)).map(|n| (n, 1.0 / n)).collect();
    let svg = log_plot(&points).svg();
    let (x, y) = (attribute(&svg, "circle", "cx"), attribute(&svg, "circle", "cy"));
    // The last circle is the legend's.
    assert_eq!(x.len(), 7);
    for i in 1..5 {
        assert!((x[i + 1] - 2.0 * x[i] + x[i - 1]).abs() < 0.21, "{x:?}");
        assert!((y[i + 1] - 2.0 * y[i] + y[i - 1]).abs() < 0.21, "{y:?}");
    }
    assert!(y[5] > y[0], "smaller errors are further down");
}

#[test]
fn files_are_balanced_and_text_is_escaped() {
    let plot = log_plot(&[(1.0, 1.0), (10.0, 0.1)])
        .curve(Curve::line("a < b & \"c\"", [(1.0, 0.5)]))
        .guide(Guide::slope(-0.5))
        .guide(Guide::level(0.2, "truth"));
    for svg in [plot.svg(), plot.svg_file()] {
        assert_balanced(&svg);
        assert!(svg.contains("a &lt; b &amp; &quot;c&quot;"));
        assert!(svg.contains("slope −½") && svg.contains("truth"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
}

#[test]
fn what_has_no_place_on_a_log_axis_is_left_out() {
    let points = [(1.0, 1.0), (2.0, 0.0), (4.0, -1.0), (8.0, f64::NAN), (0.0, 1.0), (16.0, 0.1)];
    let svg = log_plot(&points).svg();
    assert_eq!(attribute(&svg, "circle", "cx").len(), 2 + 1);
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    // No points at all still make a plot.
    assert_balanced(&log_plot(&[]).svg());
    assert!(!log_plot(&[]).svg().contains("NaN"));
}

#[test]
fn bands_stay_inside_the_frame() {
    let point = |x: f64, y: f64, lo: f64, hi: f64| Point { x, y, lo, hi };
    let curve = Curve::new("c", vec![point(1.0, 1.0, -0.5, f64::INFINITY), point(10.0, 0.1, 0.09, 0.11)]);
    let svg = Plot::new("T", ("x", Scale::Log), ("y", Scale::Log)).curve(curve).svg();
    let polygon = svg.split("<polygon points=\"").nth(1).unwrap().split('"').next().unwrap();
    let (top, bottom) = (30.0, 320.0);
    for corner in polygon.split(' ') {
        let y: f64 = corner.split(',').nth(1).unwrap().parse().unwrap();
        assert!((top..=bottom).contains(&y), "{corner}");
    }
}

#[test]
fn tick_labels_do_not_overlap_whatever_the_range() {
    for decades in [0.05, 0.3, 1.0, 2.0, 5.0, 12.0, 40.0] {
        for offset in [-20.0f64, -3.3, 0.0, 4.7] {
            let (low, high) = (10f64.powf(offset), 10f64.powf(offset + decades));
            for scale in [Scale::Log, Scale::Linear] {
                let curve = Curve::line("", [(low, low), (high, high)]);
                let svg = Plot::new("", ("", scale), ("", scale)).curve(curve).svg();
                let labels: Vec<_> = labels(&svg).into_iter().filter(|l| !l.2.is_empty()).collect();
                let mut below: Vec<_> = labels.iter().filter(|l| l.1 > 330.0).collect();
                below.sort_by(|a, b| a.0.total_cmp(&b.0));
                assert!(!below.is_empty() || decades < 0.31, "{decades} {offset} {scale:?}");
                for pair in below.windows(2) {
                    let width = 6.6 * 0.5 * (pair[0].2.chars().count() + pair[1].2.chars().count()) as f64;
                    assert!(pair[1].0 - pair[0].0 > width, "{pair:?} {decades} {offset} {scale:?}");
                }
            }
        }
    }
}

#[test]
fn the_slope_guide_lies_above_all_points() {
    let points = [(1.0, 1.0), (10.0, 0.5), (100.0, 0.02)];
    let svg = log_plot(&points).guide(Guide::slope(-1.0)).svg();
    let dotted = svg.split("<line ").find(|l| l.contains("1.5 3.5")).unwrap();
    let number = |key: &str| -> f64 {
        dotted.split(&format!("{key}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    let (x1, y1, x2, y2) = (number("x1"), number("y1"), number("x2"), number("y2"));
    let circles: Vec<_> = attribute(&svg, "circle", "cx").into_iter().zip(attribute(&svg, "circle", "cy")).collect();
    for (x, y) in &circles[..3] {
        let at = y1 + (x - x1) / (x2 - x1) * (y2 - y1);
        assert!(at < *y, "({x}, {y}) is above the guide's {at}");
    }
}
