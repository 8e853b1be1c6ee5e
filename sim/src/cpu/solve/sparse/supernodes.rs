//! The symbolic factorisation: which groups of rows are eliminated together (a supernode), which groups each supernode changes (its
//! border), and where all that lies. Groups enter by elements: sets of groups that are all coupled, as those of a body are.
//!
//! Supernodes come in postorder, children before parents. Rows of a supernode, its front: its own, padded to whole tiles of [`TILE`],
//! and then those of its border in ascending order, padded too.
//! Source: Liu, *The multifrontal method for sparse matrix solution* (1992); supernodes are merged as Ashcraft and Grimes (1989) do.

use std::ops::Range;

/// Rows and columns of a tile.
pub const TILE: usize = 4;

/// A set of groups of rows that are eliminated together.
#[derive(Clone, Debug, Default)]
pub struct Node {
    /// Own rows, padded, and those of the border, padded.
    pub own: usize,
    pub border: usize,
    /// Own rows without padding: of `own`, these are numbers.
    pub n_own: usize,
    /// First of its own rows among the rows of all supernodes.
    pub first: usize,
    /// First number of its columns in the factor.
    pub panel: usize,
    /// First number of its update in the workspace, which is the start of its descendants' part of it.
    pub update: usize,
    /// End of its descendants' part of the workspace.
    pub update_end: usize,
    /// Rows of the border among the rows of all supernodes, padding left out: a range of [`Structure::border`].
    pub rows: Range<usize>,
    /// Elements that are added to its front: a range of [`Structure::elements`].
    pub elements: Range<usize>,
    /// Children: a range of [`Structure::children`].
    pub children: Range<usize>,
    /// First of its descendants.
    pub descendants: usize,
    /// Work of its elimination and its descendants', multiplications.
    pub work: u64,
    /// Whether its pivots are negative.
    pub is_negative: bool,
}

/// The structure of a factor.
#[derive(Clone, Debug, Default)]
pub struct Structure {
    /// Supernodes in postorder.
    pub nodes: Vec<Node>,
    /// Rows of the borders among all rows, and among the rows of the parent's front.
    pub border: Vec<u32>,
    pub in_parent: Vec<u32>,
    /// Elements of the supernodes.
    pub elements: Vec<u32>,
    /// Children of the supernodes.
    pub children: Vec<u32>,
    /// First row of each element's groups in the front that it is added to: starts (n_elements + 1), rows.
    pub local_start: Vec<u32>,
    pub local: Vec<u32>,
    /// First row of each group among all rows.
    pub first: Vec<u32>,
    /// Numbers of all rows, of the factor, and of the updates that are alive at once.
    pub n_rows: usize,
    pub n_factor: usize,
    pub n_updates: usize,
}

/// Share of zeros that merged supernodes of up to so many columns may have.
const MERGE: [(usize, f64); 4] = [(12, 0.7), (32, 0.25), (64, 0.12), (usize::MAX, 0.04)];

/// A supernode while supernodes are merged: its groups by their places in the order.
#[derive(Default)]
struct Draft {
    groups: Vec<u32>,
    border: Vec<u32>,
    children: Vec<u32>,
    n_own: usize,
    n_border: usize,
    /// Entries that are zero.
    zeros: usize,
    is_negative: bool,
}

impl Structure {
    /// Analyse: `size` are the rows of each group, `order` the groups in the order of elimination, `elements` the groups of each element,
    /// which come to be sorted by their rows. Groups from `first_negative` on have negative pivots.
    pub fn analyse(size: &[u32], first_negative: usize, order: &[u32], elements: &mut [Vec<u32>]) -> Structure {
        let mut place = vec![0u32; size.len()];
        order.iter().enumerate().for_each(|(k, g)| place[*g as usize] = k as u32);
        let sizes: Vec<usize> = order.iter().map(|g| size[*g as usize] as usize).collect();
        let is_negative: Vec<bool> = order.iter().map(|g| *g as usize >= first_negative).collect();
        let (mut drafts, top) = merged(&sizes, &is_negative, &place, elements);
        let nodes = postorder(&drafts, &top);
        let mut s = Structure { first: vec![0; size.len()], local_start: vec![0], ..Structure::default() };
        let node_of = s.place_rows(&nodes, &mut drafts, &sizes, order);
        elements.iter_mut().for_each(|groups| groups.sort_unstable_by_key(|g| s.first[*g as usize]));
        s.place_elements(&place, &node_of, elements, &drafts, &nodes, &sizes);
        s.place_borders(&nodes, &drafts, &node_of, &sizes, order);
        s.place_updates();
        s
    }

