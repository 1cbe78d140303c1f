//! The renderer on a thread of its own: the window is never blocked by it.

use crate::durations::Durations;
use crate::protocol::{Failure, Frames, Request, Status};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What the two threads share.
#[derive(Default)]
struct Mailbox {
    requests: Mutex<Vec<Request>>,
    status: Mutex<Option<Result<Status, Failure>>>,
    frames: Mutex<Durations>,
    quit: AtomicBool,
}

/// The thread that renders.
pub(crate) struct RendererThread {
    mailbox: Arc<Mailbox>,
    thread: Option<JoinHandle<()>>,
}

impl RendererThread {
    /// Starts it. `start` makes the renderer, on the thread; `wake` is called when there is something to collect. A frame begins `interval`
    /// after the last at the earliest: a GPU that is faster rests.
    pub(crate) fn new(
        start: impl FnOnce() -> Result<Box<dyn Frames>, Failure> + Send + 'static,
        wake: impl Fn() + Send + 'static,
        interval: Duration,
    ) -> std::io::Result<Self> {
        let mailbox = Arc::new(Mailbox::default());
        let shared = mailbox.clone();
        let thread = std::thread::Builder::new().name("renderer".into()).spawn(move || {
            if let Err(failure) = run(start, &shared, &wake, interval) {
                *lock(&shared.status) = Some(Err(failure));
                wake();
            }
        })?;
        Ok(Self { mailbox, thread: Some(thread) })
    }

    /// Hands requests over; they are followed before the next frame.
    pub(crate) fn send(&self, requests: impl IntoIterator<Item = Request>) {
        lock(&self.mailbox.requests).extend(requests);
    }

    /// What the last frame left behind, if it is new; the failure that ended the thread.
    pub(crate) fn collect(&self) -> Option<Result<Status, Failure>> {
        lock(&self.mailbox.status).take()
    }

    /// How long the frames took so far.
    pub(crate) fn frames(&self) -> Durations {
        lock(&self.mailbox.frames).clone()
    }

    /// Whether it is still there: a thread that panicked leaves no failure behind.
    pub(crate) fn is_running(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }
}

fn run(
    start: impl FnOnce() -> Result<Box<dyn Frames>, Failure>,
    mailbox: &Mailbox,
    wake: &impl Fn(),
    interval: Duration,
) -> Result<(), Failure> {
    let mut frames = start()?;
    let mut due = Instant::now();
    while !mailbox.quit.load(Ordering::Relaxed) {
        let requests = std::mem::take(&mut *lock(&mailbox.requests));
        let begun = Instant::now();
        let status = frames.next(requests)?;
        if !status.is_resting {
            lock(&mailbox.frames).add(begun.elapsed());
        }
        *lock(&mailbox.status) = Some(Ok(status));
        wake();
        due += interval;
        match due.checked_duration_since(Instant::now()) {
            Some(rest) => std::thread::sleep(rest),
            None => due = Instant::now(),
        }
    }
    Ok(())
}

impl Drop for RendererThread {
    fn drop(&mut self) {
        self.mailbox.quit.store(true, Ordering::Relaxed);
        if self.thread.take().is_some_and(|thread| thread.join().is_err()) {
            eprintln!("warning: the thread of the renderer panicked");
        }
    }
}

/// What another thread has left is whole: a value is put there at once.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its frames wait for the end of the test.
    struct Slow(std::sync::mpsc::Receiver<()>);

    impl Frames for Slow {
        fn next(&mut self, requests: Vec<Request>) -> Result<Status, Failure> {
            let _ = self.0.recv_timeout(Duration::from_secs(20));
            Ok(Status {
                message: format!("{requests:?}"),
                is_resting: requests.is_empty(),
                ..Status::default()
            })
        }
    }

    #[test]
    fn the_window_does_not_wait_for_a_frame() {
        let (end, ended) = std::sync::mpsc::channel();
        let (wake, woken) = std::sync::mpsc::channel();
        let wake = move || {
            let _ = wake.send(());
        };
        let start = || Ok(Box::new(Slow(ended)) as Box<dyn Frames>);
        let thread = RendererThread::new(start, wake, Duration::from_millis(16)).unwrap();
        let begun = Instant::now();
        // The frame is begun meanwhile, and ends below.
        for _ in 0..20 {
            thread.send([Request::Step]);
            assert!(thread.collect().is_none() && thread.is_running());
            assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
            std::thread::sleep(Duration::from_millis(10));
        }
        drop(end);
        woken.recv().unwrap();
        while thread.frames().count() == 0 {
            woken.recv().unwrap();
        }
        assert!(thread.frames().count() <= 2, "frames that rest do not count");
    }
}
