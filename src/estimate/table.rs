//! A study as text and as CSV.

use super::method::Claim;
use super::study::{Cell, Row, Study};
use crate::report::fit::PowerLaw;
use std::fmt::{self, Write};

impl fmt::Display for Study {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let q = &self.quantity;
        writeln!(f, "{}: {}", q.name, q.formula)?;
        write!(f, "exact {:.12} ({})", q.exact, q.source)?;
        if q.exact_error > 0.0 {
            writeln!(f, ", within {:.1e}", q.exact_error)?
        } else {
            writeln!(f)?
        }
        for row in &self.rows {
            write_row(f, row)?;
        }
        writeln!(f, "\nbias: |z| > {:.2} is beyond chance among all cells of this table (Šidák, 1 %)", self.z_bound)?;
        writeln!(f, "held: how often the truth is within ±1.96 of an estimate's own standard errors of it")
    }
}

fn write_row(f: &mut fmt::Formatter, row: &Row) -> fmt::Result {
    let claim = match row.claim {
        Claim::Unbiased => "",
        Claim::Biased => ", biased by design",
        Claim::Deterministic => ", deterministic",
    };
    writeln!(f, "\n{}{claim}", row.method)?;
    let header = [
        "n",
        "estimate 1",
        "mean",
        "bias ± 95 %",
        "z",
        "RMSE",
        "MAE",
        "variance",
        "/ predicted",
        "own s.e.",
        "held",
        "µs",
    ];
    let widths = [7, 14, 14, 22, 8, 11, 11, 11, 16, 10, 7, 9];
    header.iter().zip(widths).try_for_each(|(h, w)| write!(f, "{h:>w$} "))?;
    writeln!(f)?;
    for cell in &row.cells {
        cells(row, cell).iter().zip(widths).try_for_each(|(text, w)| write!(f, "{text:>w$} "))?;
        let notes = cell.note.iter().cloned().chain(cell.doubts()).collect::<Vec<_>>();
        writeln!(f, "{}{}", if notes.is_empty() { "" } else { " " }, notes.join("; "))?;
    }
    if let Some(slope) = &row.slope {
        writeln!(f, "  RMSE ∝ n^{}{}", slope_text(slope), in_time(row))?;
    }
    Ok(())
}

fn in_time(row: &Row) -> String {
    row.slope_in_time.as_ref().map_or(String::new(), |slope| format!(", ∝ seconds^{}", slope_text(slope)))
}

/// −0.502 ± 0.004.
pub(super) fn slope_text(law: &PowerLaw) -> String {
    let half = 0.5 * (law.exponent.hi - law.exponent.lo);
    format!("{:.3} ± {half:.3}", law.exponent.value)
}

/// What a cell shows, in the order of the header.
fn cells(row: &Row, cell: &Cell) -> [String; 12] {
    let optional = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.3e}"));
    let half = 0.5 * (cell.bias.hi - cell.bias.lo);
    let bias = if cell.repeats > 1 {
        format!("{:+.2e} ± {half:.1e}", cell.bias.value)
    } else {
        format!("{:+.3e}", cell.bias.value)
    };
    let flag = match (cell.biased, row.claim) {
        (true, Claim::Unbiased) => "!!",
        (true, _) => "*",
        _ => "",
    };
    [
        cell.samples.to_string(),
        format!("{:.9}", cell.first),
        format!("{:.9}", cell.mean.value),
        bias,
        cell.z.map_or(String::new(), |z| format!("{z:+.2}{flag}")),
        format!("{:.4e}", cell.rmse.value),
        format!("{:.4e}", cell.mae.value),
        format!("{:.4e}", cell.variance),
        cell.variance_ratio.map_or(String::new(), |r| format!("{:.3} ± {:.3}", r.value, 0.5 * (r.hi - r.lo))),
        optional(cell.own_standard_error),
        cell.own_coverage.map_or(String::new(), |held| format!("{:.1} %", 100.0 * held)),
        format!("{:.3}", 1e6 * cell.seconds),
    ]
}

/// One line a cell.
pub fn csv(study: &Study) -> String {
    let mut text = "method,samples,repeats,mean,bias,bias_lo,bias_hi,z,biased,rmse,rmse_lo,rmse_hi,mae,variance,\
                    predicted_variance,own_standard_error,own_coverage,largest_share,seconds\n"
        .to_owned();
    let optional = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
    for row in &study.rows {
        for c in &row.cells {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                row.method,
                c.samples,
                c.repeats,
                c.mean.value,
                c.bias.value,
                c.bias.lo,
                c.bias.hi,
                optional(c.z),
                c.biased,
                c.rmse.value,
                c.rmse.lo,
                c.rmse.hi,
                c.mae.value,
                c.variance,
                optional(c.predicted_variance),
                optional(c.own_standard_error),
                optional(c.own_coverage),
                c.largest_share,
                c.seconds
            );
        }
    }
    text
}
