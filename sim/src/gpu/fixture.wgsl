// The row of a shape that is held in place: a plane, a box, a capsule, a cylinder, a cone, a hull, a surface of triangles, or one of these.
#import fixed

// Position and half lengths in fine units; axes of its frame over 2^60, of which the last is a plane's normal; kind, shape, body, material
// and collision group; the first row of a hull, the first node of a surface. A triangle has its corners in place of the position and of two
// axes, its normal as the third, and in `half` what `triangle_with.wgsl` reads.
struct Fixture {
    position: Fixed,
    x_axis: Fixed,
    y_axis: Fixed,
    z_axis: Fixed,
    half: Fixed,
    kind: u32,
    shape: u32,
    body: u32,
    material: u32,
    group: u32,
    part: u32,
}

const PLANE: u32 = 0u;
const BOX: u32 = 1u;
const CAPSULE: u32 = 2u;
const CYLINDER: u32 = 3u;
const CONE: u32 = 4u;
const HULL: u32 = 8u;
const SURFACE: u32 = 9u;
const TRIANGLE: u32 = 10u;
