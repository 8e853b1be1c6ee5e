//! Filtering of samples to pixels.

use crate::cpu::samples::Samples;
use crate::film::bucket::Bucket;
use crate::film::display::{Aov, placed};
use crate::film::filter::PixelFilter;
use sl::ir::Kind;

/// The pixels of a bucket, row by row.
#[derive(Default)]
pub struct Pixels {
    /// Red, green, blue, coverage.
    pub color: Vec<[f32; 4]>,
    /// What displays take besides, one pixel's numbers after another's.
    pub extra: Vec<f32>,
    /// The identities of what is visible, if these are kept, one pixel's samples after another's.
    pub identities: Vec<u64>,
}

impl Pixels {
    /// The pixels of a bucket from those of its halves, with `depth` numbers of what displays take besides colour.
    pub fn joined(first: Pixels, second: Pixels, bucket: &Bucket, depth: usize) -> Pixels {
        let widths = bucket.halves().map(|half| half.width);
        let is_wide = bucket.is_wide();
        let per_pixel = first.identities.len() / first.color.len().max(1);
        fn rows<T: Copy>(halves: [Vec<T>; 2], is_wide: bool, [left, right]: [usize; 2]) -> Vec<T> {
            let [mut first, second] = halves;
            if !is_wide || left == 0 {
                first.extend(second);
                return first;
            }
            let rows = first.chunks_exact(left).zip(second.chunks_exact(right));
            rows.flat_map(|(a, b)| a.iter().chain(b).copied()).collect()
        }
        let wide = |n: usize| widths.map(|width| width * n);
        Pixels {
            color: rows([first.color, second.color], is_wide, widths),
            extra: rows([first.extra, second.extra], is_wide, wide(depth)),
            identities: rows([first.identities, second.identities], is_wide, wide(per_pixel)),
        }
    }
}

impl Samples {
    /// Filter the pixels of the bucket proper, `margin` pixels in from each side.
    pub fn filter(&self, filter: &PixelFilter, margin: [usize; 2], aovs: &[Aov]) -> Pixels {
        let [sx, sy] = self.strata;
        let n_pixels = (self.width - 2 * margin[0]) * (self.height - 2 * margin[1]);
        let mut out = Pixels { color: Vec::with_capacity(n_pixels), ..Pixels::default() };
        let mut sums = vec![0.0; self.depth];
        // A box of a pixel takes its own samples and no others.
        let alone = filter.is_pixel();
        if alone && self.strata == [1, 1] && aovs.is_empty() {
            let inner = (0..self.height).flat_map(|py| (0..self.width).map(move |px| self.index([px, py], [0, 0])));
            out.color.extend(inner.map(|k| {
                let [r, g, b] = self.color[k];
                [r, g, b, self.alpha[k]]
            }));
            return out;
        }
        for py in margin[1]..self.height - margin[1] {
            for px in margin[0]..self.width - margin[0] {
                let (cx, cy) = (px as f32 + 0.5, py as f32 + 0.5);
                let (mut sum, mut weight) = ([0.0f32; 4], 0.0f32);
                let mut covered = 0.0;
                sums.fill(0.0);
                for (qx, qy) in (py - margin[1]..=py + margin[1])
                    .flat_map(|qy| (px - margin[0]..=px + margin[0]).map(move |qx| (qx, qy)))
                {
                    for row in 0..sy {
                        for column in 0..sx {
                            let k = self.index([qx, qy], [column, row]);
                            let w = if alone { 1.0 } else { filter.at(self.x[k] - cx, self.y[k] - cy) };
                            if w != 0.0 {
                                for c in 0..3 {
                                    sum[c] += w * self.color[k][c];
                                }
                                sum[3] += w * self.alpha[k];
                                weight += w;
                                if self.depth > 0 {
                                    let own = &self.outputs[k * self.depth..][..self.depth];
                                    sums.iter_mut().zip(own).for_each(|(sum, x)| *sum += w * x);
                                    covered += if self.alpha[k] > 0.0 { w } else { 0.0 };
                                }
                            }
                        }
                    }
                }
                out.color.push(if weight != 0.0 { sum.map(|x| x / weight) } else { [0.0; 4] });
                for (first, aov) in placed(aovs) {
                    let of = match aov.kind {
                        Kind::Color => weight,
                        _ => covered,
                    };
                    match aov.name.as_str() {
                        "z" => out.extra.push(self.nearest(px, py)),
                        "id" => {
                            out.extra.push(self.middle(px, py).map_or(0.0, |k| self.outputs[k * self.depth + first]))
                        }
                        _ => out.extra.extend(
                            sums[first..first + aov.width()].iter().map(|x| if of != 0.0 { x / of } else { 0.0 }),
                        ),
                    }
                }
            }
        }
        out
    }

    /// The identities of what is visible in the pixels of the bucket proper, sample by sample.
    pub fn identities(&self, margin: [usize; 2]) -> Vec<u64> {
        let inner = (margin[1]..self.height - margin[1])
            .flat_map(|py| (margin[0]..self.width - margin[0]).map(move |px| (px, py)));
        inner.flat_map(|(px, py)| self.of_pixel(px, py)).map(|k| self.identities.get(k).copied().unwrap_or(0)).collect()
    }

    /// The samples of a pixel.
    fn of_pixel(&self, px: usize, py: usize) -> impl Iterator<Item = usize> + '_ {
        let [sx, sy] = self.strata;
        (0..sy).flat_map(move |row| (0..sx).map(move |column| self.index([px, py], [column, row])))
    }

    /// The least depth in a pixel; infinity where nothing is.
    fn nearest(&self, px: usize, py: usize) -> f32 {
        let covered = self.of_pixel(px, py).filter(|k| self.alpha[*k] > 0.0);
        covered.map(|k| self.z[k]).fold(f32::INFINITY, f32::min)
    }

    /// The sample nearest the middle of a pixel, if anything is there.
    fn middle(&self, px: usize, py: usize) -> Option<usize> {
        let off = |k: &usize| {
            let (x, y) = (self.x[*k] - px as f32 - 0.5, self.y[*k] - py as f32 - 0.5);
            x * x + y * y
        };
        let nearest = self.of_pixel(px, py).min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.filter(|k| self.alpha[*k] > 0.0)
    }
}
