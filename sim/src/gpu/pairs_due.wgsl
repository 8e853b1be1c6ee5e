// The counts that the broad phase works on: all if a sphere has left its fat box or the pairs are lost, else none, and the pairs stay.
// inout left     [1]  not zero in if a sphere has left its box; zero out
// inout lost     [1]  not zero in if the pairs are to be found in any case; zero out
// out   renewed  [1]  n_spheres if a sphere has left its box, else 0
// out   spheres  [1]  n_spheres or 0
// out   rows     [1]  n_spheres + 1 or 0
// out   bins     [1]  n_bins or 0
// inout lasts    [1]  as bits: steps for which all will be in their boxes; out that of new ones, if they are renewed
// inout levels   [2]  mask of the levels of bins that are used; zero out if pairs are found
// in    params   [3]  n_spheres, n_bins; as bits the number of steps that new boxes cover
@group(0) @binding(0) var<storage, read_write> left: array<u32>;
@group(0) @binding(1) var<storage, read_write> lost: array<u32>;
@group(0) @binding(2) var<storage, read_write> renewed: array<u32>;
@group(0) @binding(3) var<storage, read_write> spheres: array<u32>;
@group(0) @binding(4) var<storage, read_write> rows: array<u32>;
@group(0) @binding(5) var<storage, read_write> bins: array<u32>;
@group(0) @binding(6) var<storage, read_write> lasts: array<u32>;
@group(0) @binding(7) var<storage, read_write> levels: array<u32>;
@group(0) @binding(8) var<storage, read> params: array<u32>;

@compute @workgroup_size(1)
fn main() {
    let has_left = left[0] != 0u;
    let is_due = has_left || lost[0] != 0u;
    renewed[0] = select(0u, params[0], has_left);
    spheres[0] = select(0u, params[0], is_due);
    rows[0] = select(0u, params[0] + 1u, is_due);
    bins[0] = select(0u, params[1], is_due);
    if has_left {
        lasts[0] = params[2];
    }
    if is_due {
        levels[0] = 0u;
        levels[1] = 0u;
    }
    left[0] = 0u;
    lost[0] = 0u;
}
