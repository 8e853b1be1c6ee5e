//! Names of primitive variables.

/// Names of the variables that the patches of a primitive have, in the order of their values.
#[derive(Clone, Debug, Default)]
pub struct VariableNames {
    /// Of those that are the same all over a patch.
    pub uniform: Vec<String>,
    /// Of those that vary.
    pub varying: Vec<String>,
}
