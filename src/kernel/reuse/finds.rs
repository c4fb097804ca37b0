//! What the paths of a group found, and which of it is shared.

use super::{LAMBERT, Row, Shared, place};
use crate::lane::array;

/// So many finds of a group are shared, about: see [`balanced`]. Measured.
const LEAST: f64 = 2.0;
const MOST: f64 = 40.0;
const BALANCE: f64 = 70.0;

/// What one path found.
pub struct Find {
    pub slot: u32,
    /// Where the second vertex is not Lambert.
    pub lobe: Option<Lobe>,
    /// Radiance; once weighed, over the sum of densities.
    pub found: [f32; 3],
    /// How much of it pixels would have, about: the path's own, and one of the group's mean albedo. (Of a dark vertex's find others
    /// have as much as of a bright one's.) In f64, like all that is made of it: squares of light stay in range.
    pub worth: f64,
    /// Do all first vertices scatter it by their albedo times their density?
    pub plain: bool,
}

/// By what a second vertex that is not Lambert scatters a find.
#[derive(Clone, Copy)]
pub struct Lobe {
    /// In the table of lobes.
    pub row: usize,
    /// Found on the path's own way on, or else by its light sample.
    pub way_on: bool,
}

/// Finds of the paths of `slots`, all that hold anything. What is no finite number goes to its own pixel, where the film counts
/// it as discarded.
pub fn collect(slots: &[u32], shared: &Shared, rgb: &mut [[f32; 3]], finds: &mut Vec<Find>) {
    finds.clear();
    let count = shared.slots() as usize;
    let mean = mean_albedo(slots, shared);
    for slot in slots.iter().map(|&slot| slot as usize) {
        let second = &shared.second[slot];
        let scattered = 0.5 * (albedo(&shared.first[slot]) + mean);
        let mut add = |part: usize, lobe: Option<Lobe>| {
            let found = rgb[part * count + slot];
            let factor = lobe.map_or(1.0, |lobe| f64::from(shared.lobes[lobe.row][place::SEEN]));
            let worth = brightness(found) * scattered * factor;
            if !worth.is_finite() {
                rgb[slot] = [f32::NAN; 3];
            } else if worth > 0.0 {
                finds.push(Find { slot: slot as u32, lobe, found, worth, plain: false });
            }
        };
        if second[place::KIND] == LAMBERT {
            add(1, None);
        }
        for (at, part) in [(place::LIGHT, 1), (place::WAY_ON, 2)] {
            if second[at] != 0.0 {
                add(part, Some(Lobe { row: second[at] as usize - 1, way_on: at == place::WAY_ON }));
            }
        }
    }
}

/// Of a first vertex.
fn albedo(first: &Row) -> f64 {
    brightness(array::from_fn(|c| first[place::ALBEDO + c]))
}

/// Of first vertices that share.
fn mean_albedo(slots: &[u32], shared: &Shared) -> f64 {
    let valid = slots.iter().map(|&slot| &shared.first[slot as usize]).filter(|first| first[place::VALID] != 0.0);
    let (n, sum) = valid.fold((0.0, 0.0), |(n, sum), first| (n + 1.0, sum + albedo(first)));
    sum / f64::max(n, 1.0)
}

/// Keeps about `number` finds, each with a probability in proportion to its worth, by one number for all (systematic sampling),
/// and lets it carry the more. `u` is in [0, 1).
pub fn choose(finds: &mut Vec<Find>, number: f64, u: f64) {
    if finds.len() as f64 <= number {
        return;
    }
    let scale = number / total_worth(finds);
    let mut walk = u;
    finds.retain_mut(|find| {
        let probability = (find.worth * scale).min(1.0);
        walk += probability;
        let kept = walk >= 1.0;
        if kept {
            walk -= 1.0;
            let share = probability.recip() as f32;
            find.found = find.found.map(|x| x * share);
        }
        kept
    });
}

/// As many as balance the noise of the choice with that of all else: n of them cost c n beside a path's a and leave v/n beside the
/// variance u of what is not chosen, so √(a v / c u). v is the [spread](super::spread). Were samples divided by need, u would be
/// what is not shared among the group's own pixels; where all pixels have as many, it is the whole image's, in proportion to
/// the group's brightness squared: it is taken halfway. a/c is measured, and so is how much less u is where even points add up.
pub fn balanced(finds: &[Find], spread: f64, slots: &[u32], shared: &Shared, rgb: &[[f32; 3]]) -> f64 {
    let (mut n, mut sum, mut squares) = (0.0f64, 0.0f64, 0.0f64);
    for &slot in slots.iter().filter(|&&slot| shared.first[slot as usize][place::VALID] != 0.0) {
        let own = brightness(rgb[slot as usize]);
        (n, sum, squares) = (n + 1.0, sum + own, squares + own * own);
    }
    let n = n.max(1.0);
    let (deviation, mean) = ((squares - sum * sum / n).max(0.0).sqrt() / n.sqrt(), (sum + total_worth(finds)) / n);
    let balanced = BALANCE * (spread / (deviation * mean)).sqrt();
    // Not a number where nothing varies.
    if balanced > LEAST { balanced.min(MOST) } else { LEAST }
}

/// Of all of them.
pub fn total_worth(finds: &[Find]) -> f64 {
    finds.iter().map(|find| find.worth).sum()
}

pub fn brightness([r, g, b]: [f32; 3]) -> f64 {
    (f64::from(r) + f64::from(g) + f64::from(b)) * (1.0 / 3.0)
}
