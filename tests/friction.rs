//! Friction problems of our own in the layout of the collections: files whose answer is known on paper, and small piles made here.

use crate::cli::scratch;
use crate::solver::solved;
use glam::{DMat3, DVec3};
use sim::problem::{self, Law};
use sim::{FrictionLaw, Method, SplitMix64};
use std::path::{Path, PathBuf};

fn law(friction: FrictionLaw, method: Option<Method>, tolerance: f64) -> Law {
    Law { friction, tolerance, iterations: 100_000, method }
}

#[test]
fn contacts_that_stick_slide_and_open_have_the_answers_of_paper() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/friction");
    // W is the identity, μ = 0.3. The first sticks: r = −q. The second slides: exact friction has r_n = 1 and |r_t| = 0.3 against
    // the slip; the relaxed law projects −q = (1, −0.3, 0.4) on the cone. The third opens.
    let slip = DVec3::new(0.0, -0.6, 0.8);
    let normal = (1.0 + 0.3 * 0.5) / (1.0 + 0.3 * 0.3);
    for (friction, second) in
        [(FrictionLaw::Exact, DVec3::X + slip * 0.3), (FrictionLaw::Relaxed, (DVec3::X + slip * 0.3) * normal)]
    {
        for file in ["uncoupled_blocks.dat", "uncoupled_dense.dat"] {
            for method in [None, Some(Method::GaussSeidel), Some(Method::Apgd)] {
                let mut problem = problem::read(&folder.join(file)).unwrap();
                let found = problem::solve(&mut problem, &law(friction, method, 1e-9)).gamma;
                for (found, expected) in found.iter().zip([DVec3::new(1.0, -0.2, 0.0), second, DVec3::ZERO]) {
                    assert!((*found - expected).length() < 1e-7, "{file}: {found}, expected {expected}");
                }
                assert_eq!(found.len(), 3);
            }
            solved(&folder.join(file));
        }
    }
}

/// A problem as the files hold it: W by rows of blocks, q, and μ.
struct Problem {
    w: Vec<Vec<DMat3>>,
    q: Vec<DVec3>,
    mu: Vec<f64>,
}

/// A body in contact: reciprocal mass and inertia, velocity.
struct Body {
    at: DVec3,
    inv_mass: f64,
    inv_inertia: f64,
    velocity: DVec3,
}

/// A pile of spheres and blocks on the ground: a block stands on four contacts, so that its impulses are not one answer.
fn pile(seed: u64) -> Problem {
    let mut random = SplitMix64(seed);
    let mut bodies: Vec<Body> = vec![];
    let mut contacts: Vec<Contact> = vec![];
    for i in 0..12 {
        let (column, layer) = (i % 4, i / 4);
        let at =
            DVec3::new(column as f64 + 0.5 * (layer % 2) as f64, random.between(-0.1, 0.1), 0.5 + 0.85 * layer as f64);
        let mass = random.between(0.5, 20.0);
        let velocity = DVec3::from([(); 3].map(|()| random.between(-0.3, 0.3))) - DVec3::Z * 0.1;
        bodies.push(Body { at, inv_mass: 1.0 / mass, inv_inertia: 1.0 / (0.1 * mass), velocity });
        if layer == 0 && column % 2 == 0 {
            for (x, y) in [(-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4)] {
                contacts.push((None, i, at + DVec3::new(x, y, -0.5), DVec3::Z));
            }
        } else if layer == 0 {
            contacts.push((None, i, at - DVec3::Z * 0.5, DVec3::Z));
        }
    }
    for (a, b) in (0..bodies.len()).flat_map(|b| (0..b).map(move |a| (a, b))) {
        let away = bodies[b].at - bodies[a].at;
        if away.length() < 1.1 {
            contacts.push((Some(a), b, 0.5 * (bodies[a].at + bodies[b].at), away.normalize()));
        }
    }
    friction_problem(&bodies, &contacts, || random.between(0.1, 0.9))
}

