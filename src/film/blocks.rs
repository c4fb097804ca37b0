//! Sums of whole blocks of samples, combined by a dyadic tree.
//!
//! Block `i` holds samples `[64 i, 64 (i + 1))`. A node of level `l` and index `k` holds the blocks
//! `[k·2^l, (k + 1)·2^l)`; it is made from its two halves as left + right, and only so. Which additions happen, and in
//! which association, is therefore fixed by the set of blocks: blocks may arrive one after another, or as ranges
//! rendered elsewhere and merged in any order, and every bit is the same. It is also pairwise summation, whose
//! rounding error grows with log₂ of the block count (Higham 1993, "The accuracy of floating point summation", §3).

use super::error::MergeError;

/// Samples in a block. A pixel's sum of one block is a plain f64 loop in sample order.
pub const BLOCK: u64 = 64;

/// Sums of `2^level` adjacent blocks, for every pixel of a tile.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node {
    pub level: u32,
    pub index: u64,
    pub sums: Vec<f64>,
}

impl Node {
    fn first_block(&self) -> u64 {
        self.index << self.level
    }

    fn end_block(&self) -> u64 {
        (self.index + 1) << self.level
    }

    fn is_left_sibling_of(&self, right: &Self) -> bool {
        self.level == right.level && self.index.is_multiple_of(2) && right.index == self.index + 1
    }
}

/// Disjoint dyadic nodes in increasing block order, no two of them siblings.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BlockTree {
    pub nodes: Vec<Node>,
}

impl BlockTree {
    /// Adds the sums of one whole block that lies after all blocks held.
    pub fn push(&mut self, block: u64, sums: Vec<f64>) {
        debug_assert!(self.end_block().is_none_or(|end| end <= block));
        self.nodes.push(Node { level: 0, index: block, sums });
        self.merge_siblings_at_end();
    }

    /// Adds a node as it was in another tree: one that lies after all nodes held and is no sibling of the last. `None`
    /// if it is neither or no sample number can be that high.
    pub fn append(&mut self, node: Node) -> Option<()> {
        let end = node.index.checked_add(1).filter(|_| node.level < 32)?.checked_mul(1 << node.level)?;
        let after = self.nodes.last().is_none_or(|last| last.end_block() <= node.first_block());
        let sibling = self.nodes.last().is_some_and(|last| last.is_left_sibling_of(&node));
        (after && !sibling && end <= 1 << 32).then(|| self.nodes.push(node))
    }

    /// Takes over the nodes of another tree.
    ///
    /// # Errors
    /// Both trees hold some block; `self` is then left as it was.
    pub fn absorb(&mut self, other: Self) -> Result<(), MergeError> {
        if let Some(block) = self.first_common_block(&other) {
            return Err(MergeError::Overlap { first_sample: block * BLOCK });
        }
        let mut nodes = std::mem::take(&mut self.nodes);
        nodes.extend(other.nodes);
        nodes.sort_by_key(Node::first_block);
        for node in nodes {
            self.nodes.push(node);
            self.merge_siblings_at_end();
        }
        Ok(())
    }

    /// Whole blocks held.
    pub fn block_count(&self) -> u64 {
        self.nodes.iter().map(|node| 1 << node.level).sum()
    }

    /// One past the last block held.
    pub fn end_block(&self) -> Option<u64> {
        self.nodes.last().map(Node::end_block)
    }

    /// True if `block` is in one of the nodes.
    pub fn contains(&self, block: u64) -> bool {
        self.nodes.iter().any(|node| (node.first_block()..node.end_block()).contains(&block))
    }

    /// True if each block of `other` is in one of the nodes.
    pub fn covers(&self, other: &Self) -> bool {
        let inside = |node: &Node| {
            let (first, end) = (node.first_block(), node.end_block());
            let common = |own: &Node| own.end_block().min(end).saturating_sub(own.first_block().max(first));
            self.nodes.iter().map(common).sum::<u64>() == end - first
        };
        other.nodes.iter().all(inside)
    }

    /// Each node's sums, from the lowest block to the highest: the order in which a total is taken.
    pub fn sums(&self) -> impl Iterator<Item = &[f64]> {
        self.nodes.iter().map(|node| node.sums.as_slice())
    }

    fn merge_siblings_at_end(&mut self) {
        while let [.., left, right] = self.nodes.as_mut_slice()
            && left.is_left_sibling_of(right)
        {
            for (l, r) in left.sums.iter_mut().zip(&right.sums) {
                *l += r;
            }
            left.level += 1;
            left.index /= 2;
            self.nodes.pop();
        }
    }

    fn first_common_block(&self, other: &Self) -> Option<u64> {
        let pairs = self.nodes.iter().flat_map(|a| other.nodes.iter().map(move |b| (a, b)));
        pairs
            .filter(|(a, b)| a.first_block() < b.end_block() && b.first_block() < a.end_block())
            .map(|(a, b)| a.first_block().max(b.first_block()))
            .min()
    }
}
