//! The `pt` program. Exit codes: 0 done, 1 a check failed, 2 usage or environment.

use std::process::ExitCode;

use pt_app::cli::{Cli, Command};

fn main() -> ExitCode {
    pt_core::console::program(|cli: &Cli, out| match &cli.command {
        Command::Info(args) => pt_app::info::run(args, out),
        Command::Scenes(args) => pt_app::scenes::run(args, out),
        Command::Passes(args) => pt_app::passes::run(args, out),
        Command::Bench(args) => pt_app::bench::run(args, out),
        Command::Render(args) => pt_app::render::run(args, out),
        Command::Reference(args) => pt_app::reference::run(args, out),
        Command::Merge(args) => pt_app::reference::merge(args, out),
        Command::Bake(args) => pt_app::bake::run(args, out),
        Command::Compare(args) => pt_app::compare::run(args, out),
        Command::Sheet(args) => pt_app::sheet::run(args, out),
    })
}
