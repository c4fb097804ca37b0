//! Choosing one of n in constant time: the alias table (Walker 1977), built as by Vose (1991).
//!
//! Thresholds are multiples of 2⁻²⁴, the grid of the number they are compared with, and the probabilities handed out
//! are those of the rounded table. So a sample's frequency and its pdf agree exactly; an entry whose share falls below
//! the grid gets probability 0 instead of being drawn too often.

use crate::lane::{Bits, Real};
use crate::sampling::{mix3, to_unit};

/// The most entries a table may have: indices are counted in `f32`.
pub const MAX_ENTRIES: usize = 1 << 24;

/// Steps of a random number in [0, 1).
const GRID: f64 = (1u32 << 24) as f64;

/// One entry: keep it while the second number is below `threshold`, else take `alias`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slot {
    threshold: f32,
    alias: u32,
}

/// A table with what it takes to choose by it; nothing where there is nothing to choose.
pub(super) struct Table(Vec<Slot>);

impl Table {
    /// In proportion to `weights` (finite, ≥ 0, of any range), with the probabilities it yields.
    pub(super) fn build(weights: &[f64]) -> (Self, Vec<f64>) {
        if weights.len() == 1 {
            return (Self(Vec::new()), vec![1.0]);
        }
        // Relative to the strongest, because powers may leave the range of f32 where their ratios do not.
        let strongest = weights.iter().copied().fold(0.0, f64::max);
        let relative: Vec<f32> = weights.iter().map(|w| (w / strongest) as f32).collect();
        let mut table = vec![Slot::default(); relative.len()];
        let mut probability = vec![0.0; relative.len()];
        Builder::default().fill(&relative, &mut table);
        probabilities(&table, &mut probability);
        (Self(table), probability)
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.0)
    }

    /// The entry that `u_choice` leads to, its bits extended from `u`.
    #[inline(always)]
    pub(super) fn choose<R: Real>(&self, u_choice: R, u: [R; 2]) -> R::Bits {
        if self.0.is_empty() {
            return R::Bits::splat(0);
        }
        let [fine, keep] = fresh(u_choice, u[0], u[1]);
        let (place, _) = place(self.0.len(), u_choice, fine);
        resolve(place, keep, |i| self.0[place.lane(i) as usize])
    }
}

/// Room for building tables one after the other without allocating anew.
#[derive(Default)]
pub struct Builder {
    share: Vec<f64>,
    small: Vec<u32>,
    large: Vec<u32>,
}

impl Builder {
    /// Fills `slots` in proportion to `weights` (finite, ≥ 0, equally many) and
    /// returns their sum. Where the sum is 0, the table is uniform.
    pub fn fill(&mut self, weights: &[f32], slots: &mut [Slot]) -> f64 {
        debug_assert_eq!(weights.len(), slots.len());
        let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        let to_share = if total > 0.0 { weights.len() as f64 / total } else { 0.0 };
        self.share.clear();
        self.share.extend(weights.iter().map(|&w| f64::from(w) * to_share));
        self.small.clear();
        self.large.clear();
        let mut largest = 0;
        for (i, &share) in self.share.iter().enumerate() {
            if share < 1.0 {
                self.small.push(i as u32)
            } else {
                self.large.push(i as u32)
            }
            if share > self.share[largest] {
                largest = i;
            }
        }
        while let (Some(&poor), Some(&rich)) = (self.small.last(), self.large.last()) {
            self.small.pop();
            let threshold = (self.share[poor as usize] * GRID).round() / GRID;
            slots[poor as usize] = Slot { threshold: threshold as f32, alias: rich };
            // What was really taken, so that the rounding of one threshold does not accumulate in the rich.
            self.share[rich as usize] -= 1.0 - threshold;
            if self.share[rich as usize] < 1.0 {
                self.large.pop();
                self.small.push(rich);
            }
        }
        for &i in self.large.iter().chain(&self.small) {
            // Only rounding leaves anyone in `small` here; one of weight 0 must still never be drawn.
            let drawn = total == 0.0 || weights[i as usize] > 0.0;
            slots[i as usize] = Slot { threshold: if drawn { 1.0 } else { 0.0 }, alias: largest as u32 };
        }
        total
    }
}

/// Sets `probability[i]` to how often `slots` yields i. Sums to 1 up to f64 rounding.
pub fn probabilities(slots: &[Slot], probability: &mut [f64]) {
    debug_assert_eq!(slots.len(), probability.len());
    let each = 1.0 / slots.len() as f64;
    probability.fill(0.0);
    for (i, slot) in slots.iter().enumerate() {
        let kept = f64::from(slot.threshold);
        probability[i] += kept * each;
        probability[slot.alias as usize] += (1.0 - kept) * each;
    }
}

/// The entry that `place` (an index below the table's length, from [`place`]) and the fresh number `keep` in [0, 1)
/// lead to. `slot(i)` reads entry `place.lane(i)` for lane i.
#[inline(always)]
pub fn resolve<R: Real>(place: R::Bits, keep: R, slot: impl Fn(usize) -> Slot) -> R::Bits {
    let threshold = R::from_fn(|i| slot(i).threshold);
    let alias = R::Bits::from_fn(|i| slot(i).alias);
    R::Bits::select(keep.lt(threshold), place, alias)
}

/// `⌊u·n⌋` and its remainder in [0, 1), where `fine` in [0, 1) extends `u` below its last bit of 2⁻²⁴ (without it,
/// n = 10⁵ entries would differ in frequency by up to .6 %). Never past n − 1, whatever `u` is; NaN counts as 0.
#[inline(always)]
pub fn place<R: Real>(n: usize, u: R, fine: R) -> (R::Bits, R) {
    let count = R::splat(n as f32);
    let below_grid = R::splat(n as f32 * (1.0 / GRID as f32));
    let whole = (u * count).floor();
    // The product is exact inside the fused operation; the sum may leave [0, 1) by a carry.
    let rest = fine.mul_add(below_grid, u.mul_add(count, -whole));
    let carry = rest.floor();
    let index = (whole + carry).max_or(R::zero()).min_or(R::splat((n - 1) as f32));
    let remainder = (rest - carry).max_or(R::zero()).min_or(R::splat(1.0 - f32::EPSILON / 2.0));
    (index.to_int(), remainder)
}

/// Two fresh numbers in [0, 1) hashed from three used ones: three 24-bit numbers hold too little for a place in a
/// table, the test against a threshold, and a point inside what was chosen, all to full precision.
#[inline(always)]
pub fn fresh<R: Real>(u0: R, u1: R, u2: R) -> [R; 2] {
    crate::lane::array::map(mix3::<R>(u0.to_bits(), u1.to_bits(), u2.to_bits()), to_unit)
}
