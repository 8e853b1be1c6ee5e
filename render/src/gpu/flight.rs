//! Frames in flight: any number may be drawn at a time on one device, each with its own handle to it, whose traffic and times are the
//! frame's alone, and with its own buffers.

use crate::gpu::kept::Kept;
use crate::gpu::refusal::Refusal;
use gpu::{Device, GpuError};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock};

/// What a frame in flight has of a device.
pub struct Flight {
    /// Its handle.
    pub device: Device,
    /// The buffers that it has from frames before.
    pub kept: Kept,
}

/// The frames in flight on a device.
#[derive(Default)]
pub struct Flights {
    /// What frames that are done have left for the next.
    idle: Mutex<Vec<Flight>>,
    /// Held by each frame that is drawn beside others, and alone by one that needs the device for itself.
    room: RwLock<()>,
    is_limited: bool,
}

impl Flights {
    /// Frames of which only one is drawn at a time, and which leave no buffers: memory is limited.
    pub fn limited() -> Flights {
        Flights { is_limited: true, ..Flights::default() }
    }

    /// Draw a frame beside others. One that finds no memory beside them, and beside the buffers that frames have left, is drawn again
    /// without.
    ///
    /// # Errors
    /// Those of `draw`.
    pub fn draw<T>(&self, device: &Device, draw: impl Fn(&Flight) -> Result<T, Refusal>) -> Result<T, Refusal> {
        if !self.is_limited {
            let beside = self.room.read().unwrap_or_else(PoisonError::into_inner);
            let drawn = self.draw_in(device, &draw);
            drop(beside);
            if !matches!(drawn, Err(Refusal::Device(GpuError::Memory { .. }))) {
                return drawn;
            }
        }
        let _alone = self.room.write().unwrap_or_else(PoisonError::into_inner);
        self.idle().clear();
        self.draw_in(device, &draw)
    }

    fn draw_in<T>(&self, device: &Device, draw: impl Fn(&Flight) -> Result<T, Refusal>) -> Result<T, Refusal> {
        let idle = self.idle().pop();
        let flight = idle.unwrap_or_else(|| {
            let kept = if self.is_limited { Kept::none() } else { Kept::default() };
            Flight { device: device.another(), kept }
        });
        let drawn = draw(&flight)?;
        // What a frame that was given up has left is dropped.
        self.idle().push(flight);
        Ok(drawn)
    }

    fn idle(&self) -> MutexGuard<'_, Vec<Flight>> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn a_frame_that_finds_no_memory_is_drawn_again_alone() {
        let device = match Device::open(&gpu::Choice::Any) {
            Ok(device) => device,
            Err(error) if std::env::var_os("REQUIRE_GPU").is_some() => panic!("REQUIRE_GPU is set, but {error}"),
            Err(error) => return eprintln!("skipped: {error}"),
        };
        let full = || Refusal::Device(GpuError::Memory { buffer: "points".into(), bytes: 1 });
        for (flights, n) in [(Flights::default(), 2), (Flights::limited(), 1)] {
            let drawn = Cell::new(0);
            let draw = |_: &Flight| {
                drawn.set(drawn.get() + 1);
                // The second time no other frame is drawn.
                let is_alone = flights.room.try_read().is_err();
                if is_alone && drawn.get() == n { Ok(()) } else { Err(full()) }
            };
            assert!(flights.draw(&device, draw).is_ok());
            assert_eq!(drawn.get(), n);
            assert!(flights.draw(&device, |_| Err::<(), _>(full())).is_err());
            assert!(flights.idle().is_empty());
        }
    }
}
