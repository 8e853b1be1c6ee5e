//! Calls of built-in functions.

use super::super::scene::Scene;
use super::state::Machine;
use crate::ir::*;
use crate::shadeop::direction::in_hemisphere;
use crate::shadeop::matrix::{element, inverse, one16, periodic, triple16};
use crate::shadeop::noise::{cell_noise, noise, noise4};
use crate::shadeop::number::unary_value;
use crate::shadeop::runs::{at, cross, dot, put, refract, run_of, triple, triples2};

impl Machine {
    #[allow(clippy::too_many_arguments)]
    pub(super) fn call(
        &mut self,
        program: &Program,
        f: Builtin,
        dst: Reg,
        args: &[Reg],
        first: usize,
        wd: usize,
        scene: &dyn Scene,
    ) {
        let matrix = |v: &[f32; 16]| glam::Mat4::from_cols_array(v);
        match f {
            Builtin::Comp if first == 16 => {
                return self.pointwise(program, dst, args, |v| {
                    one16(element(v[1][0], 4).zip(element(v[2][0], 4)).map_or(0.0, |(r, c)| v[0][4 * r + c]))
                });
            }
            Builtin::Comp => {
                return self.pointwise(program, dst, args, |v| one16(element(v[1][0], 3).map_or(0.0, |k| v[0][k])));
            }
            Builtin::SetComp => {
                return self.pointwise(program, dst, args, |v| {
                    let mut m = v[0];
                    let place = if first == 16 {
                        element(v[1][0], 4).zip(element(v[2][0], 4)).map(|(r, c)| 4 * r + c)
                    } else {
                        element(v[1][0], 3)
                    };
                    if let Some(k) = place {
                        m[k] = v[v.len() - 1][0];
                    }
                    m
                });
            }
            Builtin::Diagonal => {
                return self.pointwise(program, dst, args, |v| {
                    let mut m = [0.0; 16];
                    [0, 5, 10, 15].into_iter().for_each(|k| m[k] = v[0][0]);
                    m
                });
            }
            // Row vectors: a matrix's numbers are the columns of its transpose, and products go the other way round.
            Builtin::MatrixMultiply => {
                return self.pointwise(program, dst, args, |v| (matrix(&v[1]) * matrix(&v[0])).to_cols_array());
            }
            Builtin::MatrixDivide => {
                return self
                    .pointwise(program, dst, args, |v| (inverse(matrix(&v[1])) * matrix(&v[0])).to_cols_array());
            }
            Builtin::MatrixEqual => {
                return self.pointwise(program, dst, args, |v| one16((v[0] == v[1]) as u8 as f32));
            }
            Builtin::Determinant => {
                return self.pointwise(program, dst, args, |v| one16(matrix(&v[0]).determinant()));
            }
            Builtin::LogBase => {
                return self.pointwise(program, dst, args, |v| {
                    let base = unary_value(Unary::Log, v[1][0]);
                    one16(if base != 0.0 { unary_value(Unary::Log, v[0][0]) / base } else { 0.0 })
                });
            }
            Builtin::MatrixPoint | Builtin::MatrixVector | Builtin::MatrixNormal => {
                return self.pointwise(program, dst, args, |v| {
                    let (m, p) = (matrix(&v[0]), glam::Vec3::new(v[1][0], v[1][1], v[1][2]));
                    let q = match f {
                        Builtin::MatrixPoint => m.project_point3(p),
                        Builtin::MatrixVector => m.transform_vector3(p),
                        _ => inverse(m).transpose().transform_vector3(p),
                    };
                    triple16(q.into())
                });
            }
            Builtin::Translate | Builtin::Scale => {
                return self.pointwise(program, dst, args, |v| {
                    let by = glam::Vec3::new(v[1][0], v[1][1], v[1][2]);
                    let own = match f {
                        Builtin::Translate => glam::Mat4::from_translation(by),
                        _ => glam::Mat4::from_scale(by),
                    };
                    (matrix(&v[0]) * own).to_cols_array()
                });
            }
            Builtin::Rotate => {
                return self.pointwise(program, dst, args, |v| {
                    let axis = glam::Vec3::new(v[2][0], v[2][1], v[2][2]).normalize_or(glam::Vec3::Z);
                    (matrix(&v[0]) * glam::Mat4::from_axis_angle(axis, v[1][0])).to_cols_array()
                });
            }
            Builtin::PeriodicNoise => {
                let widths: Vec<usize> = args.iter().map(|r| program.widths[*r as usize] as usize).collect();
                return self.pointwise(program, dst, args, |v| periodic(&widths, v));
            }
            Builtin::Noise | Builtin::CellNoise if first == 3 && args.len() == 2 => {
                return self.pointwise(program, dst, args, |v| {
                    let (p, t) = ([v[0][0], v[0][1], v[0][2]], v[1][0]);
                    triple16([0, 1, 2].map(|c| match f {
                        Builtin::Noise => noise4(p, t, None, c),
                        _ => cell_noise(p, (t.floor() as i32 as u32).wrapping_mul(0x2545_f491) ^ c),
                    }))
                });
            }
            Builtin::Random => {
                // Without a place, the grid's first point stands for all.
                let p = program.global("P").map_or([0.0; 3], |p| triple(&self.regs[p as usize], 0, self.n));
                return self.pointwise(program, dst, args, |v| {
                    let at = v.get(1).map_or(p, |v| [v[0], v[1], v[2]]);
                    let cell = at.map(|x| x.to_bits() as f32 * 0.618_034 + v[0][0]);
                    triple16([0, 1, 2].map(|c| cell_noise(cell, c + at[c as usize].to_bits())))
                });
            }
            _ => {}
        }
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        out.clear();
        let n = self.n;
        let arg = |k: usize| &self.regs[args[k] as usize][..];
        match f {
            Builtin::Dot => triples2(&mut out, arg(0), arg(1), n, 1, |a, b| [dot(a, b), 0.0, 0.0]),
            Builtin::Cross => triples2(&mut out, arg(0), arg(1), n, 3, cross),
            Builtin::Length => triples2(&mut out, arg(0), arg(0), n, 1, |a, _| [dot(a, a).sqrt(), 0.0, 0.0]),
            Builtin::Normalize => triples2(&mut out, arg(0), arg(0), n, 3, |a, _| {
                let l = dot(a, a).sqrt();
                if l > 0.0 { a.map(|x| x / l) } else { [0.0; 3] }
            }),
            Builtin::FaceForward => {
                let (v, i, reference) = (arg(0), arg(1), arg(2));
                let lanes = if [v, i, reference].iter().all(|x| x.len() == 3) { 1 } else { n };
                out.resize(3 * lanes, 0.0);
                for k in 0..lanes {
                    let a = triple(v, k, n);
                    let sign = if dot(triple(i, k, n), triple(reference, k, n)) > 0.0 { -1.0 } else { 1.0 };
                    put(&mut out, k, lanes, a.map(|x| x * sign));
                }
            }
            Builtin::Reflect => triples2(&mut out, arg(0), arg(1), n, 3, |i, m| {
                let d = 2.0 * dot(i, m);
                [i[0] - d * m[0], i[1] - d * m[1], i[2] - d * m[2]]
            }),
            Builtin::Refract => {
                let eta = arg(2);
                let lanes = if arg(0).len() == 3 && arg(1).len() == 3 && eta.len() == 1 { 1 } else { n };
                out.resize(3 * lanes, 0.0);
                for k in 0..lanes {
                    put(&mut out, k, lanes, refract(triple(arg(0), k, n), triple(arg(1), k, n), at(eta, k)));
                }
            }
            Builtin::SmoothStep => {
                let (lo, hi, x) = (arg(0), arg(1), arg(2));
                let lanes = if lo.len() == 1 && hi.len() == 1 && x.len() == 1 { 1 } else { n };
                out.extend((0..lanes).map(|k| {
                    let (lo, hi, x) = (at(lo, k), at(hi, k), at(x, k));
                    if x < lo || hi <= lo {
                        return (x >= lo) as u8 as f32;
                    }
                    let t = ((x - lo) / (hi - lo)).min(1.0);
                    t * t * (3.0 - 2.0 * t)
                }));
            }
            Builtin::Mix => {
                let (a, b, t) = (arg(0), arg(1), arg(2));
                let lanes = if a.len() == wd && b.len() == wd && t.len() == 1 { 1 } else { n };
                for c in 0..wd {
                    let (a, b) = (run_of(a, wd, c, n), run_of(b, wd, c, n));
                    out.extend((0..lanes).map(|k| at(a, k) * (1.0 - at(t, k)) + at(b, k) * at(t, k)));
                }
            }
            Builtin::Noise | Builtin::CellNoise => {
                let value = if f == Builtin::Noise { noise } else { cell_noise };
                let (x, y) = (arg(0), args.get(1).map(|r| &self.regs[*r as usize][..]));
                let lanes = if x.len() > first || y.is_some_and(|y| y.len() > 1) { n } else { 1 };
                out.resize(wd * lanes, 0.0);
                for k in 0..lanes {
                    if self.mask.as_ref().is_some_and(|m| lanes == n && !m[k]) {
                        continue;
                    }
                    let p = if first == 3 { triple(x, k, n) } else { [at(x, k), y.map_or(0.0, |y| at(y, k)), 0.0] };
                    for c in 0..wd {
                        out[c * lanes + k] = value(p, c as u32);
                    }
                }
            }
            Builtin::Du | Builtin::Dv => self.parametric(&mut out, f == Builtin::Du, arg(0), arg(1), arg(2), wd),
            Builtin::CalculateNormal | Builtin::Area => {
                let p = arg(0);
                out.resize(wd * n, 0.0);
                for k in 0..n {
                    let d = [0, 1, 2].map(|c| self.differences(run_of(p, 3, c, n), k));
                    let m = cross(d.map(|d| d[0]), d.map(|d| d[1]));
                    if wd == 1 {
                        out[k] = dot(m, m).sqrt();
                    } else {
                        put(&mut out, k, n, m.map(|x| x * self.orientation));
                    }
                }
            }
            Builtin::Width => {
                let x = arg(0);
                let change = |k: usize| {
                    let [a, b] = self.differences(x, k);
                    a.abs().max(b.abs())
                };
                out.extend((0..if x.len() == 1 { 1 } else { n }).map(change));
            }
            Builtin::Trace | Builtin::Occlusion | Builtin::IndirectDiffuse => {
                let (p, way) = (arg(0), arg(1));
                let samples = args.get(2).map_or(1.0, |r| at(&self.regs[*r as usize], 0)).clamp(1.0, 4096.0) as usize;
                out.resize(wd * n, 0.0);
                let blind = f == Builtin::IndirectDiffuse && !scene.traces(true);
                for k in (0..n).filter(|k| !blind && self.mask.as_ref().is_none_or(|m| m[*k])) {
                    let (from, about) = (triple(p, k, n), unit(triple(way, k, n)));
                    let mut sum = [0.0f32; 3];
                    if f == Builtin::Trace {
                        sum = if wd == 3 {
                            scene.trace(from, about, false)
                        } else {
                            [scene.hit(from, about).unwrap_or(f32::INFINITY).min(1e30); 3]
                        };
                    } else {
                        for i in 0..samples {
                            let to = in_hemisphere(about, i, from);
                            let found = match f {
                                Builtin::Occlusion => [scene.hit(from, to).is_some() as u8 as f32; 3],
                                _ => scene.trace(from, to, true),
                            };
                            (0..3).for_each(|c| sum[c] += found[c] / samples as f32);
                        }
                    }
                    (0..wd).for_each(|c| out[c * n + k] = sum[c]);
                }
            }
            Builtin::Ambient => self.ambient(&mut out, scene),
            Builtin::Transmission => {
                let (from, to) = (arg(0), arg(1));
                out.resize(3 * n, 1.0);
                for k in 0..n {
                    if self.mask.as_ref().is_none_or(|m| m[k]) {
                        put(&mut out, k, n, scene.transmission(triple(from, k, n), triple(to, k, n)));
                    }
                }
            }
            _ => unreachable!("done above"),
        }
        self.regs[dst as usize] = out;
    }

    /// Derivative along u or v, whatever way the rows run on the surface.
    pub(super) fn parametric(&self, out: &mut Vec<f32>, along_u: bool, x: &[f32], u: &[f32], v: &[f32], width: usize) {
        for c in 0..width {
            let x = run_of(x, width, c, self.n);
            out.extend((0..self.n).map(|k| {
                let ([xi, xj], [ui, uj], [vi, vj]) =
                    (self.differences(x, k), self.differences(u, k), self.differences(v, k));
                let det = ui * vj - uj * vi;
                let slope = if along_u { xi * vj - xj * vi } else { xj * ui - xi * uj };
                if det != 0.0 { slope / det } else { 0.0 }
            }));
        }
    }
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let l = dot(v, v).sqrt();
    if l > 0.0 { v.map(|x| x / l) } else { v }
}
