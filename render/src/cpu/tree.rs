//! A bounding volume hierarchy over boxes, which knows nothing of what is in them.

use glam::{Vec3, Vec3A, Vec4};
use rayon::prelude::*;
use std::ops::Range;

/// A node: a leaf has `count` occluders from `at`, an inner node its second child at `at` and the first right behind it. Both
/// numbers stand, by their bits, behind the corners of the box, so that a node is half a cache line.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    pub min_at: Vec4,
    pub max_count: Vec4,
}

impl Node {
    fn new((min, max): (Vec3A, Vec3A), at: u32, count: u32) -> Node {
        Node { min_at: min.extend(f32::from_bits(at)), max_count: max.extend(f32::from_bits(count)) }
    }

    #[inline(always)]
    fn bounds(&self) -> (Vec3A, Vec3A) {
        (Vec3A::from_vec4(self.min_at), Vec3A::from_vec4(self.max_count))
    }

    #[inline(always)]
    fn at(&self) -> u32 {
        self.min_at.w.to_bits()
    }

    #[inline(always)]
    fn count(&self) -> u32 {
        self.max_count.w.to_bits()
    }
}

/// Boxes of a leaf.
const LEAF: usize = 4;

/// The hierarchy.
#[derive(Default)]
pub struct Tree {
    nodes: Vec<Node>,
}

impl Tree {
    /// The hierarchy of some boxes, and the order that its leaves have them in.
    pub fn new(bounds: impl IndexedParallelIterator<Item = (Vec3, Vec3)>) -> (Tree, Vec<u32>) {
        let mut boxes: Vec<Boxed> = bounds.enumerate().map(Boxed::new).collect();
        let nodes = if boxes.is_empty() { vec![] } else { split(&mut boxes, 0) };
        (Tree { nodes }, boxes.iter().map(|x| x.min.w.to_bits()).collect())
    }

    /// The same on this thread alone.
    pub fn alone(bounds: impl Iterator<Item = (Vec3, Vec3)>) -> (Tree, Vec<u32>) {
        let mut boxes: Vec<Boxed> = bounds.enumerate().map(Boxed::new).collect();
        let mut nodes = vec![];
        if !boxes.is_empty() {
            split_into(&mut boxes, 0, &mut nodes);
        }
        (Tree { nodes }, boxes.iter().map(|x| x.min.w.to_bits()).collect())
    }

    /// The nodes, the root first.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Whether there are no boxes.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Visit the leaves whose boxes meet a box, in their order.
    pub fn meeting(&self, lo: Vec3, hi: Vec3, mut visit: impl FnMut(Range<usize>)) {
        let (lo, hi) = (Vec3A::from(lo), Vec3A::from(hi));
        let mut stack: Vec<u32> = (!self.is_empty()).then_some(0).into_iter().collect();
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            let (min, max) = node.bounds();
            if min.cmple(hi).all() && max.cmpge(lo).all() {
                match node.count() {
                    0 => stack.extend([node.at(), at + 1]),
                    n => visit(node.at() as usize..(node.at() + n) as usize),
                }
            }
        }
    }

    /// Visit the leaves that a ray meets within a length; the visitor answers how much of the length still counts, or ends it.
    #[inline(always)]
    pub fn leaves(
        &self,
        from: Vec3,
        dir: Vec3,
        mut length: f32,
        mut visit: impl FnMut(Range<usize>, f32) -> Option<f32>,
    ) {
        let (origin, inv) = (Vec3A::from(from), Vec3A::from(dir).recip());
        let mut stack = [0u32; 64];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let at = stack[top];
            let node = &self.nodes[at as usize];
            let (min, max) = node.bounds();
            let (t0, t1) = ((min - origin) * inv, (max - origin) * inv);
            let enter = t0.min(t1).max_element().max(0.0);
            let leave = t0.max(t1).min_element().min(length);
            // A ray in the plane of a side gives a NaN there, which must not hide the node.
            if enter > leave {
                continue;
            }
            if node.count() == 0 {
                stack[top] = node.at();
                stack[top + 1] = at + 1;
                top += 2;
                continue;
            }
            match visit(node.at() as usize..(node.at() + node.count()) as usize, length) {
                Some(rest) => length = rest,
                None => return,
            }
        }
    }
}

/// A box, whose number stands, by its bits, behind the first corner.
#[derive(Clone, Copy)]
struct Boxed {
    min: Vec4,
    max: Vec4,
}

