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

            /// The register's index.
            #[inline(always)]
            pub const fn index(self) -> usize {
                self.0 as usize
            }

            /// The register of element `k` of the array whose first element is in this one.
            #[inline]
            pub const fn element(self, k: u16) -> $name {
                $name(self.0 + k)
            }

            /// The registers of the array of `len` elements whose first element is in this one.
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
    /// Handle of a register of one number.
    FloatReg "r";
    /// Handle of a register of three numbers: a colour, a point, a vector or a normal.
    TripleReg "r";
    /// Handle of a register of sixteen numbers, a 4×4 matrix.
    MatrixReg "r";
    /// Handle of a register of a string.
    TextReg "t";
}

/// Handle of a register of numbers, of any width.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reg {
    /// One number.
    Float(FloatReg),
    /// Three numbers.
    Triple(TripleReg),
    /// Sixteen numbers.
    Matrix(MatrixReg),
}

impl Reg {
    /// The register of an index and a width of 1, 3 or 16.
    pub const fn of(index: u16, width: usize) -> Reg {
        match width {
            1 => Reg::Float(FloatReg(index)),
            3 => Reg::Triple(TripleReg(index)),
            _ => Reg::Matrix(MatrixReg(index)),
        }
    }

    /// The register's index.
    #[inline(always)]
    pub const fn index(self) -> usize {
        match self {
            Reg::Float(r) => r.index(),
            Reg::Triple(r) => r.index(),
            Reg::Matrix(r) => r.index(),
        }
    }

    /// The register's width, the count of numbers in a value: 1, 3 or 16.
    #[inline(always)]
    pub const fn width(self) -> usize {
        match self {
            Reg::Float(_) => 1,
            Reg::Triple(_) => 3,
            Reg::Matrix(_) => 16,
        }
    }

    /// The register of element `k` of the array whose first element is in this one.
    #[inline]
    pub const fn element(self, k: u16) -> Reg {
        Reg::of(self.index() as u16 + k, self.width())
    }

    /// The registers of the array of `len` elements whose first element is in this one.
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

/// Handle of a register of numbers or of a string.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// A register of numbers.
    Number(Reg),
    /// A register of a string.
    Text(TextReg),
}

impl Operand {
    /// The register of element `k` of the array whose first element is in this one.
    pub fn element(self, k: u16) -> Operand {
        match self {
            Operand::Number(r) => Operand::Number(r.element(k)),
            Operand::Text(r) => Operand::Text(r.element(k)),
        }
    }

    /// The registers of the array of `len` elements whose first element is in this one.
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