    /// Number the rows. Returns the supernode of each place in the order.
    fn place_rows(&mut self, nodes: &[u32], drafts: &mut [Draft], sizes: &[usize], order: &[u32]) -> Vec<u32> {
        let mut node_of = vec![0u32; sizes.len()];
        for (k, d) in nodes.iter().enumerate() {
            let draft = &mut drafts[*d as usize];
            draft.groups.sort_unstable();
            let mut row = self.n_rows;
            for g in &draft.groups {
                node_of[*g as usize] = k as u32;
                self.first[order[*g as usize] as usize] = row as u32;
                row += sizes[*g as usize];
            }
            let (own, border) = (padded(draft.n_own), padded(draft.n_border));
            self.nodes.push(Node {
                own,
                border,
                n_own: draft.n_own,
                first: self.n_rows,
                panel: self.n_factor,
                is_negative: draft.is_negative,
                ..Node::default()
            });
            self.n_rows += own;
            self.n_factor += own * (own + border);
        }
        node_of
    }

    /// Give each element to the supernode that eliminates the first of its groups.
    fn place_elements(
        &mut self,
        place: &[u32],
        node_of: &[u32],
        elements: &[Vec<u32>],
        drafts: &[Draft],
        nodes: &[u32],
        sizes: &[usize],
    ) {
        let mut of_node: Vec<Vec<u32>> = vec![vec![]; self.nodes.len()];
        for (e, groups) in elements.iter().enumerate() {
            if let Some(node) = groups.iter().map(|g| node_of[place[*g as usize] as usize]).min() {
                of_node[node as usize].push(e as u32);
            }
        }
        let mut local: Vec<Vec<u32>> = vec![vec![]; elements.len()];
        let mut row_of = vec![0u32; sizes.len()];
        for (k, mine) in of_node.iter().enumerate() {
            let (node, draft) = (&mut self.nodes[k], &drafts[nodes[k] as usize]);
            let mut row = 0;
            for g in &draft.groups {
                row_of[*g as usize] = row as u32;
                row += sizes[*g as usize];
            }
            let mut border = draft.border.clone();
            border.sort_unstable_by_key(|g| (node_of[*g as usize], *g));
            row = node.own;
            for g in &border {
                row_of[*g as usize] = row as u32;
                row += sizes[*g as usize];
            }
            let first = self.elements.len();
            self.elements.extend(mine);
            node.elements = first..self.elements.len();
            for e in mine {
                local[*e as usize] =
                    elements[*e as usize].iter().map(|g| row_of[place[*g as usize] as usize]).collect();
            }
        }
        for rows in &local {
            self.local.extend(rows);
            self.local_start.push(self.local.len() as u32);
        }
    }

    /// Number the rows of the borders, among all rows and in the parents' fronts.
    fn place_borders(&mut self, nodes: &[u32], drafts: &[Draft], node_of: &[u32], sizes: &[usize], order: &[u32]) {
        let n = self.nodes.len();
        let mut children: Vec<Vec<u32>> = vec![vec![]; n];
        for k in 0..n {
            let mut border = drafts[nodes[k] as usize].border.clone();
            border.sort_unstable_by_key(|g| (node_of[*g as usize], *g));
            let first = self.border.len();
            for g in &border {
                let row = self.first[order[*g as usize] as usize];
                self.border.extend(row..row + sizes[*g as usize] as u32);
            }
            self.nodes[k].rows = first..self.border.len();
            if let Some(g) = border.first() {
                children[node_of[*g as usize] as usize].push(k as u32);
            }
        }
        self.in_parent = vec![0; self.border.len()];
        let mut row_of = vec![0u32; self.n_rows];
        for (k, children) in children.iter().enumerate() {
            let node = &self.nodes[k];
            (0..node.own).for_each(|i| row_of[node.first + i] = i as u32);
            for (i, row) in self.border[node.rows.clone()].iter().enumerate() {
                row_of[*row as usize] = (node.own + i) as u32;
            }
            for c in children {
                for i in self.nodes[*c as usize].rows.clone() {
                    self.in_parent[i] = row_of[self.border[i] as usize];
                }
            }
            let first = self.children.len();
            self.children.extend(children);
            self.nodes[k].children = first..self.children.len();
            self.nodes[k].descendants = children.first().map_or(k, |c| self.nodes[*c as usize].descendants);
        }
    }

