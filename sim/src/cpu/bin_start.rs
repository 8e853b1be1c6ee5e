//! Find the range of each active bin among the sorted (bin, shape) pairs.
//! in   bin        [n_bin_pairs]    sorted
//! out  bin_start  [n_active_bins]  first pair, and the end
//! Source: paper §3, stages 5 and 6.

/// The stage. Bins with a single shape are left out: they have no pairs.
pub fn run(bin: &[u32], bin_start: &mut Vec<[u32; 2]>) {
    bin_start.clear();
    let mut first = 0;
    for i in 1..=bin.len() {
        if i == bin.len() || bin[i] != bin[first] {
            if i - first > 1 {
                bin_start.push([first as u32, i as u32]);
            }
            first = i;
        }
    }
}
