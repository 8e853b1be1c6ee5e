//! The rows that kernels share with Rust; their layout is checked against the kernels by reflection.

gpu::wgsl_rows! {
    /// A position in fixed point: three signed numbers of 64 bits, low word first.
    pub struct Fixed {
        /// Along x, units.
        x: [u32; 2],
        /// Along y, units.
        y: [u32; 2],
        /// Along z, units.
        z: [u32; 2],
    }

    /// A sphere about its body's centre of mass.
    pub struct Sphere {
        /// Radius, units of the fixed-point scale.
        radius: u32,
        /// Id of the shape.
        shape: u32,
        /// Id of the body.
        body: u32,
        /// Index of the material.
        material: u32,
        /// Index of the collision group.
        group: u32,
    }

    /// Corners of an axis-aligned box, m, world; the fourth numbers are not used.
    pub struct Aabb {
        /// Minimum corner.
        low: [f32; 4],
        /// Maximum corner.
        high: [f32; 4],
    }

    /// A body of isotropic inertia: its velocities, world, and reciprocal masses, zero for a body that is held in place.
    pub struct Body {
        /// Velocity, m/s.
        v: [f32; 3],
        /// Reciprocal mass, 1/kg.
        inv_mass: f32,
        /// Angular velocity, rad/s.
        w: [f32; 3],
        /// Reciprocal moment of inertia, 1/(kg m²).
        inv_inertia: f32,
    }

    /// A contact of two spheres.
    pub struct Contact {
        /// Bodies A and B, the lower id first.
        bodies: [u32; 2],
        /// Shapes, the lower id first.
        shapes: [u32; 2],
        /// Unit normal out of A, world.
        normal: [f32; 3],
        /// Gap, m.
        gap: f32,
        /// Lengths of the arms on A and B along the normal, m.
        reach: [f32; 2],
        /// Contact law, an index into [`Model::laws`](crate::Model::laws).
        law: u32,
        /// Not used.
        pad: u32,
    }
}
