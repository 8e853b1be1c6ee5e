//! Disjoint sets of numbers.

/// Disjoint sets: of each number another one of its set that is lower, or itself.
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// The sets of 0, 1, … n − 1, each by itself.
    pub fn new(n: usize) -> DisjointSets {
        DisjointSets((0..n as u32).collect())
    }

    /// The lowest number of a number's set.
    pub fn of(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let next = self.0[i as usize];
            // The way becomes shorter.
            self.0[i as usize] = self.0[next as usize];
            i = next;
        }
        i
    }

    /// Join the sets of two numbers.
    pub fn join(&mut self, two: [u32; 2]) {
        let [a, b] = two.map(|i| self.of(i));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
