//! Maps, and changes of space.

use super::super::bound::known_as;
use super::super::scene::{MapQuery, OPTIONS, Scene, unknown_option, unknown_space};
use super::state::Machine;
use crate::ir::*;
use crate::shadeop::grid::{differences, over};
use crate::shadeop::runs::{at, dot, run_of, triple, triples2};

/// The values of these options that a lookup gives, one or one a point.
struct Given<'a>([Option<&'a [f32]>; OPTIONS.len()]);

impl Given<'_> {
    /// Set the options of a query at a point.
    fn set(&self, query: &mut MapQuery<'_>, k: usize) {
        let [blur, sblur, tblur, width, swidth, twidth, fill, samples, bias, _] = self.0;
        let number = |values: Option<&[f32]>, otherwise: f32| values.map_or(otherwise, |v| at(v, k));
        let (s, t) = (number(swidth, 1.0), number(twidth, 1.0));
        query.change.iter_mut().for_each(|change| (change[0], change[1]) = (change[0] * s, change[1] * t));
        query.blur = [sblur, tblur].map(|own| number(own, number(blur, 0.0)));
        (query.width, query.fill) = (number(width, 1.0), number(fill, 0.0));
        (query.samples, query.bias) = (number(samples, 16.0), number(bias, 0.0));
    }
}

impl Machine {
    /// The options of a lookup in a map; what is said of others than [`OPTIONS`].
    fn map_options(&self, map: &str, options: &[(TextReg, Operand)], unknown: &mut Vec<String>) -> Given<'_> {
        let mut given = Given([None; OPTIONS.len()]);
        for (key, value) in options {
            let key = &self.texts[key.index()];
            let Some(k) = OPTIONS.iter().position(|option| option == key) else {
                unknown.push(unknown_option(map, key));
                continue;
            };
            given.0[k] = match value {
                Operand::Number(r) if r.width() == 1 => Some(&self.regs[r.index()][..]).filter(|v| !v.is_empty()),
                _ => None,
            };
        }
        given
    }

    pub(super) fn map(&mut self, op: &Op, scene: &dyn Scene) {
        let Op::Map { dst, how, name, channel, at: place, options, place: byte } = op else { return };
        let n = self.n;
        let wd = dst.width();
        let name = self.texts[name.index()].clone();
        let mut refused = vec![];
        let given = self.map_options(&name, options, &mut refused);
        let mut query = MapQuery {
            how: *how,
            name: &name,
            channel: at(&self.regs[channel.index()], 0).max(0.0) as usize,
            at: [0.0; 3],
            change: [[0.0; 3]; 2],
            width: 1.0,
            blur: [0.0; 2],
            fill: 0.0,
            samples: 16.0,
            bias: 0.0,
            light: None,
        };
        let ray = self.ray.map(|(l, sun)| (self.regs[l.index()].clone(), sun));
        // One point: s and t as two numbers, others as a triple. Four: the corners of the filter's area.
        let each = if *how == Lookup::Texture { 2 } else { 1 };
        let corner = |c: usize, axis: usize, k: usize| -> f32 {
            match (each, axis) {
                (2, 2) => 0.0,
                (2, _) => at(&self.regs[place[2 * c + axis].index()], k),
                _ => at(run_of(&self.regs[place[c].index()], 3, axis, n), k),
            }
        };
        let uniform = place.iter().all(|r| self.regs[r.index()].len() == r.width())
            && given.0.iter().flatten().all(|v| v.len() <= 1);
        let lanes = if uniform { 1 } else { n };
        let (mut points, mut queries) = (Vec::with_capacity(lanes), Vec::with_capacity(lanes));
        for k in 0..lanes {
            if self.mask.as_ref().is_some_and(|m| lanes == n && !m[k]) {
                continue;
            }
            if place.len() == 4 * each {
                let all = |axis: usize| [0, 1, 2, 3].map(|c| corner(c, axis, k));
                for axis in 0..3 {
                    let [a, b, c, d] = all(axis);
                    query.at[axis] = 0.25 * (a + b + c + d);
                    query.change[0][axis] = 0.5 * (b + d - a - c);
                    query.change[1][axis] = 0.5 * (c + d - a - b);
                }
            } else {
                query.at = [0, 1, 2].map(|axis| corner(0, axis, k));
                for axis in 0..3 {
                    let r = &self.regs[place[if each == 2 { axis.min(1) } else { 0 }].index()];
                    let run = if each == 2 { &r[..] } else { run_of(r, 3, axis, n) };
                    let d = if each == 2 && axis == 2 { [0.0; 2] } else { differences(run, k, self.nu, n) };
                    let d = over(d, self.footprints.get(k));
                    (query.change[0][axis], query.change[1][axis]) = (d[0], d[1]);
                }
            }
            given.set(&mut query, k);
            query.light = ray.as_ref().map(|(l, sun)| {
                // The light's ray ends at the place; a sun's begins far away.
                let (l, far) = (triple(l, k, n), if *sun { 1e6 } else { 1.0 });
                let scale = if *sun { far / dot(l, l).sqrt().max(1e-20) } else { 1.0 };
                [0, 1, 2].map(|c| query.at[c] - l[c] * scale)
            });
            points.push(k);
            queries.push(query);
        }
        if !queries.is_empty() {
            refused.extend(scene.map_fault(*how, &name, ray.is_some()));
        }
        let mut values = vec![[0.0; 4]; queries.len()];
        scene.map(&queries, &mut values);
        let mut out = vec![0.0; wd * lanes];
        for (k, value) in points.into_iter().zip(values) {
            (0..wd).for_each(|c| out[c * lanes + k] = value[c]);
        }
        self.regs[dst.index()] = out;
        refused.into_iter().for_each(|message| self.refuse(*byte, message));
    }

    /// Note what was asked in vain at a place of the shader.
    pub(super) fn refuse(&mut self, place: u32, message: String) {
        if !self.refused.iter().any(|known| known.0 == place && known.1 == message) {
            self.refused.push((place, message));
        }
    }

    pub(super) fn transform(
        &mut self,
        how: Transform,
        (dst, a): (Reg, Reg),
        spaces: [TextReg; 2],
        place: u32,
        scene: &dyn Scene,
    ) {
        let [from, to] = spaces.map(|name| known_as(self.own_space.as_deref(), &self.texts[name.index()]));
        let matrix = scene.matrix(from, to);
        if matrix.is_none()
            && let Some(message) = unknown_space(scene, [from, to])
        {
            self.refuse(place, message);
        }
        let m = glam::Mat4::from_cols_array(&matrix.unwrap_or(glam::Mat4::IDENTITY.to_cols_array()));
        if how == Transform::Matrix {
            return self.evaluate(dst, &[a], |call, out| {
                call.pointwise(out, |v| (m * glam::Mat4::from_cols_array(&v[0])).to_cols_array())
            });
        }
        let normal = glam::Mat3::from_mat4(m).inverse().transpose();
        let mut out = std::mem::take(&mut self.regs[dst.index()]);
        out.clear();
        let a = &self.regs[a.index()][..];
        triples2(&mut out, a, a, self.n, 3, |p, _| {
            let p = glam::Vec3::from_array(p);
            match how {
                Transform::Point => m.project_point3(p),
                Transform::Vector => m.transform_vector3(p),
                Transform::Normal | Transform::Matrix => normal * p,
            }
            .to_array()
        });
        self.regs[dst.index()] = out;
    }
}
