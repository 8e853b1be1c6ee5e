//! Formulas: compiled expressions of a file, and the faults of columns that they name.

use crate::expr::Expr;
use frame::yaml::Document;
use frame::{Fault, Frame};

/// A compiled expression and its key in the file.
#[derive(Clone, Debug)]
pub struct Formula {
    /// Key of the expression, such as `objects.2.select`.
    pub key: String,
    /// The expression.
    pub expr: Expr,
}

impl Formula {
    /// Compile the expression `text` of a key. An error if it is malformed.
    pub fn compile(doc: &Document, key: String, text: &str) -> Result<Formula, Fault> {
        match Expr::parse(text) {
            Ok(expr) => Ok(Formula { key, expr }),
            Err(e) => Err(doc.fault(&key, format!("in the expression, at character {}: {}", e.at + 1, e.message))),
        }
    }
}

/// The fault of a key that names a column which a frame does not have; its advice is the nearest of those that it has.
pub fn unknown_column(doc: &Document, key: &str, column: &str, frame: &Frame) -> Fault {
    let names = frame.names();
    let fault = doc.fault(key, format!("unknown column `{column}`, the data has {}", frame::listed(&names)));
    match frame::nearest(column, names.iter().copied()) {
        Some(near) => fault.hint(format!("did you mean `{near}`?")),
        None => fault,
    }
}
