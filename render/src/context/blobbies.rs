//! Blobbies: the calls, and what becomes of those of a motion block.

use crate::context::blobby_call::BlobbyCall;
use crate::context::motion_block::Moving;
use crate::context::state::Context;
use crate::gprim::blobby::Field;
use crate::gprim::blobby::motion::between;
use crate::gprim::variables::Counts;
use crate::scene::motion;
use crate::scene::patch::Patch;
use glam::Vec3;
use ri::{Fail, Params, RiResult};

impl Context {
    /// A blobby.
    pub(super) fn draw_blobby(&mut self, leaves: i32, codes: Vec<i32>, floats: Vec<f32>, params: Params) -> RiResult {
        // Of other classes there is one a leaf.
        let others = usize::MAX;
        self.say_surplus(&params, Counts { uniform: 1, varying: others, vertex: others, facevarying: others });
        let call = BlobbyCall::new(leaves, codes, floats, params)?;
        if let Some(block) = &mut self.motion {
            block.calls.push(Moving::Blobby(Box::new(call)));
            return Ok(());
        }
        let (patches, names) = call.patches()?;
        self.add_patches(patches, names)
    }

    /// The blobbies of a motion block. Those that differ in numbers alone are found as the shutter opens, with the numbers of then,
    /// and their points go along as the numbers change; others are matched patch by patch.
    pub(super) fn moving_blobbies(&mut self, times: &[f32], calls: &[BlobbyCall]) -> RiResult {
        if calls.iter().any(|call| !call.is_like(&calls[0])) {
            return self.moving_patches(times, calls.iter().map(BlobbyCall::patches).collect::<Result<_, Fail>>()?);
        }
        if calls.iter().any(|call| call.varies_from(&calls[0])) {
            self.warn_of_variables();
        }
        let [open, close] = self.options.shutter;
        let at = |time: f32| {
            let (before, part) = motion::segment(times, time);
            (&calls[before], calls.get(before + 1).unwrap_or(&calls[before]), part)
        };
        let floats = |time: f32| {
            let (from, to, part) = at(time);
            from.floats_towards(to, part)
        };
        let (from, to, part) = at(open);
        let mut field = from.field_of(&floats(open))?;
        let net = field.net();
        let (mut patches, names) = from.attached(field.patches(&net, &from.variables_towards(to, part)))?;
        let later: Vec<f32> = times.iter().copied().filter(|t| *t > open && *t < close).collect();
        let (mut before, mut points) = (open, net.points.clone());
        let mut keys = vec![(open, points.clone())];
        for time in later.into_iter().chain((close > open).then_some(close)) {
            let (start, end) = (floats(before), floats(time));
            let along = between(&start, &end).map(|numbers| from.field_of(&numbers));
            let mut along = along.collect::<Result<Vec<Field>, Fail>>()?;
            points = field.carried(&points, net.size, &along);
            keys.push((time, points.clone()));
            (before, field) = (time, along.pop().unwrap_or(field));
        }
        for (patch, quad) in patches.iter_mut().zip(&net.quads) {
            let form = |points: &Vec<Vec3>| Patch::bilinear(quad.map(|i| points[i])).p;
            let own: Vec<_> = keys.iter().map(|(time, points)| (*time, form(points))).collect();
            (patch.p, patch.moves) = motion::in_shutter(&own, self.options.shutter);
        }
        self.add_patches(patches, names)
    }
}
