// Enter the contacts of the last step into a table by their shapes and features. Which slot a contact has may differ from run to run, what is found
// there does not.
// in    last_key  [n_last]   shapes and feature
// inout table     [n_slots]  one more than the index of a contact; zeros in
// in    count     [1]        n_last
#import sphere
#import contact_hash

@group(0) @binding(0) var<storage, read> last_key: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> table: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let n = arrayLength(&table);
    var slot = slot_of(last_key[k], n);
    for (var i = 0u; i < n; i++) {
        let found = atomicCompareExchangeWeak(&table[slot], 0u, k + 1u);
        if found.exchanged {
            return;
        }
        if found.old_value != 0u {
            slot = (slot + 1u) & (n - 1u);
        }
    }
}