impl Boxed {
    fn new((k, (min, max)): (usize, (Vec3, Vec3))) -> Boxed {
        Boxed { min: min.extend(f32::from_bits(k as u32)), max: max.extend(0.0) }
    }

    fn bounds(&self) -> (Vec3A, Vec3A) {
        (Vec3A::from_vec4(self.min), Vec3A::from_vec4(self.max))
    }

    fn center(&self) -> Vec3A {
        Vec3A::from_vec4(0.5 * (self.min + self.max))
    }
}

/// The box around nothing.
const NOTHING: (Vec3A, Vec3A) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);

fn join(a: (Vec3A, Vec3A), b: (Vec3A, Vec3A)) -> (Vec3A, Vec3A) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Boxes from which on the two sides of a split are split at the same time.
const PARALLEL: usize = 8192;

/// Split a run of boxes at the best of 16 planes along each axis by the surface area heuristic: the nodes, depth first. The boxes
/// are put in the leaves' order; `first` is the place of the first.
fn split(boxes: &mut [Boxed], first: u32) -> Vec<Node> {
    let mut nodes = vec![];
    if boxes.len() < PARALLEL {
        split_into(boxes, first, &mut nodes);
        return nodes;
    }
    let (node, middle) = divide(boxes, first, true);
    let (left, right) = boxes.split_at_mut(middle);
    let (left, right) = rayon::join(|| split(left, first), || split(right, first + middle as u32));
    nodes.reserve(1 + left.len() + right.len());
    nodes.push(Node::new(node.bounds(), 1 + left.len() as u32, 0));
    for side in [left, right] {
        let before = nodes.len() as u32;
        let moved = |n: Node| if n.count() == 0 { Node::new(n.bounds(), n.at() + before, 0) } else { n };
        nodes.extend(side.into_iter().map(moved));
    }
    nodes
}

fn split_into(boxes: &mut [Boxed], first: u32, nodes: &mut Vec<Node>) {
    let (node, middle) = divide(boxes, first, false);
    let here = nodes.len();
    nodes.push(node);
    if boxes.len() <= LEAF {
        return;
    }
    let (left, right) = boxes.split_at_mut(middle);
    split_into(left, first, nodes);
    nodes[here] = Node::new(node.bounds(), nodes.len() as u32, 0);
    split_into(right, first + middle as u32, nodes);
}

/// Boxes of a chunk: several threads look through a run by chunks of this length, whose results are put together in their order.
const CHUNK: usize = 4096;

/// The node of a run as a leaf, and how many of the run go to its first side; the run is put in order for that, by several threads if it is
/// `shared`.
fn divide(boxes: &mut [Boxed], first: u32, shared: bool) -> (Node, usize) {
    let (bounds, (lo, hi)) = if shared {
        let of_chunks: Vec<_> = boxes.par_chunks(CHUNK).map(hulls).collect();
        of_chunks.into_iter().fold((NOTHING, NOTHING), |(a, b), (c, d)| (join(a, c), join(b, d)))
    } else {
        hulls(boxes)
    };
    let node = Node::new(bounds, first, boxes.len() as u32);
    if boxes.len() <= LEAF {
        return (node, 0);
    }
    let mut middle = best_plane(boxes, lo, hi, shared)
        .map_or(0, |(axis, plane)| partition(boxes, |x| x.center()[axis] < plane, shared));
    if middle == 0 || middle == boxes.len() {
        // All centres in one place: halves of the run will do.
        middle = boxes.len() / 2;
    }
    (node, middle)
}

/// The box around some boxes, and that around their centres.
fn hulls(boxes: &[Boxed]) -> ((Vec3A, Vec3A), (Vec3A, Vec3A)) {
    boxes.iter().fold((NOTHING, NOTHING), |(a, b), x| (join(a, x.bounds()), join(b, (x.center(), x.center()))))
}

/// Planes along an axis that a run may be split at, and one more.
const BINS: usize = 16;

/// Of the boxes whose centres lie between two planes along an axis, their count and the box around them, for each axis.
type Bins = [[(u32, (Vec3A, Vec3A)); BINS]; 3];

const EMPTY: Bins = [[(0, NOTHING); BINS]; 3];

