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
        let mut room = if boxes.len() < PARALLEL { vec![] } else { boxes.clone() };
        let (mut nodes, mut order) = (vec![], vec![0; boxes.len()]);
        if !boxes.is_empty() {
            split(&mut boxes, &mut room, 0, &mut order).push_to(&mut nodes);
        }
        (Tree { nodes }, order)
    }

    /// The same on this thread alone.
    pub fn alone(bounds: impl Iterator<Item = (Vec3, Vec3)>) -> (Tree, Vec<u32>) {
        let mut boxes: Vec<Boxed> = bounds.enumerate().map(Boxed::new).collect();
        let mut nodes = vec![];
        if !boxes.is_empty() {
            split_into(&mut boxes, 0, &mut nodes, &mut vec![]);
        }
        (Tree { nodes }, boxes.iter().map(Boxed::number).collect())
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

    fn number(&self) -> u32 {
        self.min.w.to_bits()
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

/// The nodes of a run of boxes, depth first.
enum Part {
    /// All of them, by their places among these.
    Whole(Vec<Node>),
    /// The first of them, and those of the two sides.
    Split(Node, Box<[Part; 2]>),
}

impl Part {
    /// Put the nodes behind others, once it is known how many these are.
    fn push_to(self, nodes: &mut Vec<Node>) {
        let before = nodes.len() as u32;
        match self {
            Part::Whole(own) if before == 0 => *nodes = own,
            Part::Whole(own) => {
                let moved = |n: Node| if n.count() == 0 { Node::new(n.bounds(), n.at() + before, 0) } else { n };
                nodes.extend(own.into_iter().map(moved));
            }
            Part::Split(node, sides) => {
                let ([left, right], bounds) = (*sides, node.bounds());
                nodes.push(node);
                left.push_to(nodes);
                nodes[before as usize] = Node::new(bounds, nodes.len() as u32, 0);
                right.push_to(nodes);
            }
        }
    }
}

/// Split a run of boxes at the best of 16 planes along each axis by the surface area heuristic, in `room` for as many if they are many: its
/// nodes, and the numbers of the boxes in the leaves' order; `first` is the place of the first.
fn split(boxes: &mut [Boxed], room: &mut [Boxed], first: u32, order: &mut [u32]) -> Part {
    if boxes.len() < PARALLEL {
        let mut nodes = Vec::with_capacity(boxes.len());
        split_into(boxes, first, &mut nodes, &mut vec![]);
        order.iter_mut().zip(&*boxes).for_each(|(number, x)| *number = x.number());
        return Part::Whole(nodes);
    }
    let of_chunks: Vec<_> = boxes.par_chunks(CHUNK).map(hulls).collect();
    let (bounds, hull) = of_chunks.into_iter().fold((NOTHING, NOTHING), |(a, b), (c, d)| (join(a, c), join(b, d)));
    let node = Node::new(bounds, first, boxes.len() as u32);
    // Where all centres are in one place there is no plane, and nothing is before it.
    let (axis, plane) = plane_of_many(boxes, hull).unwrap_or((0, f32::NEG_INFINITY));
    let middle = middle_of(scatter(boxes, room, |x| x.center()[axis] < plane), boxes.len());
    let (left, right) = room.split_at_mut(middle);
    let (left_room, right_room) = boxes.split_at_mut(middle);
    let (left_order, right_order) = order.split_at_mut(middle);
    let (left, right) = rayon::join(
        || split(left, left_room, first, left_order),
        || split(right, right_room, first + middle as u32, right_order),
    );
    Part::Split(node, Box::new([left, right]))
}

/// The same on this thread alone, behind other nodes; `room` is for boxes.
fn split_into(boxes: &mut [Boxed], first: u32, nodes: &mut Vec<Node>, room: &mut Vec<Boxed>) {
    let (bounds, hull) = hulls(boxes);
    let here = nodes.len();
    nodes.push(Node::new(bounds, first, boxes.len() as u32));
    if boxes.len() <= LEAF {
        return;
    }
    let plane = if boxes.len() <= FEW { plane_of_few(boxes, hull) } else { plane_of(&bins(boxes, hull), hull) };
    let front = plane.map_or(0, |(axis, plane)| partition(boxes, room, |x| x.center()[axis] < plane));
    let middle = middle_of(front, boxes.len());
    let (left, right) = boxes.split_at_mut(middle);
    split_into(left, first, nodes, room);
    nodes[here] = Node::new(bounds, nodes.len() as u32, 0);
    split_into(right, first + middle as u32, nodes, room);
}

/// How many of a run go to its first side, of which so many are before a plane: if all centres are in one place, halves will do.
fn middle_of(front: usize, n: usize) -> usize {
    if front == 0 || front == n { n / 2 } else { front }
}

/// Boxes of a chunk: several threads look through a run by chunks of this length, whose results are put together in their order.
const CHUNK: usize = 4096;

/// The box around some boxes, and that around their centres.
fn hulls(boxes: &[Boxed]) -> ((Vec3A, Vec3A), (Vec3A, Vec3A)) {
    boxes.iter().fold((NOTHING, NOTHING), |(a, b), x| (join(a, x.bounds()), join(b, (x.center(), x.center()))))
}

/// Planes along an axis that a run may be split at, and one more.
const BINS: usize = 16;

/// Of the boxes whose centres lie between two planes along an axis, their count and the box around them, for each axis.
type Bins = [[(u32, (Vec3A, Vec3A)); BINS]; 3];

const EMPTY: Bins = [[(0, NOTHING); BINS]; 3];

/// The scale from places in a box to numbers of bins.
fn scale_of((lo, hi): (Vec3A, Vec3A)) -> [f32; 3] {
    (BINS as f32 / (hi - lo)).to_array()
}

/// The bin of a place along an axis. Along one that has no width this is not a number, and makes bin 0.
fn bin_of(at: f32, scale: f32) -> usize {
    ((at * scale) as usize).min(BINS - 1)
}

fn bins(boxes: &[Boxed], hull: (Vec3A, Vec3A)) -> Bins {
    let (mut bins, scale) = (EMPTY, scale_of(hull));
    for x in boxes {
        let at = (x.center() - hull.0).to_array();
        for (axis, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[bin_of(at[axis], scale[axis])];
            *bin = (bin.0 + 1, join(bin.1, x.bounds()));
        }
    }
    bins
}

/// The best plane by the surface area heuristic so far: its cost, axis and place.
struct Best(Option<(f32, usize, f32)>);

impl Best {
    /// Compare the plane before a bin along an axis of a box: how many boxes are before and after it, and what is around them.
    fn compare(&mut self, (lo, hi): (Vec3A, Vec3A), (axis, bin): (usize, usize), sides: [(u32, (Vec3A, Vec3A)); 2]) {
        let area = |(lo, hi): (Vec3A, Vec3A)| {
            let d = (hi - lo).max(Vec3A::ZERO);
            d.x * d.y + d.y * d.z + d.z * d.x
        };
        let [before, after] = sides.map(|(n, around)| n as f32 * area(around));
        let cost = before + after;
        if self.0.is_none_or(|(least, ..)| cost < least) {
            self.0 = Some((cost, axis, lo[axis] + (hi - lo)[axis] * bin as f32 / BINS as f32));
        }
    }

    fn plane(self) -> Option<(usize, f32)> {
        self.0.map(|(_, axis, plane)| (axis, plane))
    }
}

/// The best plane of boxes in bins, whose centres are in a box.
fn plane_of(bins: &Bins, hull: (Vec3A, Vec3A)) -> Option<(usize, f32)> {
    let (mut best, width) = (Best(None), hull.1 - hull.0);
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
                best.compare(hull, (axis, k), [before, after[k]]);
            }
        }
    }
    best.plane()
}

