//! Rays: `gather`.

use super::super::scene::Scene;
use super::state::Machine;
use crate::ir::*;
use crate::shadeop::direction::in_cone;
use crate::shadeop::runs::{at, put, triple};

impl Machine {
    /// Rays from a place about an axis.
    pub(super) fn gather(
        &mut self,
        program: &Program,
        args: [Reg; 4],
        out: &[(String, Reg)],
        hit: &[Op],
        miss: &[Op],
        scene: &dyn Scene,
    ) {
        let n = self.n;
        let [p, axis, angle, samples] = args.map(|r| self.regs[r as usize].clone());
        let samples = at(&samples, 0).clamp(1.0, 1024.0) as usize;
        let outer = self.mask.clone();
        for i in 0..samples {
            let mut ways = vec![0.0; 3 * n];
            let mut lengths = vec![0.0; n];
            let (mut hits, mut misses) = (vec![false; n], vec![false; n]);
            for k in (0..n).filter(|k| outer.as_ref().is_none_or(|m| m[*k])) {
                let (from, about) = (triple(&p, k, n), triple(&axis, k, n));
                let way = in_cone(about, at(&angle, k), i, samples, from);
                put(&mut ways, k, n, way);
                match scene.hit(from, way) {
                    Some(distance) => (lengths[k], hits[k]) = (distance, true),
                    None => misses[k] = true,
                }
            }
            for (name, reg) in out {
                let w = program.widths[*reg as usize] as usize;
                match name.as_str() {
                    "ray:direction" if w == 3 => self.assign_value(*reg, &ways, 3),
                    "ray:origin" if w == 3 => self.assign_value(*reg, &p, 3),
                    "ray:length" if w == 1 => self.assign_value(*reg, &lengths, 1),
                    _ if w == 3 && name.ends_with(":Ci") => {
                        let mut colors = vec![0.0; 3 * n];
                        for k in (0..n).filter(|k| hits[*k]) {
                            let color = scene.trace(triple(&p, k, n), triple(&ways, k, n), samples > 1);
                            put(&mut colors, k, n, color);
                        }
                        self.assign_value(*reg, &colors, 3);
                    }
                    _ => {}
                }
            }
            for (mask, ops) in [(hits, hit), (misses, miss)] {
                if mask.contains(&true) {
                    self.mask = Some(mask);
                    self.block(program, ops, scene);
                }
            }
            self.mask.clone_from(&outer);
            self.drop_left();
            if self.all_off() {
                break;
            }
        }
    }
}
