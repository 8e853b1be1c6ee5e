// The layers of samples in their order: nearest first, and of what is equally near, what came first.
// in    ends    [n]         where the list of a sample ends
// inout layers  [n_layers]  key of the depth, and id
// in    params  [1]         count of samples
// Twin: cpu/samples/layers.rs
#import layer_ids

@group(0) @binding(0) var<storage, read> ends: array<u32>;
@group(0) @binding(1) var<storage, read_write> layers: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> params: array<u32>;

// Layers up to which a list is sorted by insertion, and layers of a heap that one loop goes through.
const FEW: u32 = 12u;
const RUN: u32 = 32768u;

fn is_before(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.x < b.x || (a.x == b.x && (a.y & ID) < (b.y & ID));
}

fn insert(first: u32, end: u32) {
    for (var k = first + 1u; k < end; k += 1u) {
        let layer = layers[k];
        var at = k;
        while at > first && is_before(layer, layers[at - 1u]) {
            layers[at] = layers[at - 1u];
            at -= 1u;
        }
        layers[at] = layer;
    }
}

// Let a layer sink into a heap of n, whose greatest is at the top, from a place on.
fn sink(first: u32, n: u32, start: u32, layer: vec2<u32>) {
    var at = start;
    while 2u * at + 1u < n {
        var child = 2u * at + 1u;
        if child + 1u < n && is_before(layers[first + child], layers[first + child + 1u]) {
            child += 1u;
        }
        if !is_before(layer, layers[first + child]) {
            break;
        }
        layers[first + at] = layers[first + child];
        at = child;
    }
    layers[first + at] = layer;
}

fn sort_heap(first: u32, n: u32) {
    for (var high = n / 2u; high > 0u; high -= min(high, RUN)) {
        for (var k = high; k > high - min(high, RUN); k -= 1u) {
            sink(first, n, k - 1u, layers[first + k - 1u]);
        }
    }
    for (var high = n - 1u; high > 0u; high -= min(high, RUN)) {
        for (var last = high; last > high - min(high, RUN); last -= 1u) {
            let layer = layers[first + last];
            layers[first + last] = layers[first];
            sink(first, last, 0u, layer);
        }
    }
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = (group.x + group.y * 65535u) * 64u + thread;
    if k >= params[0] {
        return;
    }
    var first = 0u;
    if k > 0u {
        first = ends[k - 1u];
    }
    let n = ends[k] - first;
    if n <= FEW {
        insert(first, ends[k]);
    } else {
        sort_heap(first, n);
    }
}
