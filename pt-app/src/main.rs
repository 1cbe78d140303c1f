//! The `pt` program. Exit codes: 0 done, 1 a check failed, 2 usage or environment.

use std::process::ExitCode;

use pt_app::cli::Cli;

fn main() -> ExitCode {
    pt_core::console::program(|cli: &Cli, out| cli.run(out))
}
