//! Which of the emitting primitives, in proportion to their power.

use super::alias::Table;
use super::inversion::{Choice, Inversion};
use crate::lane::{Bits, Real};

/// More lights than this are not put side by side in one number's 2²⁴ values, which would round their shares too much.
const MOST_IN_A_ROW: usize = 1024;

/// A light by its power.
pub(super) enum ByPower {
    /// There is one.
    Only,
    /// Neighbours in the list are neighbours in the number.
    InARow(Inversion),
    /// By a number of its own.
    Apart(Table),
}

impl ByPower {
    /// In proportion to `powers`, with the probabilities it yields.
    pub(super) fn build(powers: &[f64]) -> (Self, Vec<f64>) {
        if powers.len() == 1 {
            return (Self::Only, vec![1.0]);
        }
        if powers.len() > MOST_IN_A_ROW {
            let (table, probability) = Table::build(powers);
            return (Self::Apart(table), probability);
        }
        // Relative to the strongest, because powers may leave the range of f32 where their ratios do not.
        let strongest = powers.iter().copied().fold(0.0, f64::max);
        let relative: Vec<f32> = powers.iter().map(|power| (power / strongest) as f32).collect();
        let mut inversion = Inversion::new(1, powers.len());
        let mut probability = Vec::new();
        for table in &mut inversion.tables() {
            table.fill(&relative);
            probability.extend(table.probability());
        }
        (Self::InARow(inversion), probability)
    }

    /// By `u[0]` and, where its digits end, `fine`; what is left of `u[0]` is in the choice.
    #[inline(always)]
    pub(super) fn choose<R: Real>(&self, u: [R; 2], fine: R) -> Choice<R> {
        match self {
            Self::Only => Choice { entry: R::Bits::splat(0), rest: u[0] },
            Self::InARow(inversion) => inversion.choose_first(u[0], fine),
            Self::Apart(table) => Choice { entry: table.choose(fine, u), rest: u[0] },
        }
    }

    pub(super) fn memory(&self) -> usize {
        match self {
            Self::Only => 0,
            Self::InARow(inversion) => inversion.bytes(),
            Self::Apart(table) => table.memory(),
        }
    }
}
