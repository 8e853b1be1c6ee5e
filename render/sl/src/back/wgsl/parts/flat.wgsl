// Points that are shaded each on its own: a workgroup has some of those of a grid.

var<private> work: Grid;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = group.x + group.y * n_groups.x;
    if at >= arrayLength(&groups) {
        return;
    }
    work = sl_grid(groups[at].x);
    point = groups[at].y + local;
    if point < work.n {
        shader_0(work.slots, true);
    }
}
