//! What the paths of a group found, and which of it is shared.

use super::{LAMBERT, Shared, place};
use crate::lane::array;

/// So many finds of a group are shared, about: see [`balanced`]. Measured.
const LEAST: f64 = 2.0;
const MOST: f64 = 24.0;
const BALANCE: f64 = 30.0;

/// What one path found.
pub struct Find {
    pub slot: u32,
    /// Where the second vertex is not Lambert.
    pub lobe: Option<Lobe>,
    /// Radiance; once weighed, over the sum of densities.
    pub found: [f32; 3],
    /// How much of it the path's own pixel would have, about. In f64, like all that is made of it: squares of light stay in range.
    worth: f64,
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
    for slot in slots.iter().map(|&slot| slot as usize) {
        let second = &shared.second[slot];
        let albedo = brightness(array::from_fn(|c| shared.first[slot][place::ALBEDO + c]));
        let mut add = |part: usize, lobe: Option<Lobe>| {
            let found = rgb[part * count + slot];
            let factor = lobe.map_or(1.0, |lobe| f64::from(shared.lobes[lobe.row][place::FACTOR]));
            let worth = brightness(found) * albedo * factor;
            if !worth.is_finite() {
                rgb[slot] = found;
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

/// Keeps each find with a probability in proportion to its worth, by one number for all (systematic sampling), and lets it
/// carry the more. `u` is in [0, 1).
pub fn choose(finds: &mut Vec<Find>, slots: &[u32], shared: &Shared, rgb: &[[f32; 3]], u: f64) {
    let number = balanced(finds, slots, shared, rgb);
    if finds.len() as f64 <= number {
        return;
    }
    let scale = number / finds.iter().map(|find| find.worth).sum::<f64>();
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

/// As many as balance the noise of finds with that of all else: n of them cost c n beside a path's a and leave v/n beside the
/// variance u of what is not shared, so √(a v / c u). Both variances are those among the group's pixels now; a/c is measured,
/// and so is how much less u is where even points add up.
fn balanced(finds: &[Find], slots: &[u32], shared: &Shared, rgb: &[[f32; 3]]) -> f64 {
    let (mut n, mut sum, mut squares) = (0.0f64, 0.0f64, 0.0f64);
    for &slot in slots.iter().filter(|&&slot| shared.first[slot as usize][place::VALID] != 0.0) {
        let own = brightness(rgb[slot as usize]);
        (n, sum, squares) = (n + 1.0, sum + own, squares + own * own);
    }
    let variance = |sum: f64, squares: f64| (squares - sum * sum / n.max(1.0)).max(0.0);
    let worth = |of: fn(f64) -> f64| finds.iter().map(|find| of(find.worth)).sum::<f64>();
    let (found, own) = (variance(worth(|x| x), worth(|x| x * x)), variance(sum, squares));
    let balanced = BALANCE * (found / own).sqrt();
    // Not a number where neither varies.
    if balanced > LEAST { balanced.min(MOST) } else { LEAST }
}

fn brightness([r, g, b]: [f32; 3]) -> f64 {
    (f64::from(r) + f64::from(g) + f64::from(b)) * (1.0 / 3.0)
}
