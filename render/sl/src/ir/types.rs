//! The kinds of shaders and of values.

/// What a shader is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShaderKind {
    /// Colour and opacity of a surface.
    Surface,
    /// Moves the surface.
    Displacement,
    /// A source of light.
    Light,
    /// What fills space.
    Volume,
    /// A last step on pixels.
    Imager,
}

impl ShaderKind {
    /// The keyword.
    pub fn name(self) -> &'static str {
        match self {
            ShaderKind::Surface => "surface",
            ShaderKind::Displacement => "displacement",
            ShaderKind::Light => "light",
            ShaderKind::Volume => "volume",
            ShaderKind::Imager => "imager",
        }
    }

    pub(crate) fn of_name(name: &str) -> Option<ShaderKind> {
        use ShaderKind::*;
        [Surface, Displacement, Light, Volume, Imager].into_iter().find(|k| k.name() == name)
    }
}

/// What a value means, for parameters and globals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number.
    Float,
    /// A colour.
    Color,
    /// A position.
    Point,
    /// A direction.
    Vector,
    /// A normal.
    Normal,
    /// A matrix.
    Matrix,
    /// Text.
    Text,
}

impl Kind {
    /// The keyword.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Float => "float",
            Kind::Color => "color",
            Kind::Point => "point",
            Kind::Vector => "vector",
            Kind::Normal => "normal",
            Kind::Matrix => "matrix",
            Kind::Text => "string",
        }
    }

    /// Numbers in a value.
    pub fn width(self) -> usize {
        match self {
            Kind::Float | Kind::Text => 1,
            Kind::Color | Kind::Point | Kind::Vector | Kind::Normal => 3,
            Kind::Matrix => 16,
        }
    }
}