/// Heavy and light stones on each other: every pair touches at four points, with normals that differ a little, and friction is strong.
fn stones(seed: u64) -> Problem {
    let mut random = SplitMix64(seed);
    let mut vector = |size: f64| DVec3::from([(); 3].map(|()| random.between(-size, size)));
    let mut bodies: Vec<Body> = vec![];
    let mut contacts: Vec<Contact> = vec![];
    for i in 0..20 {
        let (column, layer) = (i % 5, i / 5);
        let place = DVec3::new(0.9 * column as f64 + 0.45 * (layer % 2) as f64, 0.0, 0.45 + 0.8 * layer as f64);
        let at = place + vector(1.0) * DVec3::new(0.2, 0.3, 0.0);
        let mass = 10f64.powf(0.5 + vector(1.0).x);
        let velocity = vector(0.8) - DVec3::Z;
        bodies.push(Body { at, inv_mass: 1.0 / mass, inv_inertia: 1.0 / (0.05 * mass), velocity });
        if layer == 0 {
            contacts.extend(around(DVec3::Z).map(|arm| (None, i, at + arm * 0.4 - DVec3::Z * 0.45, DVec3::Z)));
        }
        for a in 0..i {
            let (away, middle) = (at - bodies[a].at, 0.5 * (at + bodies[a].at));
            if away.length() < 1.15 {
                let normal = away.normalize();
                let point = |arm: DVec3| (Some(a), i, middle + arm * 0.3, (normal + vector(0.08)).normalize());
                contacts.extend(around(normal).map(point));
            }
        }
    }
    friction_problem(&bodies, &contacts, || random.between(0.7, 1.1))
}

/// Four directions around a normal.
fn around(normal: DVec3) -> [DVec3; 4] {
    let (u, v) = normal.any_orthonormal_pair();
    [u, v, -u, -v]
}

/// Bodies A (none is the ground) and B, point, normal from A to B.
type Contact = (Option<usize>, usize, DVec3, DVec3);

/// The friction problem of bodies in contact, without gravity.
fn friction_problem(bodies: &[Body], contacts: &[Contact], mut friction: impl FnMut() -> f64) -> Problem {
    // Velocity of a point of a body by an impulse at another point: v + ω × arm with v = j/m and ω = (arm × j)/J.
    let response = |body: usize, to: DVec3, at: DVec3, impulse: DVec3| {
        let Body { at: centre, inv_mass, inv_inertia, .. } = bodies[body];
        impulse * inv_mass + ((at - centre).cross(impulse) * inv_inertia).cross(to - centre)
    };
    let frame = |n: DVec3| {
        let (u, v) = n.any_orthonormal_pair();
        DMat3::from_cols(n, u, v)
    };
    let sides = |c: &Contact| [(c.0, -1.0), (Some(c.1), 1.0)];
    let mut problem = Problem { w: vec![], q: vec![], mu: vec![] };
    for to in contacts {
        let own = frame(to.3).transpose();
        let row = contacts.iter().map(|from| {
            let mut block = DMat3::ZERO;
            for ((a, sign), (b, other)) in sides(to).into_iter().flat_map(|s| sides(from).map(|t| (s, t))) {
                if let (Some(a), Some(b)) = (a, b)
                    && a == b
                {
                    for c in 0..3 {
                        *block.col_mut(c) += own * response(a, to.2, from.2, frame(from.3).col(c)) * sign * other;
                    }
                }
            }
            block
        });
        problem.w.push(row.collect());
        let velocity = bodies[to.1].velocity - to.0.map_or(DVec3::ZERO, |a| bodies[a].velocity);
        problem.q.push(own * velocity);
        problem.mu.push(friction());
    }
    problem
}

