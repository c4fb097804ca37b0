//! The report's files apart from the page: JSON, CSV and plots.

use super::ConvergeError;
use super::summary::{ConvergeReport, Row};
use crate::film::beside::write_beside;
use crate::report::fit::Estimate;
use crate::report::plot::{Curve, Guide, Plot, Point, Scale};
use std::io::Write;
use std::path::Path;

/// What [`files`] writes, and the page.
pub const NAMES: [&str; 9] = [
    "report.json",
    "errors.csv",
    "report.html",
    "rmse-samples.svg",
    "rmse-seconds.svg",
    "relmse-samples.svg",
    "relmse-seconds.svg",
    "relmse-wall.svg",
    "bias-variance.svg",
];

/// Writes `report.json`, `errors.csv` and an SVG for each plot.
///
/// # Errors
/// A file cannot be written.
pub fn files(folder: &Path, report: &ConvergeReport) -> Result<(), ConvergeError> {
    write_beside(&folder.join("report.json"), |out| serde_json::to_writer_pretty(out, report))?;
    write_beside(&folder.join("errors.csv"), |out| out.write_all(csv(report).as_bytes()))?;
    for (name, plot) in plots(report) {
        let svg = plot.svg_file();
        write_beside(&folder.join(format!("{name}.svg")), |out| out.write_all(svg.as_bytes()))?;
    }
    Ok(())
}

/// A named value of a row, with the ends of its interval.
type Column = (&'static str, fn(&Row) -> Option<Estimate>);

const COLUMNS: [Column; 10] = [
    ("rmse", |row| Some(row.rmse)),
    ("relmse", |row| Some(row.relmse)),
    ("mae", |row| Some(row.mae)),
    ("bias_squared", |row| row.bias_squared),
    ("variance", |row| row.variance),
    ("relative_bias_squared", |row| row.relative_bias_squared),
    ("relative_variance", |row| row.relative_variance),
    ("seconds", |row| Some(row.seconds)),
    ("wall_seconds", |row| Some(row.wall_seconds)),
    ("time_to_unit_variance", |row| row.time_to_unit_variance),
];

/// A line each variant and budget; an end or value that is not known is empty.
fn csv(report: &ConvergeReport) -> String {
    let mut text = "variant,budget,samples_per_pixel,seeds,paths,discarded_samples,largest_share,\
                    largest_relative_share,largest_sample_share,rmse_trusted,relmse_trusted"
        .to_owned();
    for (name, _) in COLUMNS {
        text += &format!(",{name},{name}_lo,{name}_hi");
    }
    text.push('\n');
    let number = |x: f64| if x.is_finite() { format!("{x:e}") } else { String::new() };
    for row in report.variants.iter().flat_map(|variant| &variant.rows) {
        let name = format!("\"{}\"", row.variant.replace('"', "\"\""));
        text += &format!(
            "{name},{},{},{},{},{},{:e},{:e},{},{},{}",
            row.budget,
            row.samples_per_pixel,
            row.seeds.len(),
            row.paths,
            row.discarded_samples,
            row.largest_share,
            row.largest_relative_share,
            row.largest_sample_share.map_or(String::new(), number),
            row.rmse_trusted,
            row.relmse_trusted
        );
        for (_, value) in COLUMNS {
            match value(row) {
                Some(e) => text += &format!(",{},{},{}", number(e.value), number(e.lo), number(e.hi)),
                None => text += ",,,",
            }
        }
        text.push('\n');
    }
    text
}

const SAMPLES: (&str, fn(&Row) -> f64) = ("samples a pixel", |row| row.samples_per_pixel as f64);
const SECONDS: (&str, fn(&Row) -> f64) = ("seconds of rendering", |row| row.seconds.value);
const WALL: (&str, fn(&Row) -> f64) = ("seconds, set-up and writing included", |row| row.wall_seconds.value);
const RMSE: (&str, fn(&Row) -> Estimate) = ("RMSE", |row| row.rmse);
const RELMSE: (&str, fn(&Row) -> Estimate) = ("relMSE", |row| row.relmse);

/// All plots with the names of their files.
pub fn plots(report: &ConvergeReport) -> Vec<(&'static str, Plot)> {
    let (by_samples, by_time) = (Curves::by_samples(report), Curves::by_time(report));
    vec![
        ("rmse-samples", by_samples.plot("RMSE against samples", SAMPLES, RMSE, -0.5)),
        ("rmse-seconds", by_time.plot("RMSE against rendering time", SECONDS, RMSE, -0.5)),
        ("relmse-samples", by_samples.plot("relMSE against samples", SAMPLES, RELMSE, -1.0)),
        ("relmse-seconds", by_time.plot("relMSE against rendering time", SECONDS, RELMSE, -1.0)),
        ("relmse-wall", by_time.plot("relMSE against wall clock", WALL, RELMSE, -1.0)),
        ("bias-variance", by_samples.bias_variance(report)),
    ]
}

/// Which variants are drawn, under what names: each has its look, the same in all plots.
struct Curves<'a>(Vec<(usize, String, &'a [Row])>);

