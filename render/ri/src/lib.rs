//! The RenderMan Interface: one trait, the RIB reader and the RIB writer.
