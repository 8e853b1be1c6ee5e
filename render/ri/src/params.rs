//! Parameter lists: `"class type name[n]" values`, declared inline or by `Declare` (RISpec section 3).

use std::collections::HashMap;

/// The storage class of a primitive variable (RISpec section 3): the count of its values over a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// One value per primitive.
    Constant,
    /// One value per facet of the primitive.
    Uniform,
    /// One value per parametric corner, interpolated bilinearly.
    Varying,
    /// One value per control vertex, interpolated as the surface itself is.
    Vertex,
    /// One value per corner of each face, interpolated bilinearly.
    FaceVarying,
}

impl Class {
    /// Whether a value is constant over a facet or the whole primitive.
    pub fn is_whole(self) -> bool {
        matches!(self, Class::Constant | Class::Uniform)
    }

    /// The class's name in declarations.
    pub fn name(self) -> &'static str {
        match self {
            Class::Constant => "constant",
            Class::Uniform => "uniform",
            Class::Varying => "varying",
            Class::Vertex => "vertex",
            Class::FaceVarying => "facevarying",
        }
    }
}

/// The type of a parameter's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// A floating-point number.
    Float,
    /// A whole number.
    Integer,
    /// A string.
    String,
    /// A colour, three numbers.
    Color,
    /// A position.
    Point,
    /// A direction.
    Vector,
    /// A surface normal.
    Normal,
    /// A homogeneous position, four numbers.
    HPoint,
    /// A 4×4 matrix, 16 numbers.
    Matrix,
    /// A position of blobbies: at each leaf the matrix from the leaf's own space, 16 numbers.
    MatrixPoint,
}

impl Type {
    /// The type's name in declarations.
    pub fn name(self) -> &'static str {
        match self {
            Type::Float => "float",
            Type::Integer => "integer",
            Type::String => "string",
            Type::Color => "color",
            Type::Point => "point",
            Type::Vector => "vector",
            Type::Normal => "normal",
            Type::HPoint => "hpoint",
            Type::Matrix => "matrix",
            Type::MatrixPoint => "mpoint",
        }
    }

    /// Count of numbers (or strings) in one value.
    pub fn width(self) -> usize {
        match self {
            Type::Float | Type::Integer | Type::String => 1,
            Type::Color | Type::Point | Type::Vector | Type::Normal => 3,
            Type::HPoint => 4,
            Type::Matrix | Type::MatrixPoint => 16,
        }
    }
}

/// The declaration of a parameter: name, storage class, type and array length.
#[derive(Clone, Debug, PartialEq)]
pub struct Declaration {
    /// Name of the parameter.
    pub name: String,
    /// Storage class.
    pub class: Class,
    /// Type of the values.
    pub ty: Type,
    /// Count of elements of an array; 1 for a single value.
    pub array: usize,
}

impl Declaration {
    /// The declaration of a single value, not an array.
    pub fn new(name: &str, class: Class, ty: Type) -> Declaration {
        Declaration { name: name.into(), class, ty, array: 1 }
    }

    /// The inline form of the declaration: `class type[n] name`.
    pub fn inline(&self) -> String {
        let array = if self.array > 1 { format!("[{}]", self.array) } else { String::new() };
        format!("{} {}{array} {}", self.class.name(), self.ty.name(), self.name)
    }

    /// Count of numbers (or strings) in one value of this declaration, array elements included.
    pub fn width(&self) -> usize {
        self.ty.width() * self.array
    }
}

/// The values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers; [`Declaration::width`] of them for each value.
    Floats(Vec<f32>),
    /// Strings, one for each value and array element.
    Strings(Vec<String>),
}

/// A parameter: its declaration and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// The declaration.
    pub decl: Declaration,
    /// The values.
    pub values: Values,
}

impl Param {
    /// A parameter of numbers, not an array.
    pub fn floats(name: &str, class: Class, ty: Type, values: impl Into<Vec<f32>>) -> Param {
        Param { decl: Declaration::new(name, class, ty), values: Values::Floats(values.into()) }
    }

    /// A uniform parameter of one string.
    pub fn string(name: &str, value: &str) -> Param {
        Param {
            decl: Declaration::new(name, Class::Uniform, Type::String),
            values: Values::Strings(vec![value.into()]),
        }
    }

    /// The numbers; empty if the values are strings.
    pub fn numbers(&self) -> &[f32] {
        match &self.values {
            Values::Floats(v) => v,
            Values::Strings(_) => &[],
        }
    }

    /// The first string, if the values are strings.
    pub fn text(&self) -> Option<&str> {
        match &self.values {
            Values::Strings(v) => v.first().map(String::as_str),
            Values::Floats(_) => None,
        }
    }
}

/// A parameter list.
pub type Params = Vec<Param>;

/// Parameters that options and attributes of a group have without a declaration, with the type of each.
const SETTINGS: [(&str, &str, &str); 9] = [
    ("shape", "kind", "float"),
    ("shape", "size offset", "float[3]"),
    ("texture", "colorspace", "string"),
    ("sky", "sun", "vector"),
    ("sky", "turbidity", "float"),
    ("quality", "sky sun", "float"),
    ("imager", "exposed", "float"),
    ("film", "view", "float"),
    ("film", "levels", "float[2]"),
];