impl Problem {
    /// As the text of a file, with a dense matrix or with blocks.
    fn text(&self, dense: bool) -> String {
        let n = self.q.len();
        let lines = |numbers: &[f64]| numbers.iter().map(|x| format!("  {x:.17e}\n")).collect::<String>();
        let list = |items: &mut dyn Iterator<Item = usize>| items.map(|i| format!("{i}\t")).collect::<String>() + "\n";
        let mut text = format!("3\n{n}\n{}\n{}\n{}\n", if dense { 0 } else { 1 }, 3 * n, 3 * n);
        if dense {
            text += &format!("{}\t{}\n", 3 * n, 3 * n);
            for (j, c) in (0..n).flat_map(|j| (0..3).map(move |c| (j, c))) {
                self.w.iter().for_each(|row| text += &lines(&row[j].col(c).to_array()));
            }
        } else {
            let places = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            let filled: Vec<(usize, usize)> = places.filter(|(i, j)| self.w[*i][*j] != DMat3::ZERO).collect();
            text += &format!("{}\n{n}\n{n}\n", filled.len());
            (0..2).for_each(|_| text += &list(&mut (1..=n).map(|i| 3 * i)));
            text += &format!("{}\n{}\n", n + 1, filled.len());
            text += &list(&mut (0..=n).map(|i| filled.iter().filter(|(row, _)| *row < i).count()));
            text += &list(&mut filled.iter().map(|(_, j)| *j));
            for (k, (i, j)) in filled.iter().enumerate() {
                text += &format!("{k}\n{}", lines(&self.w[*i][*j].to_cols_array()));
            }
        }
        self.q.iter().for_each(|q| text += &lines(&q.to_array()));
        text + &lines(&self.mu)
    }

    /// Error of impulses, over |q|: at each contact u = W r + q (+ μ|u_t| along the normal), and r is the projection of r − u on the
    /// cone.
    fn error(&self, r: &[DVec3], exact: bool) -> f64 {
        let mut sum = 0.0;
        for (i, row) in self.w.iter().enumerate() {
            let mut u = self.q[i] + row.iter().zip(r).map(|(w, r)| *w * *r).sum::<DVec3>();
            if exact {
                u.x += self.mu[i] * u.y.hypot(u.z);
            }
            sum += (r[i] - in_cone(r[i] - u, self.mu[i])).length_squared();
        }
        (sum / self.q.iter().map(|q| q.length_squared()).sum::<f64>()).sqrt()
    }
}

/// The nearest point of the cone |t| ≤ μ n.
fn in_cone(x: DVec3, mu: f64) -> DVec3 {
    let tangent = x.y.hypot(x.z);
    if tangent <= mu * x.x {
        x
    } else if mu * tangent <= -x.x {
        DVec3::ZERO
    } else {
        let normal = (x.x + mu * tangent) / (1.0 + mu * mu);
        DVec3::new(normal, x.y * mu * normal / tangent, x.z * mu * normal / tangent)
    }
}

#[test]
fn piles_of_our_own_are_solved_by_both_laws() {
    let work = scratch();
    for seed in 0..6 {
        let problem = pile(seed);
        assert!(problem.q.len() >= 20, "{} contacts", problem.q.len());
        let paths: [PathBuf; 2] = ["dense.dat", "blocks.dat"].map(|name| work.path().join(name));
        for (path, dense) in paths.iter().zip([true, false]) {
            std::fs::write(path, problem.text(dense)).unwrap();
        }
        for friction in [FrictionLaw::Exact, FrictionLaw::Relaxed] {
            let solutions = paths.clone().map(|path| {
                let mut read = problem::read(&path).unwrap();
                problem::solve(&mut read, &law(friction, None, 1e-6))
            });
            for solution in &solutions {
                let error = problem.error(&solution.gamma, friction == FrictionLaw::Exact);
                assert!(solution.error <= 1e-6, "pile {seed}, {friction:?}: {}", solution.error);
                assert!(
                    (error - solution.error).abs() < 1e-3 * error + 1e-12,
                    "{error}, but the solution says {}",
                    solution.error
                );
            }
            // Both layouts are one problem.
            assert_eq!(solutions[0].gamma, solutions[1].gamma, "pile {seed}");
        }
        if seed == 0 {
            paths.iter().for_each(|path| solved(path));
        }
    }
}

