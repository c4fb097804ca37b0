//! The file of closed-form and high-precision values, ../shared/spec/oracles.json.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// One known value. See ../shared/spec/numerics.md for what `abs_tol` leaves out (f32 inputs, standard errors).
#[derive(Clone, Debug)]
pub struct OracleCase {
    pub id: String,
    pub category: String,
    /// The problem, in words.
    pub setup: String,
    pub value: f64,
    /// The error of `value` itself.
    pub abs_tol: f64,
    /// All of the record, for fields only some cases have.
    pub record: serde_json::Value,
}

/// The folder `shared` beside the crate, or up to two levels higher (work trees); None where there is none.
pub fn shared_dir() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.ancestors().skip(1).take(3).map(|d| d.join("shared")).find(|d| d.join("spec/oracles.json").is_file())
}

/// The case of that id. None, after printing the reason, where ../shared is absent; an id that is not in the file is a
/// mistake of the test and panics.
#[track_caller]
pub fn oracle(id: &str) -> Option<OracleCase> {
    let cases = cases()?;
    match cases.by_id.get(id) {
        Some(&i) => Some(cases.list[i].clone()),
        None => panic!("oracles.json has no case {id}"),
    }
}

/// All cases of a category, in file order; none, after printing the reason, where ../shared is absent. A category that
/// the file does not have panics.
#[track_caller]
pub fn oracles_in(category: &str) -> Vec<OracleCase> {
    let Some(cases) = cases() else { return Vec::new() };
    let found: Vec<_> = cases.list.iter().filter(|c| c.category == category).cloned().collect();
    assert!(!found.is_empty(), "oracles.json has no category {category:?}");
    found
}

struct Cases {
    list: Vec<OracleCase>,
    by_id: HashMap<String, usize>,
}

fn cases() -> Option<&'static Cases> {
    static CASES: OnceLock<Option<Cases>> = OnceLock::new();
    let cases = CASES.get_or_init(|| shared_dir().map(|dir| read(&dir.join("spec/oracles.json"))));
    if cases.is_none() {
        eprintln!("skipped: ../shared/spec/oracles.json is absent");
    }
    cases.as_ref()
}

fn read(path: &Path) -> Cases {
    let text = std::fs::read_to_string(path).expect("oracles.json is readable");
    let records: Vec<serde_json::Value> = serde_json::from_str(&text).expect("oracles.json is a list");
    let list: Vec<OracleCase> = records.into_iter().map(case).collect();
    let by_id = list.iter().enumerate().map(|(i, c)| (c.id.clone(), i)).collect();
    Cases { list, by_id }
}

fn case(record: serde_json::Value) -> OracleCase {
    let text = |key: &str| record[key].as_str().unwrap_or_else(|| panic!("{record}: no {key}")).to_string();
    let number = |key: &str| record[key].as_f64().unwrap_or_else(|| panic!("{record}: no {key}"));
    OracleCase {
        id: text("id"),
        category: text("category"),
        setup: text("setup"),
        value: number("value"),
        abs_tol: number("abs_tol"),
        record,
    }
}
