//! `octolux check --numerics`: the catalogue of extreme cases as a table.

use super::CliError;
use crate::check::numerics::{self, Effort, Row};
use crate::render;

#[derive(clap::Args)]
pub struct NumericsArgs {
    /// Instead of a scene: run the catalogue of stiff and extreme cases on this build and CPU
    #[arg(long, conflicts_with = "SceneArgs")]
    numerics: bool,
    /// With --numerics: all 2³² arguments of the lane functions, 10⁹ pairs, 10⁷ rays; takes some twenty minutes
    #[arg(long, requires = "numerics", conflicts_with_all = ["quick", "SceneArgs"])]
    full: bool,
    /// With --numerics: seconds, fewer samples of the same cases
    #[arg(long, requires = "numerics", conflicts_with = "SceneArgs")]
    quick: bool,
    /// With --numerics: only the groups whose name contains this
    #[arg(long, requires = "numerics", conflicts_with = "SceneArgs", value_name = "GROUP")]
    only: Option<String>,
}

impl NumericsArgs {
    fn effort(&self) -> Effort {
        match (self.full, self.quick) {
            (true, _) => Effort::Full,
            (_, true) => Effort::Quick,
            _ => Effort::Strided,
        }
    }
}

/// True where every case kept its bound.
pub fn run(args: &NumericsArgs, json: bool) -> Result<bool, CliError> {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let pool = render::thread_pool(threads)?;
    let only = args.only.as_deref().unwrap_or("");
    if !numerics::GROUPS.iter().any(|group| group.name.contains(only)) {
        let names: Vec<_> = numerics::GROUPS.iter().map(|group| group.name).collect();
        return Err(CliError::Usage(format!("no group `{only}`; there are {}", names.join(", "))));
    }
    if !json {
        println!("| case | tried | worst | bound | | textbook form |\n|---|---|---|---|---|---|");
    }
    let report = numerics::run(args.effort(), only, &pool, |rows| {
        if !json {
            rows.iter().for_each(print_row);
        }
    });
    if json {
        println!("{}", serde_json::to_string_pretty(&report).map_err(|e| CliError::Usage(e.to_string()))?);
    } else {
        let failed = report.rows.iter().filter(|row| !row.pass).count();
        let verdict = if failed == 0 { "all cases pass".into() } else { format!("{failed} cases FAIL") };
        println!("\n{verdict} in {:.1} s on {threads} threads", report.seconds);
    }
    Ok(report.pass)
}

fn print_row(row: &Row) {
    let at = if row.at.is_empty() || row.worst == 0.0 { String::new() } else { format!(" at {}", row.at) };
    let verdict = if row.pass { "pass" } else { "FAIL" };
    let (worst, bound) = (number(row.worst), number(row.bound));
    let Row { group, case, count, unit, naive, .. } = row;
    println!("| {group}: {case} | {count} | {worst} {unit}{at} | {bound} | {verdict} | {naive} |");
}

/// Four digits.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) {
        let text = format!("{x:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        format!("{x:.3e}")
    }
}
