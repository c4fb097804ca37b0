//! A study as a page: error against samples and run time, bias and variance, the table.

use super::method::Claim;
use super::study::{Cell, Row, Study};
use super::table::slope_text;
use crate::film::shares::LARGEST_TRUSTED_OF_VALUE;
use crate::report::fit::Estimate;
use crate::report::page::{Block, Cell as TableCell, Page, Section, Table};
use crate::report::plot::{Curve, Guide, Plot, Point, Scale};

/// All names that [`plots`] gives.
pub const PLOT_NAMES: [&str; 5] = ["rmse-samples", "rmse-seconds", "mae-samples", "mae-seconds", "bias-samples"];

/// The plots of a study, with the name of a file for each, one of [`PLOT_NAMES`].
pub fn plots(study: &Study) -> Vec<(&'static str, Plot)> {
    let rmse = |c: &Cell| c.rmse;
    let mae = |c: &Cell| c.mae;
    let samples = |c: &Cell| c.samples as f64;
    let mut plots = vec![
        ("rmse-samples", errors(study, "RMSE against samples", "samples", samples, "RMSE", rmse)),
        ("rmse-seconds", errors(study, "RMSE against run time", "seconds of one core", |c| c.seconds, "RMSE", rmse)),
        ("mae-samples", errors(study, "Mean absolute error against samples", "samples", samples, "MAE", mae)),
        (
            "mae-seconds",
            errors(study, "Mean absolute error against run time", "seconds of one core", |c| c.seconds, "MAE", mae),
        ),
    ];
    if study.rows.iter().any(|row| row.claim == Claim::Biased) {
        let size = |c: &Cell| Estimate { value: c.bias.value.abs(), ..c.bias };
        plots.push(("bias-samples", errors(study, "Size of the bias", "samples", samples, "|mean − exact|", size)));
    }
    plots
}

fn errors(
    study: &Study,
    title: &str,
    x_label: &str,
    x: impl Fn(&Cell) -> f64,
    y_label: &str,
    y: impl Fn(&Cell) -> Estimate,
) -> Plot {
    let mut plot = Plot::new(title, (x_label, Scale::Log), (y_label, Scale::Log)).guide(Guide::slope(-0.5));
    for (style, row) in study.rows.iter().enumerate() {
        let point = |cell: &Cell| {
            let e = y(cell);
            // A logarithmic axis has no place for what an interval holds below zero.
            Point { x: x(cell), y: e.value, lo: if e.lo > 0.0 { e.lo } else { e.value }, hi: e.hi.max(e.value) }
        };
        let mut points: Vec<Point> = row.cells.iter().map(point).filter(|p| p.y > 0.0 && p.hi.is_finite()).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        plot = plot.curve(Curve::new(&row.method, points).styled(style));
    }
    plot
}

/// The whole report.
pub fn page(study: &Study, notes: &[String], command: &str) -> Page {
    let q = &study.quantity;
    let within = if q.exact_error > 0.0 { format!(", within {:.1e}", q.exact_error) } else { String::new() };
    let lead = format!("{}. Exact: {:.12} ({}{within}).", q.formula, q.exact, q.source);
    let run = format!(
        "{} estimates of each kind, seed {}; bands and ± are 95 % intervals. Seconds are those of one core, the median over \
         blocks of estimates. Compiled for {}.",
        study.repeats,
        study.seed,
        crate::cpu::compiled_features().join(" ")
    );
    let plots = plots(study).into_iter().map(|(_, plot)| plot).collect();
    let errors =
        Section::new("Errors").with(Block::prose(run)).with(Block::Plots(plots)).with(Block::Table(slopes(study)));
    let mut theory = Section::new("Theory").with(Block::Code(notes.join("\n")));
    for warning in warnings(study) {
        theory = theory.with(Block::Warning(warning));
    }
    let mut cells = Section::new("All cells").with(Block::prose(format!(
        "z is the bias over its standard error: beyond {:.2} it is no chance (Šidák, 1 % for all cells together). Held: how \
         often the truth is within ±1.96 of an estimate's own standard errors of it; marked where it misses more than twice as \
         often as 5 %. An RMSE is marked where one estimate makes up more than a tenth of the squared error.",
        study.z_bound
    )));
    for row in &study.rows {
        cells = cells.with(Block::Table(table(row)));
    }
    Page::new(q.name.clone())
        .lead(lead)
        .section(errors)
        .section(theory)
        .section(cells)
        .section(Section::new("Command").with(Block::Code(command.to_owned())))
}

