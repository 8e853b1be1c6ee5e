//! Operations component by component, and elements of arrays.

use super::state::{Beyond, Indexed, Machine};
use crate::ir::*;
use crate::shadeop::matrix::element;
use crate::shadeop::number::{binary_run, binary_value, select_run, unary_run, unary_value};
use crate::shadeop::runs::{at, run_of};

impl Machine {
    /// Run an operation component by component, if it is one. Those of single numbers are the most.
    #[inline]
    pub(super) fn number(&mut self, op: &Op) -> bool {
        match op {
            Op::Const(dst @ Reg::Float(_), v) => {
                self.set_one(*dst, *v);
                true
            }
            Op::Binary(f, dst, a, b) => {
                self.binary(*f, *dst, *a, *b);
                true
            }
            _ => self.other_number(op),
        }
    }

    #[inline(never)]
    fn other_number(&mut self, op: &Op) -> bool {
        match op {
            Op::Const(dst, v) => {
                let reg = &mut self.regs[dst.index()];
                reg.clear();
                reg.resize(dst.width(), *v);
            }
            Op::Unary(f, dst, a) => self.unary(*f, *dst, *a),
            Op::Select(dst, c, a, b) => self.select(*dst, *c, *a, *b),
            Op::Pack(dst, parts) => self.pack(*dst, parts),
            Op::Component(dst, a, c) => self.component(*dst, *a, *c),
            Op::Assign(dst, a) => self.assign(*dst, *a),
            _ => return false,
        }
        true
    }

    /// Set a register to one number.
    #[inline]
    fn set_one(&mut self, dst: Reg, value: f32) {
        let reg = &mut self.regs[dst.index()];
        match &mut reg[..] {
            [one] => *one = value,
            _ => {
                reg.clear();
                reg.push(value);
            }
        }
    }

    fn unary(&mut self, f: Unary, dst: Reg, a: Reg) {
        if let ([a], 1) = (&self.regs[a.index()][..], dst.width()) {
            let value = unary_value(f, *a);
            return self.set_one(dst, value);
        }
        let repeats = dst.width() / a.width();
        let mut out = std::mem::take(&mut self.regs[dst.index()]);
        let a = &self.regs[a.index()];
        let n = a.len();
        out.resize(repeats * n, 0.0);
        (0..repeats).for_each(|c| unary_run(f, &mut out[c * n..][..n], a));
        self.regs[dst.index()] = out;
    }

    #[inline]
    pub(super) fn binary(&mut self, f: Binary, dst: Reg, a: Reg, b: Reg) {
        match (&self.regs[a.index()][..], &self.regs[b.index()][..], dst) {
            ([a], [b], Reg::Float(_)) => {
                let value = binary_value(f, *a, *b);
                self.set_one(dst, value);
            }
            _ => self.binary_of_many(f, dst, a, b),
        }
    }

    #[inline(never)]
    fn binary_of_many(&mut self, f: Binary, dst: Reg, a: Reg, b: Reg) {
        let (w, wa, wb) = (dst.width(), a.width(), b.width());
        let mut out = std::mem::take(&mut self.regs[dst.index()]);
        let (a, b) = (&self.regs[a.index()][..], &self.regs[b.index()][..]);
        if a.len() == wa && b.len() == wb {
            out.resize(w, 0.0);
            for (c, x) in out.iter_mut().enumerate() {
                *x = binary_value(f, a[c.min(wa - 1)], b[c.min(wb - 1)]);
            }
        } else {
            let n = self.n;
            out.resize(w * n, 0.0);
            for c in 0..w {
                binary_run(f, &mut out[c * n..][..n], run_of(a, wa, c, n), run_of(b, wb, c, n));
            }
        }
        self.regs[dst.index()] = out;
    }

    fn select(&mut self, dst: Reg, c: FloatReg, a: Reg, b: Reg) {
        let mut out = std::mem::take(&mut self.regs[dst.index()]);
        let view = |r: Reg| (&self.regs[r.index()][..], r.width());
        let (c, a, b) = (view(c.into()), view(a), view(b));
        let varying = [c, a, b].iter().any(|(v, w)| v.len() != *w);
        let n = if varying { self.n } else { 1 };
        out.resize(dst.width() * n, 0.0);
        for k in 0..dst.width() {
            let of = |(v, w)| run_of(v, w, k, self.n);
            select_run(&mut out[k * n..][..n], of(c), of(a), of(b));
        }
        self.regs[dst.index()] = out;
    }

