//! Solids (RISpec 5.9): primitives that bound a volume, and volumes made of others by union, intersection and difference.

use crate::warnings::Spot;
use std::collections::HashMap;
use std::ops::Range;

/// What a solid is of its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// What its surfaces enclose.
    Primitive,
    /// All that is in any part.
    Union,
    /// All that is in every part.
    Intersection,
    /// All that is in the first part and in no other.
    Difference,
}

impl Operation {
    /// By its name in `SolidBegin`.
    pub fn of_name(name: &str) -> Option<Operation> {
        Some(match name {
            "primitive" => Operation::Primitive,
            "union" => Operation::Union,
            "intersection" => Operation::Intersection,
            "difference" => Operation::Difference,
            _ => return None,
        })
    }

    /// Its name in `SolidBegin`.
    pub fn name(self) -> &'static str {
        match self {
            Operation::Primitive => "primitive",
            Operation::Union => "union",
            Operation::Intersection => "intersection",
            Operation::Difference => "difference",
        }
    }
}

/// A solid, and what it is a part of.
#[derive(Clone, Debug)]
struct Node {
    operation: Operation,
    parent: Option<u32>,
    /// What it is in the end a part of.
    root: u32,
    /// How many it is within.
    depth: u32,
    parts: Vec<u32>,
}

/// The solids of a scene.
#[derive(Clone, Debug, Default)]
pub struct Solids {
    nodes: Vec<Node>,
    /// Primitives that are no parts of solids, which are drawn as they are.
    pub lone: Vec<Lone>,
}

/// A primitive that is a solid by itself.
#[derive(Clone, Debug)]
pub struct Lone {
    /// Its sources in the scene.
    pub sources: Range<u32>,
    /// Where it begins.
    pub spot: Option<Spot>,
}

impl Solids {
    /// A new solid, a part of another if one is given.
    pub fn add(&mut self, operation: Operation, parent: Option<u32>) -> u32 {
        let id = self.nodes.len() as u32;
        let outer = parent.map(|parent| &self.nodes[parent as usize]);
        let (root, depth) = outer.map_or((id, 0), |outer| (outer.root, outer.depth + 1));
        self.nodes.push(Node { operation, parent, root, depth, parts: vec![] });
        if let Some(parent) = parent {
            self.nodes[parent as usize].parts.push(id);
        }
        id
    }

    /// What a solid is of its parts.
    pub fn operation(&self, id: u32) -> Operation {
        self.nodes[id as usize].operation
    }

    /// The solid that it is in the end a part of.
    pub fn root(&self, id: u32) -> u32 {
        self.nodes[id as usize].root
    }

    /// The solids that are no parts of others.
    pub fn roots(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.nodes.len() as u32).filter(|id| self.nodes[*id as usize].parent.is_none())
    }

    /// Its parts.
    pub fn parts(&self, id: u32) -> &[u32] {
        &self.nodes[id as usize].parts
    }

    /// How many solids one is within.
    pub fn depth(&self, id: u32) -> u32 {
        self.nodes[id as usize].depth
    }

    /// Another solid like the one that a primitive is a part of, as a part of `parent`; `copied` knows which of its parts became
    /// which, and is told more.
    pub fn copy(&mut self, leaf: u32, parent: Option<u32>, copied: &mut HashMap<u32, u32>) -> u32 {
        if let Some(known) = copied.get(&leaf) {
            return *known;
        }
        let root = self.root(leaf);
        self.copy_below(root, parent, copied);
        copied[&leaf]
    }

    fn copy_below(&mut self, id: u32, parent: Option<u32>, copied: &mut HashMap<u32, u32>) {
        let Node { operation, parts, .. } = self.nodes[id as usize].clone();
        let new = self.add(operation, parent);
        copied.insert(id, new);
        parts.into_iter().for_each(|part| self.copy_below(part, Some(new), copied));
    }
}

/// Places nearer to each other than this part of their distance coincide.
const COINCIDENT: f32 = 1e-5;

/// A place where a line meets a surface of a primitive.
#[derive(Clone, Copy, Debug)]
pub struct Met {
    /// How far along the line.
    pub at: f32,
    /// The primitive.
    pub leaf: u32,
    /// Whether the line enters it.
    pub enters: bool,
    /// What the caller knows it by.
    pub name: u32,
}

/// A walk along a line through solids, from what it meets first on.
#[derive(Default)]
pub struct Walk {
    kept: Vec<bool>,
    /// Of every solid, what of it the line is in; `touched` are those where that is anything.
    states: Vec<State>,
    touched: Vec<u32>,
}

/// What of a solid a line is in.
#[derive(Clone, Copy, Default)]
struct State {
    /// Parts.
    parts: u32,
    /// Its first part.
    first: bool,
    /// The whole of it.
    held: bool,
    /// A primitive that has been met.
    met: bool,
}

impl Walk {
    /// Begin another line. It begins inside what it is going to leave first: note what it meets, in order, before it is walked.
    fn start(&mut self, solids: &Solids, line: &[Met]) {
        self.touched.drain(..).for_each(|id| self.states[id as usize] = State::default());
        self.states.resize(solids.nodes.len(), State::default());
        for Met { leaf, enters, .. } in line {
            let state = &mut self.states[*leaf as usize];
            if !std::mem::replace(&mut state.met, true) {
                self.touched.push(*leaf);
                if !enters {
                    self.turn(solids, *leaf);
                }
            }
        }
    }

