// Whether there is room for all pairs and all of their contacts, and the pairs hold where that was expected; else the step has none, and is
// undone.
// in    place       [n_pairs + 1]  number of contacts of the pairs before each, and of all; of spheres as of shapes of any kind
// inout room        [3]            number of pairs that room is needed for in; whether there is room and number of contacts out
// out   n_contacts  [1]
// in    count       [1]            n_pairs
// in    left, lost  [1]            not zero if the pairs do not hold
// in    params      [3]            room for pairs and for contacts; whether the pairs are expected to hold

@group(0) @binding(0) var<storage, read> place: array<u32>;
@group(0) @binding(1) var<storage, read_write> room: array<u32>;
@group(0) @binding(2) var<storage, read_write> n_contacts: array<u32>;
@group(0) @binding(3) var<storage, read> count: array<u32>;
@group(0) @binding(4) var<storage, read> left: array<u32>;
@group(0) @binding(5) var<storage, read> lost: array<u32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

@compute @workgroup_size(1)
fn main() {
    let n = place[count[0]];
    let holds = params[2] == 0u || (left[0] == 0u && lost[0] == 0u);
    let has_room = holds && room[0] <= params[0] && n <= params[1];
    room[1] = select(0u, 1u, has_room);
    room[2] = n;
    n_contacts[0] = select(0u, n, has_room);
}
