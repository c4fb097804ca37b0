//! Samples that were not finite: dropped, counted, and the first few remembered so that they can be replayed.

use serde::Serialize;

/// How many dropped samples are remembered by name.
pub const REMEMBERED: usize = 16;

/// Where a dropped sample was: enough to replay its path. Ordered by sample, then row, then column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct DiscardedSample {
    /// Column, from the left.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// Index of the sample.
    pub sample: u64,
}

impl DiscardedSample {
    fn key(&self) -> (u64, u32, u32) {
        (self.sample, self.y, self.x)
    }
}

/// A dropped sample counts as zero radiance: the sample count of its pixel stays, so that the mean is what a path
/// that carried nothing would have given.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Discarded {
    /// Samples whose radiance was NaN or infinite in some channel.
    pub count: u64,
    /// Samples of which some AOV was not finite; their radiance is kept.
    pub aov_count: u64,
    /// The lowest [`REMEMBERED`] samples of `count`, in order: the same whatever the tile size and thread count.
    pub first: Vec<DiscardedSample>,
}

impl Discarded {
    pub(crate) fn record(&mut self, sample: DiscardedSample) {
        self.count += 1;
        self.remember(sample);
    }

    /// Adds what another part of the same film dropped.
    pub fn absorb(&mut self, other: &Self) {
        self.count += other.count;
        self.aov_count += other.aov_count;
        other.first.iter().for_each(|&sample| self.remember(sample));
    }

    fn remember(&mut self, sample: DiscardedSample) {
        let at = self.first.partition_point(|known| known.key() <= sample.key());
        if at < REMEMBERED {
            self.first.insert(at, sample);
            self.first.truncate(REMEMBERED);
        }
    }
}
