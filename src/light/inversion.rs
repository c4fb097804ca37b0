//! Choosing one of n by inverting the cumulative distribution: near numbers choose near entries, which keeps what a
//! low-discrepancy sampler puts into them. A guide table (Chen & Asau 1974) finds the place in constant expected time.
//!
//! Cumulative values are multiples of 2⁻²⁴, the grid of the numbers they are compared with: an entry's probability is
//! exactly the share of numbers that choose it. One whose share falls below the grid is never chosen.

use crate::lane::{Bits, MAX_WIDTH, Real, prefetch};
use crate::sampling::ONE_BELOW;

const GRID: f64 = (1u32 << 24) as f64;
/// Entries a bucket of the guide covers on average: 2, searched one by one, were no faster.
const ENTRIES_PER_BUCKET: usize = 8;
/// Fewer entries than this are compared with, rather than searched.
const FEW: usize = 16;

/// Tables of equal length, one after the other.
pub struct Inversion {
    entries: usize,
    buckets: usize,
    /// `entries` + 1 values a table, 0 first.
    cumulative: Vec<u32>,
    /// `buckets` + 1 a table: the entry at which a bucket's numbers begin. Empty where entries are fewer than [`FEW`].
    guide: Vec<u32>,
    /// Where they are, the cumulative values of each table, the last 1 whatever they are, and infinity past
    /// it: any number falls somewhere.
    rows: Vec<[f32; FEW]>,
}

/// One table while it is made.
pub struct Table<'a> {
    cumulative: &'a mut [u32],
    finder: Finder<'a>,
}

/// By what its entries are found.
enum Finder<'a> {
    Guide(&'a mut [u32]),
    Row(&'a mut [f32; FEW]),
}

/// Entries chosen, and where in them the number fell, again uniform in [0, 1).
pub struct Choice<R: Real> {
    pub entry: R::Bits,
    pub rest: R,
}

impl Inversion {
    /// Room for `tables` of `entries` ≥ 1 each; nothing can be chosen until they are filled.
    pub fn new(tables: usize, entries: usize) -> Self {
        let buckets = entries.div_ceil(ENTRIES_PER_BUCKET).next_power_of_two();
        let mut unfilled = [f32::INFINITY; FEW];
        unfilled[0] = 0.0;
        let (searched, compared) = if entries < FEW { (0, tables) } else { (tables, 0) };
        let cumulative = vec![0; tables * (entries + 1)];
        Self { entries, buckets, cumulative, guide: vec![0; searched * (buckets + 1)], rows: vec![unfilled; compared] }
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&*self.cumulative) + size_of_val(&*self.guide) + size_of_val(&*self.rows)
    }

    /// The tables, to be filled in any order.
    pub fn tables(&mut self) -> Vec<Table<'_>> {
        let guides = self.guide.chunks_exact_mut(self.buckets + 1).map(Finder::Guide);
        let finders = guides.chain(self.rows.iter_mut().map(Finder::Row));
        let cumulative = self.cumulative.chunks_exact_mut(self.entries + 1);
        cumulative.zip(finders).map(|(cumulative, finder)| Table { cumulative, finder }).collect()
    }

    /// How many of the 2²⁴ numbers choose `entry` of a table.
    #[inline(always)]
    pub fn share<R: Real>(&self, table: R::Bits, entry: R::Bits) -> R::Bits {
        R::Bits::from_fn(|i| {
            let at = table.lane(i) as usize * (self.entries + 1) + entry.lane(i) as usize;
            self.cumulative[at + 1] - self.cumulative[at]
        })
    }

    /// Chooses from the first table by `u`, extended as in [`Inversion::choose`].
    #[inline(always)]
    pub fn choose_first<R: Real>(&self, u: R, fine: R) -> Choice<R> {
        if self.entries >= FEW {
            return self.choose(R::Bits::splat(0), u, fine);
        }
        // All cumulative values, which `f32` holds, against all lanes: no lane looks anything up.
        let steps = steps(u).floor();
        let value = |k: usize| R::splat(self.cumulative[k] as f32);
        let (mut entry, mut below, mut above) = (R::zero(), R::zero(), value(1));
        for k in 1..self.entries {
            let beyond = steps.ge(value(k));
            entry = R::select(beyond, R::splat(k as f32), entry);
            below = R::select(beyond, value(k), below);
            above = R::select(beyond, value(k + 1), above);
        }
        Choice { entry: entry.to_int(), rest: rest(steps - below, above - below, fine) }
    }

    /// A lane's whole table is compared with its number: no branch depends on where it falls.
    #[inline(always)]
    fn choose_of_few<R: Real>(&self, table: R::Bits, u: R, fine: R) -> Choice<R> {
        let steps = steps(u).floor();
        let (mut entry, mut below, mut above) = ([0; MAX_WIDTH], [0.0; MAX_WIDTH], [0.0; MAX_WIDTH]);
        for i in 0..R::WIDTH {
            let row = &self.rows[table.lane(i) as usize];
            let step = R::splat(steps.lane(i));
            let passed = row.chunks_exact(R::WIDTH.min(FEW)).map(|part| R::load(part).le_bits(step).count_ones());
            let at = passed.sum::<u32>() as usize;
            // 0 is passed by all, and what follows the last entry by none.
            (entry[i], below[i], above[i]) = (at as u32 - 1, row[(at - 1) % FEW], row[at % FEW]);
        }
        let (below, above) = (R::load(&below), R::load(&above));
        Choice { entry: R::Bits::load(&entry), rest: rest(steps - below, above - below, fine) }
    }

    /// Chooses from table `table` by `u`; `fine` in [0, 1) extends `u` below its last bit of 2⁻²⁴.
    #[inline(always)]
    pub fn choose<R: Real>(&self, table: R::Bits, u: R, fine: R) -> Choice<R> {
        if self.entries < FEW {
            return self.choose_of_few(table, u, fine);
        }
        let steps = steps(u).to_int();
        let shift = 24 - self.buckets.trailing_zeros();
        // All addresses first: lanes then wait for the cache together.
        let mut bucket = [0; MAX_WIDTH];
        for (i, bucket) in bucket.iter_mut().enumerate().take(R::WIDTH) {
            *bucket = table.lane(i) as usize * (self.buckets + 1) + (steps.lane(i) >> shift) as usize;
            prefetch(self.guide.as_ptr().wrapping_add(*bucket));
        }
        let (mut from, mut to) = ([0; MAX_WIDTH], [0; MAX_WIDTH]);
        for i in 0..R::WIDTH {
            from[i] = self.guide[bucket[i]] as usize;
            to[i] = self.guide[bucket[i] + 1] as usize;
            prefetch(self.cumulative.as_ptr().wrapping_add(table.lane(i) as usize * (self.entries + 1) + from[i]));
        }
        let (mut entry, mut below, mut share) = ([0; MAX_WIDTH], [0; MAX_WIDTH], [0; MAX_WIDTH]);
        for i in 0..R::WIDTH {
            let first = table.lane(i) as usize * (self.entries + 1);
            let row = &self.cumulative[first..][..self.entries + 1];
            let at = from[i] + row[from[i] + 1..to[i] + 1].partition_point(|&c| c <= steps.lane(i));
            (entry[i], below[i], share[i]) = (at as u32, row[at], row[at + 1] - row[at]);
        }
        let into = R::from_int(steps - R::Bits::load(&below));
        Choice { entry: R::Bits::load(&entry), rest: rest(into, R::from_int(R::Bits::load(&share)), fine) }
    }
}

