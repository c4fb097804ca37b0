//! From a binary tree to eight-wide nodes, by exact dynamic programming over the surface-area cost
//! (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", §3.1).

use super::node::{Child, Node};
use super::tree::{MAX_DEPTH, Tree};
use crate::geometry::Bounds;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};

/// Cost of visiting a node and a block of eight, per half area; only the ratio matters. Found by measuring.
const NODE_COST: f32 = 1.0;
const BLOCK_COST: f32 = 1.4;

/// Below this many nodes of the longest way down the optimal choice gives way to balanced halving, so that no input
/// (a binary tree can be a list) makes a tree deeper than [`MAX_DEPTH`]: what is left, at most 2²⁸ primitives, is
/// divided by eight at each further node, nine times until a block holds it.
const FREE_DEPTH: usize = MAX_DEPTH - 11;

/// What is known of the subtree below a binary inner node.
#[derive(Clone, Copy)]
struct Subtree {
    /// `cost[j − 1]`: cheapest way to stand for it by at most j roots, j = 1 … 7.
    cost: [f32; 7],
    /// Number of primitives, 255 for more.
    count: u8,
}

struct Collapse<'a, F> {
    tree: &'a Bvh2,
    /// Own boxes by primitive.
    boxes: &'a [Bounds],
    /// By node of `tree`.
    bounds: Vec<Bounds>,
    /// By [`slot`].
    subtrees: Vec<Subtree>,
    block: F,
}

/// A wide child still to be made.
enum Pending {
    Subtree(usize),
    Primitives(Vec<u32>),
}

/// Makes the wide tree of `tree`, which has one primitive a leaf and more than eight leaves. The boxes are rebuilt from
/// `boxes`, those of the primitives.
pub fn collapse<B, F: FnMut(&[u32]) -> B>(tree: &Bvh2, boxes: &[Bounds], block: F) -> Tree<B> {
    let mut state = Collapse { tree, boxes, bounds: Vec::new(), subtrees: Vec::new(), block };
    state.costs();
    state.emit()
}