/// The same of boxes that several threads put in bins.
fn plane_of_many(boxes: &[Boxed], hull: (Vec3A, Vec3A)) -> Option<(usize, f32)> {
    let of_chunks: Vec<Bins> = boxes.par_chunks(CHUNK).map(|chunk| bins(chunk, hull)).collect();
    let mut all = EMPTY;
    for own in &of_chunks {
        for (all, own) in all.as_flattened_mut().iter_mut().zip(own.as_flattened()) {
            *all = (all.0 + own.0, join(all.1, own.1));
        }
    }
    plane_of(&all, hull)
}

/// Boxes that are fewer than bins of all axes: what is around those of a bin is not kept.
const FEW: usize = 16;

/// The same of a few boxes: of planes that have the same boxes before them, the first counts.
fn plane_of_few(boxes: &[Boxed], hull: (Vec3A, Vec3A)) -> Option<(usize, f32)> {
    let (mut best, n, scale, width) = (Best(None), boxes.len(), scale_of(hull), hull.1 - hull.0);
    for axis in (0..3).filter(|axis| width[*axis] > 0.0) {
        // The bin and the place of each box, by bins.
        let mut sorted = [[0u8; 2]; FEW];
        for (k, x) in boxes.iter().enumerate() {
            let own = [bin_of((x.center() - hull.0)[axis], scale[axis]) as u8, k as u8];
            let mut at = k;
            while at > 0 && sorted[at - 1][0] > own[0] {
                sorted[at] = sorted[at - 1];
                at -= 1;
            }
            sorted[at] = own;
        }
        let around = |k: usize| boxes[sorted[k][1] as usize].bounds();
        let mut after = [NOTHING; FEW];
        let mut sum = NOTHING;
        for k in (1..n).rev() {
            sum = join(sum, around(k));
            after[k] = sum;
        }
        let mut before = NOTHING;
        for k in 1..n {
            before = join(before, around(k - 1));
            let bin = sorted[k - 1][0] as usize + 1;
            if sorted[k][0] as usize >= bin {
                best.compare(hull, (axis, bin), [(k as u32, before), ((n - k) as u32, after[k])]);
            }
        }
    }
    best.plane()
}

