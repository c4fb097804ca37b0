//! A rectangle of the film, filled by one thread at a time.

use super::blocks::{BLOCK, BlockTree};
use super::discarded::{Discarded, DiscardedSample};
use super::error::MergeError;
use super::pixel::PixelSums;
use super::slot::{AovSample, COLOUR_SUMS, FilmChannels, MOST_SUMS};

/// Pixels `[x, x + width) × [y, y + height)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// First column.
    pub x: u32,
    /// First row, from the top.
    pub y: u32,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

impl Rect {
    /// How many pixels it has.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Row-major index of a pixel inside the rectangle, given in image coordinates.
    pub fn index_of(self, x: u32, y: u32) -> usize {
        (y - self.y) as usize * self.width as usize + (x - self.x) as usize
    }
}

/// Sums of the samples of one rectangle of pixels: whole blocks in a dyadic tree and the block under way.
#[derive(Clone, Debug, PartialEq)]
pub struct TileFilm {
    rect: Rect,
    channels: FilmChannels,
    pub(super) whole: BlockTree,
    /// Sums of the block that holds `next_sample`, pixel after pixel; at a block's start zeros, or not allocated.
    pub(super) partial: Vec<f64>,
    /// Largest sample of each pixel and channel, in size; allocated with the first block.
    pub(super) largest: Vec<[f32; 3]>,
    pub(super) next_sample: u64,
    pub(super) discarded: Discarded,
}

impl TileFilm {
    /// An empty tile whose first sample will be number `64 · first_block`.
    pub fn new(rect: Rect, channels: FilmChannels, first_block: u64) -> Self {
        Self {
            rect,
            channels,
            whole: BlockTree::default(),
            partial: Vec::new(),
            largest: Vec::new(),
            next_sample: first_block * BLOCK,
            discarded: Discarded::default(),
        }
    }

    /// Where it is on the film.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// Kept of each sample.
    pub fn channels(&self) -> FilmChannels {
        self.channels
    }

    /// The number that the next sample must have.
    pub fn next_sample(&self) -> u64 {
        self.next_sample
    }

    /// Samples held for every pixel.
    pub fn samples(&self) -> u64 {
        self.whole.block_count() * BLOCK + self.next_sample % BLOCK
    }

    /// What was dropped.
    pub fn discarded(&self) -> &Discarded {
        &self.discarded
    }

    /// Adds samples `first_sample … first_sample + count − 1` of every pixel, in that order.
    ///
    /// Slots are pixel after pixel (rows from the top), and each pixel's samples in order: sample `first_sample + s` of
    /// pixel `p` is `radiance[p · count + s]`. One slot's three channels share a cache line, since that is how a path
    /// that ended writes them. `aovs` has the same layout, or is empty on a film without AOVs. A call may cross block
    /// boundaries; cutting it in two anywhere gives the same bits. A sample that is not finite counts as zero and goes
    /// to [`Self::discarded`].
    ///
    /// # Panics
    /// If `first_sample` is not [`Self::next_sample`], or a slice has not one slot for each pixel and sample: a fault of
    /// the caller, which would otherwise spoil the image silently.
    pub fn add_samples(&mut self, first_sample: u64, count: usize, radiance: &[[f32; 3]], aovs: &[AovSample]) {
        assert_eq!(first_sample, self.next_sample, "samples are added in order");
        let slots = self.rect.pixels() * count;
        assert_eq!(radiance.len(), slots, "one radiance slot for each pixel and sample");
        let aov_slots = if self.channels.has_aovs() { slots } else { 0 };
        assert_eq!(aovs.len(), aov_slots, "one AOV slot for each pixel and sample, if the film keeps them");

        let mut offset = 0;
        while offset < count {
            let room = (BLOCK - self.next_sample % BLOCK) as usize;
            let length = room.min(count - offset);
            let part = Part { count, offset, length };
            self.begin_block_if_none();
            self.add_radiance(part, radiance);
            self.add_aovs(part, aovs);
            self.next_sample += length as u64;
            self.finish_block_if_full();
            offset += length;
        }
    }

