//! The global variables of shaders (RISpec section 14).

use super::types::Kind;

/// Global variables: name and type. The grid supplies those that a shader uses.
pub const GLOBALS: &[(&str, Kind)] = &[
    ("P", Kind::Point),
    ("N", Kind::Normal),
    ("Ng", Kind::Normal),
    ("I", Kind::Vector),
    ("E", Kind::Point),
    ("Cs", Kind::Color),
    ("Os", Kind::Color),
    ("Ci", Kind::Color),
    ("Oi", Kind::Color),
    ("s", Kind::Float),
    ("t", Kind::Float),
    ("u", Kind::Float),
    ("v", Kind::Float),
    ("L", Kind::Vector),
    ("Cl", Kind::Color),
    ("Ol", Kind::Color),
    ("Ps", Kind::Point),
    ("time", Kind::Float),
    ("dtime", Kind::Float),
    ("dPdtime", Kind::Vector),
    ("alpha", Kind::Float),
    ("ncomps", Kind::Float),
];
