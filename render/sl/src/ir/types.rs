//! The kinds of shaders and of values.

/// The type of a shader (RISpec section 9).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShaderKind {
    /// `surface`: colour and opacity of a surface.
    Surface,
    /// `displacement`: displaced positions and normals of a surface.
    Displacement,
    /// `light`: the light that a source emits.
    Light,
    /// `volume`: colour and opacity through a volume, such as fog.
    Volume,
    /// `imager`: colour and opacity of filtered pixels, before exposure.
    Imager,
}

impl ShaderKind {
    /// The keyword that declares such a shader.
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

/// The type of a parameter or global variable (RISpec section 11).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `float`: a number.
    Float,
    /// `color`: red, green and blue.
    Color,
    /// `point`: a position.
    Point,
    /// `vector`: a direction.
    Vector,
    /// `normal`: a surface normal.
    Normal,
    /// `matrix`: a 4×4 matrix.
    Matrix,
    /// `string`: text.
    Text,
}

impl Kind {
    /// The keyword of the type.
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

    /// Count of numbers in a value: 1, 3 or 16. A string counts as 1.
    pub fn width(self) -> usize {
        match self {
            Kind::Float | Kind::Text => 1,
            Kind::Color | Kind::Point | Kind::Vector | Kind::Normal => 3,
            Kind::Matrix => 16,
        }
    }
}
