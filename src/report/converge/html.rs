//! The study as a page.

use super::ConvergeError;
use super::reference::NoiseSource;
use super::statistics::LARGEST_TRUSTED_SHARE;
use super::summary::{ConvergeReport, Row, VariantReport};
use super::write::plots;
use crate::film::beside::write_beside;
use crate::report::fit::{Estimate, PowerLaw, Reached};
use crate::report::page::{Block, Cell, Image, Page, Picker, Section, Table};
use std::io::Write;
use std::path::Path;

/// Writes `report.html`.
///
/// # Errors
/// It cannot be written.
pub fn write(folder: &Path, report: &ConvergeReport, images: &[Image]) -> Result<(), ConvergeError> {
    let html = page(report, images).html();
    Ok(write_beside(&folder.join("report.html"), |out| out.write_all(html.as_bytes()))?)
}

fn page(report: &ConvergeReport, images: &[Image]) -> Page {
    let lead = format!(
        "{}×{} pixels, {} seeds for each of {} budgets and {} variants; {}",
        report.width,
        report.height,
        report.seeds,
        report.budgets.len(),
        report.variants.len(),
        reference_line(report)
    );
    Page::new(format!("Error against run time: {}", report.scene))
        .lead(lead)
        .section(curves(report))
        .section(Section::new("What an error costs").with(Block::Table(costs(report))).with(Block::prose(COSTS_NOTE)))
        .section(pictures(report, images))
        .section(Section::new("Errors").with(Block::Table(errors(report))).with(Block::Table(parts(report))))
        .section(method(report))
        .section(machine(report))
}

const COSTS_NOTE: &str = "Slopes are those of relMSE with their 95 % intervals; independent samples have −1. A bend of \
    1 is what the points' own errors explain; far above it the points do not lie on a line. Times to a relMSE are \
    interpolated between measured budgets; ~ marks those beyond them, extrapolated along the slope; in brackets their 95 % intervals, from those of \
    the errors, the seconds and the slope. Set-up is that of the scene and the tables; the wall clock includes it. Time to unit variance \
    is variance × seconds at the largest budget.";

fn reference_line(report: &ConvergeReport) -> String {
    let r = &report.reference;
    let samples = r.samples_per_pixel.map_or(String::new(), |n| format!(" ({n} samples a pixel)"));
    let noise = match r.noise_source {
        NoiseSource::Sidecar => "by the file beside it",
        NoiseSource::Variance => "by its variance layer",
        NoiseSource::Replicates => "by the spread of four independent renders",
        NoiseSource::Unknown => return format!("reference {}{samples} of unknown noise", r.file),
    };
    format!("reference {}{samples}, whose own noise is a relMSE of {} {noise}", r.file, number(r.noise.relmse))
}

fn curves(report: &ConvergeReport) -> Section {
    let mut section = Section::new("Curves");
    if report.cells_done < report.cells {
        let text = format!("Unfinished: {} of {} cells. Go on with --resume.", report.cells_done, report.cells);
        section = section.with(Block::Warning(text));
    }
    if report.reference.noise_source == NoiseSource::Unknown {
        let text = "The noise of the reference is not known and is in every error: curves flatten where they reach it.";
        section = section.with(Block::Warning(text.to_owned()));
    }
    let rows = || report.variants.iter().flat_map(|variant| &variant.rows);
    let doubted = rows().filter(|row| !row.doubts.is_empty()).count();
    if doubted > 0 {
        let text = format!("{doubted} of {} points have intervals that cannot be trusted: see Errors.", rows().count());
        section = section.with(Block::Warning(text));
    }
    for twins in report.same_images() {
        let text = format!("The same images bit for bit, and one curve against samples: {}.", twins.join(", "));
        section = section.with(Block::prose(text));
    }
    let discarded: u64 = rows().map(|row| row.discarded_samples).sum();
    if discarded > 0 {
        section = section.with(Block::Warning(format!("{discarded} samples were not finite and count as 0.")));
    }
    section.with(Block::Plots(plots(report).into_iter().map(|(_, plot)| plot).collect())).with(Block::prose(
        "Bands are 95 % intervals over independent seeds. Errors are measured less the reference's own noise.",
    ))
}