fn bins(boxes: &[Boxed], lo: Vec3A, scale: [f32; 3]) -> Bins {
    let mut bins = EMPTY;
    for x in boxes {
        let at = (x.center() - lo).to_array();
        for (axis, bins) in bins.iter_mut().enumerate() {
            // Along an axis that has no width this is not a number, and makes bin 0.
            let bin = &mut bins[((at[axis] * scale[axis]) as usize).min(BINS - 1)];
            *bin = (bin.0 + 1, join(bin.1, x.bounds()));
        }
    }
    bins
}

fn best_plane(boxes: &[Boxed], lo: Vec3A, hi: Vec3A, shared: bool) -> Option<(usize, f32)> {
    let area = |(lo, hi): (Vec3A, Vec3A)| {
        let d = (hi - lo).max(Vec3A::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    };
    let width = hi - lo;
    let scale = (BINS as f32 / width).to_array();
    let bins = if !shared {
        bins(boxes, lo, scale)
    } else {
        let of_chunks: Vec<Bins> = boxes.par_chunks(CHUNK).map(|chunk| bins(chunk, lo, scale)).collect();
        let mut all = EMPTY;
        for own in &of_chunks {
            for (all, own) in all.as_flattened_mut().iter_mut().zip(own.as_flattened()) {
                *all = (all.0 + own.0, join(all.1, own.1));
            }
        }
        all
    };
    let mut best: Option<(f32, usize, f32)> = None;
    for (axis, bins) in bins.iter().enumerate().filter(|(axis, _)| width[*axis] > 0.0) {
        let mut after = [(0u32, NOTHING); BINS];
        let mut sum = (0, NOTHING);
        for k in (1..BINS).rev() {
            sum = (sum.0 + bins[k].0, join(sum.1, bins[k].1));
            after[k] = sum;
        }
        let mut before = (0u32, NOTHING);
        for k in 1..BINS {
            before = (before.0 + bins[k - 1].0, join(before.1, bins[k - 1].1));
            if before.0 > 0 && after[k].0 > 0 {
                let cost = before.0 as f32 * area(before.1) + after[k].0 as f32 * area(after[k].1);
                if best.is_none_or(|(c, ..)| cost < c) {
                    best = Some((cost, axis, lo[axis] + width[axis] * k as f32 / BINS as f32));
                }
            }
        }
    }
    best.map(|(_, axis, plane)| (axis, plane))
}

/// Move what satisfies `first` to the front, keeping the order on both sides; how many do.
fn partition(boxes: &mut [Boxed], first: impl Fn(&Boxed) -> bool + Sync, shared: bool) -> usize {
    if !shared {
        return partition_alone(boxes, first);
    }
    let fronts: Vec<usize> = boxes.par_chunks_mut(CHUNK).map(|chunk| partition_alone(chunk, &first)).collect();
    let (front, back): (Vec<&[Boxed]>, Vec<&[Boxed]>) =
        boxes.chunks(CHUNK).zip(&fronts).map(|(chunk, front)| chunk.split_at(*front)).unzip();
    let sorted = [front, back].concat().concat();
    boxes.copy_from_slice(&sorted);
    fronts.into_iter().sum()
}

fn partition_alone(boxes: &mut [Boxed], first: impl Fn(&Boxed) -> bool) -> usize {
    let mut back = vec![];
    let mut front = 0;
    for k in 0..boxes.len() {
        let x = boxes[k];
        if first(&x) {
            boxes[front] = x;
            front += 1;
        } else {
            back.push(x);
        }
    }
    boxes[front..].copy_from_slice(&back);
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_of_several_threads_is_that_of_one() {
        let number = |k: u32| (k.wrapping_mul(0x9e37_79b9) >> 8) as f32 / (1 << 24) as f32;
        let place = |k: u32| Vec3::new(number(3 * k), number(3 * k + 1), 0.1 * number(3 * k + 2));
        // Not a whole number of chunks, and many in one place.
        let bounds: Vec<(Vec3, Vec3)> = (0..50_001).map(|k| place(k / 3)).map(|at| (at - 0.01, at + 0.01)).collect();
        let (alone, order) = Tree::alone(bounds.iter().copied());
        let bits = |tree: &Tree| -> Vec<[u32; 8]> {
            let of = |node: &Node| {
                std::array::from_fn(|k| if k < 4 { node.min_at[k] } else { node.max_count[k - 4] }.to_bits())
            };
            tree.nodes().iter().map(of).collect()
        };
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let (tree, own) = pool.install(|| Tree::new(bounds.par_iter().copied()));
            assert!(bits(&tree) == bits(&alone) && own == order, "{threads} threads");
        }
    }
}
