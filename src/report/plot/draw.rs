//! From a [`Plot`] to SVG text.

use super::axis::{Axis, Scale};
use super::{Curve, Guide, Plot, Point, escape, style};
use std::fmt::Write;

/// Width of the drawing: a phone shows it nearly pixel for pixel.
const WIDTH: f64 = 520.0;
/// The frame that the curves are in.
const LEFT: f64 = 62.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 30.0;
const HEIGHT: f64 = 290.0;
/// Below the frame: tick labels and the axis label; then the legend, a line each row.
const AXIS_ROOM: f64 = 44.0;
const LEGEND_LINE: f64 = 19.0;
/// Mean advance of a letter at 12 px; wide enough for capitals in sans-serif.
const LETTER: f64 = 6.6;
/// An interval's lower end is drawn at most this factor below its point: on a logarithmic axis it may reach 0.
const LOWEST_BAND: f64 = 0.1;

pub fn svg(plot: &Plot, head: &str) -> String {
    let frame = Frame::new(plot);
    let legend = legend(plot);
    let height = TOP + HEIGHT + AXIS_ROOM + legend.rows as f64 * LEGEND_LINE + 6.0;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" \
         height=\"{height}\" role=\"img\" color=\"#1c1e21\" \
         font-family=\"system-ui,-apple-system,'Segoe UI',Roboto,'DejaVu Sans',sans-serif\" font-size=\"12\">\
         <title>{}</title>{head}",
        escape(&plot.title)
    );
    let middle = LEFT + frame.width() / 2.0;
    out += &text(middle, 18.0, "middle", "font-size=\"14\" font-weight=\"600\"", &plot.title);
    frame.axes(plot, &mut out);
    plot.guides.iter().for_each(|guide| frame.guide(guide, plot, &mut out));
    for (i, curve) in plot.curves.iter().enumerate() {
        frame.curve(curve, curve.style.unwrap_or(i), &mut out);
    }
    out += &legend.svg;
    out + "</svg>\n"
}

fn text(x: f64, y: f64, anchor: &str, attributes: &str, text: &str) -> String {
    format!(
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"currentColor\" {attributes}>{}</text>",
        escape(text)
    )
}

struct Frame {
    x: Axis,
    y: Axis,
}

impl Frame {
    fn new(plot: &Plot) -> Self {
        let points = || plot.curves.iter().flat_map(|curve| &curve.points);
        let levels = plot.guides.iter().filter_map(|guide| match guide {
            Guide::Level { value, .. } => Some(*value),
            Guide::Slope { .. } => None,
        });
        let of_point = |p: &Point| [p.y, finite_or(p.hi, p.y), lower_end(p, plot.y.1)];
        let x = Axis::new(plot.x.1, points().map(|p| p.x), WIDTH - LEFT - RIGHT);
        let y = Axis::new(plot.y.1, points().flat_map(of_point).chain(levels), HEIGHT);
        Frame { x, y }
    }

    fn width(&self) -> f64 {
        WIDTH - LEFT - RIGHT
    }

    fn at(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        Some((LEFT + self.x.place(x)?, TOP + HEIGHT - self.y.place(y)?))
    }

