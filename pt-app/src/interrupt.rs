//! Ctrl-C ends a long command early, and what it has computed by then is written.

use anyhow::{Context, Result};
use pt_core::console::print_warning;
use signal_hook::consts::SIGINT;
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code after a second Ctrl-C: 128 and the number of the signal, as shells have it.
const STOPPED: i32 = 128 + SIGINT;

/// For the help of the commands that listen.
pub const HELP: &str = "Ctrl-C (SIGINT) ends the command after the frame or the samples in work: what is complete by then is written, and the \
     exit code is 0. A second Ctrl-C stops at once and writes nothing.";

/// Whether Ctrl-C was pressed (SIGINT was sent) since [`Interrupt::listen`]. Before that call the signal ends the program at once, as nothing
/// is there to be written.
pub struct Interrupt {
    pressed: Arc<AtomicBool>,
}

impl Interrupt {
    /// Listens from now on. The second signal ends the program at once.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn listen() -> Result<Self> {
        let pressed = Arc::new(AtomicBool::new(false));
        // In this order: a signal ends the program if an earlier one has set the flag.
        flag::register_conditional_shutdown(SIGINT, STOPPED, Arc::clone(&pressed))
            .and_then(|_| flag::register(SIGINT, Arc::clone(&pressed)))
            .context("cannot listen for Ctrl-C")?;
        Ok(Self { pressed })
    }

    /// Whether the command is to end early.
    pub fn is_pressed(&self) -> bool {
        self.pressed.load(Ordering::Relaxed)
    }

    /// Says that `done` of `total` units (in the plural) are what is written. Nothing is said when all are done.
    pub fn report(&self, done: u32, total: u32, units: &str) {
        if done < total && self.is_pressed() {
            print_warning(&format!("interrupted after {done} of {total} {units}, which are written"));
        }
    }
}
