//! The independent parts of a friction problem: contacts that blocks of W couple, directly or by way of others.
//!
//! Each part is a problem of its own. A factorisation has n³ operations, so that the parts cost far less than the whole.

use super::matrix::MatrixOperator;
use crate::disjoint_sets::DisjointSets;
use glam::DMat3;

/// The contacts of each part, ascending; parts with fewer contacts first, and of as many in the order of their first contacts.
pub fn split(op: &MatrixOperator) -> Vec<Vec<usize>> {
    let n = op.q.len();
    let mut sets = DisjointSets::new(n);
    for i in 0..n {
        for (j, _) in op.blocks(i).filter(|(_, block)| *block != DMat3::ZERO) {
            sets.join([i as u32, j as u32]);
        }
    }
    let mut parts: Vec<Vec<usize>> = vec![vec![]; n];
    (0..n).for_each(|i| parts[sets.of(i as u32) as usize].push(i));
    parts.retain(|part| !part.is_empty());
    parts.sort_by_key(Vec::len);
    parts
}

/// The problem of some contacts, ascending, that blocks do not couple to others.
pub fn part(op: &MatrixOperator, contacts: &[usize]) -> MatrixOperator {
    let (mut start, mut column, mut block) = (vec![0], vec![], vec![]);
    for i in contacts {
        for (j, own) in op.blocks(*i) {
            // Blocks that are zero may lie between parts.
            if let Ok(place) = contacts.binary_search(&j) {
                column.push(place as u32);
                block.push(own);
            }
        }
        start.push(block.len() as u32);
    }
    let q = contacts.iter().map(|i| op.q[*i]).collect();
    let friction = contacts.iter().map(|i| op.friction[*i]).collect();
    MatrixOperator::new(start, column, block, q, friction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Five contacts: 0, 2 and 3 in a row, 1 alone, 4 coupled to 1 by a block that is zero.
    fn five() -> MatrixOperator {
        let rows: [&[u32]; 5] = [&[0, 2], &[1, 4], &[0, 2], &[2, 3], &[4]];
        let start = vec![0, 2, 4, 6, 8, 9];
        let column: Vec<u32> = rows.concat();
        let mut block: Vec<DMat3> = (1..=9).map(|k| DMat3::IDENTITY * f64::from(k)).collect();
        block[3] = DMat3::ZERO;
        let q = (0..5).map(|i| DVec3::X * f64::from(i)).collect();
        MatrixOperator::new(start, column, block, q, vec![0.0, 0.1, 0.2, 0.3, 0.4])
    }

    #[test]
    fn parts_are_what_blocks_couple() {
        // The block of row 3 and column 2 has no counterpart: W need not be symmetric.
        assert_eq!(split(&five()), [vec![1], vec![4], vec![0, 2, 3]]);
    }

    #[test]
    fn a_part_has_the_velocities_of_the_whole() {
        let op = five();
        let gamma: Vec<DVec3> = (0..5).map(|i| DVec3::new(1.0, 0.1, -0.2) * f64::from(i + 1)).collect();
        for contacts in split(&op) {
            let own = part(&op, &contacts);
            let gammas: Vec<DVec3> = contacts.iter().map(|i| gamma[*i]).collect();
            for (k, i) in contacts.iter().enumerate() {
                assert_eq!(own.velocity(&gammas, k), op.velocity(&gamma, *i), "{i}");
                assert_eq!((own.friction[k], own.q[k]), (op.friction[*i], op.q[*i]), "{i}");
            }
        }
    }
}
