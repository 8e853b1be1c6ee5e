//! The intermediate representation: registers and structured operations.
//!
//! Invariants, which [`validate`] checks:
//! 1. Every register that an operation names exists, and numbers and strings are not confused.
//! 2. A handle has its register's width: 1 (float), 3 (triple) or 16 (matrix); where an operation does not fix the widths by the types
//!    of its handles, they agree with each other, and those of a call with its function's row.
//! 3. Every register is written before it is read, on every path; globals and parameters count as written.
//! 4. `Break` and `Continue` stand inside a `Loop`, `Return` inside an `Inline`, `Solar` and `Illuminate` only in light shaders, `Illuminance` only outside.
//!
//! Whether a register is uniform (one value) or varying (one a point) is settled while running: an operation on uniform
//! operands gives a uniform result, so nothing uniform is computed twice.

pub mod builtins;
mod globals;
mod op;
mod optimise;
mod program;
mod register;
mod show;
mod types;
mod validate;
mod walk;

pub use crate::shadeop::number::{Binary, Unary};
pub use globals::Global;
pub use op::{Ask, Builtin, Lookup, Op, Transform};
pub(crate) use optimise::optimise;
pub use program::{Parameter, Program};
pub use register::{FloatReg, MatrixReg, Operand, Reg, TextReg, TripleReg};
pub use types::{Kind, ShaderKind};
pub use validate::validate;
pub use walk::visit;
