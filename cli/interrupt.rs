//! Interruption by the user or the scheduler: SIGINT and SIGTERM.
//!
//! While somebody listens, the first signal is a request to stop, and a second one ends the program at once. Else signals do what they
//! do by default.

use crate::report::{Exit, Failure, Outcome};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// The flags that the handlers of the signals read and write.
#[derive(Default)]
struct Flags {
    /// Whether nobody listens.
    is_idle: Arc<AtomicBool>,
    /// Whether a signal has come.
    is_requested: Arc<AtomicBool>,
}

/// A listener to interruptions, until it is dropped.
pub struct Listener {
    flags: &'static Flags,
}

impl Listener {
    /// Listen to interruptions.
    pub fn new() -> Outcome<Listener> {
        static FLAGS: OnceLock<Flags> = OnceLock::new();
        let flags = match FLAGS.get() {
            Some(flags) => flags,
            None => {
                let flags =
                    handle().map_err(|e| Failure::new(Exit::Fault, format!("signals cannot be handled: {e}")))?;
                FLAGS.get_or_init(|| flags)
            }
        };
        flags.is_idle.store(false, Ordering::SeqCst);
        Ok(Listener { flags })
    }

    /// Whether a stop is requested.
    pub fn is_requested(&self) -> bool {
        self.flags.is_requested.load(Ordering::Relaxed)
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.flags.is_idle.store(true, Ordering::SeqCst);
    }
}

/// Install the handlers. They run in the order in which they are registered.
fn handle() -> std::io::Result<Flags> {
    let flags = Flags::default();
    for signal in [SIGINT, SIGTERM] {
        flag::register_conditional_default(signal, flags.is_idle.clone())?;
        flag::register_conditional_shutdown(signal, Exit::Interrupted as i32, flags.is_requested.clone())?;
        flag::register(signal, flags.is_requested.clone())?;
    }
    Ok(flags)
}
