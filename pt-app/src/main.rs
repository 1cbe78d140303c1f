//! The `pt` program. Exit codes: 0 done, 1 a check failed, 2 usage or environment.

use std::io::Write;
use std::process::ExitCode;

use anyhow::Context;
use clap::Parser;
use pt_app::cli::{Cli, Command};
use pt_app::console::{Console, one_line, print_error, usage_error};

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage_error(&error),
    };
    let mut out = Console::stdout();
    let outcome = match &cli.command {
        Command::Info(args) => pt_app::info::run(args, &mut out),
        Command::Scenes => pt_app::scenes::run(&mut out),
        Command::Passes(args) => pt_app::passes::run(args, &mut out),
        Command::Bench(args) => pt_app::bench::run(args, &mut out),
        Command::Render(args) => pt_app::render::run(args, &mut out),
        Command::Compare(args) => pt_app::compare::run(args, &mut out),
    };
    match outcome.and_then(|passed| out.flush().context("cannot write to standard output").map(|()| passed)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            print_error(&one_line(&error));
            ExitCode::from(2)
        }
    }
}
