//! When paths may end by chance.

use std::fmt;
use std::str::FromStr;

/// Russian roulette (Arvo & Kirk 1990): from the scattering event `after` on, a path that carries the share β < `below` of
/// what it started with goes on with probability min(β/`below`, .95) and then carries that much more; others go on. No choice
/// of the two biases an image: they trade noise for time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// Scattering events, from 1 on.
    pub after: u32,
    /// In [0, 1]; 0 is no roulette.
    pub below: f32,
}

impl Roulette {
    /// What many renderers do, Mitsuba among them: to compare with those ray by ray.
    pub const USUAL: Roulette = Roulette { after: 5, below: 1.0 };
}

/// Found by measuring (`benches/README.md`): ending a path by its whole β adds more noise than the rays it saves are worth.
impl Default for Roulette {
    fn default() -> Self {
        Roulette { after: 2, below: 0.25 }
    }
}

/// As the command line has it.
impl fmt::Display for Roulette {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{},{}", self.after, self.below)
    }
}

impl FromStr for Roulette {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once(',').and_then(|(after, below)| {
            let after = after.parse().ok().filter(|&n: &u32| n >= 1)?;
            let below = below.parse().ok().filter(|x: &f32| (0.0..=1.0).contains(x))?;
            Some(Roulette { after, below })
        });
        numbers.ok_or_else(|| {
            "write AFTER,BELOW: a number of scattering events from 1 on, and a share in [0, 1], as in 5,1".to_string()
        })
    }
}
