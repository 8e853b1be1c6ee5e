// The place of an invocation in its workgroup of 256, without subgroup operations: subgroups of 32 by its index.
struct Lane {
    @builtin(local_invocation_index) thread: u32,
}

fn thread_of(lane: Lane) -> u32 {
    return lane.thread;
}
