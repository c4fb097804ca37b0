//! The problems of `octolux estimate`, and what belongs to one or another of them.

use crate::plan::GeometryMode;
use clap::ValueEnum;
use std::path::PathBuf;

/// Where [`ProblemArgs`] says nothing; its help has them, too. (Not clap's: what was given must be told from what was not.)
pub(super) const DIMENSIONS: usize = 6;
pub(super) const EXPONENT: f64 = 1.0;
pub(super) const SKY: u64 = 0;
pub(super) const HEMISPHERE: &str = "cosine";

/// What belongs to one problem or another.
#[derive(clap::Args)]
pub(super) struct ProblemArgs {
    /// The function: a name, or for interval and continuous an expression in x [default: the problem's first]
    #[arg(long, value_name = "NAME|EXPR")]
    pub f: Option<String>,
    /// interval, continuous: the range of x
    #[arg(long, value_name = "A,B", value_parser = parse_range, allow_hyphen_values = true)]
    pub range: Option<[f64; 2]>,
    /// continuous: the density of X; interval: the density that mc-is draws from
    #[arg(long, value_name = "EXPR")]
    pub density: Option<String>,
    /// continuous: estimate Pr(X in [A, B]) instead of E[f(X)]
    #[arg(long, value_name = "A,B", value_parser = parse_range, allow_hyphen_values = true, conflicts_with = "f")]
    pub probability: Option<[f64; 2]>,
    /// discrete: VALUE:PROBABILITY pairs
    #[arg(long, value_name = "X:P,…", value_delimiter = ',', value_parser = parse_pair, allow_hyphen_values = true)]
    pub table: Vec<[f64; 2]>,
    /// cube-d: dimensions, 1 to 20 [default: 6]
    #[arg(long)]
    pub dimensions: Option<usize>,
    /// hemisphere: n of cosine^n, of --f cosine [default: 1]
    #[arg(long)]
    pub exponent: Option<f64>,
    /// hemisphere: which of the random skies, of --f sky, edge, sun [default: 0]
    #[arg(long)]
    pub sky: Option<u64>,
    /// hemisphere: a latitude-longitude OpenEXR image instead of --f; +y is up
    #[arg(long, value_name = "FILE.exr", conflicts_with_all = ["f", "sky", "exponent"])]
    pub image: Option<PathBuf>,
    /// illumination: the scene
    #[arg(long, value_name = "SCENE.toml")]
    pub scene: Option<PathBuf>,
    /// illumination: column and row of the pixel, from the top left [default: the middle]
    #[arg(long, value_name = "X,Y", value_parser = super::replay::parse_pixel)]
    pub pixel: Option<(u32, u32)>,
    /// illumination: how all rays find geometry, to compare: the same bits [default: as the plan decides]
    #[arg(long, value_enum)]
    pub mode: Option<GeometryMode>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum ProblemName {
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
    /// An integral over the hemisphere (--f, --exponent, --sky, --image)
    Hemisphere,
    /// The light that a pixel of a scene reflects (--scene, --pixel)
    Illumination,
    /// V(ΣX), V(aX): rules of variance, by dice
    VarianceRules,
    /// A Gaussian process on [0, 1]: prior, posterior, integral (--f)
    #[value(name = "gp-1d")]
    Gp1d,
    /// O'Hagan's objections to Monte Carlo (--f)
    Ohagan,
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

impl ProblemArgs {
    /// An option of other problems would be read and not heeded.
    pub fn check(&self, problem: ProblemName) -> Result<(), String> {
        use ProblemName::*;
        let options: [(&str, bool, &[ProblemName]); 12] = [
            ("f", self.f.is_some(), &[Continuous, Interval, CubeD, Hemisphere, Gp1d, Ohagan]),
            ("range", self.range.is_some(), &[Continuous, Interval]),
            ("density", self.density.is_some(), &[Continuous, Interval]),
            ("probability", self.probability.is_some(), &[Continuous]),
            ("table", !self.table.is_empty(), &[Discrete]),
            ("dimensions", self.dimensions.is_some(), &[CubeD]),
            ("exponent", self.exponent.is_some(), &[Hemisphere]),
            ("sky", self.sky.is_some(), &[Hemisphere]),
            ("image", self.image.is_some(), &[Hemisphere]),
            ("scene", self.scene.is_some(), &[Illumination]),
            ("pixel", self.pixel.is_some(), &[Illumination]),
            ("mode", self.mode.is_some(), &[Illumination]),
        ];
        if let Some((option, of)) = unheeded(&options, problem) {
            let of = of.iter().map(|&problem| name(problem)).collect::<Vec<_>>().join(", ");
            return Err(format!("--{option} says nothing of {}: it is for {of}; leave it out", name(problem)));
        }
        let options: [(&str, bool, &[&str]); 2] =
            [("exponent", self.exponent.is_some(), &["cosine"]), ("sky", self.sky.is_some(), &["sky", "edge", "sun"])];
        let f = self.f.as_deref().unwrap_or(HEMISPHERE);
        match unheeded(&options, f) {
            Some((option, of)) => Err(format!("--{option} says nothing of --f {f}: it is for {}", of.join(", "))),
            None => Ok(()),
        }
    }
}

/// The first option that was given and is not for `what`, and what it is for.
fn unheeded<'a, T: PartialEq>(options: &[(&'a str, bool, &'a [T])], what: T) -> Option<(&'a str, &'a [T])> {
    options.iter().find(|(_, given, of)| *given && !of.contains(&what)).map(|&(option, _, of)| (option, of))
}

/// As it is written.
pub(super) fn name(problem: ProblemName) -> String {
    problem.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned())
}
