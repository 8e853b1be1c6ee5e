// The bits of the bins' coordinates: enough for the box about all fat boxes, as long as there are not too many bins.
// inout extent  [6]  minimum and maximum corner, as numbers in the order of the real ones; empty out
// out   grid    [3]  bits of a coordinate along each axis, at least 3
// in    count   [1]  n_spheres if pairs are to be found, else 0
// in    params  [2]  the most bits of a bin, and as bits the usual width of a bin (m)
@group(0) @binding(0) var<storage, read_write> extent: array<u32>;
@group(0) @binding(1) var<storage, read_write> grid: array<u32>;
@group(0) @binding(2) var<storage, read> count: array<u32>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

fn real_of(x: u32) -> f32 {
    return bitcast<f32>(select(~x, x & 0x7fffffffu, x >= 0x80000000u));
}

@compute @workgroup_size(1)
fn main() {
    if count[0] == 0u {
        return;
    }
    var bits = vec3(3u);
    for (var axis = 0u; axis < 3u; axis++) {
        if extent[axis] <= extent[axis + 3u] {
            let length = real_of(extent[axis + 3u]) - real_of(extent[axis]);
            var covered = 8.0 * bitcast<f32>(params[1]);
            for (var i = 3u; i < 24u && covered < length; i++) {
                covered *= 2.0;
                bits[axis]++;
            }
        }
        extent[axis] = 0xffffffffu;
        extent[axis + 3u] = 0u;
    }
    for (var i = 0u; i < 72u && bits.x + bits.y + bits.z > params[0]; i++) {
        if bits.x >= max(bits.y, bits.z) {
            bits.x--;
        } else if bits.y >= bits.z {
            bits.y--;
        } else {
            bits.z--;
        }
    }
    for (var axis = 0u; axis < 3u; axis++) {
        grid[axis] = bits[axis];
    }
}
