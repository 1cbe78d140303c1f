//! All tests of pt-view but those of its modules, in one program.

mod headless;
mod widgets;
