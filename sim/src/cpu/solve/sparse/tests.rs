//! Tests of the sparse factorisation against dense elimination, on mechanisms of many topologies.

use super::*;
use crate::fill::SplitMix64;

/// A system: groups of rows between bodies, and Jacobians of the rows on their bodies.
struct System {
    size: Vec<u32>,
    order: Vec<u32>,
    elements: Vec<Vec<u32>>,
    /// A Jacobian of each element, group and row.
    jacobian: std::collections::HashMap<(usize, u32, usize), [f64; 6]>,
}

impl System {
    fn new(n_bodies: usize, ends: &[[Option<u32>; 2]], size: impl Fn(usize) -> u32) -> System {
        let mut elements = vec![vec![]; n_bodies];
        for (g, ends) in ends.iter().enumerate() {
            ends.iter().flatten().for_each(|b| elements[*b as usize].push(g as u32));
        }
        let size: Vec<u32> = (0..ends.len()).map(size).collect();
        let mut random = SplitMix64(3);
        let mut jacobian = std::collections::HashMap::new();
        for (e, groups) in elements.iter().enumerate() {
            for g in groups {
                for k in 0..size[*g as usize] as usize {
                    jacobian.insert((e, *g, k), std::array::from_fn(|_| random.between(-1.0, 1.0)));
                }
            }
        }
        let order = order(n_bodies, ends);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, g)| i == *g as usize) && sorted.len() == ends.len());
        System { size, order, elements, jacobian }
    }

    fn factor(&mut self, softness: f64) -> Factor {
        let mut factor = Factor::new(Structure::analyse(&self.size, self.size.len(), &self.order, &mut self.elements));
        factor.diagonal().fill(softness);
        self.factorise(&mut factor);
        factor
    }

    fn factorise(&self, factor: &mut Factor) {
        factor.factorise(1e-14, |front, e, first| {
            let groups = self.elements[e].iter().zip(first);
            let rows: Vec<(usize, [f64; 6])> = groups
                .flat_map(|(g, first)| {
                    (0..self.size[*g as usize] as usize).map(move |k| (*first as usize + k, self.jacobian[&(e, *g, k)]))
                })
                .collect();
            for (p, (i, a)) in rows.iter().enumerate() {
                let mut row = front.row(*i);
                rows[..=p].iter().for_each(|(j, b)| row.add(*j, a.iter().zip(b).map(|(x, y)| x * y).sum()));
            }
        });
    }

    /// S x, by the rows of the factor.
    fn product(&self, factor: &Factor, x: &[f64], softness: f64) -> Vec<f64> {
        let mut b: Vec<f64> = x.iter().map(|x| softness * x).collect();
        for (e, groups) in self.elements.iter().enumerate() {
            let rows = || {
                groups.iter().flat_map(move |g| {
                    let first = factor.first()[*g as usize] as usize;
                    (0..self.size[*g as usize] as usize).map(move |k| (first + k, self.jacobian[&(e, *g, k)]))
                })
            };
            let mut speed = [0.0; 6];
            rows().for_each(|(i, j)| speed.iter_mut().zip(j).for_each(|(s, j)| *s += j * x[i]));
            rows().for_each(|(i, j)| b[i] += speed.iter().zip(j).map(|(s, j)| s * j).sum::<f64>());
        }
        b
    }

    /// Solve for a known solution; the greatest error.
    fn error(&mut self, softness: f64) -> f64 {
        let mut factor = self.factor(softness);
        let mut x = vec![0.0; factor.rows().len()];
        let mut random = SplitMix64(9);
        for (first, size) in factor.first().iter().zip(&self.size) {
            x[*first as usize..(first + size) as usize].iter_mut().for_each(|x| *x = random.between(-1.0, 1.0));
        }
        let b = self.product(&factor, &x, softness);
        factor.rows().copy_from_slice(&b);
        factor.solve();
        let by_phases = solve_by_phases(&factor, &b);
        let off = by_phases.iter().zip(factor.rows()).map(|(a, b)| (a - *b).abs()).fold(0.0, f64::max);
        assert!(off < 2e-3, "{off} by phases, with numbers of single precision");
        factor.rows().iter().zip(&x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}

/// Solve by phases for a right-hand side.
fn solve_by_phases(factor: &Factor, b: &[f64]) -> Vec<f64> {
    let phases = factor.phases();
    let mut numbers = vec![];
    factor.numbers(&mut numbers);
    let mut x = [b, &vec![0.0; b.len()]].concat();
    for rows in phases.start.windows(2) {
        for [row, first, end] in &phases.row[rows[0] as usize..rows[1] as usize] {
            let terms = &phases.term[*first as usize..*end as usize];
            let sum: f64 = terms.iter().map(|[row, n]| x[*row as usize] * f64::from(numbers[*n as usize])).sum();
            let is_added = (*row as usize) < phases.n_rows;
            x[*row as usize] = sum + if is_added { x[*row as usize] } else { 0.0 };
        }
    }
    x.split_off(b.len())
}

/// Bodies and joints of a grid whose first bodies hang on the world.
fn grid(n: u32, m: u32) -> (usize, Vec<[Option<u32>; 2]>) {
    let mut ends = vec![];
    for k in 0..n {
        for i in 0..m {
            let b = k * m + i;
            ends.push([(i > 0).then(|| b - 1), Some(b)]);
            if k > 0 {
                ends.push([Some(b - m), Some(b)]);
            }
        }
    }
    ((n * m) as usize, ends)
}

fn topologies() -> Vec<(&'static str, usize, Vec<[Option<u32>; 2]>)> {
    let chain = |n: u32| -> Vec<_> { (0..n).map(|i| [i.checked_sub(1), Some(i)]).collect() };
    let ring: Vec<_> = (0..50).map(|i| [Some(i), Some((i + 1) % 50)]).collect();
    let star: Vec<_> = (1..40).map(|i| [Some(0), Some(i)]).collect();
    let wheel = [ring.clone(), (0..50).map(|i| [Some(50), Some(i)]).collect()].concat();
    let tree: Vec<_> = (1..200).map(|i| [Some((i - 1) / 3), Some(i)]).collect();
    let mut random = SplitMix64(1);
    let mut tangle: Vec<_> = (0..150).map(|_| [random.below(60) as u32, random.below(60) as u32]).collect();
    tangle.iter_mut().for_each(|e| e.sort_unstable());
    tangle.sort_unstable();
    tangle.dedup();
    let tangle: Vec<_> = tangle.iter().filter(|[a, b]| a != b).map(|e| e.map(Some)).collect();
    let islands: Vec<_> = (0..90).map(|i| [Some(i), Some(i / 9 * 9 + (i + 1) % 9)]).collect();
    let ((n_small, small), (n_large, large)) = (grid(7, 5), grid(34, 31));
    vec![
        ("one body", 1, chain(1)),
        ("chain", 300, chain(300)),
        ("ring", 50, ring),
        ("star", 40, star),
        ("wheel", 51, wheel),
        ("tree", 200, tree),
        ("tangle", 60, tangle),
        ("islands", 90, islands),
        ("small grid", n_small, small),
        ("large grid", n_large, large),
    ]
}

#[test]
fn any_topology_is_solved() {
    for (name, n_bodies, ends) in topologies() {
        for sizes in [[3, 3, 3], [1, 5, 6], [2, 7, 4]] {
            let mut system = System::new(n_bodies, &ends, |g| sizes[g % 3]);
            let error = system.error(0.1);
            assert!(error < 1e-11, "{name}, groups of {sizes:?}: {error:e}");
        }
    }
}

#[test]
fn a_chain_has_no_fill_and_a_grid_little() {
    let size = |n_bodies: usize, ends: &[[Option<u32>; 2]]| {
        let mut system = System::new(n_bodies, ends, |_| 3);
        let factor = system.factor(0.1);
        (factor.n_numbers(), factor.work())
    };
    let chain: Vec<_> = (0..3000u32).map(|i| [i.checked_sub(1), Some(i)]).collect();
    let (numbers, _) = size(3000, &chain);
    assert!(numbers < 3000 * 60, "{numbers} numbers");
    // Twice the grid's width: n² log n numbers, n³ multiplications.
    let ((a, small), (b, large)) = (grid(20, 20), grid(40, 40));
    let ((few, cheap), (many, dear)) = (size(a, &small), size(b, &large));
    assert!(many < few * 6 && dear < cheap * 10, "{few} and {many} numbers, {cheap} and {dear} multiplications");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (n_bodies, ends) = grid(36, 36);
    let mut system = System::new(n_bodies, &ends, |_| 3);
    let mut factor = system.factor(0.1);
    assert!(factor.levels.len() > 1 && factor.levels[0].len() > 2, "no trees side by side");
    let one = |n: usize, factor: &mut Factor| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads");
        pool.install(|| system.factorise(factor));
        factor.rows().fill(1.0);
        factor.solve();
        factor.rows().iter().map(|x| x.to_bits()).collect::<Vec<u64>>()
    };
    let first = one(1, &mut factor);
    assert!(first == one(2, &mut factor) && first == one(7, &mut factor));
}

