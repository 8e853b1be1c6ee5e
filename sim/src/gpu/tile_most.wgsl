// The most bodies of a tile that is not big: with them the memory of a workgroup is 16 KiB. In place of one that is held.
const MOST_BODIES: u32 = 480u;