    /// Lay out the updates: a supernode's lies where those of its descendants were, which are gone by then.
    fn place_updates(&mut self) {
        let mut need = vec![0usize; self.nodes.len()];
        for k in 0..self.nodes.len() {
            let children = &self.children[self.nodes[k].children.clone()];
            let of_children: usize = children.iter().map(|c| need[*c as usize]).sum();
            let below: u64 = children.iter().map(|c| self.nodes[*c as usize].work).sum();
            let node = &mut self.nodes[k];
            need[k] = of_children.max(node.border * node.border);
            let (own, border) = (node.own as u64, node.border as u64);
            node.work = below + own * own * own / 6 + own * border * (own + border) / 2;
        }
        let mut is_child = vec![false; self.nodes.len()];
        self.children.iter().for_each(|c| is_child[*c as usize] = true);
        for k in (0..self.nodes.len()).filter(|k| !is_child[*k]) {
            self.nodes[k].update = self.n_updates;
            self.n_updates += need[k];
        }
        for k in (0..self.nodes.len()).rev() {
            let mut at = self.nodes[k].update;
            self.nodes[k].update_end = at + need[k];
            for c in self.nodes[k].children.clone() {
                let c = self.children[c] as usize;
                self.nodes[c].update = at;
                at += need[c];
            }
        }
    }
}

/// A number of rows in whole tiles.
fn padded(n: usize) -> usize {
    n.next_multiple_of(TILE)
}

/// Supernodes by the place of their last group, and which of these there are.
fn merged(sizes: &[usize], is_negative: &[bool], place: &[u32], elements: &[Vec<u32>]) -> (Vec<Draft>, Vec<u32>) {
    let n = sizes.len();
    let mut of_place: Vec<Vec<u32>> = vec![vec![]; n];
    for (e, groups) in elements.iter().enumerate() {
        if let Some(k) = groups.iter().map(|g| place[*g as usize]).min() {
            of_place[k as usize].push(e as u32);
        }
    }
    let mut drafts: Vec<Draft> = (0..n).map(|_| Draft::default()).collect();
    let mut mark = vec![u32::MAX; n];
    let mut top = vec![];
    for k in 0..n {
        let children = std::mem::take(&mut drafts[k].children);
        let mut border = vec![];
        let mut take = |g: u32| {
            if g as usize != k && std::mem::replace(&mut mark[g as usize], k as u32) != k as u32 {
                border.push(g);
            }
        };
        for e in &of_place[k] {
            elements[*e as usize].iter().for_each(|g| take(place[*g as usize]));
        }
        for c in &children {
            drafts[*c as usize].border.iter().for_each(|g| take(*g));
        }
        border.sort_unstable();
        match border.first() {
            Some(parent) => drafts[*parent as usize].children.push(k as u32),
            None => top.push(k as u32),
        }
        let n_border = border.iter().map(|g| sizes[*g as usize]).sum();
        drafts[k] = Draft {
            groups: vec![k as u32],
            border,
            children,
            n_own: sizes[k],
            n_border,
            zeros: 0,
            is_negative: is_negative[k],
        };
        merge_children(&mut drafts, k);
    }
    (drafts, top)
}

/// Merge those children of a supernode with it that leave few zeros.
fn merge_children(drafts: &mut [Draft], k: usize) {
    let mut children = std::mem::take(&mut drafts[k].children);
    // Those with the longest borders leave the fewest zeros.
    children.sort_by_key(|c| std::cmp::Reverse((drafts[*c as usize].n_border, *c)));
    let mut kept = vec![];
    for c in children {
        let (parent, child) = (&drafts[k], &drafts[c as usize]);
        let n_own = parent.n_own + child.n_own;
        let zeros = parent.zeros + child.zeros + child.n_own * (parent.n_own + parent.n_border - child.n_border);
        let all = n_own * (n_own + 1) / 2 + n_own * parent.n_border;
        let share = MERGE.iter().find(|(most, _)| n_own <= *most).map_or(0.0, |(_, share)| *share);
        if child.is_negative != parent.is_negative || zeros as f64 > share * all as f64 {
            kept.push(c);
            continue;
        }
        let child = std::mem::take(&mut drafts[c as usize]);
        let parent = &mut drafts[k];
        parent.groups.extend(child.groups);
        kept.extend(child.children);
        (parent.n_own, parent.zeros) = (n_own, zeros);
    }
    kept.sort_unstable();
    drafts[k].children = kept;
}

/// Children before their parents, each with all that is below it in a row.
fn postorder(drafts: &[Draft], top: &[u32]) -> Vec<u32> {
    let mut from_end = vec![];
    let mut open: Vec<u32> = top.to_vec();
    while let Some(k) = open.pop() {
        from_end.push(k);
        open.extend(&drafts[k as usize].children);
    }
    from_end.reverse();
    from_end
}
