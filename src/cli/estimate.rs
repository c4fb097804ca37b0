//! `octolux estimate`: an estimator's error against samples and run time, on problems with known answers.

use super::CliError;
use super::problem::{DIMENSIONS, EXPONENT, HEMISPHERE, ProblemArgs, ProblemName, SKY, name};
use super::targets::check_apart;
use crate::estimate::demos::{self, Demonstration};
use crate::estimate::expression::Expression;
use crate::estimate::method::Method;
use crate::estimate::page;
use crate::estimate::problems::{self, Problem, Wanted};
use crate::estimate::study::{Budget, Quantity, Study, run as run_study};
use crate::estimate::table::csv;
use crate::film::beside::{check_writable, write_beside};
use crate::kernel::{Prepare, Width, World};
use crate::plan::{Force, Plan};
use crate::process::command_line;
use crate::render::interrupt;
use crate::scene::{EnvironmentImage, Scene};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct EstimateArgs {
    #[arg(value_enum)]
    problem: ProblemName,
    /// Methods to compare; `--methods help` lists those of the problem
    #[arg(long, value_delimiter = ',')]
    methods: Vec<String>,
    /// Numbers of samples of an estimate [default: 1,4,16,64,256,1024,4096; 2,4,8 for gp-1d, 5 for ohagan]
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    samples: Vec<u32>,
    /// Independent estimates of each kind [default: 1000]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    repeats: Option<u32>,
    /// Picks the random numbers
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Folder for report.html, study.json, errors.csv and the plots as SVG; made if it is not there
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

/// Where [`EstimateArgs`] says nothing.
const REPEATS: u32 = 1000;
const SAMPLES: [usize; 7] = [1, 4, 16, 64, 256, 1024, 4096];

pub fn run(args: &EstimateArgs) -> Result<bool, CliError> {
    check(args).map_err(CliError::Usage)?;
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).map_err(|source| CliError::Write { path: folder.clone(), source })?;
    }
    if let Some(demonstration) = demonstration(args).transpose().map_err(CliError::Usage)? {
        show(args, &demonstration)?;
        return Ok(true);
    }
    let scene = scene(args).map_err(CliError::Usage)?;
    let read = [&args.of.image, &args.of.scene].into_iter().flatten().chain(scene.iter().flat_map(|s| &s.files));
    check_apart(args.json.as_deref().filter(|path| *path != Path::new("-")), read.map(PathBuf::as_path))?;
    let problem = problem(args, scene.as_ref()).map_err(CliError::Usage)?;
    if args.methods.iter().any(|m| m == "help") {
        let (names, defaults) = problem.method_names();
        println!("default: {}\nalso: {}", names[..defaults].join(","), names[defaults..].join(","));
        return Ok(true);
    }
    let methods = methods(args, &*problem).map_err(CliError::Usage)?;
    check_folder(args, ["errors.csv".to_owned()].into_iter().chain(page::PLOT_NAMES.map(plot_file)))?;
    let budget = Budget { samples: samples(args, &SAMPLES), repeats: repeats(args), seed: args.seed };
    // Ctrl-C ends the study after the cell at hand: what is finished is reported.
    interrupt::listen(super::leave);
    interrupt::keep();
    let threads = args.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let study = pool.install(|| run_study(problem.quantity(), &methods, &budget, &|| interrupt::asked()));
    output(args, &*problem, &study)?;
    Ok(true)
}

/// An option that would be read and not heeded is an error.
fn check(args: &EstimateArgs) -> Result<(), String> {
    args.of.check(args.problem)?;
    use ProblemName::{Gp1d, Ohagan, VarianceRules};
    let options: [(&str, bool, &[ProblemName]); 4] = [
        ("methods", !args.methods.is_empty(), &[VarianceRules, Gp1d, Ohagan]),
        ("lanes", args.lanes.is_some(), &[VarianceRules, Gp1d, Ohagan]),
        ("samples", !args.samples.is_empty(), &[VarianceRules]),
        ("repeats", args.repeats.is_some(), &[Gp1d, Ohagan]),
    ];
    match options.iter().find(|(_, given, not_of)| *given && not_of.contains(&args.problem)) {
        Some((option, ..)) => {
            Err(format!("--{option} says nothing of {}, which is shown; leave it out", name(args.problem)))
        }
        None => Ok(()),
    }
}

fn repeats(args: &EstimateArgs) -> usize {
    args.repeats.unwrap_or(REPEATS) as usize
}

/// Those asked for, in rising order, each once.
fn samples(args: &EstimateArgs, default: &[usize]) -> Vec<usize> {
    let mut samples: Vec<usize> = args.samples.iter().map(|&n| n as usize).collect();
    if samples.is_empty() {
        samples = default.to_vec();
    }
    samples.sort_unstable();
    samples.dedup();
    samples
}

/// What is shown instead of studied, if that is what was asked for.
fn demonstration(args: &EstimateArgs) -> Option<Result<Demonstration, String>> {
    let named = |default: &str| args.of.f.clone().unwrap_or_else(|| default.to_owned());
    let of_function = |name: String, counts: Vec<usize>, show: fn(&Expression, &Quantity, &[usize], u64) -> _| {
        if let Some(many) = counts.iter().find(|&&n| n > 512) {
            return Err(format!("{many} samples are more than this can show; give --samples up to 512"));
        }
        let quantity = problems::interval(&name, [0.0, 1.0], None, Width::One)?.quantity;
        let expression = Expression::parse(problems::interval_expression(&name))?;
        show(&expression, &quantity, &counts, args.seed)
    };
    match args.problem {
        ProblemName::VarianceRules => Some(Ok(demos::variance_rules(repeats(args), args.seed))),
        ProblemName::Gp1d => Some(of_function(named("sin(2*PI*x)+x"), samples(args, &[2, 4, 8]), |f, q, n, seed| {
            demos::gp_line(f, q, n, seed)
        })),
        ProblemName::Ohagan => Some(of_function(named("exp"), samples(args, &[5]), |f, q, n, seed| {
            demos::ohagan(f, q, n.first().copied().unwrap_or(5), seed)
        })),
        _ => None,
    }
}