fn costs(report: &ConvergeReport) -> Table {
    let mut header = vec!["variant".to_owned(), "slope by samples".into(), "bend".into(), "slope by seconds".into()];
    header.extend(["set-up s".to_owned(), "time to unit variance s".into()]);
    for target in report.variants.first().map_or(&[][..], |v| &v.targets) {
        let target = format!("{:e}", target.relmse).replace('-', "−");
        header.extend([
            format!("relMSE {target}: s rendering"),
            format!("relMSE {target}: s wall clock"),
            format!("relMSE {target}: paths"),
        ]);
    }
    report.variants.iter().fold(Table::new(header), |table, v| table.row(cost_row(v)))
}

fn cost_row(v: &VariantReport) -> Vec<Cell> {
    let slope = |law: &Option<PowerLaw>| law.map_or("–".to_owned(), |law| slope_text(law.exponent));
    let bend = v.relmse_by_samples.and_then(|law| law.lack_of_fit).map_or("–".to_owned(), number);
    let unit = v.rows.last().and_then(|row| row.time_to_unit_variance).map_or("–".to_owned(), with_percent);
    let mut row: Vec<Cell> = vec![v.name.as_str().into(), slope(&v.relmse_by_samples).into(), bend.into()];
    row.extend([slope(&v.relmse_by_seconds), number(v.setup_seconds), unit].map(Cell::from));
    let reached = |r: Option<Reached>| match r {
        None => "–".to_owned(),
        Some(r) => {
            let interval =
                if r.hi.is_finite() { format!(" [{}, {}]", number(r.lo), number(r.hi)) } else { String::new() };
            format!("{}{}{interval}", if r.extrapolated { "~ " } else { "" }, number(r.budget))
        }
    };
    for target in &v.targets {
        let cell = if v.is_doubted(target.relmse) { Cell::flagged } else { Cell::from };
        row.extend([target.seconds, target.wall_seconds, target.paths].map(|r| cell(reached(r))));
    }
    row
}

fn errors(report: &ConvergeReport) -> Table {
    let header = ["variant", "budget", "spp", "seeds", "RMSE", "relMSE", "MAE", "s rendering", "s wall clock"];
    let table =
        Table::new(header.into_iter().chain(["paths", "discarded", "largest value", "largest sample", "doubts"]));
    let table = table.captioned(
        "Means over seeds, ± half the 95 % interval. MAE holds the reference's noise. The largest \
                                 value's and sample's shares are of the squared error of all seeds.",
    );
    rows(report, table, |row| {
        let text = |text: String, trusted: bool| if trusted { Cell::from(text) } else { Cell::flagged(text) };
        vec![
            row.variant.as_str().into(),
            row.budget.to_string().into(),
            row.samples_per_pixel.to_string().into(),
            row.seeds.len().to_string().into(),
            text(with_percent(row.rmse), row.rmse_trusted),
            text(with_percent(row.relmse), row.relmse_trusted),
            with_percent(row.mae).into(),
            with_percent(row.seconds).into(),
            number(row.wall_seconds.value).into(),
            number(row.paths as f64).into(),
            row.discarded_samples.to_string().into(),
            format!("{:.2} %", 100.0 * row.largest_share.max(row.largest_relative_share)).into(),
            row.largest_sample_share.map_or("–".to_owned(), |share| format!("{:.2} %", 100.0 * share)).into(),
            text(row.doubts.join("; "), row.doubts.is_empty()),
        ]
    })
}

fn parts(report: &ConvergeReport) -> Table {
    let header = ["variant", "budget", "variance", "bias²", "relative variance", "relative bias²", "bias"];
    let caption = "Variance and bias² apart, with 95 % intervals. Bias² comes from pairs of seeds less the reference's \
                   noise and may be negative; it is called seen where its interval lies above a tenth of that noise.";
    rows(report, Table::new(header).captioned(caption), |row| {
        let part = |e: Option<Estimate>| Cell::from(e.map_or("–".to_owned(), with_interval));
        let seen = row.relative_bias_squared.map(|bias| bias.lo > 0.1 * report.reference.noise.relmse);
        let seen = match seen {
            Some(true) => Cell::flagged("seen"),
            Some(false) => "not seen".into(),
            None => "–".into(),
        };
        let (variance, bias) = (part(row.variance), part(row.bias_squared));
        let (relative_variance, relative_bias) = (part(row.relative_variance), part(row.relative_bias_squared));
        vec![
            row.variant.as_str().into(),
            row.budget.to_string().into(),
            variance,
            bias,
            relative_variance,
            relative_bias,
            seen,
        ]
    })
}

