//! Attributes that primitives are made by, which their own attributes do not keep (RISpec 5).

use crate::scene::trim::Trim;
use std::sync::Arc;

/// Attributes that primitives are made by.
#[derive(Clone)]
pub struct Geometry {
    /// Bases of cubic patches and curves along u and v.
    pub bases: ([f32; 16], [f32; 16]),
    /// Control points from one patch to the next.
    pub steps: [usize; 2],
    /// What is cut away of NURBS patches.
    pub trim: Option<Arc<Trim>>,
    /// Whether what trim curves enclose is cut away, rather than what is around.
    pub trims_inside: bool,
}