    fn axes(&self, plot: &Plot, out: &mut String) {
        let (right, bottom) = (LEFT + self.width(), TOP + HEIGHT);
        let line = |x1: f64, y1: f64, x2: f64, y2: f64, opacity: f64| {
            format!(
                "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"currentColor\" \
                 stroke-opacity=\"{opacity}\"/>"
            )
        };
        // The widest label of the x axis is some seven letters; a line of text is 16 high.
        for tick in self.x.ticks(7.0 * LETTER) {
            let Some(x) = self.x.place(tick.value).map(|x| LEFT + x) else { continue };
            let major = !tick.label.is_empty();
            *out += &line(x, TOP, x, bottom, if major { 0.18 } else { 0.07 });
            if major {
                *out += &text(x, bottom + 17.0, "middle", "", &tick.label);
            }
        }
        for tick in self.y.ticks(16.0) {
            let Some(y) = self.y.place(tick.value).map(|y| bottom - y) else { continue };
            let major = !tick.label.is_empty();
            *out += &line(LEFT, y, right, y, if major { 0.18 } else { 0.07 });
            if major {
                *out += &text(LEFT - 6.0, y + 4.0, "end", "", &tick.label);
            }
        }
        let _ = write!(
            out,
            "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"currentColor\" \
             stroke-opacity=\"0.5\"/>",
            self.width()
        );
        *out += &text(LEFT + self.width() / 2.0, bottom + 36.0, "middle", "", &plot.x.0);
        let turn = format!("transform=\"rotate(-90 14 {:.1})\"", TOP + HEIGHT / 2.0);
        *out += &text(14.0, TOP + HEIGHT / 2.0, "middle", &turn, &plot.y.0);
    }

    fn guide(&self, guide: &Guide, plot: &Plot, out: &mut String) {
        let (left, right) = self.x.range();
        let ends = match guide {
            Guide::Level { value, .. } => Some([(left, *value), (right, *value)]),
            Guide::Slope { .. } if plot.x.1 != Scale::Log || plot.y.1 != Scale::Log => None,
            Guide::Slope { slope, .. } => self.clipped_slope(*slope, plot),
        };
        let Some([(x1, y1), (x2, y2)]) = ends.and_then(|[a, b]| Some([self.at(a.0, a.1)?, self.at(b.0, b.1)?])) else {
            return;
        };
        let _ = write!(
            out,
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"currentColor\" \
             stroke-opacity=\"0.6\" stroke-dasharray=\"1.5 3.5\" stroke-linecap=\"round\" stroke-width=\"1.5\"/>"
        );
    }

    /// y = c x^slope with the least c that keeps every point 15 % below it, cut where it leaves the frame.
    fn clipped_slope(&self, slope: f64, plot: &Plot) -> Option<[(f64, f64); 2]> {
        let points = plot.curves.iter().flat_map(|curve| &curve.points).filter(|p| p.x > 0.0 && p.y > 0.0);
        let constant = 1.15 * points.map(|p| p.y / p.x.powf(slope)).fold(f64::NAN, f64::max);
        let ((left, right), (bottom, top)) = (self.x.range(), self.y.range());
        let (mut low, mut high) = (left, right);
        if slope != 0.0 {
            let at_top = (top / constant).powf(1.0 / slope);
            let at_bottom = (bottom / constant).powf(1.0 / slope);
            (low, high) = (low.max(at_top.min(at_bottom)), high.min(at_top.max(at_bottom)));
        }
        let inside = |x: f64| (x, (constant * x.powf(slope)).clamp(bottom, top));
        (constant.is_finite() && low < high).then(|| [inside(low), inside(high)])
    }

    fn curve(&self, curve: &Curve, look: usize, out: &mut String) {
        let scale = |p: &Point| (p.x, p.y, p.hi, p.lo);
        let places: Vec<_> = curve.points.iter().filter_map(|p| Some((p, self.at(p.x, p.y)?))).collect();
        let _ = write!(out, "<g {}>", style::group(look));
        let has_band = curve.points.iter().any(|p| scale(p).2 > p.y || scale(p).3 < p.y);
        if has_band && places.len() > 1 {
            *out += &self.band(&places);
        } else if has_band {
            places.iter().for_each(|(p, _)| *out += &self.bar(p));
        }
        if curve.joined && places.len() > 1 {
            let path: Vec<_> = places.iter().map(|(_, (x, y))| format!("{x:.1},{y:.1}")).collect();
            let _ = write!(
                out,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"currentColor\" stroke-width=\"1.8\" \
                 stroke-linejoin=\"round\" stroke-dasharray=\"{}\"/>",
                path.join(" "),
                style::dash(look)
            );
        }
        if curve.markers || !curve.joined {
            places.iter().for_each(|(_, (x, y))| *out += &style::marker(look, *x, *y));
        }
        *out += "</g>";
    }

