//! V(ΣXᵢ) = ΣV(Xᵢ) for independent X, V(aX) = a²V(X), and what happens when they are not independent: by rolling dice.

use super::{Demonstration, Part};
use crate::estimate::points::{Points, unit};
use crate::kernel::Width;
use crate::report::fit::Estimate;
use crate::report::page::{Cell, Table};
use crate::sampling::sample_key;

/// V of a fair die.
const DIE: f64 = 35.0 / 12.0;

/// One rule: how many dice, what is made of them, its variance.
struct Rule {
    name: String,
    dice: usize,
    of: fn(&[f64]) -> f64,
    exact: f64,
}

fn rules() -> Vec<Rule> {
    let sum = |rolls: &[f64]| rolls.iter().sum();
    let mean = |rolls: &[f64]| rolls.iter().sum::<f64>() / rolls.len() as f64;
    let rule = |name: &str, dice, of, exact| Rule { name: name.into(), dice, of, exact };
    let mut all = vec![
        rule("V[X]", 1, sum, DIE),
        rule("V[3X] = 9 V[X]", 1, |r| 3.0 * r[0], 9.0 * DIE),
        rule("V[X + 7] = V[X]", 1, |r| r[0] + 7.0, DIE),
        rule("V[−X] = V[X]", 1, |r| -r[0], DIE),
        rule("V[X + X] = 4 V[X]: one die, twice", 1, |r| r[0] + r[0], 4.0 * DIE),
        rule("V[X₁ − X₂] = 2 V[X]", 2, |r| r[0] - r[1], 2.0 * DIE),
        rule("V[X + (7 − X)] = 0: antithetic", 1, |r| r[0] + (7.0 - r[0]), 0.0),
    ];
    for n in [2, 4, 16] {
        all.push(rule(&format!("V[X₁ + … + X{n}] = {n} V[X]"), n, sum, n as f64 * DIE));
        all.push(rule(&format!("V[(X₁ + … + X{n})/{n}] = V[X]/{n}"), n, mean, DIE / n as f64));
    }
    all
}

/// Rolls that are kept in memory at once.
const MOST_ROLLS: usize = 1 << 20;

/// `repeats` rolls for each rule: from 2 to 2²⁰.
pub fn variance_rules(repeats: usize, seed: u64) -> Demonstration {
    let repeats = repeats.clamp(2, MOST_ROLLS);
    let mut table = Table::new(["rule", "exact", "measured", "± 95 %", "measured / exact"]);
    for (k, rule) in rules().iter().enumerate() {
        let measured = measured(rule, repeats, sample_key(seed, k as u32, 0));
        let half = 0.5 * (measured.hi - measured.lo);
        let off = (measured.value - rule.exact).abs() > 4.0 * measured.standard_error + 1e-12;
        let ratio = if rule.exact > 0.0 { format!("{:.4}", measured.value / rule.exact) } else { "–".into() };
        table = table.row([
            Cell::from(rule.name.as_str()),
            Cell::from(format!("{:.6}", rule.exact)),
            Cell { text: format!("{:.6}", measured.value), flagged: off },
            Cell::from(format!("{half:.6}")),
            Cell::from(ratio),
        ]);
    }
    let prose = format!(
        "Each rule by {repeats} rolls of fair dice, V[X] = 35/12. A measured value stands out where it is off by \
                         more than four of its standard errors."
    );
    Demonstration {
        title: "variance-rules".into(),
        lead: "Variances add where variables are independent; factors come out squared".into(),
        sections: vec![Part { title: "Rules".into(), prose, table, plots: Vec::new() }],
    }
}

/// Variance over the repeats, with the error √((μ₄ − s⁴)/R).
fn measured(rule: &Rule, repeats: usize, key: u64) -> Estimate {
    let Some(plan) = Points::Independent.plan(repeats, rule.dice) else { return Estimate::mean(&[]) };
    let mut bits = vec![Vec::new(); rule.dice];
    plan.fill(Width::One, key, &mut bits);
    let roll = |i: usize| {
        let rolls: Vec<f64> = bits.iter().map(|row| (6.0 * unit(row[i])).floor() + 1.0).collect();
        (rule.of)(&rolls)
    };
    let values: Vec<f64> = (0..repeats).map(roll).collect();
    let mean = values.iter().sum::<f64>() / repeats as f64;
    let squares: Vec<f64> = values.iter().map(|v| (v - mean) * (v - mean)).collect();
    let biased = Estimate::mean(&squares);
    let unbiased = repeats as f64 / (repeats - 1) as f64;
    Estimate::student(biased.value * unbiased, biased.standard_error * unbiased, biased.dof)
}
