//! The graphics device that images are drawn on, opened when the first image needs it.

use crate::job::DrawOn;
use crate::report::{Exit, Failure, Outcome};
use gpu::{Choice, GpuError};
use render::DeviceRenderer;
use std::sync::Arc;

/// The device of a command, if it draws on one.
pub struct Drawer {
    on: DrawOn,
    open: Option<Arc<DeviceRenderer>>,
    /// The most of its memory that is taken, bytes, if there is a limit.
    memory: Option<u64>,
}

impl Drawer {
    /// None is open yet.
    pub fn new(on: DrawOn) -> Drawer {
        Drawer { on, open: None, memory: None }
    }

    /// The same, with a limit on the memory of the device that is taken, bytes, if one is given.
    pub fn within(self, memory: Option<u64>) -> Drawer {
        Drawer { memory, ..self }
    }

    /// Whether the images may be drawn on a device.
    pub fn may_be_device(&self) -> bool {
        match &self.on {
            DrawOn::Cpu => false,
            DrawOn::Gpu(_) => true,
            DrawOn::Auto => gpu::may_have_hardware(),
        }
    }

    /// Whether a device is open that draws.
    pub fn is_open(&self) -> bool {
        self.open.as_ref().is_some_and(|device| !device.has_failed())
    }

    /// The device, opened if it is not, or has failed; none if the processor draws.
    pub fn device(&mut self) -> Outcome<Option<Arc<DeviceRenderer>>> {
        if self.open.as_ref().is_some_and(|device| device.has_failed()) {
            self.open = None;
        }
        let choice = match &self.on {
            DrawOn::Cpu => return Ok(None),
            DrawOn::Gpu(choice) => choice.clone(),
            DrawOn::Auto if !gpu::may_have_hardware() => return Ok(None),
            DrawOn::Auto => Choice::Hardware,
        };
        if self.open.is_none() {
            match DeviceRenderer::open(&choice) {
                Ok(mut device) => {
                    if let Some(bytes) = self.memory {
                        device.limit_memory(bytes);
                    }
                    self.open = Some(Arc::new(device));
                }
                Err(why) if self.on == DrawOn::Auto => {
                    if !matches!(why, GpuError::NoAdapter { .. }) {
                        eprintln!("--backend auto: the processor draws: {why}");
                    }
                    self.on = DrawOn::Cpu;
                }
                Err(why) => return Err(failure(&why)),
            }
        }
        Ok(self.open.clone())
    }
}

/// Why there is no device, as a command fails by it.
fn failure(why: &GpuError) -> Failure {
    match why {
        GpuError::Choice { .. } => Failure::new(Exit::Usage, format!("--adapter: {why}")),
        _ => Failure::new(Exit::Fault, format!("--backend gpu: {why}")),
    }
}
