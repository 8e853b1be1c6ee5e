//! The global variables of shaders (RISpec section 14).

use super::types::Kind;

/// A global variable; its index is its slot in the points of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Global {
    /// Position.
    P,
    /// Shading normal.
    N,
    /// Normal of the surface itself.
    Ng,
    /// Incident direction.
    I,
    /// Position of the eye.
    E,
    /// Colour of the primitive.
    Cs,
    /// Opacity of the primitive.
    Os,
    /// Colour that comes out.
    Ci,
    /// Opacity that comes out.
    Oi,
    /// Texture coordinate.
    S,
    /// Texture coordinate.
    T,
    /// Surface parameter.
    U,
    /// Surface parameter.
    V,
    /// Direction of light.
    L,
    /// Colour of light.
    Cl,
    /// Opacity of light.
    Ol,
    /// Point that is lit.
    Ps,
    /// Time of the shutter.
    Time,
    /// How long the shutter is open.
    Dtime,
    /// Velocity.
    DPdtime,
    /// Coverage of a pixel.
    Alpha,
    /// Components of a colour.
    Ncomps,
}

/// Global variables by their slots: name and type.
const TABLE: [(Global, &str, Kind); Global::COUNT] = [
    (Global::P, "P", Kind::Point),
    (Global::N, "N", Kind::Normal),
    (Global::Ng, "Ng", Kind::Normal),
    (Global::I, "I", Kind::Vector),
    (Global::E, "E", Kind::Point),
    (Global::Cs, "Cs", Kind::Color),
    (Global::Os, "Os", Kind::Color),
    (Global::Ci, "Ci", Kind::Color),
    (Global::Oi, "Oi", Kind::Color),
    (Global::S, "s", Kind::Float),
    (Global::T, "t", Kind::Float),
    (Global::U, "u", Kind::Float),
    (Global::V, "v", Kind::Float),
    (Global::L, "L", Kind::Vector),
    (Global::Cl, "Cl", Kind::Color),
    (Global::Ol, "Ol", Kind::Color),
    (Global::Ps, "Ps", Kind::Point),
    (Global::Time, "time", Kind::Float),
    (Global::Dtime, "dtime", Kind::Float),
    (Global::DPdtime, "dPdtime", Kind::Vector),
    (Global::Alpha, "alpha", Kind::Float),
    (Global::Ncomps, "ncomps", Kind::Float),
];

impl Global {
    /// Count of globals.
    pub const COUNT: usize = 22;

    /// Its slot.
    #[inline(always)]
    pub const fn slot(self) -> usize {
        self as usize
    }

    /// Its name in shaders.
    pub const fn name(self) -> &'static str {
        TABLE[self.slot()].1
    }

    /// Its type.
    pub const fn kind(self) -> Kind {
        TABLE[self.slot()].2
    }

    /// The global of a name.
    pub fn of_name(name: &str) -> Option<Global> {
        Global::all().find(|g| g.name() == name)
    }

    /// All of them.
    pub fn all() -> impl Iterator<Item = Global> {
        TABLE.iter().map(|row| row.0)
    }
}

// Rows stand in the order of the slots.
const _: () = {
    let mut k = 0;
    while k < Global::COUNT {
        assert!(TABLE[k].0.slot() == k);
        k += 1;
    }
};
