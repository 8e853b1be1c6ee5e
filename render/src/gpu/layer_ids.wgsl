// What is known of a layer beside its id: it is near a side of its grid, where another grid of the primitive may be met, too; near an edge of its
// primitive; another face was met with it.

const AT_SIDE: u32 = 0x80000000u;
const AT_RIM: u32 = 0x40000000u;
const JOINED: u32 = 0x20000000u;
const ID: u32 = 0x1fffffffu;
