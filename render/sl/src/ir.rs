//! The intermediate representation: registers and structured operations.
//!
//! Invariants, which [`validate`] checks:
//! 1. Every register that an operation names exists, and is of the operand's kind: numbers or a string.
//! 2. A handle has its register's width: 1 (float), 3 (triple) or 16 (matrix). Where the types of an operation's handles leave
//!    widths open, these agree with each other; those of a call agree with the function's row in [`builtins`].
//! 3. Every register is written before it is read, on every path; globals and parameters count as written.
//! 4. `Break` and `Continue` stand inside a `Loop`, `Return` inside an `Inline`, `Solar` and `Illuminate` only in light shaders,
//!    `Illuminance` only in other shaders.
//!
//! Whether a register is uniform (one value) or varying (one value per point) is determined at run time: an operation on uniform
//! operands gives a uniform result, so no uniform value is computed more than once per grid.

pub mod builtins;
mod globals;
mod op;
pub mod opacity;
mod optimise;
mod program;
mod register;
mod show;
mod types;
mod validate;
pub(crate) mod walk;

pub use crate::shadeop::number::{Binary, Unary};
pub use globals::Global;
pub use op::{Ask, Builtin, Lookup, Op, Transform};
pub(crate) use optimise::optimise;
pub use program::{Parameter, Program};
pub use register::{FloatReg, MatrixReg, Operand, Reg, TextReg, TripleReg};
pub use types::{Kind, ShaderKind};
pub use validate::validate;
pub use walk::visit;

/// The most rays of a `gather`.
pub const MAX_GATHERED: f32 = 65_535.0;