/// Put what satisfies `first` before all else, in the order of both, to other memory; how many do.
fn scatter(boxes: &[Boxed], to: &mut [Boxed], first: impl Fn(&Boxed) -> bool + Sync) -> usize {
    let counts: Vec<usize> = boxes.par_chunks(CHUNK).map(|chunk| chunk.iter().filter(|x| first(x)).count()).collect();
    let middle = counts.iter().sum();
    let (mut front, mut back) = to.split_at_mut(middle);
    let goals = boxes.chunks(CHUNK).zip(counts).map(|(chunk, n)| {
        let own_front = front.split_off_mut(..n).expect("as many as are counted");
        let own_back = back.split_off_mut(..chunk.len() - n).expect("as many as are left");
        (chunk, own_front, own_back)
    });
    let goals: Vec<_> = goals.collect();
    goals.into_par_iter().for_each(|(chunk, front, back)| {
        let (mut front, mut back) = (front.iter_mut(), back.iter_mut());
        for x in chunk {
            if let Some(goal) = if first(x) { front.next() } else { back.next() } {
                *goal = *x;
            }
        }
    });
    middle
}

/// Move what satisfies `first` to the front, keeping the order on both sides, with memory for what does not; how many do.
fn partition(boxes: &mut [Boxed], back: &mut Vec<Boxed>, first: impl Fn(&Boxed) -> bool) -> usize {
    back.clear();
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
    boxes[front..].copy_from_slice(back);
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

    #[test]
    fn a_few_boxes_are_split_where_their_bins_are() {
        let number = |k: u32| (k.wrapping_mul(0x9e37_79b9) >> 8) as f32 / (1 << 24) as f32;
        let mut n_planes = 0;
        for run in 0..2000u32 {
            // Of some axes no width, and of some runs few places.
            let (n, steps) = (2 + run % (FEW as u32 - 1), [1e6, 3.0, 1.0, 0.0][run as usize / 7 % 4]);
            let at = |k: u32| (number(64 * run + k) * steps).round() * if k % 3 == run % 5 { 0.0 } else { 1.0 };
            let place = |k: u32| Vec3::new(at(3 * k), at(3 * k + 1), at(3 * k + 2));
            let around = |k: u32| (place(k) - number(run + k), place(k) + number(run + k));
            let boxes: Vec<Boxed> = (0..n).map(|k| Boxed::new((k as usize, around(k)))).collect();
            let (_, hull) = hulls(&boxes);
            let plane = plane_of_few(&boxes, hull);
            assert_eq!(plane, plane_of(&bins(&boxes, hull), hull), "run {run}");
            n_planes += u32::from(plane.is_some());
        }
        assert!((500..1950).contains(&n_planes), "{n_planes} of 2000 runs have a plane");
    }
}
