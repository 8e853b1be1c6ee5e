// The recovery of overlaps where arms lie along normals, of two vectors a body: linear, and what keeps the angular momentum.
const DISPLACED: u32 = 2u;
