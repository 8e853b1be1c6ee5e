//! Why a model cannot be simulated on a device.

use gpu::GpuError;

/// Why a model cannot be simulated on a device.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// The model has something that is not built for devices.
    Unsupported(String),
    /// A body is not where a position can be: not finite, or too far from the origin.
    Position(u32),
    /// A fault of the device.
    Gpu(GpuError),
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Fault::Unsupported(what) => f.write_str(what),
            Fault::Position(body) => write!(f, "body {body} is too far from the origin for the graphics device"),
            Fault::Gpu(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for Fault {}

impl From<GpuError> for Fault {
    fn from(error: GpuError) -> Fault {
        Fault::Gpu(error)
    }
}
