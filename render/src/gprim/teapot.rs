//! The teapot.

use crate::gprim::quadric::{AROUND, Profile, revolve};
use crate::scene::patch::Patch;
use glam::Vec3;

/// The teapot of Newell (1975), its axis along z and its bottom at 0.
pub fn teapot() -> Vec<Patch> {
    let profile = |list: &[[f32; 2]]| -> Vec<Profile> {
        let n = (list.len() - 1) / 3;
        (0..n)
            .map(|k| {
                let p = [0, 1, 2, 3].map(|i| Vec3::new(list[3 * k + i][0], 0.0, list[3 * k + i][1]));
                (p, [k as f32 / n as f32, (k + 1) as f32 / n as f32])
            })
            .collect()
    };
    #[rustfmt::skip]
    let body = [
        [0.0, 0.0], [1.425, 0.0], [1.5, 0.075], [1.5, 0.15], [1.5, 0.225], [2.0, 0.45], [2.0, 0.9], [2.0, 1.35],
        [1.75, 1.875], [1.5, 2.4], [1.4375, 2.53125], [1.3375, 2.53125], [1.4, 2.4],
    ];
    let lid = [[1.3, 2.4], [1.3, 2.4], [0.4, 2.4], [0.2, 2.55], [0.0, 2.7], [0.8, 3.15], [0.0, 3.15]];
    // Half of the spout and of the handle: rows from the body outwards, y going to one side; the other is its mirror image.
    #[rustfmt::skip]
    let spout: [[[f32; 3]; 4]; 7] = [
        [[1.7, 0.0, 1.425], [1.7, 0.66, 1.425], [1.7, 0.66, 0.6], [1.7, 0.0, 0.6]],
        [[2.6, 0.0, 1.425], [2.6, 0.66, 1.425], [3.1, 0.66, 0.825], [3.1, 0.0, 0.825]],
        [[2.3, 0.0, 2.1], [2.3, 0.25, 2.1], [2.4, 0.25, 2.025], [2.4, 0.0, 2.025]],
        [[2.7, 0.0, 2.4], [2.7, 0.25, 2.4], [3.3, 0.25, 2.4], [3.3, 0.0, 2.4]],
        [[2.8, 0.0, 2.475], [2.8, 0.25, 2.475], [3.525, 0.25, 2.49375], [3.525, 0.0, 2.49375]],
        [[2.9, 0.0, 2.475], [2.9, 0.15, 2.475], [3.45, 0.15, 2.5125], [3.45, 0.0, 2.5125]],
        [[2.8, 0.0, 2.4], [2.8, 0.15, 2.4], [3.2, 0.15, 2.4], [3.2, 0.0, 2.4]],
    ];
    #[rustfmt::skip]
    let handle: [[[f32; 3]; 4]; 7] = [
        [[-1.6, 0.0, 2.025], [-1.6, 0.3, 2.025], [-1.5, 0.3, 2.25], [-1.5, 0.0, 2.25]],
        [[-2.3, 0.0, 2.025], [-2.3, 0.3, 2.025], [-2.5, 0.3, 2.25], [-2.5, 0.0, 2.25]],
        [[-2.7, 0.0, 2.025], [-2.7, 0.3, 2.025], [-3.0, 0.3, 2.25], [-3.0, 0.0, 2.25]],
        [[-2.7, 0.0, 1.8], [-2.7, 0.3, 1.8], [-3.0, 0.3, 1.8], [-3.0, 0.0, 1.8]],
        [[-2.7, 0.0, 1.575], [-2.7, 0.3, 1.575], [-3.0, 0.3, 1.35], [-3.0, 0.0, 1.35]],
        [[-2.5, 0.0, 1.125], [-2.5, 0.3, 1.125], [-2.65, 0.3, 0.9375], [-2.65, 0.0, 0.9375]],
        [[-2.0, 0.0, 0.9], [-2.0, 0.3, 0.9], [-1.9, 0.3, 0.6], [-1.9, 0.0, 0.6]],
    ];
    let mut patches = revolve(&profile(&body), 360.0, AROUND);
    patches.extend(revolve(&profile(&lid), 360.0, AROUND));
    // Seen from outside, u × v points outwards on each half.
    for (rows, outward) in [(spout, true), (handle, false)] {
        for k in [0, 3] {
            for mirrored in [false, true] {
                let mut p = [Vec3::ZERO; 16];
                for (i, q) in p.iter_mut().enumerate() {
                    let column = if mirrored == outward { i % 4 } else { 3 - i % 4 };
                    let [x, y, z] = rows[k + i / 4][column];
                    *q = Vec3::new(x, if mirrored { -y } else { y }, z);
                }
                patches.push(Patch::smooth(p, [0.0, 1.0], [0.0, 1.0]));
            }
        }
    }
    patches
}
