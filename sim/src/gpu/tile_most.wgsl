// The most bodies of a tile that is not big: with them the memory of a workgroup is 16 KiB. In place of one that is held.
const MOST_BODIES: u32 = 480u;
// The same for spheres in the rounds after the first, whose pairs cross the sides of the first's tiles: as many as lie at the sides of a full one. With
// half of the memory, more of these small workgroups are under way at once.
const MOST_LATER: u32 = 224u;
