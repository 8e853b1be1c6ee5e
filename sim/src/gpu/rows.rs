//! The rows that kernels share with Rust; their layout is checked against the kernels by reflection.

gpu::wgsl_rows! {
    /// A vector in fixed point: three signed numbers of 64 bits, low word first.
    pub struct Fixed {
        /// Along x.
        x: [u32; 2],
        /// Along y.
        y: [u32; 2],
        /// Along z.
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

    /// A shape of any kind.
    pub struct Solid {
        /// Half lengths, m, as [`ShapeKind`](crate::ShapeKind) has them.
        half: [f32; 3],
        /// Kind, as [`kinds`](super::kinds) names them.
        kind: u32,
        /// Position in the body's frame, m.
        offset: [f32; 3],
        /// Distance of the farthest point from the centre of mass, m; 0 for a sphere about it.
        lever: f32,
        /// Orientation in the body's frame.
        turn: [f32; 4],
        /// First row of a hull.
        part: u32,
        /// Not used.
        pad: u32,
        /// Not used.
        more: [u32; 2],
    }

    /// A shape that is held in place, or a triangle of one.
    pub struct Fixture {
        /// Position, fine units.
        position: Fixed,
        /// Axes of its frame in the world, over 2⁶⁰.
        x_axis: Fixed,
        /// The second axis.
        y_axis: Fixed,
        /// The third axis: the normal of a plane.
        z_axis: Fixed,
        /// Half lengths, fine units.
        half: Fixed,
        /// Kind, as [`kinds`](super::kinds) names them.
        kind: u32,
        /// Id of the shape.
        shape: u32,
        /// Id of the body.
        body: u32,
        /// Index of the material.
        material: u32,
        /// Index of the collision group.
        group: u32,
        /// First row of a hull, or first node of a surface.
        part: u32,
    }

    /// A box of the tree of a surface's triangles, in its frame.
    pub struct Node {
        /// Minimum corner, m.
        low: [f32; 3],
        /// Number of the triangles of a leaf in three bits, and the first of them as a fixture; 0 where boxes follow below this one.
        leaf: u32,
        /// Maximum corner, m.
        high: [f32; 3],
        /// The node beside this one.
        next: u32,
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

    /// A contact.
    pub struct Contact {
        /// Bodies A and B, the lower id first.
        bodies: [u32; 2],
        /// Shapes, the lower id first.
        shapes: [u32; 2],
        /// Unit normal out of A, world.
        normal: [f32; 3],
        /// Gap, m.
        gap: f32,
        /// Lengths of the arms on A and B along the normal, m, where they lie along it; else they are [`Arms`].
        reach: [f32; 2],
        /// Contact law, an index into [`Model::laws`](crate::Model::laws).
        law: u32,
        /// Feature id, which identifies the point from step to step.
        feature: u32,
    }

    /// The arms of a contact where they are of any direction.
    pub struct Arms {
        /// From the centre of mass of A, m, world.
        a: [f32; 3],
        /// Whether the contact is one of a shape with faces that moves.
        is_face: u32,
        /// From the centre of mass of B, m, world.
        b: [f32; 3],
        /// Not used.
        pad: u32,
    }

    /// A body that joints, springs or loads act on.
    pub struct Member {
        /// Id of the body.
        body: u32,
        /// The first side of rows on it.
        first: u32,
        /// The end of these.
        end: u32,
        /// Not used.
        pad: u32,
    }

    /// The row of a joint on one of its bodies.
    pub struct JointSide {
        /// Jacobian: linear part.
        linear: [f32; 3],
        /// Index of the row.
        row: u32,
        /// Jacobian: angular part.
        angular: [f32; 3],
        /// Id of the body.
        body: u32,
        /// Velocity that a unit impulse along the row gives the body.
        to_linear: [f32; 3],
        /// Not used.
        pad: u32,
        /// Its angular velocity.
        to_angular: [f32; 3],
        /// Not used.
        last: u32,
    }

    /// The row of a joint.
    pub struct JointRow {
        /// Its sides, on bodies that move.
        sides: [u32; 2],
        /// Place among the rows of the factor.
        place: u32,
        /// Compliance, 1/kg or 1/(kg m²).
        softness: f32,
    }

    /// The state of a body on its way between the processor and the device.
    pub struct BodyState {
        /// Position, fine units.
        position: Fixed,
        /// Id of the body.
        body: u32,
        /// Whether a joint holds it, on the way to the device.
        is_held: u32,
        /// Orientation, x, y, z, w.
        orientation: [f32; 4],
        /// Velocity, m/s, world.
        velocity: [f32; 4],
        /// Angular velocity, rad/s, in the body's frame.
        spin: [f32; 4],
    }

    /// Its velocities without contacts, and its inertia in the step.
    pub struct MemberFree {
        /// Velocity, m/s.
        v: [f32; 3],
        /// Reciprocal mass, 1/kg.
        inv_mass: f32,
        /// Angular velocity, rad/s, world.
        w: [f32; 3],
        /// Id of the body.
        body: u32,
        /// Reciprocal principal moments, 1/(kg m²).
        moments: [f32; 4],
        /// The principal frame, x, y, z, w.
        axes: [f32; 4],
    }

    /// What comes back of a step.
    pub struct Summary {
        /// Number of pairs that room is needed for.
        pairs: u32,
        /// Whether there was room for all pairs; else the step was undone.
        has_room: u32,
        /// Number of contacts.
        contacts: u32,
        /// Number of iterations.
        iterations: u32,
        /// Residual, m/s.
        residual: f32,
        /// Greatest overlap, m.
        worst: f32,
        /// Kinetic energy, J.
        kinetic: f32,
        /// Potential energy over a level, J.
        potential: f32,
        /// Potential energy over the lowest positions, J.
        over_lowest: f32,
        /// h |F·v| of the weights, J.
        oscillation: f32,
        /// Greatest speed squared, m²/s²; infinite where a body's state is not finite.
        speed2: f32,
        /// The body that has it.
        fastest: u32,
        /// Greatest kinetic energy of a body, J.
        greatest: f32,
        /// The body that has it.
        most_energetic: u32,
        /// Number of contacts that room is needed for, where a pair may have several.
        needed: u32,
        /// Number of steps like this one for which the pairs hold, from its start on.
        lasts: f32,
        /// The same from the start of the next step on: none where a body has left its box by then.
        next: f32,
        /// Mask of the rounds of Gauss–Seidel that have any tiles.
        rounds: u32,
    }
}
