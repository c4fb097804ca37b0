//! Plots as SVG: curves with bands on linear or logarithmic axes, for a file of their own or inside a page.
//!
//! ```
//! use octolux::report::plot::{Curve, Guide, Plot, Scale};
//! let points = (0..5).map(|i| { let n = 4f64.powi(i); (n, 1.0 / n.sqrt()) });
//! let plot = Plot::new("RMSE", ("samples", Scale::Log), ("RMSE", Scale::Log))
//!     .curve(Curve::line("Monte Carlo", points))
//!     .guide(Guide::slope(-0.5));
//! assert!(plot.svg_file().starts_with("<svg"));
//! ```
//!
//! Text and axes take the colour of what surrounds them; curves differ by colour (a palette that the colour-blind can
//! tell apart, darker on light ground and lighter on dark), by dash and by marker.

mod axis;
mod draw;
mod style;

pub use axis::Scale;
pub use style::STYLE;

/// A plot: what is drawn, not how.
#[derive(Clone, Debug)]
pub struct Plot {
    pub title: String,
    pub x: (String, Scale),
    pub y: (String, Scale),
    pub curves: Vec<Curve>,
    pub guides: Vec<Guide>,
}

/// A named sequence of points in increasing x. Its place in [`Plot::curves`] picks colour, dash and marker, unless
/// `style` does: curves of one style in several plots mean the same thing.
#[derive(Clone, Debug)]
pub struct Curve {
    pub name: String,
    pub points: Vec<Point>,
    pub style: Option<usize>,
    pub joined: bool,
    pub markers: bool,
}

/// A point, and the ends of its interval in y; equal to `y` where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    pub lo: f64,
    pub hi: f64,
}

impl Curve {
    /// Joined points with markers and a band from `lo` to `hi`.
    pub fn new(name: impl Into<String>, points: Vec<Point>) -> Self {
        Curve { name: name.into(), points, style: None, joined: true, markers: true }
    }

    /// Joined points without intervals.
    pub fn line(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::new(name, points.into_iter().map(|(x, y)| Point { x, y, lo: y, hi: y }).collect())
    }

    /// Points alone.
    pub fn scatter(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Curve { joined: false, ..Self::line(name, points) }
    }

    /// Without markers: for densely sampled functions.
    pub fn smooth(self) -> Self {
        Curve { markers: false, ..self }
    }

    pub fn styled(self, style: usize) -> Self {
        Curve { style: Some(style), ..self }
    }
}

/// A dotted straight line for the eye.
#[derive(Clone, Debug)]
pub enum Guide {
    /// On log-log axes: y ∝ x^slope, just above all the points.
    Slope { slope: f64, name: String },
    /// y = value: a known truth.
    Level { value: f64, name: String },
}

impl Guide {
    /// Names −½, −1 … as a person would.
    pub fn slope(slope: f64) -> Self {
        let halves = (2.0 * slope).round();
        let size = match halves.abs() as i64 {
            _ if (halves - 2.0 * slope).abs() > 1e-9 => format!("{:.3}", slope.abs()),
            1 => "½".to_string(),
            n if n % 2 == 1 => format!("{}½", n / 2),
            n => format!("{}", n / 2),
        };
        Guide::Slope { slope, name: format!("slope {}{size}", if slope < 0.0 { "−" } else { "" }) }
    }

    pub fn level(value: f64, name: impl Into<String>) -> Self {
        Guide::Level { value, name: name.into() }
    }

    fn name(&self) -> &str {
        match self {
            Guide::Slope { name, .. } | Guide::Level { name, .. } => name,
        }
    }
}

impl Plot {
    pub fn new(
        title: impl Into<String>,
        (x_label, x): (impl Into<String>, Scale),
        (y_label, y): (impl Into<String>, Scale),
    ) -> Self {
        let (curves, guides) = (Vec::new(), Vec::new());
        Plot { title: title.into(), x: (x_label.into(), x), y: (y_label.into(), y), curves, guides }
    }

    pub fn curve(mut self, curve: Curve) -> Self {
        self.curves.push(curve);
        self
    }

    pub fn guide(mut self, guide: Guide) -> Self {
        self.guides.push(guide);
        self
    }

    /// For a page that holds [`STYLE`].
    pub fn svg(&self) -> String {
        draw::svg(self, "")
    }

    /// A file of its own: with its ground and style.
    pub fn svg_file(&self) -> String {
        let ground = "<rect width=\"100%\" height=\"100%\" class=\"ground\" fill=\"#ffffff\"/>";
        draw::svg(self, &format!("<style>{STYLE}{}</style>{ground}", style::FILE_STYLE))
    }
}

/// Text as it stands in XML and HTML, attributes included.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            // XML knows no other control characters, not even escaped.
            c if c.is_control() && c != '\n' && c != '\t' => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}
