// The block of work of a workgroup: 256 threads, four consecutive values each.
// A dispatch of more than 65,535 workgroups goes on in the second dimension.
const THREADS: u32 = 256u;
const PER_THREAD: u32 = 4u;
const BLOCK: u32 = 1024u;

fn block_of(group: vec3<u32>) -> u32 {
    return group.x + group.y * 65535u;
}

// Number of values of a level: those of level 0 are n, and of each further level one for each block of the level before.
fn values_of_level(n: u32, level: u32) -> u32 {
    var count = n;
    for (var l = 0u; l < level; l++) {
        count = count / BLOCK + select(0u, 1u, count % BLOCK != 0u);
    }
    return count;
}
