//! A binary tree as one list, every node before those below it: what is computed from the leaves up or the root down then
//! reads memory in order, and subtrees are ranges of the list, which threads can share out.

use obvhs::bvh2::Bvh2;
use rayon::prelude::*;
use std::ops::Range;

/// Binary trees of fewer leaves stay in one part.
const WORTH_SHARING: usize = 2048;

/// How far below the root the parts of a shared tree begin: at most 2⁷ of them.
const SHARED_DEPTH: usize = 7;

/// A full binary tree of at most 2²⁸ leaves.
pub struct Preorder {
    /// Of an inner node where its subtree ends; of a leaf [`LEAF`] and its primitive.
    words: Vec<u32>,
    /// Subtrees that together are all of the tree but the nodes above them, in order. The same whatever the threads.
    pub parts: Vec<Range<usize>>,
}

const LEAF: u32 = 1 << 31;

impl Preorder {
    /// Of a tree with one primitive a leaf.
    pub fn new(tree: &Bvh2) -> Self {
        let depth = if tree.nodes.len() < 2 * WORTH_SHARING { 0 } else { SHARED_DEPTH };
        let mut roots = Vec::new();
        part_roots(tree, 0, depth, &mut roots);
        let lists: Vec<Vec<u32>> = roots.into_par_iter().map(|root| subtree(tree, root)).collect();
        let mut order = Self { words: Vec::with_capacity(tree.nodes.len()), parts: Vec::with_capacity(lists.len()) };
        order.append(tree, 0, depth, &mut lists.into_iter());
        order
    }

    /// The nodes above parts, and those of the next parts in between.
    fn append(&mut self, tree: &Bvh2, node: usize, depth: usize, lists: &mut impl Iterator<Item = Vec<u32>>) {
        let first = self.words.len();
        if depth == 0 || tree.nodes[node].is_leaf() {
            let moved = |word: u32| if word & LEAF != 0 { word } else { word + first as u32 };
            self.words.extend(lists.next().into_iter().flatten().map(moved));
            return self.parts.push(first..self.words.len());
        }
        self.words.push(0);
        for child in children(tree, node) {
            self.append(tree, child, depth - 1, lists);
        }
        self.words[first] = self.words.len() as u32;
    }

    pub fn len(&self) -> usize {
        self.words.len()
    }
    /// The primitive of a leaf.
    pub fn primitive(&self, node: usize) -> Option<u32> {
        let word = self.words[node];
        (word & LEAF != 0).then_some(word & !LEAF)
    }
    pub fn children(&self, node: usize) -> [usize; 2] {
        [node + 1, self.end(node + 1)]
    }
    fn end(&self, node: usize) -> usize {
        if self.primitive(node).is_some() { node + 1 } else { self.words[node] as usize }
    }
    /// Primitives below a node.
    pub fn primitives(&self, node: usize) -> impl Iterator<Item = u32> {
        (node..self.end(node)).filter_map(|node| self.primitive(node))
    }
}

fn children(tree: &Bvh2, node: usize) -> [usize; 2] {
    let first = tree.nodes[node].first_index as usize;
    [first, first + 1]
}

fn part_roots(tree: &Bvh2, node: usize, depth: usize, roots: &mut Vec<usize>) {
    if depth == 0 || tree.nodes[node].is_leaf() {
        return roots.push(node);
    }
    for child in children(tree, node) {
        part_roots(tree, child, depth - 1, roots);
    }
}

/// [`Preorder::words`] of the subtree below `root`, as if it were all.
fn subtree(tree: &Bvh2, root: usize) -> Vec<u32> {
    let mut words = Vec::new();
    // Nodes to list, and inner nodes (by place in the list) that end there.
    let mut stack = vec![(root, false)];
    while let Some((node, ends)) = stack.pop() {
        if ends {
            words[node] = words.len() as u32;
        } else if tree.nodes[node].is_leaf() {
            words.push(LEAF | tree.primitive_indices[tree.nodes[node].first_index as usize]);
        } else {
            let [left, right] = children(tree, node);
            stack.extend([(words.len(), true), (right, false), (left, false)]);
            words.push(0);
        }
    }
    words
}