/// In units of the grid; whatever `u` is, NaN included, a place in the table.
#[inline(always)]
fn steps<R: Real>(u: R) -> R {
    u.max_or(R::zero()).min_or(R::splat(ONE_BELOW)) * R::splat(GRID as f32)
}

/// Where a number fell, so many steps `into` the `share` of an entry.
#[inline(always)]
fn rest<R: Real>(into: R, share: R, fine: R) -> R {
    ((into + fine) / share).max_or(R::zero()).min_or(R::splat(ONE_BELOW))
}

impl Table<'_> {
    /// Fills the table in proportion to `weights` (finite, ≥ 0, as many as entries) and returns their sum. Where that is 0,
    /// nothing is ever chosen.
    pub fn fill(&mut self, weights: &[f32]) -> f64 {
        let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        let last = weights.iter().rposition(|&w| w > 0.0).unwrap_or(0);
        let (before, rest) = self.cumulative[1..].split_at_mut(last);
        let (mut sum, to_grid) = (0.0, GRID / total);
        for (end, &w) in before.iter_mut().zip(weights) {
            sum += f64::from(w);
            *end = (sum * to_grid + 0.5).min(GRID) as u32;
        }
        // The last that weighs anything ends at 1 whatever the sums' rounding.
        rest.fill(if total > 0.0 { GRID as u32 } else { 0 });
        match &mut self.finder {
            Finder::Guide(guide) => point(guide, self.cumulative, last),
            Finder::Row(row) => {
                row.iter_mut().zip(&*self.cumulative).for_each(|(value, &sum)| *value = sum as f32);
                row[self.cumulative.len() - 1] = GRID as f32;
            }
        }
        total
    }

    /// How often each entry is chosen.
    pub fn probability(&self) -> impl Iterator<Item = f64> + '_ {
        self.cumulative.windows(2).map(|pair| f64::from(pair[1] - pair[0]) / GRID)
    }
}

/// Points each bucket of a guide at the entry where its numbers begin, `last` at most.
fn point(guide: &mut [u32], cumulative: &[u32], last: usize) {
    let buckets = guide.len() - 1;
    let mut entry = 0;
    for (bucket, guide) in guide.iter_mut().enumerate() {
        let begins = (bucket * ((1 << 24) / buckets)) as u32;
        while entry < last && cumulative[entry + 1] <= begins {
            entry += 1;
        }
        *guide = entry as u32;
    }
}