fn show(args: &EstimateArgs, demonstration: &Demonstration) -> Result<(), CliError> {
    let json = serde_json::to_string_pretty(&demonstration.json()).map_err(|e| CliError::Usage(e.to_string()))? + "\n";
    let plots = || demonstration.sections.iter().flat_map(|part| &part.plots);
    check_folder(args, ["tables.csv".to_owned()].into_iter().chain(plots().map(|(name, _)| plot_file(name))))?;
    if let Some(folder) = &args.output {
        write(&folder.join("study.json"), &json)?;
        write(&folder.join("tables.csv"), &demonstration.csv())?;
        write(&folder.join("report.html"), &demonstration.page(&command_line()).html())?;
        for (name, plot) in plots() {
            write(&folder.join(plot_file(name)), &plot.svg_file())?;
        }
    }
    print_or_write(args, &json, || print!("{demonstration}"))
}

fn plot_file(name: &str) -> String {
    format!("{name}.svg")
}

/// The folder may hold an earlier study, which is replaced, but of the `names` of this one (and of what all have) nothing that
/// was written by another program: to be known before anything is estimated.
fn check_folder(args: &EstimateArgs, names: impl Iterator<Item = String>) -> Result<(), CliError> {
    let Some(folder) = &args.output else { return Ok(()) };
    let files: Vec<_> = ["study.json", "report.html"]
        .map(str::to_owned)
        .into_iter()
        .chain(names)
        .map(|name| folder.join(name))
        .collect();
    files.iter().try_for_each(|file| check_writable(file))?;
    let earlier = std::fs::read(folder.join("study.json")).ok();
    let earlier = earlier.and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
    // The forms of a study and of a demonstration.
    if earlier.is_some_and(|json| json.get("quantity").is_some() || json.get("lead").is_some()) {
        return Ok(());
    }
    match files.iter().find(|file| file.exists()) {
        Some(file) => Err(CliError::Usage(format!(
            "{}: is there already, and not made by `octolux estimate`; name another folder",
            file.display()
        ))),
        None => Ok(()),
    }
}

/// The scene of the problem, if it is of one.
fn scene(args: &EstimateArgs) -> Result<Option<Scene>, String> {
    let path = args.of.scene.as_ref().filter(|_| args.problem == ProblemName::Illumination);
    path.map(|path| crate::scene::load(path).map_err(|e| e.to_string())).transpose()
}

fn illumination(of: &ProblemArgs, scene: Option<&Scene>, seed: u64, width: Width) -> Result<Box<dyn Problem>, String> {
    let scene = scene.ok_or("illumination is of a scene: give --scene SCENE.toml")?;
    let force = Force { geometry: of.mode, ..Force::default() };
    let plan = Plan::new(scene, force, false).with_light_samples_alone();
    if let Some(why) = plan.geometry.refusal(scene) {
        return Err(why);
    }
    let world = World::new(scene, plan, Prepare { seed, ..Prepare::default() }).map_err(|e| e.to_string())?;
    let (x, y) = of.pixel.unwrap_or((world.film.width / 2, world.film.height / 2));
    Ok(Box::new(problems::illumination(world, &scene.name, [x, y], width)?))
}

fn problem(args: &EstimateArgs, scene: Option<&Scene>) -> Result<Box<dyn Problem>, String> {
    let of = &args.of;
    let width = args.lanes.unwrap_or_else(Width::native);
    let named = |default: &str| of.f.clone().unwrap_or_else(|| default.to_owned());
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
        ProblemName::CubeD => Box::new(problems::cube(&named("sine"), of.dimensions.unwrap_or(DIMENSIONS), width)?),
        ProblemName::Illumination => illumination(of, scene, args.seed, width)?,
        ProblemName::VarianceRules | ProblemName::Gp1d | ProblemName::Ohagan => {
            return Err("this is shown, not studied".into());
        }
        ProblemName::Hemisphere => Box::new(match &of.image {
            Some(path) => under_image(path, width)?,
            None => {
                problems::hemisphere(&named(HEMISPHERE), of.exponent.unwrap_or(EXPONENT), of.sky.unwrap_or(SKY), width)?
            }
        }),
    })
}

fn under_image(path: &Path, width: Width) -> Result<problems::Hemisphere, String> {
    let image = EnvironmentImage::load(path).map_err(|e| e.to_string())?;
    problems::hemisphere_of_image(&image, width).map_err(|why| format!("{}: {why}", path.display()))
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
        write(&folder.join("report.html"), &page::page(study, &problem.notes(), &command_line()).html())?;
        for (name, plot) in page::plots(study) {
            write(&folder.join(plot_file(name)), &plot.svg_file())?;
        }
    }
    print_or_write(args, &json, || {
        print!("{study}");
        problem.notes().iter().for_each(|note| println!("{note}"));
    })
}

/// JSON where it was asked for, and the text unless standard output carries the JSON.
fn print_or_write(args: &EstimateArgs, json: &str, text: impl FnOnce()) -> Result<(), CliError> {
    match args.json.as_deref() {
        Some(path) if path.as_os_str() == "-" => {
            print!("{json}");
            return Ok(());
        }
        Some(path) => write(path, json)?,
        None => {}
    }
    text();
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), CliError> {
    Ok(write_beside(path, |file| std::io::Write::write_all(file, text.as_bytes()))?)
}
