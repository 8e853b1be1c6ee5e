// The block of keys of a workgroup of the radix sort: 256 threads, 16 keys each.
#import block

const KEYS: u32 = 16u;
const RADIX_BLOCK: u32 = 4096u;
const DIGITS: u32 = 256u;

fn radix_blocks(n: u32) -> u32 {
    return n / RADIX_BLOCK + select(0u, 1u, n % RADIX_BLOCK != 0u);
}