#[test]
fn the_lanes_do_not_change_the_bits() {
    let (n_bodies, ends) = grid(9, 8);
    let mut system = System::new(n_bodies, &ends, |g| 1 + g as u32 % 6);
    let mut factor = system.factor(0.1);
    let (own, border) = (28, 20);
    let mut random = SplitMix64(4);
    let front: Vec<f64> = (0..(own + border) * own).map(|_| random.between(-0.1, 0.1)).collect();
    let eliminated = |is_wide: bool| {
        let (mut panel, mut update) = (front.clone(), vec![0.0; border * border]);
        (0..own).for_each(|i| panel[(i / TILE * own + i) * TILE + i % TILE] = 9.0);
        let task = front::Eliminate { panel: &mut panel, update: &mut update, own, border, min_pivot: 1e-14 };
        if is_wide {
            widest(task)
        } else {
            task.run::<crate::lanes::Plain<f64, 4>>()
        }
        (panel, update)
    };
    assert!(eliminated(true) == eliminated(false));
    let mut solved = |is_wide: bool| {
        let Factor { structure, panels, x, at_border, sums, .. } = &mut factor;
        x.fill(1.0);
        let task = Solve { structure, panels, x, at_border, sums };
        if is_wide {
            widest(task)
        } else {
            task.run::<crate::lanes::Plain<f64, 4>>()
        }
        factor.rows().to_vec()
    };
    assert!(solved(true) == solved(false));
}

