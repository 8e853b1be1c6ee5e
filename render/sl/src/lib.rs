//! The RenderMan shading language: front end, typed IR, and the grid machine.
