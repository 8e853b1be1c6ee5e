//! Buffers that are kept from frame to frame, since to make them takes longer than to use them.

use gpu::{Buffer, Commands, Device, GpuError, Pod};
use std::any::Any;
use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Buffers that nothing uses at present, one a name. What they hold is left from before.
#[derive(Default)]
pub struct Kept {
    buffers: Mutex<HashMap<&'static str, Box<dyn Any + Send>>>,
    is_off: bool,
}

impl Kept {
    /// None is kept: what a frame does not use takes no memory.
    pub fn none() -> Kept {
        Kept { is_off: true, ..Kept::default() }
    }

    /// A buffer of a name with room for a number of rows, which hold anything: one that is kept, or a new one.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`].
    pub fn take<T: Pod + Send>(&self, device: &Device, name: &'static str, n: usize) -> Result<Buffer<T>, GpuError> {
        let kept = self.buffers().remove(name).and_then(|kept| kept.downcast::<Buffer<T>>().ok());
        match kept.filter(|kept| kept.capacity() >= n) {
            Some(kept) => Ok(*kept),
            // One that is too small is dropped before another is made.
            None => Buffer::zeros(device, name, n),
        }
    }

    /// The same with rows written to it.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`].
    pub fn filled<T: Pod + Send>(
        &self,
        device: &Device,
        name: &'static str,
        rows: &[T],
    ) -> Result<Buffer<T>, GpuError> {
        let buffer = self.take(device, name, rows.len())?;
        buffer.write(device, rows);
        Ok(buffer)
    }

    /// Keep a buffer for the next that wants one of its name; commands that use it may be under way.
    pub fn give<T: Pod + Send>(&self, name: &'static str, buffer: Buffer<T>) {
        if !self.is_off {
            self.buffers().insert(name, Box::new(buffer));
        }
    }

    fn buffers(&self) -> MutexGuard<'_, HashMap<&'static str, Box<dyn Any + Send>>> {
        self.buffers.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Commands with the buffers that they use, which are kept for others once these are sent: what is written to a buffer by then comes before them.
pub struct Recorded {
    pub commands: Commands,
    held: Vec<(&'static str, Box<dyn Any + Send>)>,
}

impl Recorded {
    /// Commands that use no such buffers yet.
    pub fn new(commands: Commands) -> Recorded {
        Recorded { commands, held: vec![] }
    }

    /// Hold a buffer until the commands are sent.
    pub fn hold<T: Pod + Send>(&mut self, name: &'static str, buffer: Buffer<T>) {
        self.held.push((name, Box::new(buffer)));
    }

    /// Send the commands, and keep the buffers.
    ///
    /// # Errors
    /// Those of [`Commands::send`].
    pub fn send(self, device: &Device, kept: &Kept) -> Result<(), GpuError> {
        self.commands.send(device)?;
        if !kept.is_off {
            kept.buffers().extend(self.held);
        }
        Ok(())
    }
}
