//! The catalogue of `octolux check --numerics` at its shortest: every case, fewer samples.

mod naive;

use octolux::check::numerics::{self, Effort, Row, ulp};
use octolux::render;

/// The two longest parts of the catalogue's cases run beside each other: all groups share a pool of their own.
#[test]
fn every_case_keeps_its_bound() {
    let pool = render::thread_pool(2).expect("threads");
    let report = numerics::run(Effort::Quick, "", &pool, |_| ());
    for row in report.rows.iter().filter(|row| !row.pass) {
        println!("{row:?}");
    }
    assert!(report.pass, "{} of {} cases fail", report.rows.iter().filter(|r| !r.pass).count(), report.rows.len());
    assert!(report.rows.iter().all(|row| row.count > 0));
}

/// What a row must not let through.
#[test]
fn rows_fail_on_nan_and_on_nothing_tried() {
    assert!(Row::new("g", "c", 1, 1.0, 1.0, "ulp").pass);
    assert!(!Row::new("g", "c", 1, 1.1, 1.0, "ulp").pass);
    assert!(!Row::new("g", "c", 1, f64::NAN, 1.0, "ulp").pass);
    assert!(!Row::new("g", "c", 0, 0.0, 1.0, "ulp").pass);
    assert!(!Row::never("g", "c", 5, 1, "misses").pass);
}

#[test]
fn errors_are_counted_in_units_of_the_exact_result() {
    assert_eq!(ulp::spacing(1.0), f64::from(f32::EPSILON));
    assert_eq!(ulp::spacing(0.999), f64::from(f32::EPSILON) / 2.0);
    assert_eq!(ulp::spacing(1e-42), 2f64.powi(-149));
    assert_eq!(ulp::error(1.0f32.next_up(), 1.0), 1.0);
    assert_eq!(ulp::error(f32::INFINITY, 1e30), f64::INFINITY);
    assert_eq!(ulp::error(f32::NAN, 1.0), f64::INFINITY);
    assert_eq!(ulp::error(f32::NAN, f64::NAN), 0.0);
    assert_eq!(ulp::rounded_to_infinity(3.4028235e38), 3.4028235e38);
    assert_eq!(ulp::rounded_to_infinity(-3.4028236e38), f64::NEG_INFINITY);
}