#[test]
fn stiff_piles_of_stones_are_solved_to_the_end() {
    let folder = scratch();
    let path = folder.path().join("stones.dat");
    for seed in 0..2 {
        let problem = stones(seed);
        std::fs::write(&path, problem.text(true)).unwrap();
        let solve = || {
            let mut read = problem::read(&path).unwrap();
            problem::solve(&mut read, &law(FrictionLaw::Exact, None, 1e-8))
        };
        let solution = solve();
        let error = problem.error(&solution.gamma, true);
        assert!(error <= 1.001e-8, "stones {seed}: {error} after {} of {}", solution.iterations, solution.method);
        if seed == 0 {
            assert!(
                ["newton", "central_path"].contains(&solution.method),
                "the sweeps stall, but: {}",
                solution.method
            );
            assert_eq!(solve().gamma, solution.gamma, "one input, one answer");
        }
    }
}

#[test]
fn stiff_piles_with_contacts_without_friction_are_solved_by_continuation() {
    let folder = scratch();
    let path = folder.path().join("slippery.dat");
    for seed in [0, 4] {
        let mut problem = stones(seed);
        problem.mu.iter_mut().step_by(4).for_each(|mu| *mu = 0.0);
        std::fs::write(&path, problem.text(false)).unwrap();
        let solve = |iterations: u32| {
            let mut read = problem::read(&path).unwrap();
            problem::solve(&mut read, &Law { iterations, ..law(FrictionLaw::Exact, None, 1e-8) })
        };
        let solution = solve(100_000);
        let error = problem.error(&solution.gamma, true);
        assert!(error <= 1.001e-8, "stones {seed}: {error} by {}", solution.method);
        assert_eq!(solution.method, "continuation", "stones {seed}: the sweeps stall, and Newton's method from there");
        if seed == 4 {
            assert_eq!(solve(100_000).gamma, solution.gamma, "one input, one answer");
            // Without iterations for it, the sweeps' answer is as they leave it.
            let left = solve(17_000);
            assert!(left.error > 1e-8 && ["gauss_seidel", "apgd"].contains(&left.method), "{}", left.method);
        }
    }
}

/// A pile with the W of an implicit step: W + W S W, where S is skew, as the derivative of gyroscopic torques.
fn gyroscopic(seed: u64) -> Problem {
    let mut problem = pile(seed);
    let n = problem.q.len();
    let mean = (0..n).map(|i| problem.w[i][i].x_axis.x).sum::<f64>() / n as f64;
    let skew = |k: usize| {
        let s = DVec3::new(k as f64, 1.0 + k as f64, 2.0).map(f64::sin) * (0.2 / mean);
        DMat3::from_cols(DVec3::new(0.0, s.z, -s.y), DVec3::new(-s.z, 0.0, s.x), DVec3::new(s.y, -s.x, 0.0))
    };
    let turned = |w: &[Vec<DMat3>], i: usize, j: usize| (0..n).map(|k| w[i][k] * skew(k) * w[k][j]).sum::<DMat3>();
    let w = (0..n).map(|i| (0..n).map(|j| problem.w[i][j] + turned(&problem.w, i, j)).collect()).collect();
    problem.w = w;
    problem
}

#[test]
fn unsymmetric_problems_are_solved_by_both_laws() {
    let folder = scratch();
    for seed in 0..3 {
        let problem = gyroscopic(seed);
        let path = folder.path().join("gyroscopic.dat");
        std::fs::write(&path, problem.text(false)).unwrap();
        let asymmetry = (problem.w[0][1] - problem.w[1][0].transpose()).to_cols_array();
        assert!(seed > 0 || asymmetry.iter().any(|a| a.abs() > 1e-3 * problem.w[0][0].x_axis.x), "{asymmetry:?}");
        for friction in [FrictionLaw::Exact, FrictionLaw::Relaxed] {
            let mut read = problem::read(&path).unwrap();
            let solution = problem::solve(&mut read, &law(friction, None, 1e-8));
            let error = problem.error(&solution.gamma, friction == FrictionLaw::Exact);
            assert!(error <= 1.001e-8, "pile {seed}, {friction:?}: {error} by {}", solution.method);
        }
    }
}
