// The pass of the broad phase: pairs are counted.
const WRITES: bool = false;