impl<B, F: FnMut(&[u32]) -> B> Collapse<'_, F> {
    fn children(&self, node: usize) -> [usize; 2] {
        let first = self.tree.nodes[node].first_index as usize;
        [first, first + 1]
    }
    /// Children come in pairs from 1 on, so (first child − 1)/2 numbers inner nodes without gaps.
    fn slot(&self, node: usize) -> usize {
        (self.tree.nodes[node].first_index as usize - 1) / 2
    }
    /// The primitive of a leaf.
    fn primitive(&self, leaf: &Bvh2Node) -> usize {
        self.tree.primitive_indices[leaf.first_index as usize] as usize
    }
    fn is_leaf(&self, node: usize) -> bool {
        self.tree.nodes[node].is_leaf()
    }
    fn count(&self, node: usize) -> usize {
        if self.is_leaf(node) { 1 } else { self.subtrees[self.slot(node)].count as usize }
    }
    /// Cheapest way to stand for `node` by at most `roots` roots.
    fn cost(&self, node: usize, roots: usize) -> f32 {
        if self.is_leaf(node) {
            self.bounds[node].half_area() * BLOCK_COST
        } else {
            self.subtrees[self.slot(node)].cost[roots - 1]
        }
    }
    /// Cheapest way to share `roots` ≥ 2 roots between the children: how many go left, and the cost.
    fn share(&self, node: usize, roots: usize) -> (usize, f32) {
        let [l, r] = self.children(node);
        let options = (1..roots).map(|k| (k, self.cost(l, k.min(7)) + self.cost(r, (roots - k).min(7))));
        options.fold((1, f32::INFINITY), |best, option| if option.1 < best.1 { option } else { best })
    }

    /// Fills `bounds` and `subtrees` from the leaves up.
    fn costs(&mut self) {
        let nodes = &self.tree.nodes;
        let mut order = Vec::with_capacity(nodes.len() / 2);
        let mut stack = vec![0];
        while let Some(node) = stack.pop() {
            if !self.is_leaf(node) {
                order.push(node);
                stack.extend(self.children(node));
            }
        }
        let own = |n: &Bvh2Node| if n.is_leaf() { self.boxes[self.primitive(n)] } else { Bounds::EMPTY };
        self.bounds = nodes.iter().map(own).collect();
        self.subtrees = vec![Subtree { cost: [0.0; 7], count: 0 }; nodes.len() / 2];
        for node in order.into_iter().rev() {
            let [l, r] = self.children(node);
            // Exact unions: the proof in `geometry` leans on it.
            self.bounds[node] = self.bounds[l].union(&self.bounds[r]);
            let area = self.bounds[node].half_area();
            let count = (self.count(l) + self.count(r)).min(255);
            let as_node = self.share(node, 8).1 + area * NODE_COST;
            let as_block = if count <= 8 { area * BLOCK_COST } else { f32::INFINITY };
            let mut cost = [as_node.min(as_block); 7];
            for roots in 2..=7 {
                cost[roots - 1] = self.share(node, roots).1.min(cost[roots - 2]);
            }
            let slot = self.slot(node);
            self.subtrees[slot] = Subtree { cost, count: count as u8 };
        }
    }

    /// Appends the roots that stand for `node`, at most `roots`.
    fn roots(&self, node: usize, roots: usize, out: &mut Vec<usize>) {
        if roots == 1 || self.is_leaf(node) {
            return out.push(node);
        }
        if self.cost(node, roots) == self.cost(node, roots - 1) {
            return self.roots(node, roots - 1, out);
        }
        self.split(node, roots, out);
    }
    fn split(&self, node: usize, roots: usize, out: &mut Vec<usize>) {
        let [l, r] = self.children(node);
        let left = self.share(node, roots).0;
        self.roots(l, left.min(7), out);
        self.roots(r, (roots - left).min(7), out);
    }

    /// Primitives below `node`, in the order of the tree.
    fn primitives(&self, node: usize) -> Vec<u32> {
        let mut out = Vec::new();
        let mut stack = vec![node];
        while let Some(node) = stack.pop() {
            if self.is_leaf(node) {
                out.push(self.primitive(&self.tree.nodes[node]) as u32);
            } else {
                let [l, r] = self.children(node);
                stack.extend([r, l]);
            }
        }
        out
    }

    /// Nodes and blocks depth first, so that a way down stays close in memory.
    fn emit(mut self) -> Tree<B> {
        let mut out = Tree { root: Child::node(0), ..Tree::default() };
        // (what, nodes above it, node and slot that refer to it)
        let mut stack = vec![(Pending::Subtree(0), 0, None::<(usize, usize)>)];
        while let Some((pending, above, parent)) = stack.pop() {
            let child = match self.as_block(&pending) {
                Some(mut ids) => {
                    // The lower of equals is then the first.
                    ids.sort_unstable();
                    out.blocks.push((self.block)(&ids));
                    Child::leaf(out.blocks.len() - 1)
                }
                None => {
                    let parts = self.parts(pending, above);
                    let bounds: Vec<_> = parts.iter().map(|part| (Child(0), self.part_bounds(part))).collect();
                    let index = out.nodes.len();
                    out.nodes.push(Node::new(&bounds));
                    out.depth = out.depth.max(above + 1);
                    let parts = parts.into_iter().enumerate().rev();
                    stack.extend(parts.map(|(slot, part)| (part, above + 1, Some((index, slot)))));
                    Child::node(index)
                }
            };
            match parent {
                Some((node, slot)) => out.nodes[node].children[slot] = child.0,
                None => out.root = child,
            }
        }
        out
    }

    /// The primitives, where the pending child is best made a block.
    fn as_block(&self, pending: &Pending) -> Option<Vec<u32>> {
        match pending {
            Pending::Primitives(ids) => (ids.len() <= 8).then(|| ids.clone()),
            Pending::Subtree(node) => {
                let fits = self.count(*node) <= 8;
                let block = fits && self.cost(*node, 1) >= self.bounds[*node].half_area() * BLOCK_COST;
                block.then(|| self.primitives(*node))
            }
        }
    }

    /// The children of a pending child that is to be a node.
    fn parts(&self, pending: Pending, above: usize) -> Vec<Pending> {
        match pending {
            Pending::Subtree(node) if above < FREE_DEPTH => {
                let mut roots = Vec::with_capacity(8);
                self.split(node, 8, &mut roots);
                roots.into_iter().map(Pending::Subtree).collect()
            }
            Pending::Subtree(node) => halve(self.primitives(node)),
            Pending::Primitives(ids) => halve(ids),
        }
    }

    fn part_bounds(&self, part: &Pending) -> Bounds {
        match part {
            Pending::Subtree(node) => self.bounds[*node],
            Pending::Primitives(ids) => ids.iter().fold(Bounds::EMPTY, |all, id| all.union(&self.boxes[*id as usize])),
        }
    }
}

/// Eight parts of nearly equal length, more than eight primitives.
fn halve(ids: Vec<u32>) -> Vec<Pending> {
    let size = ids.len().div_ceil(8);
    ids.chunks(size).map(|part| Pending::Primitives(part.to_vec())).collect()
}