#[test]
fn dissection_orders_all_vertices_and_separates_halves() {
    // A strip of 3 × 40 vertices, with two more on their own.
    let (rows, columns) = (3u32, 40u32);
    let at = |r: u32, c: u32| c * rows + r;
    let along = (0..columns - 1).flat_map(|c| (0..rows).map(move |r| [at(r, c), at(r, c + 1)]));
    let across = (0..columns).flat_map(|c| (0..rows - 1).map(move |r| [at(r, c), at(r + 1, c)]));
    let edges: Vec<[u32; 2]> = along.chain(across).collect();
    let n = (rows * columns) as usize + 2;
    let ends: Vec<[Option<u32>; 2]> = edges.iter().map(|edge| edge.map(Some)).collect();
    let order = dissection(n, &ends);
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert!(sorted.iter().enumerate().all(|(i, v)| i == *v as usize) && sorted.len() == n);
    // By an order that jumps about, the factorisation is more than twice the work.
    let work = |order: &[u32]| {
        let mut elements: Vec<Vec<u32>> = edges.iter().map(|e| e.to_vec()).collect();
        Factor::new(Structure::analyse(&vec![6; n], n, order, &mut elements)).work()
    };
    let worst: Vec<u32> = (0..n as u32).map(|v| v * 7 % n as u32).collect();
    assert!(2 * work(&order) < work(&worst), "{} {}", work(&order), work(&worst));
    assert!(dissection(0, &[]).is_empty() && dissection(1, &[]) == [0]);
}
