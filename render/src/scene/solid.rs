//! Solids (RISpec 5.9): primitives that bound a volume, and volumes made of others by union, intersection and difference.

use std::collections::HashMap;

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
}

/// A solid, and what it is a part of.
#[derive(Clone, Debug)]
struct Node {
    operation: Operation,
    parent: Option<u32>,
    parts: Vec<u32>,
}

/// The solids of a scene.
#[derive(Clone, Debug, Default)]
pub struct Solids {
    nodes: Vec<Node>,
}

impl Solids {
    /// A new solid, a part of another if one is given.
    pub fn add(&mut self, operation: Operation, parent: Option<u32>) -> u32 {
        let id = self.nodes.len() as u32;
        self.nodes.push(Node { operation, parent, parts: vec![] });
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
    pub fn root(&self, mut id: u32) -> u32 {
        while let Some(parent) = self.nodes[id as usize].parent {
            id = parent;
        }
        id
    }

    /// Whether a point is in a solid, if it is in these primitives.
    pub fn holds(&self, id: u32, inside: &[u32]) -> bool {
        let Node { operation, parts, .. } = &self.nodes[id as usize];
        let mut each = parts.iter().map(|part| self.holds(*part, inside));
        match operation {
            Operation::Primitive => inside.contains(&id),
            Operation::Union => each.any(|held| held),
            Operation::Intersection => !parts.is_empty() && each.all(|held| held),
            Operation::Difference => each.next().is_some_and(|held| held) && !each.any(|held| held),
        }
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

/// A walk along a line through solids, from what it meets first on.
#[derive(Default)]
pub struct Walk {
    /// Primitives that have been met, and those that the line is in.
    met: Vec<u32>,
    inside: Vec<u32>,
}

impl Walk {
    /// Begin another line. It begins inside what it is going to leave first: note what it meets, in order, before it is walked.
    pub fn start(&mut self, met: impl Iterator<Item = (u32, bool)>) {
        self.met.clear();
        self.inside.clear();
        for (leaf, enters) in met {
            if !self.met.contains(&leaf) {
                self.met.push(leaf);
                if !enters {
                    self.inside.push(leaf);
                }
            }
        }
    }

    /// Enter or leave a primitive: whether the surface there is one of the whole that it is a part of.
    pub fn cross(&mut self, solids: &Solids, leaf: u32, enters: bool) -> bool {
        let root = solids.root(leaf);
        let before = solids.holds(root, &self.inside);
        match (enters, self.inside.iter().position(|l| *l == leaf)) {
            (true, None) => self.inside.push(leaf),
            (false, Some(at)) => {
                self.inside.swap_remove(at);
            }
            // An edge that two surfaces share is met twice.
            _ => return false,
        }
        before != solids.holds(root, &self.inside)
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
        let met = [(a, true), (b, true), (b, true), (c, true), (b, false), (c, false), (a, false)];
        let mut walk = Walk::default();
        walk.start(met.into_iter());
        let kept: Vec<bool> = met.iter().map(|(leaf, enters)| walk.cross(&solids, *leaf, *enters)).collect();
        assert_eq!(kept, [true, true, false, false, false, true, true]);
        // One that begins in a leaves it first.
        walk.start([(a, false)].into_iter());
        assert!(walk.cross(&solids, a, false) && !walk.cross(&solids, a, false));
        // A copy is another solid with the same parts.
        let mut copied = HashMap::new();
        let other = solids.copy(b, None, &mut copied);
        assert!(
            other != b && solids.root(other) != root && solids.operation(solids.root(other)) == Operation::Difference
        );
    }
}
