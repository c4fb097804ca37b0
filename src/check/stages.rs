//! Every tapped value of every path: random numbers, hits, pdfs, weights, contributions.

use crate::kernel::{Counters, Job, Record, Recorder, SampleBuffer, Stage, Width, World, select_recording};

/// The first value of a sample that is not what width 1 computes.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Difference {
    pub x: u32,
    pub y: u32,
    pub sample: u32,
    pub bounce: u32,
    pub stage: Stage,
    pub lanes: usize,
    pub lane: u32,
    pub expected_bits: u32,
    /// `None`: the path ended earlier.
    pub found_bits: Option<u32>,
}

/// What was compared.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct StageReport {
    pub values: u64,
    pub samples: u64,
    pub differing_samples: u64,
    /// Values that were disturbed on purpose.
    pub faults: u64,
    pub first: Option<Difference>,
}

/// Records a job at a width.
pub fn record_tile(world: &World, job: &Job, width: Width, fault: Option<Stage>) -> Recorder {
    let mut recorder = Recorder::new(job.slots(), fault);
    let mut out = SampleBuffer::default();
    out.reset(job.slots(), false);
    select_recording(world, width)(world, job, &mut out, &mut Counters::default(), &mut recorder);
    recorder
}

/// Compares `found` at each of `widths` with `expected` at width 1, over the whole film. A fault is injected into
/// `found` only.
pub fn compare_stages(
    expected: &World,
    found: &World,
    widths: &[Width],
    samples: u32,
    fault: Option<Stage>,
) -> StageReport {
    const TILE: u32 = 32;
    let mut report = StageReport::default();
    let film = expected.film;
    for y in (0..film.height).step_by(TILE as usize) {
        for x in (0..film.width).step_by(TILE as usize) {
            let (width, height) = (TILE.min(film.width - x), TILE.min(film.height - y));
            let job = Job { x, y, width, height, first_sample: 0, samples };
            let reference = record_tile(expected, &job, Width::One, None);
            for &lanes in widths {
                let other = record_tile(found, &job, lanes, fault);
                report.faults += other.faults;
                compare_tile(&job, lanes, &reference, &other, &mut report);
            }
        }
    }
    report
}

fn compare_tile(job: &Job, width: Width, expected: &Recorder, found: &Recorder, report: &mut StageReport) {
    for (slot, (a, b)) in expected.records.iter().zip(&found.records).enumerate() {
        report.samples += 1;
        report.values += a.len() as u64;
        let Some((expected, found)) = first_difference(a, b) else { continue };
        report.differing_samples += 1;
        let pixel = slot as u32 / job.samples;
        report.first.get_or_insert(Difference {
            x: job.x + pixel % job.width,
            y: job.y + pixel / job.width,
            sample: job.first_sample + slot as u32 % job.samples,
            bounce: expected.bounce,
            stage: expected.stage,
            lanes: width.lanes(),
            lane: found.map_or(0, |r| r.lane),
            expected_bits: expected.bits,
            found_bits: found.map(|r| r.bits),
        });
    }
}

/// The first place where two records of a path part; where one merely goes on longer, its next value.
fn first_difference(a: &[Record], b: &[Record]) -> Option<(Record, Option<Record>)> {
    let same = |r: &Record, s: &Record| (r.bounce, r.stage, r.bits) == (s.bounce, s.stage, s.bits);
    let at = (0..a.len().max(b.len())).find(|&i| match (a.get(i), b.get(i)) {
        (Some(r), Some(s)) => !same(r, s),
        _ => true,
    })?;
    match (a.get(at), b.get(at)) {
        (Some(r), s) => Some((*r, s.copied())),
        (None, Some(s)) => Some((Record { bits: 0, ..*s }, Some(*s))),
        (None, None) => None,
    }
}
