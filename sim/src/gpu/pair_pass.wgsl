// The pass of the broad phase: pairs are written where they were counted before.
const WRITES: bool = true;