    /// Sums of one pixel, given in image coordinates inside [`Self::rect`]: whole blocks from the lowest to the
    /// highest, then the block under way.
    pub fn pixel(&self, x: u32, y: u32) -> PixelSums {
        let stride = self.channels.stride();
        let at = self.rect.index_of(x, y) * stride;
        let mut total = [0.0; MOST_SUMS];
        let partial = (!self.partial.is_empty()).then_some(self.partial.as_slice());
        for sums in self.whole.sums().chain(partial) {
            for (t, s) in total.iter_mut().zip(&sums[at..at + stride]) {
                *t += s;
            }
        }
        PixelSums::new(self.samples(), &total, self.channels)
    }

    /// Adds to every pixel's mean an estimate of something else, with its variance (`of` a place in the image, by channel), and that
    /// to the variance of the mean. Nothing can be added after it.
    pub fn add_estimate(&mut self, of: impl Fn(u32, u32) -> [[f64; 2]; 3]) {
        let (Rect { x, y, width, height }, stride, n) = (self.rect, self.channels.stride(), self.samples() as f64);
        for (x, y) in (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y))) {
            let (at, now, added) = (self.rect.index_of(x, y) * stride, self.pixel(x, y).sum, of(x, y));
            let whole = self.whole.nodes.last_mut().map(|node| &mut node.sums);
            let Some(sums) = (if self.partial.is_empty() { whole } else { Some(&mut self.partial) }) else { return };
            for (c, [mean, variance]) in added.into_iter().enumerate() {
                let sum = mean * n;
                sums[at + c] += sum;
                // So that n Σx² − (Σx)² grows by n² (n − 1) times the variance.
                sums[at + 3 + c] += sum * (2.0 * now[c] + sum) / n + variance * n * (n - 1.0);
            }
        }
    }

    /// The largest sample of one pixel, channel by channel, in size; 0 without samples.
    pub fn largest(&self, x: u32, y: u32) -> [f32; 3] {
        self.largest.get(self.rect.index_of(x, y)).copied().unwrap_or_default()
    }

    /// Takes over the samples of the same tile that were rendered elsewhere. The bits are those of one tile that was
    /// given all the samples; ranges may come in any order and leave gaps.
    ///
    /// # Errors
    /// The tiles differ in place or channels, both hold some block, or a block that is not the last is unfinished.
    /// `self` is then left as it was.
    pub fn merge(&mut self, other: Self) -> Result<(), MergeError> {
        if (self.rect, self.channels) != (other.rect, other.channels) {
            return Err(MergeError::Shape);
        }
        if other.samples() == 0 {
            return Ok(());
        }
        if self.samples() == 0 {
            *self = other;
            return Ok(());
        }
        self.refuse_unfinished_inner_block(&other)?;
        other.refuse_unfinished_inner_block(self)?;
        self.whole.absorb(other.whole)?;
        if !self.is_inside_block() {
            self.partial = other.partial;
        }
        for (largest, theirs) in self.largest.iter_mut().zip(other.largest) {
            *largest = larger(*largest, theirs);
        }
        self.next_sample = self.next_sample.max(other.next_sample);
        self.discarded.absorb(&other.discarded);
        Ok(())
    }

    /// An unfinished block must come after all that `other` holds, or the order of additions would not be the one of
    /// a single render.
    fn refuse_unfinished_inner_block(&self, other: &Self) -> Result<(), MergeError> {
        if !self.is_inside_block() {
            return Ok(());
        }
        let block = self.next_sample / BLOCK;
        let first_sample = block * BLOCK;
        let other_partial = other.is_inside_block().then_some(other.next_sample / BLOCK);
        if other_partial == Some(block) || other.whole.contains(block) {
            return Err(MergeError::Overlap { first_sample });
        }
        let later = other.whole.end_block().is_some_and(|end| end > block) || other_partial.is_some_and(|b| b > block);
        if later { Err(MergeError::UnfinishedBlock { first_sample }) } else { Ok(()) }
    }

    /// Has a block been begun and not finished?
    pub(super) fn is_inside_block(&self) -> bool {
        !self.next_sample.is_multiple_of(BLOCK)
    }

    /// Makes room for the next sample, so that adding it does not wait for memory.
    pub fn begin(&mut self) {
        self.begin_block_if_none();
    }

    fn begin_block_if_none(&mut self) {
        if self.partial.is_empty() {
            self.partial = vec![0.0; self.rect.pixels() * self.channels.stride()];
        }
        if self.largest.is_empty() {
            self.largest = vec![[0.0; 3]; self.rect.pixels()];
        }
    }

    fn finish_block_if_full(&mut self) {
        if self.next_sample.is_multiple_of(BLOCK) {
            self.whole.push(self.next_sample / BLOCK - 1, std::mem::take(&mut self.partial));
        }
    }

    fn add_radiance(&mut self, part: Part, radiance: &[[f32; 3]]) {
        let stride = self.channels.stride();
        let pixels = self.partial.chunks_exact_mut(stride).zip(&mut self.largest);
        for (pixel, (sums, largest)) in pixels.enumerate() {
            let slots = part.slots(pixel, radiance);
            let Some(sums) = sums.first_chunk_mut() else { continue };
            let all_finite = sum_finite(sums, slots);
            let finite = slots.iter().filter(|slot| all_finite || is_finite(slot));
            *largest = finite.fold(*largest, |largest, slot| larger(largest, slot.map(f32::abs)));
            if all_finite {
                continue;
            }
            let (column, row) = (pixel as u32 % self.rect.width, pixel as u32 / self.rect.width);
            let dropped = slots.iter().enumerate().filter(|(_, value)| !is_finite(value));
            for (s, _) in dropped {
                let sample = self.next_sample + s as u64;
                self.discarded.record(DiscardedSample { x: self.rect.x + column, y: self.rect.y + row, sample });
            }
        }
    }

    fn add_aovs(&mut self, part: Part, aovs: &[AovSample]) {
        if !self.channels.has_aovs() {
            return;
        }
        for (pixel, sums) in self.partial.chunks_exact_mut(self.channels.stride()).enumerate() {
            for slot in part.slots(pixel, aovs) {
                let values = slot.values();
                if !values.iter().all(|value| value.is_finite()) {
                    self.discarded.aov_count += 1;
                    continue;
                }
                for (sum, value) in sums[COLOUR_SUMS..].iter_mut().zip(values) {
                    *sum += f64::from(value);
                }
            }
        }
    }
}