    fn pack(&mut self, dst: Reg, parts: &[FloatReg]) {
        let varying = parts.iter().any(|r| self.regs[r.index()].len() != 1);
        debug_assert_eq!(parts.len(), dst.width());
        let mut out = std::mem::take(&mut self.regs[dst.index()]);
        out.clear();
        for r in parts {
            match (&self.regs[r.index()], varying) {
                (v, true) if v.len() == 1 => out.extend(std::iter::repeat_n(v[0], self.n)),
                (v, _) => out.extend_from_slice(v),
            }
        }
        self.regs[dst.index()] = out;
    }

    fn component(&mut self, dst: FloatReg, a: TripleReg, c: u8) {
        let mut out = std::mem::take(&mut self.regs[dst.index()]);
        let a = &self.regs[a.index()];
        let run = a.len() / 3;
        out.clear();
        out.extend_from_slice(&a[c as usize * run..(c as usize + 1) * run]);
        self.regs[dst.index()] = out;
    }

    /// Note an index that is of no component.
    pub(super) fn note_index(&mut self, index: FloatReg, len: u16, place: u32) {
        let index = &self.regs[index.index()];
        let is_on = |k: usize| index.len() == 1 || self.mask.as_ref().is_none_or(|mask| mask[k]);
        let lost = index.iter().enumerate().find(|(k, i)| is_on(*k) && element(**i, len).is_none());
        if let Some((_, i)) = lost {
            self.beyond.get_or_insert(Beyond { what: Indexed::Components, index: *i, len, place });
        }
    }

    /// The element of an array of strings that an index means.
    pub(super) fn text_element(&mut self, index: FloatReg, len: u16, place: u32) -> Option<usize> {
        let i = at(&self.regs[index.index()], 0);
        let found = element(i, len);
        if found.is_none() {
            self.beyond.get_or_insert(Beyond::of_array(i, len, place));
        }
        found
    }

    pub(super) fn load_element(&mut self, dst: Reg, first: Reg, len: u16, index: FloatReg, place: u32) {
        let (n, w) = (self.n, dst.width());
        let mut out = std::mem::take(&mut self.regs[dst.index()]);
        out.clear();
        let index = &self.regs[index.index()];
        if let [i] = index[..] {
            match element(i, len) {
                Some(k) => out.extend_from_slice(&self.regs[first.index() + k]),
                None => {
                    self.beyond.get_or_insert(Beyond::of_array(i, len, place));
                    out.resize(w, 0.0);
                }
            }
        } else {
            out.resize(w * n, 0.0);
            for (k, i) in index.iter().enumerate() {
                let Some(e) = element(*i, len) else {
                    if self.mask.as_ref().is_none_or(|mask| mask[k]) {
                        self.beyond.get_or_insert(Beyond::of_array(*i, len, place));
                    }
                    continue;
                };
                let value = &self.regs[first.index() + e];
                (0..w).for_each(|c| out[c * n + k] = at(run_of(value, w, c, n), k));
            }
        }
        self.regs[dst.index()] = out;
    }

    pub(super) fn store_element(&mut self, first: Reg, len: u16, index: FloatReg, value: Reg, place: u32) {
        let index = self.regs[index.index()].clone();
        let value = self.regs[value.index()].clone();
        if let [i] = index[..] {
            match element(i, len) {
                Some(k) => self.assign_value(first.element(k as u16), &value),
                None => _ = self.beyond.get_or_insert(Beyond::of_array(i, len, place)),
            }
            return;
        }
        let outer = self.mask.take();
        let is_on = |p: usize| outer.as_ref().is_none_or(|m| m[p]);
        if let Some(p) = (0..self.n).find(|p| is_on(*p) && element(index[*p], len).is_none()) {
            self.beyond.get_or_insert(Beyond::of_array(index[p], len, place));
        }
        for k in 0..len as usize {
            let here = |p: usize| outer.as_ref().is_none_or(|m| m[p]) && element(index[p], len) == Some(k);
            let mask: Vec<bool> = (0..self.n).map(here).collect();
            if mask.contains(&true) {
                self.mask = Some(mask);
                self.assign_value(first.element(k as u16), &value);
            }
        }
        self.mask = outer;
    }
}
