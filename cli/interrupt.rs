//! Interruption by the user or the scheduler: SIGINT and SIGTERM.
//!
//! While somebody listens, the first signal is a request to stop. Else, or by a second one, the program ends at once with exit code 130:
//! every file that it has written is whole. A signal that is ignored, as `nohup` and background jobs of scripts have it, stays so.

use crate::report::Exit;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

static IS_LISTENING: AtomicBool = AtomicBool::new(false);
static IS_REQUESTED: AtomicBool = AtomicBool::new(false);
/// What is said when a signal ends the program.
static REMARK: Mutex<String> = Mutex::new(String::new());

/// A listener to interruptions, until it is dropped.
pub struct Listener(());

impl Listener {
    /// Listen to interruptions.
    pub fn new() -> Listener {
        IS_LISTENING.store(true, Ordering::SeqCst);
        Listener(())
    }

    /// Whether a stop is requested.
    pub fn is_requested(&self) -> bool {
        IS_REQUESTED.load(Ordering::Relaxed)
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        IS_LISTENING.store(false, Ordering::SeqCst);
    }
}

/// Set what is said when a signal ends the program: what is done, and how it goes on.
pub fn remark(text: String) {
    *REMARK.lock().unwrap_or_else(|e| e.into_inner()) = text;
}

/// Answer to a signal.
#[cfg(unix)]
fn answer() {
    let is_first = !IS_REQUESTED.swap(true, Ordering::SeqCst);
    if is_first && IS_LISTENING.load(Ordering::SeqCst) {
        return;
    }
    let remark = REMARK.lock().unwrap_or_else(|e| e.into_inner());
    eprintln!("error: interrupted{}{remark}", if remark.is_empty() { "" } else { ": " });
    std::process::exit(Exit::Interrupted as i32);
}

/// Handle signals from now on, in a thread of their own.
#[cfg(unix)]
pub fn handle() -> std::io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM].into_iter().filter(|s| !is_ignored(*s)))?;
    std::thread::Builder::new().name("signals".into()).spawn(move || signals.forever().for_each(|_| answer()))?;
    Ok(())
}

/// Leave signals as they are.
#[cfg(not(unix))]
pub fn handle() -> std::io::Result<()> {
    Ok(())
}

#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    // SAFETY: a zeroed `sigaction` is valid, and with a null pointer for the new action the call only reads the present one.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        libc::sigaction(signal, std::ptr::null(), &mut action) == 0 && action.sa_sigaction == libc::SIG_IGN
    }
}
