// The place of an invocation in its workgroup of 256, by its subgroup: threads that are consecutive are of one subgroup.
const SUBGROUP_MIN: u32 = 32u;

struct Lane {
    @builtin(subgroup_id) group: u32,
    @builtin(subgroup_invocation_id) place: u32,
    @builtin(subgroup_size) size: u32,
}

fn thread_of(lane: Lane) -> u32 {
    return lane.group * lane.size + lane.place;
}
