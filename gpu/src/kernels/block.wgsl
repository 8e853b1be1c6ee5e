// The block of work of a workgroup: 256 threads, four consecutive values each.
// A dispatch of more than 65,535 workgroups goes on in the second dimension.
const THREADS: u32 = 256u;
const PER_THREAD: u32 = 4u;
const BLOCK: u32 = 1024u;

fn block_of(group: vec3<u32>) -> u32 {
    return group.x + group.y * 65535u;
}
