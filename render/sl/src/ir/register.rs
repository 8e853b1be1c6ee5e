//! Handles of registers. Registers of numbers are numbered together, whatever their width; those of strings apart.

use std::fmt::{Display, Formatter, Result};

macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident $letter:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub struct $name(u16);

        impl $name {
            /// The register of an index.
            pub const fn of_index(index: u16) -> $name {
                $name(index)
            }

            /// Its index.
            #[inline(always)]
            pub const fn index(self) -> usize {
                self.0 as usize
            }

            /// The register of the element `k` of an array that starts here.
            #[inline]
            pub const fn element(self, k: u16) -> $name {
                $name(self.0 + k)
            }

            /// The registers of an array that starts here.
            pub fn array(self, len: u16) -> impl Iterator<Item = $name> {
                (0..len).map(move |k| self.element(k))
            }
        }

        impl Display for $name {
            fn fmt(&self, f: &mut Formatter<'_>) -> Result {
                write!(f, concat!($letter, "{}"), self.0)
            }
        }
    )*};
}

handles! {
    /// A register of one number.
    FloatReg "r";
    /// A register of three numbers: a colour, a point, a vector or a normal.
    TripleReg "r";
    /// A register of sixteen numbers.
    MatrixReg "r";
    /// A register of a string.
    TextReg "t";
}

/// A register of numbers, of any width.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reg {
    /// One number.
    Float(FloatReg),
    /// Three.
    Triple(TripleReg),
    /// Sixteen.
    Matrix(MatrixReg),
}

impl Reg {
    /// The register of an index and a width.
    pub const fn of(index: u16, width: usize) -> Reg {
        match width {
            1 => Reg::Float(FloatReg(index)),
            3 => Reg::Triple(TripleReg(index)),
            _ => Reg::Matrix(MatrixReg(index)),
        }
    }

    /// Its index.
    #[inline(always)]
    pub const fn index(self) -> usize {
        match self {
            Reg::Float(r) => r.index(),
            Reg::Triple(r) => r.index(),
            Reg::Matrix(r) => r.index(),
        }
    }

    /// Components of a value: 1, 3 or 16.
    #[inline(always)]
    pub const fn width(self) -> usize {
        match self {
            Reg::Float(_) => 1,
            Reg::Triple(_) => 3,
            Reg::Matrix(_) => 16,
        }
    }

    /// The register of the element `k` of an array that starts here.
    #[inline]
    pub const fn element(self, k: u16) -> Reg {
        Reg::of(self.index() as u16 + k, self.width())
    }

    /// The registers of an array that starts here.
    pub fn array(self, len: u16) -> impl Iterator<Item = Reg> {
        (0..len).map(move |k| self.element(k))
    }
}

impl Display for Reg {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "r{}", self.index())
    }
}

macro_rules! widths {
    ($($name:ident $variant:ident;)*) => {$(
        impl From<$name> for Reg {
            #[inline(always)]
            fn from(r: $name) -> Reg {
                Reg::$variant(r)
            }
        }

        /// Back; an error if the register has another width.
        impl TryFrom<Reg> for $name {
            type Error = Reg;
            fn try_from(r: Reg) -> std::result::Result<$name, Reg> {
                if let Reg::$variant(own) = r { Ok(own) } else { Err(r) }
            }
        }
    )*};
}

widths! {
    FloatReg Float;
    TripleReg Triple;
    MatrixReg Matrix;
}

/// A number or a string register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// Numbers.
    Number(Reg),
    /// Text.
    Text(TextReg),
}

impl Operand {
    /// The register of the element `k` of an array that starts here.
    pub fn element(self, k: u16) -> Operand {
        match self {
            Operand::Number(r) => Operand::Number(r.element(k)),
            Operand::Text(r) => Operand::Text(r.element(k)),
        }
    }

    /// The registers of an array that starts here.
    pub fn array(self, len: u16) -> impl Iterator<Item = Operand> {
        (0..len).map(move |k| self.element(k))
    }
}

impl Display for Operand {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Operand::Number(r) => r.fmt(f),
            Operand::Text(r) => r.fmt(f),
        }
    }
}