/// What a reader must not overlook.
fn warnings(study: &Study) -> Vec<String> {
    let mut found = Vec::new();
    for row in &study.rows {
        if let Some(cell) = row.cells.iter().find(|c| c.biased) {
            let what = match row.claim {
                Claim::Unbiased if cell.doubts().is_empty() => "claims to be unbiased, and is not",
                // Its mean is as little normal as its estimates: what is rare may not have been met in all of them.
                Claim::Unbiased => "claims to be unbiased, and is not, or rare samples carry it that were not met",
                _ => "is biased",
            };
            found.push(format!("{} {what}: {:+.3e} with n = {}.", row.method, cell.bias.value, cell.samples));
        }
        if let Some((cell, doubt)) = row.cells.iter().find_map(|c| Some((c, c.doubts().into_iter().next()?))) {
            found.push(format!("{} with n = {}: {doubt}.", row.method, cell.samples));
        }
        if let Some((cell, note)) = row.cells.iter().find_map(|c| Some((c, c.note.as_ref()?))) {
            found.push(format!("{} with n = {}: {note}.", row.method, cell.samples));
        }
    }
    found
}

fn slopes(study: &Study) -> Table {
    let mut table = Table::new(["method", "RMSE ∝ n^", "RMSE ∝ seconds^", "RMSE at the most samples", "µs for it"]);
    for row in &study.rows {
        let Some(last) = row.cells.last() else { continue };
        let text = |law: &Option<_>| law.as_ref().map_or("–".to_owned(), slope_text);
        table = table.row([
            row.method.clone(),
            text(&row.slope),
            text(&row.slope_in_time),
            format!("{:.3e}", last.rmse.value),
            format!("{:.2}", 1e6 * last.seconds),
        ]);
    }
    table
}

fn table(row: &Row) -> Table {
    let header =
        ["n", "mean", "bias", "± 95 %", "z", "RMSE", "MAE", "variance", "/ predicted", "own s.e.", "held", "µs"];
    let mut table = Table::new(header).captioned(row.method.clone());
    for c in &row.cells {
        let optional = |v: Option<f64>| v.map_or("–".to_owned(), |v| format!("{v:.3e}"));
        let half = |e: &Estimate| if c.repeats > 1 { format!("{:.1e}", 0.5 * (e.hi - e.lo)) } else { "–".into() };
        let z = c.z.map_or("–".to_owned(), |z| format!("{z:+.2}"));
        let plain = |text: String| TableCell::from(text);
        let ratio =
            c.variance_ratio.map_or("–".to_owned(), |r| format!("{:.3} ± {:.3}", r.value, 0.5 * (r.hi - r.lo)));
        let held = c.own_coverage.map_or("–".to_owned(), |held| format!("{:.1} %", 100.0 * held));
        let off = c.variance_ratio.is_some_and(|r| (r.value - 1.0).abs() > 4.0 * r.standard_error);
        table = table.row([
            plain(c.samples.to_string()),
            plain(format!("{:.8}", c.mean.value)),
            plain(format!("{:+.2e}", c.bias.value)),
            plain(half(&c.bias)),
            TableCell { text: z, flagged: c.biased },
            TableCell { text: format!("{:.3e}", c.rmse.value), flagged: c.largest_share > LARGEST_TRUSTED_OF_VALUE },
            plain(format!("{:.3e}", c.mae.value)),
            plain(format!("{:.3e}", c.variance)),
            TableCell { text: ratio, flagged: off },
            plain(optional(c.own_standard_error)),
            TableCell { text: held, flagged: !c.own_interval_trusted },
            plain(format!("{:.3}", 1e6 * c.seconds)),
        ]);
    }
    table
}
