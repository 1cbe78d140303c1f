//! Wall-clock times of the steps of a long operation, such as loading a scene.

use serde::Serialize;
use std::time::Instant;

/// One step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Phase {
    /// Name of the step.
    pub name: &'static str,
    /// How long it took, milliseconds.
    pub ms: f64,
}

/// Splits time into [`Phase`]s.
#[derive(Clone, Debug)]
pub struct Phases {
    list: Vec<Phase>,
    since: Instant,
}

impl Default for Phases {
    fn default() -> Self {
        Self::start()
    }
}

impl Phases {
    /// The clock runs from now on.
    pub fn start() -> Self {
        Self { list: Vec::new(), since: Instant::now() }
    }

    /// What took place since the last mark (or the start) was `name`. Times of the same name add up.
    pub fn mark(&mut self, name: &'static str) {
        let ms = self.since.elapsed().as_secs_f64() * 1e3;
        match self.list.iter_mut().find(|phase| phase.name == name) {
            Some(phase) => phase.ms += ms,
            None => self.list.push(Phase { name, ms }),
        }
        self.since = Instant::now();
    }

    /// Takes over the steps of an operation that was part of this one; the clock starts anew.
    pub fn include(&mut self, phases: &[Phase]) {
        self.list.extend_from_slice(phases);
        self.since = Instant::now();
    }

    /// All of them together, milliseconds.
    pub fn total_ms(&self) -> f64 {
        self.list.iter().map(|phase| phase.ms).sum()
    }

    /// The steps, in order.
    pub fn list(&self) -> &[Phase] {
        &self.list
    }
}
