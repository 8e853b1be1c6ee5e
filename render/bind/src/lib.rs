//! Metadata that binds data columns to geometry and shaders, and the injection into scenes.