/// The samples `offset … offset + length` of the `count` that a call brings for each pixel: those of one block.
#[derive(Clone, Copy)]
struct Part {
    count: usize,
    offset: usize,
    length: usize,
}

impl Part {
    fn slots<T>(self, pixel: usize, all: &[T]) -> &[T] {
        let start = pixel * self.count + self.offset;
        &all[start..start + self.length]
    }
}

/// Adds the slots in order; the finite ones alone if some are not, and then says false.
fn sum_finite(sums: &mut [f64; COLOUR_SUMS], slots: &[[f32; 3]]) -> bool {
    let total = add_slots(*sums, slots);
    // One test for all: sums of finite f32 and of their squares cannot overflow f64, and NaN or ∞ stays in them.
    let all_finite = total[3..].iter().all(|sum| sum.is_finite());
    *sums = if all_finite {
        total
    } else {
        slots.iter().filter(|slot| is_finite(slot)).fold(*sums, |sums, slot| add_slots(sums, &[*slot]))
    };
    all_finite
}

fn add_slots(mut sums: [f64; COLOUR_SUMS], slots: &[[f32; 3]]) -> [f64; COLOUR_SUMS] {
    for slot in slots {
        for c in 0..3 {
            let value = f64::from(slot[c]);
            sums[c] += value;
            // The square of an f32 is exact in f64.
            sums[3 + c] += value * value;
        }
    }
    sums
}

/// Channel by channel, of finite numbers.
fn larger(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|c| if b[c] > a[c] { b[c] } else { a[c] })
}

fn is_finite(radiance: &[f32; 3]) -> bool {
    radiance.iter().all(|value| value.is_finite())
}
