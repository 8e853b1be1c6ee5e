//! `gather`: a loop over rays, whose distances the host's function `scene_hit` gives.

use super::module::Query;
use super::writer::{Done, Leaves, Writer};
use crate::ir::{MAX_GATHERED, Op, Reg};

impl Writer<'_, '_> {
    pub fn gather(&mut self, op: &Op) -> Done {
        let Op::Gather { out, hit, miss, .. } = op else { return Ok(()) };
        if !self.module.uses(Query::Hit) {
            return self.refuse("gathers rays");
        }
        if out.iter().any(|(name, r)| r.width() == 3 && name.ends_with(":Ci")) {
            return self.refuse("gathers the colours of rays");
        }
        if self.grid && self.is_together(op) {
            return self.refuse("looks at neighbouring points in a loop over rays");
        }
        [hit, miss].into_iter().for_each(|block| self.texts.forget(block));
        self.alone(false, |w| w.rays(op))?;
        [hit, miss].into_iter().for_each(|block| self.texts.forget(block));
        Ok(())
    }

    /// The loop over rays.
    fn rays(&mut self, op: &Op) -> Done {
        let Op::Gather { position, axis, angle, samples, out, hit, miss } = op else { return Ok(()) };
        let [position, axis] = [position, axis].map(|r| self.registers.value(*r));
        let [angle, samples] = [angle, samples].map(|r| self.registers.value(*r));
        let turn = self.begin_turns();
        let id = self.enter(Leaves::Lights);
        self.line(format!("let place_{id} = {position};"));
        self.line(format!("let axis_{id} = {axis};"));
        self.line(format!("let angle_{id} = {angle};"));
        self.line(format!("let n_{id} = u32(clamp({samples}, 1.0, {MAX_GATHERED:?}));"));
        self.open(format!("for (var i_{id} = 0u; i_{id} < n_{id}; i_{id} += 1u)"));
        if let Some(turn) = turn {
            self.line(format!("turn = sl_turn(outer_turn_{turn}, i_{id} + 1u);"));
        }
        self.line(format!("let way_{id} = sl_in_cone(axis_{id}, angle_{id}, i_{id}, n_{id}, place_{id});"));
        self.line(format!("let far_{id} = scene_hit(place_{id}, way_{id});"));
        out.iter().for_each(|(name, r)| self.of_ray(id, name, *r));
        self.open(format!("if far_{id} >= 0.0"));
        self.block(hit)?;
        self.between("else");
        self.block(miss)?;
        self.close();
        self.close();
        self.end_turns(turn);
        self.exit();
        Ok(())
    }

    /// A value of a ray.
    fn of_ray(&mut self, id: usize, name: &str, r: Reg) {
        let value = match (name, r.width()) {
            ("ray:direction", 3) => format!("way_{id}"),
            ("ray:origin", 3) => format!("place_{id}"),
            ("ray:length", 1) => format!("max(far_{id}, 0.0)"),
            _ => return,
        };
        self.assign(r, &value);
    }
}
