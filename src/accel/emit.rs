//! Writes the nodes and blocks of a [`Plan`], on all threads of the current pool.

use super::collapse::Plan;
use super::node::{Child, Node};
#[cfg(doc)]
use super::preorder::Preorder;
use super::tree::{MAX_DEPTH, Tree};
use crate::geometry::Bounds;
use rayon::prelude::*;

/// Below this many nodes of the longest way down the optimal choice gives way to balanced halving, so that no input
/// (a binary tree can be a list) makes a tree deeper than [`MAX_DEPTH`]: what is left, fewer than 2²⁸ primitives, is
/// divided by eight at each further node, nine times until a block holds it.
const FREE_DEPTH: usize = MAX_DEPTH - 11;

/// A wide child still to be made.
enum Pending {
    Subtree(usize),
    Primitives(Vec<u32>),
}

/// What is to be made, the nodes above it, and the node and slot that refer to it.
type Task = (Pending, usize, Option<(usize, usize)>);

/// What is to be written.
pub struct Emit<'a, F> {
    pub plan: &'a Plan<'a>,
    /// Own boxes by primitive.
    pub boxes: &'a [Bounds],
    /// Makes the block of up to eight primitives.
    pub block: F,
}

impl<B: Send, F: Fn(&[u32]) -> B + Sync> Emit<'_, F> {
    /// Nodes and blocks depth first, so that a way down stays close in memory; those above the [parts](Preorder::parts)
    /// come before all others.
    pub fn tree(&self) -> Tree<B> {
        let parts = &self.plan.tree.parts;
        let in_part = |node: usize| parts[parts.partition_point(|part| part.end <= node)].start <= node;
        let later = |pending: &Pending| matches!(pending, Pending::Subtree(node) if in_part(*node));
        let (mut tree, tasks) = self.run((Pending::Subtree(0), 0, None), later);
        let part = |(pending, above, parent): Task| (self.run((pending, above, None), |_| false).0, parent);
        let made: Vec<_> = tasks.into_par_iter().map(part).collect();
        tree.nodes.reserve_exact(made.iter().map(|(part, _)| part.nodes.len()).sum());
        tree.blocks.reserve_exact(made.iter().map(|(part, _)| part.blocks.len()).sum());
        for (part, parent) in made {
            tree.append(part, parent);
        }
        tree
    }

    /// Does `task` and what comes of it, but what is to be done `later`.
    fn run(&self, task: Task, later: impl Fn(&Pending) -> bool) -> (Tree<B>, Vec<Task>) {
        let (mut out, mut left) = (Tree::default(), Vec::new());
        let mut stack = vec![task];
        while let Some((pending, above, parent)) = stack.pop() {
            if later(&pending) {
                left.push((pending, above, parent));
                continue;
            }
            let child = match self.as_block(&pending) {
                Some(mut ids) => {
                    // The lower of equals is then the first.
                    ids.sort_unstable();
                    out.blocks.push((self.block)(&ids));
                    Child::leaf(out.blocks.len() - 1)
                }
                None => {
                    let parts = self.parts(pending, above);
                    let bounds: Vec<_> = parts.iter().map(|part| (Child(0), self.bounds(part))).collect();
                    let index = out.nodes.len();
                    out.nodes.push(Node::new(&bounds));
                    out.depth = out.depth.max(above + 1);
                    let parts = parts.into_iter().enumerate().rev();
                    stack.extend(parts.map(|(slot, part)| (part, above + 1, Some((index, slot)))));
                    Child::node(index)
                }
            };
            out.refer(parent, child);
        }
        (out, left)
    }

    /// The primitives, where the pending child is best made a block.
    fn as_block(&self, pending: &Pending) -> Option<Vec<u32>> {
        match pending {
            Pending::Primitives(ids) => (ids.len() <= 8).then(|| ids.clone()),
            Pending::Subtree(node) => self.plan.is_block(*node).then(|| self.plan.tree.primitives(*node).collect()),
        }
    }

    /// The children of a pending child that is to be a node.
    fn parts(&self, pending: Pending, above: usize) -> Vec<Pending> {
        match pending {
            Pending::Subtree(node) if above < FREE_DEPTH => {
                self.plan.split(node).into_iter().map(Pending::Subtree).collect()
            }
            Pending::Subtree(node) => halve(self.plan.tree.primitives(node).collect()),
            Pending::Primitives(ids) => halve(ids),
        }
    }

    fn bounds(&self, part: &Pending) -> Bounds {
        match part {
            Pending::Subtree(node) => self.plan.bounds[*node],
            Pending::Primitives(ids) => ids.iter().fold(Bounds::EMPTY, |all, id| all.union(&self.boxes[*id as usize])),
        }
    }
}

impl<B> Tree<B> {
    /// Makes `parent` (node and slot; else the root) refer to `child`.
    fn refer(&mut self, parent: Option<(usize, usize)>, child: Child) {
        match parent {
            Some((node, slot)) => self.nodes[node].children[slot] = child.0,
            None => self.root = child,
        }
    }

    /// Takes in a tree that `parent` is to refer to.
    fn append(&mut self, part: Self, parent: Option<(usize, usize)>) {
        let (nodes, blocks) = (self.nodes.len(), self.blocks.len());
        let moved = |child: Child| {
            if child.is_leaf() { Child::leaf(child.index() + blocks) } else { Child::node(child.index() + nodes) }
        };
        self.refer(parent, moved(part.root));
        self.nodes.extend(part.nodes.into_iter().map(|mut node| {
            let count = node.count();
            node.children[..count].iter_mut().for_each(|word| *word = moved(Child(*word)).0);
            node
        }));
        self.blocks.extend(part.blocks);
        self.depth = self.depth.max(part.depth);
    }
}

/// Eight parts of nearly equal length, more than eight primitives.
fn halve(ids: Vec<u32>) -> Vec<Pending> {
    let size = ids.len().div_ceil(8);
    ids.chunks(size).map(|part| Pending::Primitives(part.to_vec())).collect()
}
