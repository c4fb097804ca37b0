//! From a binary tree to eight-wide nodes, by exact dynamic programming over the surface-area cost
//! (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", §3.1).

use super::preorder::Preorder;
use crate::geometry::Bounds;
use crate::lane::array::from_fn;
use rayon::prelude::*;

/// Cost of visiting a node and a block of eight, per half area; only the ratio matters. Found by measuring.
const NODE_COST: f32 = 1.0;
const BLOCK_COST: f32 = 1.4;

/// A binary tree, and how its nodes are best made wide ones.
pub struct Plan<'a> {
    pub tree: &'a Preorder,
    /// Exact, by node of `tree`.
    pub bounds: Vec<Bounds>,
    /// By node of `tree`, 0 of leaves.
    choices: Vec<Choice>,
}

/// How an inner node is best stood for. Three bits for each number j = 2 … 8 of roots: how many of them stand for the left
/// child, or 0 if one root fewer does as well. The highest bit: is a single root best a block?
#[derive(Clone, Copy)]
struct Choice(u32);

impl Choice {
    const BLOCK: u32 = 1 << 31;

    fn left(self, roots: usize) -> usize {
        (self.0 >> (3 * (roots - 2)) & 7) as usize
    }
}

/// What is known of a subtree.
struct Subtree {
    bounds: Bounds,
    /// `cost[j − 1]`: cheapest way to stand for it by at most j roots.
    cost: [f32; 7],
    /// Number of primitives, if not more than a block holds.
    count: u32,
}

impl Subtree {
    fn leaf(bounds: Bounds) -> Self {
        Self { bounds, cost: [bounds.half_area() * BLOCK_COST; 7], count: 1 }
    }

    fn join(left: &Self, right: &Self) -> (Self, Choice) {
        // Exact unions: the proof in `geometry` leans on it.
        let bounds = left.bounds.union(&right.bounds);
        let (area, count) = (bounds.half_area(), left.count + right.count);
        let shares: [(usize, f32); 7] = from_fn(|i| share(left, right, i + 2));
        let as_node = shares[6].1 + area * NODE_COST;
        let as_block = if count <= 8 { area * BLOCK_COST } else { f32::INFINITY };
        let mut cost = [as_node.min(as_block); 7];
        let mut choice = (shares[6].0 as u32) << 18;
        if as_block <= as_node {
            choice |= Choice::BLOCK;
        }
        for (i, share) in shares[..6].iter().enumerate() {
            cost[i + 1] = cost[i];
            if share.1 < cost[i] {
                cost[i + 1] = share.1;
                choice |= (share.0 as u32) << (3 * i);
            }
        }
        (Self { bounds, cost, count: count.min(9) }, Choice(choice))
    }
}

/// Cheapest way to share `roots` ≥ 2 roots between two children: how many go left, and the cost.
#[inline(always)]
fn share(left: &Subtree, right: &Subtree, roots: usize) -> (usize, f32) {
    let options = (1..roots).map(|k| (k, left.cost[k.min(7) - 1] + right.cost[(roots - k).min(7) - 1]));
    options.fold((1, f32::INFINITY), |best, option| if option.1 < best.1 { option } else { best })
}

impl<'a> Plan<'a> {
    /// `boxes` are those of the primitives.
    pub fn new(tree: &'a Preorder, boxes: &[Bounds]) -> Self {
        let mut plan = Self { tree, bounds: vec![Bounds::EMPTY; tree.len()], choices: vec![Choice(0); tree.len()] };
        // Parts are in order, so that each takes its places from the front of what is left.
        let (mut bounds, mut choices, mut end) = (&mut plan.bounds[..], &mut plan.choices[..], 0);
        let parts: Vec<_> = (tree.parts.iter())
            .map(|part| {
                let places =
                    (take(&mut bounds, part.start - end, part.len()), take(&mut choices, part.start - end, part.len()));
                end = part.end;
                (part, places)
            })
            .collect();
        let subtrees: Vec<Subtree> = (parts.into_par_iter())
            .map(|(part, (bounds, choices))| {
                let mut stack = Vec::new();
                for node in part.clone().rev() {
                    let place = node - part.start;
                    (bounds[place], choices[place]) = fold(tree, boxes, node, &mut stack);
                }
                stack.pop().expect("a part is a subtree")
            })
            .collect();
        let mut subtrees = tree.parts.iter().zip(subtrees).rev().peekable();
        let (mut stack, mut node) = (Vec::new(), tree.len());
        while node > 0 {
            match subtrees.next_if(|(part, _)| part.end == node) {
                Some((part, subtree)) => {
                    stack.push(subtree);
                    node = part.start;
                }
                None => {
                    node -= 1;
                    (plan.bounds[node], plan.choices[node]) = fold(tree, boxes, node, &mut stack);
                }
            }
        }
        plan
    }

    /// Is one root for `node` best a block?
    pub fn is_block(&self, node: usize) -> bool {
        self.tree.primitive(node).is_some() || self.choices[node].0 & Choice::BLOCK != 0
    }

    /// The children of the wide node that stands for `node`.
    pub fn split(&self, node: usize) -> Vec<usize> {
        let mut out = Vec::with_capacity(8);
        self.share(node, 8, &mut out);
        out
    }
    fn share(&self, node: usize, roots: usize, out: &mut Vec<usize>) {
        let [left, right] = self.tree.children(node);
        let count = self.choices[node].left(roots);
        self.roots(left, count, out);
        self.roots(right, (roots - count).min(7), out);
    }
    /// Appends the roots that stand for `node`, at most `roots`.
    fn roots(&self, node: usize, roots: usize, out: &mut Vec<usize>) {
        let mut roots = roots;
        while roots > 1 && self.choices[node].left(roots) == 0 {
            roots -= 1;
        }
        if roots == 1 { out.push(node) } else { self.share(node, roots, out) }
    }
}

/// The next `len` of `slice` after `skip`, which both are taken off it.
fn take<'a, T>(slice: &mut &'a mut [T], skip: usize, len: usize) -> &'a mut [T] {
    let (taken, rest) = core::mem::take(slice)[skip..].split_at_mut(len);
    *slice = rest;
    taken
}

/// Puts what is known of `node` on the stack, where that of its children is (the left one's last).
fn fold(tree: &Preorder, boxes: &[Bounds], node: usize, stack: &mut Vec<Subtree>) -> (Bounds, Choice) {
    let (subtree, choice) = match tree.primitive(node) {
        Some(primitive) => (Subtree::leaf(boxes[primitive as usize]), Choice(0)),
        None => {
            let left = stack.pop().expect("a child comes before its parent");
            let right = stack.pop().expect("inner nodes have two children");
            Subtree::join(&left, &right)
        }
    };
    let bounds = subtree.bounds;
    stack.push(subtree);
    (bounds, choice)
}
