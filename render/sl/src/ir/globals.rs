//! The global variables of shaders (RISpec section 12).

use super::types::Kind;

/// A global variable of shaders (RISpec section 12); its discriminant is its slot in
/// [`crate::machine::Points`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Global {
    /// Surface position.
    P,
    /// Shading normal.
    N,
    /// Geometric normal.
    Ng,
    /// Incident ray direction, from the eye to the point.
    I,
    /// Position of the eye.
    E,
    /// Surface colour of the primitive.
    Cs,
    /// Surface opacity of the primitive.
    Os,
    /// Output colour.
    Ci,
    /// Output opacity.
    Oi,
    /// First texture coordinate.
    S,
    /// Second texture coordinate.
    T,
    /// First surface parameter.
    U,
    /// Second surface parameter.
    V,
    /// Light direction: towards the light in surface shaders, from it in light shaders.
    L,
    /// Light colour.
    Cl,
    /// Light opacity.
    Ol,
    /// Position of the point that is lit, in light shaders.
    Ps,
    /// Shading normal at the point that is lit, in light shaders.
    Ns,
    /// Shutter time.
    Time,
    /// Duration for which the shutter is open.
    Dtime,
    /// Change of P per unit of time, the velocity.
    DPdtime,
    /// Coverage of a pixel, in imager shaders.
    Alpha,
    /// Count of components of a colour.
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
    (Global::Ns, "Ns", Kind::Normal),
    (Global::Time, "time", Kind::Float),
    (Global::Dtime, "dtime", Kind::Float),
    (Global::DPdtime, "dPdtime", Kind::Vector),
    (Global::Alpha, "alpha", Kind::Float),
    (Global::Ncomps, "ncomps", Kind::Float),
];

impl Global {
    /// Count of global variables.
    pub const COUNT: usize = 23;

    /// The variable's slot, from 0.
    #[inline(always)]
    pub const fn slot(self) -> usize {
        self as usize
    }

    /// The variable's name in shaders.
    pub const fn name(self) -> &'static str {
        TABLE[self.slot()].1
    }

    /// The variable's type.
    pub const fn kind(self) -> Kind {
        TABLE[self.slot()].2
    }

    /// Whether its class is varying; the others are uniform.
    pub const fn varies(self) -> bool {
        !matches!(self, Global::E | Global::Time | Global::Dtime | Global::Ncomps)
    }

    /// The global variable of a name.
    pub fn of_name(name: &str) -> Option<Global> {
        Global::all().find(|g| g.name() == name)
    }

    /// All global variables, by slot.
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