impl<'a> Curves<'a> {
    fn by_time(report: &'a ConvergeReport) -> Self {
        let variants = report.variants.iter().enumerate();
        Curves(variants.map(|(look, v)| (look, v.name.clone(), v.rows.as_slice())).collect())
    }

    /// Variants with the same images are one curve, `A = B`.
    fn by_samples(report: &'a ConvergeReport) -> Self {
        let groups = report.same_images();
        let mut curves = Self::by_time(report).0;
        curves.retain_mut(|(_, name, _)| {
            let Some(group) = groups.iter().find(|group| group.contains(&name.as_str())) else { return true };
            let first = group[0] == *name;
            *name = group.join(" = ");
            first
        });
        Curves(curves)
    }

    fn plot(
        &self,
        title: &str,
        (x_label, x): (&str, fn(&Row) -> f64),
        (y_label, y): (&str, fn(&Row) -> Estimate),
        slope: f64,
    ) -> Plot {
        let plot = Plot::new(title, (x_label, Scale::Log), (y_label, Scale::Log)).guide(Guide::slope(slope));
        self.0.iter().fold(plot, |plot, (look, name, rows)| {
            let points = rows.iter().map(|row| point(x(row), y(row))).collect();
            plot.curve(Curve::new(name, points).styled(*look))
        })
    }

    /// Relative variance, and relative bias² where its interval lies above zero.
    fn bias_variance(&self, report: &ConvergeReport) -> Plot {
        let plot = Plot::new("Variance and bias²", (SAMPLES.0, Scale::Log), ("share of relMSE", Scale::Log));
        let mut plot = plot.guide(Guide::slope(-1.0));
        if report.reference.noise.relmse > 0.0 {
            plot = plot.guide(Guide::level(report.reference.noise.relmse, "noise of the reference"));
        }
        let points = |rows: &[Row], part: fn(&Row) -> Option<Estimate>| -> Vec<Point> {
            rows.iter().filter_map(|row| Some(point(SAMPLES.1(row), part(row)?))).collect()
        };
        for (look, name, rows) in &self.0 {
            let variance = points(rows, |row| row.relative_variance);
            plot = plot.curve(Curve::new(format!("{name}: variance"), variance).styled(*look));
            let bias = points(rows, |row| row.relative_bias_squared.filter(|bias| bias.lo > 0.0));
            if !bias.is_empty() {
                let curve = Curve::new(format!("{name}: bias²"), bias).styled(*look);
                plot = plot.curve(Curve { joined: false, ..curve });
            }
        }
        plot
    }
}

fn point(x: f64, y: Estimate) -> Point {
    Point { x, y: y.value, lo: y.lo, hi: y.hi }
}
