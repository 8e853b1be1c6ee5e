//! Many rigid bodies with exact Coulomb friction cones: model, state, stages, solvers.
