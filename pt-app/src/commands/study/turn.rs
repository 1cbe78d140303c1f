//! Studies that run at the same time on one device take turns: times of passes are those of a device that nothing else uses.

use pt_core::Device;
use std::fs::{File, OpenOptions};
use std::path::Path;

/// The right to use a device. It is a lock of the system on a file in the folder of temporary files, so that a process that is killed gives it back.
pub struct Turn {
    /// None: a CPU device, whose cores several processes may well share, or the file cannot be opened.
    file: Option<File>,
    is_held: bool,
}

impl Turn {
    /// Does not wait.
    pub fn of(device: &Device) -> Self {
        let info = device.info();
        if info.is_cpu() {
            return Self { file: None, is_held: false };
        }
        Self::at(&std::env::temp_dir().join(format!("pt-device-{}.lock", info.uuid)))
    }

    fn at(path: &Path) -> Self {
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        // Another user's file cannot be written to, but locked.
        Self { file: file.or_else(|_| File::open(path)).ok(), is_held: false }
    }

    /// Waits until no other study uses the device. Does nothing if it is ours already.
    pub fn take(&mut self) {
        if let (false, Some(file)) = (self.is_held, &self.file) {
            // Where the file system has no locks, all run at once.
            self.is_held = file.lock().is_ok();
        }
    }

    /// Lets others use the device, which must have finished our work.
    pub fn release(&mut self) {
        if let (true, Some(file)) = (self.is_held, &self.file) {
            self.is_held = file.unlock().is_err();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;

    #[test]
    fn one_at_a_time_has_the_turn() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        let (mut first, mut second) = (Turn::at(&path), Turn::at(&path));
        first.take();
        first.take();
        let free = AtomicBool::new(false);
        std::thread::scope(|threads| {
            threads.spawn(|| {
                second.take();
                assert!(free.load(Ordering::SeqCst), "both have it");
                second.release();
            });
            std::thread::sleep(Duration::from_millis(50));
            free.store(true, Ordering::SeqCst);
            first.release();
        });
        assert!(!first.is_held);
        first.take();
        assert!(first.is_held, "it has been given back");
    }

    #[test]
    fn without_a_file_nobody_waits() {
        let mut turn = Turn::at(Path::new("/no/such/folder/lock"));
        turn.take();
        turn.release();
        assert!(!turn.is_held);
    }
}
