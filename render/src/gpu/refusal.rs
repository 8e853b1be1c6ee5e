//! Why a frame is not drawn on a device.

use gpu::GpuError;
use sl::wgsl::{Fault, Refused};
use std::fmt::{Display, Formatter};

/// Why a frame is not drawn on a device.
#[derive(Debug)]
pub enum Refusal {
    /// It has something that is not built for devices: a sentence.
    Unsupported(String),
    /// The device cannot do it, or has failed.
    Device(GpuError),
}

impl Refusal {
    /// A shader does something that is not built: the end of the sentence "the shader `x` …".
    pub fn of_shader(name: &str, reason: &str) -> Refusal {
        Refusal::Unsupported(format!("the shader `{name}` {reason}, which is not built for graphics devices"))
    }

    /// A shader has gone wrong: the processor finds how.
    pub fn of_fault(fault: &Fault) -> Refusal {
        let (name, place, what) = match fault {
            Fault::Endless(name, place) => (name, place, "has a loop that does not end"),
            Fault::Outside(name, place) => (name, place, "uses an element that its array does not have"),
        };
        Refusal::Unsupported(format!("the shader `{name}` {what} ({place})"))
    }
}

impl Display for Refusal {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Refusal::Unsupported(why) => f.write_str(why),
            Refusal::Device(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for Refusal {}

impl From<Refused> for Refusal {
    fn from(refused: Refused) -> Refusal {
        Refusal::Unsupported(refused.to_string())
    }
}

impl From<GpuError> for Refusal {
    fn from(error: GpuError) -> Refusal {
        Refusal::Device(error)
    }
}