    /// Enter or leave a primitive, and with it what it is a part of. Whether the line enters or leaves the whole.
    fn turn(&mut self, solids: &Solids, leaf: u32) -> bool {
        let mut id = leaf;
        self.states[id as usize].held ^= true;
        loop {
            let held = self.states[id as usize].held;
            let Some(parent) = solids.nodes[id as usize].parent else { return true };
            let Node { operation, parts, .. } = &solids.nodes[parent as usize];
            let state = &mut self.states[parent as usize];
            self.touched.push(parent);
            state.parts = if held { state.parts + 1 } else { state.parts - 1 };
            if parts[0] == id {
                state.first = held;
            }
            let now = match operation {
                Operation::Primitive => state.held,
                Operation::Union => state.parts > 0,
                Operation::Intersection => state.parts as usize == parts.len(),
                Operation::Difference => state.first && state.parts == 1,
            };
            if now == std::mem::replace(&mut state.held, now) {
                return false;
            }
            id = parent;
        }
    }

    /// Walk all the way, along places that are sorted, which are sorted by wholes then: which of them are surfaces of the whole that they are
    /// of. Surfaces of a whole that coincide are none where the line is on the same side of it before and after all of them.
    pub fn surfaces<'a>(&'a mut self, solids: &Solids, line: &mut [Met]) -> &'a [bool] {
        self.start(solids, line);
        self.kept.clear();
        let whole = |met: &Met| solids.root(met.leaf);
        if line.windows(2).any(|pair| whole(&pair[0]) != whole(&pair[1])) {
            line.sort_by_key(whole);
        }
        for line in line.chunk_by_mut(|a, b| whole(a) == whole(b)) {
            let mut first = 0;
            while first < line.len() {
                let reach = line[first].at * (1.0 + COINCIDENT);
                let n = line[first..].iter().take_while(|met| met.at <= reach).count();
                self.group(solids, &mut line[first..first + n]);
                first += n;
            }
        }
        &self.kept
    }

    /// Cross surfaces of a whole that coincide, in the order of the parts, so that one of them counts whichever was met first.
    fn group(&mut self, solids: &Solids, group: &mut [Met]) {
        let first = self.kept.len();
        if group.iter().any(|met| met.leaf != group[0].leaf) {
            group.sort_by_key(|met| met.leaf);
        }
        for met in &*group {
            let is_surface = self.cross(solids, met.leaf, met.enters);
            self.kept.push(is_surface);
        }
        // Each surface of a whole leads to its other side, and a second one back.
        let mut last = None;
        for i in first..self.kept.len() {
            if !self.kept[i] {
                continue;
            }
            match last.take() {
                Some(other) => (self.kept[i], self.kept[other]) = (false, false),
                None => last = Some(i),
            }
        }
    }

    /// Enter or leave a primitive: whether the surface there is one of the whole that it is a part of.
    fn cross(&mut self, solids: &Solids, leaf: u32, enters: bool) -> bool {
        // An edge that two surfaces share is met twice.
        self.states[leaf as usize].held != enters && self.turn(solids, leaf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_meets_the_surfaces_of_the_whole_alone() {
        // a − (b ∪ c): in at a, out at b, in where c ends, out where a ends.
        let mut solids = Solids::default();
        let root = solids.add(Operation::Difference, None);
        let a = solids.add(Operation::Primitive, Some(root));
        let union = solids.add(Operation::Union, Some(root));
        let (b, c) = (solids.add(Operation::Primitive, Some(union)), solids.add(Operation::Primitive, Some(union)));
        let line = |met: &[(f32, u32, bool)]| -> Vec<Met> {
            met.iter().map(|(at, leaf, enters)| Met { at: *at, leaf: *leaf, enters: *enters, name: 0 }).collect()
        };
        let mut met = line(&[
            (1.0, a, true),
            (2.0, b, true),
            (2.0, b, true),
            (3.0, c, true),
            (4.0, b, false),
            (5.0, c, false),
            (6.0, a, false),
        ]);
        let mut walk = Walk::default();
        assert_eq!(walk.surfaces(&solids, &mut met), [true, true, false, false, false, true, true]);
        // One that begins in a leaves it first.
        assert_eq!(walk.surfaces(&solids, &mut line(&[(1.0, a, false), (2.0, a, false)])), [true, false]);
        // Where a and b begin and end together, there is a hole, in whichever order they are met.
        for [one, other] in [[a, b], [b, a]] {
            let mut met = line(&[(1.0, one, true), (1.000_001, other, true), (2.0, other, false), (2.0, one, false)]);
            assert_eq!(walk.surfaces(&solids, &mut met), [false; 4]);
        }
        // Where b ends as a begins, there is one surface.
        for [one, other] in [[(a, true), (b, false)], [(b, false), (a, true)]] {
            let mut met = line(&[(0.5, b, true), (1.0, one.0, one.1), (1.0, other.0, other.1), (2.0, a, false)]);
            assert_eq!(walk.surfaces(&solids, &mut met).iter().filter(|kept| **kept).count(), 2);
        }
        // Another solid changes nothing: what is too thin to tell its sides apart is none, whatever is met just before.
        let sole = solids.add(Operation::Union, None);
        let thin = solids.add(Operation::Primitive, Some(sole));
        let sliver = [(1.0, thin, true), (1.000_008, thin, false)];
        assert_eq!(walk.surfaces(&solids, &mut line(&sliver)), [false; 2]);
        let mut both = line(&[&[(0.999_995, a, true)], &sliver[..], &[(2.0, a, false)]].concat());
        let kept = walk.surfaces(&solids, &mut both).to_vec();
        assert!(both.iter().zip(kept).all(|(met, kept)| kept == (met.leaf == a)));
        // A copy is another solid with the same parts.
        let mut copied = HashMap::new();
        let other = solids.copy(b, None, &mut copied);
        assert!(
            other != b && solids.root(other) != root && solids.operation(solids.root(other)) == Operation::Difference
        );
    }
}