    /// The ends of a point's interval in pixels from the top.
    fn interval(&self, p: &Point) -> (f64, f64) {
        let bottom = self.y.place(p.lo).map_or(TOP + HEIGHT, |y| TOP + HEIGHT - y).min(TOP + HEIGHT);
        let top = self.y.place(finite_or(p.hi, p.y)).map_or(TOP, |y| TOP + HEIGHT - y).max(TOP);
        (bottom, top)
    }

    fn band(&self, places: &[(&Point, (f64, f64))]) -> String {
        let upper = places.iter().map(|(p, (x, _))| format!("{x:.1},{:.1}", self.interval(p).1));
        let lower = places.iter().rev().map(|(p, (x, _))| format!("{x:.1},{:.1}", self.interval(p).0));
        let path: Vec<_> = upper.chain(lower).collect();
        format!("<polygon points=\"{}\" fill=\"currentColor\" fill-opacity=\"0.2\"/>", path.join(" "))
    }

    fn bar(&self, p: &Point) -> String {
        let Some((x, _)) = self.at(p.x, p.y) else { return String::new() };
        let (bottom, top) = self.interval(p);
        format!("<line x1=\"{x:.1}\" y1=\"{bottom:.1}\" x2=\"{x:.1}\" y2=\"{top:.1}\" stroke=\"currentColor\"/>")
    }
}

fn finite_or(value: f64, otherwise: f64) -> f64 {
    if value.is_finite() { value } else { otherwise }
}

fn lower_end(p: &Point, scale: Scale) -> f64 {
    let low = finite_or(p.lo, p.y);
    if scale == Scale::Log { low.max(LOWEST_BAND * p.y) } else { low }
}

struct Legend {
    svg: String,
    rows: usize,
}

/// Entries in rows below the axis, as many in a row as fit.
fn legend(plot: &Plot) -> Legend {
    let looks = plot.curves.iter().enumerate().map(|(i, c)| (c.name.as_str(), Some((c, c.style.unwrap_or(i)))));
    let entries = looks.chain(plot.guides.iter().map(|guide| (guide.name(), None)));
    let (mut svg, mut x, mut row) = (String::new(), LEFT, 0);
    let most = ((WIDTH - LEFT - RIGHT - 40.0) / LETTER) as usize;
    for (name, look) in entries.filter(|(name, _)| !name.is_empty()) {
        let name = shortened(name, most);
        let width = 34.0 + name.chars().count() as f64 * LETTER + 16.0;
        if x > LEFT && x + width > WIDTH {
            (x, row) = (LEFT, row + 1);
        }
        let y = TOP + HEIGHT + AXIS_ROOM + (row as f64 + 0.5) * LEGEND_LINE;
        svg += &sample(look, x, y);
        svg += &text(x + 33.0, y + 4.0, "start", "", &name);
        x += width;
    }
    Legend { rows: if svg.is_empty() { 0 } else { row + 1 }, svg }
}

/// A piece of the curve, 26 wide.
fn sample(look: Option<(&Curve, usize)>, x: f64, y: f64) -> String {
    let line = |more: &str| {
        let end = x + 26.0;
        format!("<line x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{end:.1}\" y2=\"{y:.1}\" stroke=\"currentColor\" {more}/>")
    };
    let Some((curve, look)) = look else {
        return line(
            "stroke-opacity=\"0.6\" stroke-dasharray=\"1.5 3.5\" stroke-linecap=\"round\" stroke-width=\"1.5\"",
        );
    };
    let dash = format!("stroke-width=\"1.8\" stroke-dasharray=\"{}\"", style::dash(look));
    let stroke = if curve.joined { line(&dash) } else { String::new() };
    let marker = if curve.markers || !curve.joined { style::marker(look, x + 13.0, y) } else { String::new() };
    format!("<g {}>{stroke}{marker}</g>", style::group(look))
}

fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_string();
    }
    name.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}