fn rows(report: &ConvergeReport, table: Table, cells: impl Fn(&Row) -> Vec<Cell>) -> Table {
    report.variants.iter().flat_map(|variant| &variant.rows).fold(table, |table, row| table.row(cells(row)))
}

fn pictures(report: &ConvergeReport, images: &[Image]) -> Section {
    let names: Vec<String> = images.iter().map(|image| image.name.clone()).collect();
    let second = names.get(1).or(names.first()).cloned().unwrap_or_default();
    let left = names.first().cloned().unwrap_or_default();
    let largest = report.budgets.last().map_or(String::new(), ToString::to_string);
    Section::new("Images")
        .with(Block::prose(format!("At the largest budget ({largest}), first seed.")))
        .with(Block::Picker(Picker { names, left, right: second }))
        .with(Block::Images(images.to_vec()))
}

fn method(report: &ConvergeReport) -> Section {
    let times = "Cells run in one process on pinned threads, seed after seed, variants in turn. A budget in seconds is \
                 turned into a sample count by a discarded pilot, so estimates stay unbiased; the seconds plotted are \
                 those measured. Seconds of rendering run from the first sample to the finished film; the wall clock adds \
                 set-up and the writing of the EXR image.";
    let metrics = "RMSE = √(mean (x − r)² − noise), relMSE = mean (x − r)²/(r² + 0.01) − noise, MAE = mean |x − r|, over \
                   pixels and channels; noise is what the reference's own variance adds.";
    let doubts = format!(
        "An interval is not trusted with fewer than three seeds, where one value (a channel of a pixel of a seed) makes up \
         more than {} % of the summed squared error, or where the error cannot be told from the reference's noise. Events \
         so rare that no seed has met them cannot be flagged.",
        100.0 * LARGEST_TRUSTED_SHARE
    );
    let seeds = format!("Budget i uses seeds {} + 2²⁰ i + 0, 1, 2 …, the same for all variants.", report.first_seed);
    [times, metrics, &doubts, &seeds]
        .into_iter()
        .fold(Section::new("How it was measured"), |section, text| section.with(Block::prose(text)))
}

fn machine(report: &ConvergeReport) -> Section {
    let m = &report.machine;
    let variants = Table::new(["variant", "arguments", "lanes", "threads", "load s", "set-up s"]);
    let variants = report.variants.iter().fold(variants, |table, v| {
        let seconds = [number(v.load_seconds), number(v.setup_seconds)];
        let [load, setup] = seconds;
        table.row([v.name.clone(), v.arguments.clone(), v.lanes.to_string(), v.threads.to_string(), load, setup])
    });
    let build = format!(
        "octolux {}, build {}{}, compiled for {}. {}, {} cores. This session took {:.1} s.",
        m.version,
        m.build,
        if m.optimised { "" } else { " (not optimised)" },
        m.cpu_features.join(" "),
        m.cpu.as_deref().unwrap_or("unknown processor"),
        m.cores,
        report.wall_seconds
    );
    Section::new("Machine and build")
        .with(Block::Table(variants))
        .with(Block::prose(build))
        .with(Block::Code(report.command.clone()))
}

/// Three significant digits, with an exponent where many zeros would stand.
pub fn number(x: f64) -> String {
    let size = x.abs();
    let text = match size {
        _ if !x.is_finite() => return "–".to_owned(),
        0.0 => "0".to_owned(),
        s if (999.5..99_999.5).contains(&s) => format!("{x:.0}"),
        s if (0.001..999.5).contains(&s) => {
            let decimals = (2.0 - s.log10().floor()).clamp(0.0, 6.0) as usize;
            format!("{x:.decimals$}")
        }
        _ => format!("{x:.2e}"),
    };
    text.replace('-', "−")
}

fn slope_text(e: Estimate) -> String {
    if e.lo.is_finite() {
        format!("{:.3} [{:.3}, {:.3}]", e.value, e.lo, e.hi).replace('-', "−")
    } else {
        format!("{:.3}", e.value).replace('-', "−")
    }
}

/// Value ± half the interval in percent of the value.
fn with_percent(e: Estimate) -> String {
    let half = 0.5 * (e.hi - e.lo) / e.value.abs();
    if half.is_finite() { format!("{} ± {:.1} %", number(e.value), 100.0 * half) } else { number(e.value) }
}

fn with_interval(e: Estimate) -> String {
    if e.lo.is_finite() { format!("{} [{}, {}]", number(e.value), number(e.lo), number(e.hi)) } else { number(e.value) }
}
