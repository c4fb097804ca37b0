//! `octolux estimate`: an estimator's error against samples and run time, on problems with known answers.

use super::CliError;
use crate::estimate::expression::Expression;
use crate::estimate::method::Method;
use crate::estimate::problems::{self, Problem, Wanted};
use crate::estimate::study::{Budget, Study, run as run_study};
use crate::estimate::table::csv;
use crate::film::beside::write_beside;
use crate::kernel::Width;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct EstimateArgs {
    #[arg(value_enum)]
    problem: ProblemName,
    /// Methods to compare; `--methods help` lists those of the problem
    #[arg(long, value_delimiter = ',')]
    methods: Vec<String>,
    /// Numbers of samples of an estimate
    #[arg(long, value_delimiter = ',', default_value = "1,4,16,64,256,1024,4096", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    samples: Vec<u32>,
    /// Independent estimates of each kind
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    repeats: u32,
    /// Picks the random numbers
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Folder for study.json and errors.csv; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Write the study as JSON; `-` is standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// Worker threads [default: all cores]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Lanes: 1, 8 or 16; the numbers are the same [default: the fastest of this build]
    #[arg(long, value_parser = super::scene_args::parse_lanes)]
    lanes: Option<Width>,
    #[command(flatten)]
    of: ProblemArgs,
}

/// What belongs to one problem or another.
#[derive(clap::Args)]
struct ProblemArgs {
    /// The function: a name, or for interval and continuous an expression in x [default: the problem's first]
    #[arg(long, value_name = "NAME|EXPR")]
    f: Option<String>,
    /// interval, continuous: the range of x
    #[arg(long, value_name = "A,B", value_parser = parse_range, allow_hyphen_values = true)]
    range: Option<[f64; 2]>,
    /// continuous: the density of X; interval: the density that mc-is draws from
    #[arg(long, value_name = "EXPR")]
    density: Option<String>,
    /// continuous: estimate Pr(X in [A, B]) instead of E[f(X)]
    #[arg(long, value_name = "A,B", value_parser = parse_range, allow_hyphen_values = true)]
    probability: Option<[f64; 2]>,
    /// discrete: VALUE:PROBABILITY pairs
    #[arg(long, value_name = "X:P,…", value_delimiter = ',', value_parser = parse_pair, allow_hyphen_values = true)]
    table: Vec<[f64; 2]>,
    /// cube-d: dimensions, 1 to 20
    #[arg(long, default_value_t = 6)]
    dimensions: usize,
    /// hemisphere: n of cosine^n
    #[arg(long, default_value_t = 1.0)]
    exponent: f64,
    /// hemisphere: which of the random skies
    #[arg(long, default_value_t = 0)]
    sky: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum ProblemName {
    /// π by darts
    Pi,
    /// The mean of a fair die: 3.5, with variance 35/12
    Die,
    /// The mean of a table of yours (--table)
    Discrete,
    /// E[f(X)] or a probability, X with a density of yours (--density, --range, --f, --probability)
    Continuous,
    /// An integral over an interval (--f, --range, --density)
    Interval,
    /// An integral over the unit cube (--f, --dimensions)
    CubeD,
    /// An integral over the hemisphere (--f, --exponent, --sky)
    Hemisphere,
}

fn parse_range(text: &str) -> Result<[f64; 2], String> {
    parse_two(text, ',').ok_or_else(|| "write two numbers, as in 0,1".to_owned())
}

fn parse_pair(text: &str) -> Result<[f64; 2], String> {
    parse_two(text, ':').ok_or_else(|| "write VALUE:PROBABILITY, as in 1:0.5,2:0.5".to_owned())
}

fn parse_two(text: &str, separator: char) -> Option<[f64; 2]> {
    let (a, b) = text.split_once(separator)?;
    Some([a.trim().parse().ok()?, b.trim().parse().ok()?])
}

pub fn run(args: &EstimateArgs) -> Result<bool, CliError> {
    let problem = problem(args).map_err(CliError::Usage)?;
    if args.methods.iter().any(|m| m == "help") {
        let (names, defaults) = problem.method_names();
        println!("default: {}\nalso: {}", names[..defaults].join(","), names[defaults..].join(","));
        return Ok(true);
    }
    let methods = methods(args, &*problem).map_err(CliError::Usage)?;
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).map_err(|source| CliError::Write { path: folder.clone(), source })?;
    }
    let mut samples: Vec<usize> = args.samples.iter().map(|&n| n as usize).collect();
    samples.sort_unstable();
    samples.dedup();
    let budget = Budget { samples, repeats: args.repeats as usize, seed: args.seed };
    let threads = args.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let study = pool.install(|| run_study(problem.quantity(), &methods, &budget, &|| false));
    output(args, &*problem, &study)?;
    Ok(true)
}

fn problem(args: &EstimateArgs) -> Result<Box<dyn Problem>, String> {
    let of = &args.of;
    let width = args.lanes.unwrap_or_else(Width::native);
    let named = |default: &'static str| of.f.clone().unwrap_or_else(|| default.to_owned());
    let range = of.range.unwrap_or([0.0, 1.0]);
    Ok(match args.problem {
        ProblemName::Pi => Box::new(problems::pi(width)),
        ProblemName::Die => Box::new(problems::discrete("die", &die(), width)?),
        ProblemName::Discrete if of.table.is_empty() => {
            return Err("discrete needs its table: give --table X:P,X:P,…, as in --table 0:0.3,1:0.7".into());
        }
        ProblemName::Discrete => Box::new(problems::discrete("discrete", &of.table, width)?),
        ProblemName::Continuous => {
            let wanted = match of.probability {
                Some(event) => Wanted::Probability(event),
                None => Wanted::Expectation(Expression::parse(&named("x"))?),
            };
            let density = of.density.as_deref().unwrap_or("2*x");
            Box::new(problems::continuous(density, range, wanted, width)?)
        }
        ProblemName::Interval => Box::new(problems::interval(&named("exp"), range, of.density.as_deref(), width)?),
        ProblemName::CubeD => Box::new(problems::cube(&named("sine"), of.dimensions, width)?),
        ProblemName::Hemisphere => Box::new(problems::hemisphere(&named("cosine"), of.exponent, of.sky, width)?),
    })
}

fn die() -> [[f64; 2]; 6] {
    std::array::from_fn(|i| [(i + 1) as f64, 1.0 / 6.0])
}

fn methods(args: &EstimateArgs, problem: &dyn Problem) -> Result<Vec<Method>, String> {
    let (names, defaults) = problem.method_names();
    let chosen = if args.methods.is_empty() { &names[..defaults] } else { &args.methods[..] };
    chosen.iter().map(|name| problem.method(name)).collect()
}

/// The table to the terminal, and the files that were asked for.
fn output(args: &EstimateArgs, problem: &dyn Problem, study: &Study) -> Result<(), CliError> {
    let json = serde_json::to_string_pretty(study).map_err(|e| CliError::Usage(e.to_string()))? + "\n";
    if let Some(folder) = &args.output {
        write(&folder.join("study.json"), &json)?;
        write(&folder.join("errors.csv"), &csv(study))?;
    }
    match args.json.as_deref() {
        Some(path) if path.as_os_str() == "-" => {
            print!("{json}");
            return Ok(());
        }
        Some(path) => write(path, &json)?,
        None => {}
    }
    print!("{study}");
    problem.notes().iter().for_each(|note| println!("{note}"));
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), CliError> {
    Ok(write_beside(path, |file| std::io::Write::write_all(file, text.as_bytes()))?)
}