/// The declaration of a parameter that the group of an option or an attribute has.
pub(crate) fn declaration_in(group: &str, name: &str) -> Option<Declaration> {
    let is_it = |(of, names, _): &&(&str, &str, &str)| *of == group && names.split(' ').any(|n| n == name);
    let (.., ty) = SETTINGS.iter().find(is_it)?;
    Some(parse_inline(&format!("{ty} {name}")).expect("a sound declaration"))
}

/// The declarations in force: the standard ones of RISpec section 3 and what `Declare` added.
pub struct Declarations(HashMap<String, Declaration>);

impl Default for Declarations {
    fn default() -> Declarations {
        let mut known = Declarations(HashMap::new());
        for (names, class, ty) in [
            ("P", Class::Vertex, Type::Point),
            ("Pw", Class::Vertex, Type::HPoint),
            ("Pz", Class::Vertex, Type::Float),
            ("N", Class::Varying, Type::Normal),
            ("Np", Class::Uniform, Type::Normal),
            ("Cs Os", Class::Varying, Type::Color),
            ("s t", Class::Varying, Type::Float),
            ("width", Class::Varying, Type::Float),
            ("constantwidth", Class::Constant, Type::Float),
            ("Ka Kd Ks Kr roughness intensity coneangle conedeltaangle beamdistribution", Class::Uniform, Type::Float),
            ("mindistance maxdistance distance amplitude fov Km eta blur bias samples", Class::Uniform, Type::Float),
            ("lightcolor specularcolor background bgcolor", Class::Uniform, Type::Color),
            ("from to", Class::Uniform, Type::Point),
            ("texturename shadowname name shadinggroup depthfilter", Class::Uniform, Type::String),
            ("shader texture archive procedural display rib", Class::Uniform, Type::String),
            ("gridsize bucketsize texturememory eyesplits jitter binary endofframe", Class::Uniform, Type::Integer),
            ("camera nsamples displacements maxdepth maxdiffusedepth", Class::Uniform, Type::Integer),
            ("coordinatesystem space sense", Class::Uniform, Type::String),
            ("sphere dither", Class::Uniform, Type::Float),
        ] {
            for name in names.split(' ') {
                known.0.insert(name.into(), Declaration::new(name, class, ty));
            }
        }
        known.declare("st", "varying float[2]").expect("a sound declaration");
        known.declare("quantize", "uniform float[4]").expect("a sound declaration");
        known
    }
}

impl Declarations {
    /// Add a declaration, as `Declare "name" "class type[n]"` does. An error if its text is malformed.
    pub fn declare(&mut self, name: &str, declaration: &str) -> Result<(), String> {
        let decl = parse_inline(&format!("{declaration} {name}"))?;
        self.0.insert(name.into(), decl);
        Ok(())
    }

    /// The declaration that a token of a parameter list stands for: an inline declaration, or the name of one in force; `None` for
    /// an undeclared name. An error if an inline declaration is malformed.
    pub fn resolve(&self, token: &str) -> Result<Option<Declaration>, String> {
        if let Some(known) = self.0.get(token) {
            return Ok(Some(known.clone()));
        }
        if token.contains(char::is_whitespace) { parse_inline(token).map(Some) } else { Ok(None) }
    }

    /// All declared names, in no particular order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }
}

/// `[class] type[n] name`.
fn parse_inline(text: &str) -> Result<Declaration, String> {
    let spaced = text.replace('[', " [ ").replace(']', " ] ");
    let mut words = spaced.split_whitespace().peekable();
    let class = match words.peek().copied() {
        Some("constant") => Class::Constant,
        Some("uniform") => Class::Uniform,
        Some("varying") => Class::Varying,
        Some("vertex") => Class::Vertex,
        Some("facevarying") => Class::FaceVarying,
        _ => Class::Uniform,
    };
    if words.peek() == Some(&class.name()) {
        words.next();
    }
    let ty = match words.next() {
        Some("float") => Type::Float,
        Some("integer" | "int") => Type::Integer,
        Some("string") => Type::String,
        Some("color") => Type::Color,
        Some("point") => Type::Point,
        Some("vector") => Type::Vector,
        Some("normal") => Type::Normal,
        Some("hpoint") => Type::HPoint,
        Some("matrix") => Type::Matrix,
        Some("mpoint") => Type::MatrixPoint,
        other => {
            return Err(format!(
                "`{}` is not a type, expected float, integer, string, color, point, vector, normal, hpoint, matrix or mpoint",
                other.unwrap_or("")
            ));
        }
    };
    let mut array = 1;
    if words.peek() == Some(&"[") {
        words.next();
        array = words
            .next()
            .and_then(|n| n.parse().ok())
            .filter(|n| *n > 0)
            .ok_or("an array's size must be a whole number above 0")?;
        if words.next() != Some("]") {
            return Err("expected `]` after an array's size".into());
        }
    }
    let name = words.next().ok_or("a declaration needs a name")?;
    match words.next() {
        Some(extra) => Err(format!("unexpected `{extra}` in a declaration")),
        None => Ok(Declaration { name: name.into(), class, ty, array }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declarations() {
        let known = Declarations::default();
        assert_eq!(known.resolve("P").unwrap().unwrap().class, Class::Vertex);
        let d = known.resolve("varying color[2] tint").unwrap().unwrap();
        assert_eq!((d.class, d.ty, d.array, d.name.as_str()), (Class::Varying, Type::Color, 2, "tint"));
        assert_eq!(d.inline(), "varying color[2] tint");
        assert!(known.resolve("uniform flaot x").is_err());
        assert_eq!(known.resolve("unheard").unwrap(), None);
    }
}
