//! Studies that run at the same time on one device take turns: times of passes are those of a device that nothing else uses.

use pt_core::Device;
use std::fs::{File, OpenOptions};
use std::path::Path;
use std::time::{Duration, SystemTime};

/// The right to use a device: alone, for frames whose time is measured, or together with others that prepare theirs. It is a lock of the system on a file in the folder of temporary files, so that a process that is killed gives it back.
pub struct Turn {
    /// None: a CPU device, whose cores several processes may well share, or the file cannot be opened.
    file: Option<File>,
    held: Held,
    pause: Duration,
    /// Whether we have had it alone.
    has_used: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Held {
    Not,
    Shared,
    Alone,
}

impl Turn {
    /// Does not wait.
    pub fn of(device: &Device) -> Self {
        let info = device.info();
        if info.is_cpu() {
            return Self::with(None);
        }
        Self::at(&std::env::temp_dir().join(format!("pt-device-{}.lock", info.uuid)))
    }

    fn with(file: Option<File>) -> Self {
        Self { file, held: Held::Not, pause: Duration::MAX, has_used: false }
    }

    fn at(path: &Path) -> Self {
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        // Another user's file cannot be written to, but locked.
        Self::with(file.or_else(|_| File::open(path)).ok())
    }

    /// Waits until no other study uses the device. Does nothing if it is ours alone already.
    pub fn take(&mut self) {
        self.wait(Held::Alone, File::lock);
    }

    /// How long no study had used the device when we took it. Long before the first time.
    pub fn pause(&self) -> Duration {
        self.pause
    }

    /// Waits until no study measures times, and keeps them from it: for the upload of a scene.
    pub fn share(&mut self) {
        self.wait(Held::Shared, File::lock_shared);
    }

    fn wait(&mut self, held: Held, lock: impl Fn(&File) -> std::io::Result<()>) {
        if self.held != held
            && let Some(file) = &self.file
        {
            // Where the file system has no locks, all run at once.
            self.held = if lock(file).is_ok() { held } else { Held::Not };
            // Whoever has had it alone leaves the time in the file.
            let used = self.has_used.then(|| file.metadata().and_then(|data| data.modified()).ok()).flatten();
            self.pause = used.and_then(|used| used.elapsed().ok()).unwrap_or(Duration::MAX);
        }
    }

    /// Lets others use the device, which must have finished our work.
    pub fn release(&mut self) {
        if self.held != Held::Not
            && let Some(file) = &self.file
        {
            if self.held == Held::Alone {
                self.has_used = file.set_modified(SystemTime::now()).is_ok();
            }
            if file.unlock().is_ok() {
                self.held = Held::Not;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;

    /// Fails unless `next` gets the turn only when `holder` gives it back.
    fn takes_it_after(next: &mut Turn, holder: &mut Turn) {
        let free = AtomicBool::new(false);
        std::thread::scope(|threads| {
            threads.spawn(|| {
                next.take();
                assert!(free.load(Ordering::SeqCst), "both have it");
                next.release();
            });
            std::thread::sleep(Duration::from_millis(50));
            free.store(true, Ordering::SeqCst);
            holder.release();
        });
    }

    #[test]
    fn one_at_a_time_has_the_turn() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        let (mut first, mut second) = (Turn::at(&path), Turn::at(&path));
        first.take();
        first.take();
        takes_it_after(&mut second, &mut first);
        assert_eq!(first.held, Held::Not);
        first.take();
        assert_eq!(first.held, Held::Alone, "it has been given back");
    }

    #[test]
    fn scenes_are_uploaded_together_but_not_beside_measured_frames() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        let (mut first, mut second, mut measures) = (Turn::at(&path), Turn::at(&path), Turn::at(&path));
        first.share();
        // Would wait for ever if one excluded the other.
        second.share();
        first.release();
        takes_it_after(&mut measures, &mut second);
    }

    #[test]
    fn a_pause_begins_when_the_last_one_gives_it_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        let (mut first, mut second) = (Turn::at(&path), Turn::at(&path));
        first.take();
        assert_eq!(first.pause(), Duration::MAX, "nobody has used it");
        first.release();
        std::thread::sleep(Duration::from_millis(300));
        second.take();
        second.release();
        first.take();
        assert!(first.pause() < Duration::from_millis(250), "{:?}", first.pause());
        first.release();
        std::thread::sleep(Duration::from_millis(300));
        // Who uploads leaves the device idle.
        second.share();
        second.release();
        first.take();
        assert!(first.pause() >= Duration::from_millis(300), "{:?}", first.pause());
    }

    #[test]
    fn without_a_file_nobody_waits() {
        let mut turn = Turn::at(Path::new("/no/such/folder/lock"));
        turn.take();
        turn.release();
        assert_eq!(turn.held, Held::Not);
    }
}
