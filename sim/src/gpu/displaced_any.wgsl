// The recovery of overlaps of bodies of any shape, of three vectors a body: linear, what keeps the angular momentum, and angular.
const DISPLACED: u32 = 3u;
