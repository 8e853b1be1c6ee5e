// The first tile of each round.
// in   key          [n_pairs]  sorted: round and cube
// in   tile_first   [n_tiles]  first pair of each tile
// in   n_tiles      [1]
// in   n_due        [1]        not zero if pairs were put into tiles in this step
// out  round_start  [10]       first tile of each round and of the tile of pairs in none, and the end
// out  n_colored    [1]        tiles that are to be coloured: all or none
// in   params       [1]        bits of the index of a cube
@group(0) @binding(0) var<storage, read> key: array<u32>;
@group(0) @binding(1) var<storage, read> tile_first: array<u32>;
@group(0) @binding(2) var<storage, read> n_tiles: array<u32>;
@group(0) @binding(3) var<storage, read> n_due: array<u32>;
@group(0) @binding(4) var<storage, read_write> round_start: array<u32>;
@group(0) @binding(5) var<storage, read_write> n_colored: array<u32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

// The round of a tile; that after the last one is past all.
fn round_at(tile: u32) -> u32 {
    return key[tile_first[tile]] >> params[0];
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    let n = n_tiles[0];
    if thread == 0u {
        n_colored[0] = select(0u, n, n_due[0] != 0u);
    }
    if thread < 10u {
        // The first tile whose round is not before this one, by halving.
        var low = 0u;
        var high = n;
        for (var i = 0u; i < 32u && low < high; i++) {
            let middle = (low + high) / 2u;
            if round_at(middle) < thread {
                low = middle + 1u;
            } else {
                high = middle;
            }
        }
        round_start[thread] = low;
    }
}
