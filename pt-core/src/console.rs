//! Output and exit codes of programs.

mod usage;

use std::error::Error;
use std::io::{self, BufWriter, ErrorKind, StdoutLock, Write};
use std::process::ExitCode;

/// A writer that ignores that its reader has closed the pipe (`pt compare A B | head -1`): the work and its exit code do
/// not depend on the reader. Other errors, such as a full disk, are passed on.
#[derive(Debug)]
pub struct Console<W> {
    inner: W,
}

impl Console<BufWriter<StdoutLock<'static>>> {
    /// Standard output, buffered: call `flush` at the end.
    pub fn stdout() -> Self {
        Self::new(BufWriter::new(io::stdout().lock()))
    }
}

impl<W: Write> Console<W> {
    /// Wraps any writer.
    pub fn new(inner: W) -> Self {
        Self { inner }
    }
}

impl<W: Write> Write for Console<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.inner.write(bytes) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(bytes.len()),
            other => other,
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self.inner.flush() {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            other => other,
        }
    }
}

/// Runs a program: parses its command line, calls `run`, prints an error as one line. Exit codes: 0 done, 1 a check failed
/// (`run` says `false`), 2 wrong usage or environment.
pub fn program<A, E>(
    run: impl FnOnce(&A, &mut Console<BufWriter<StdoutLock<'static>>>) -> Result<bool, E>,
) -> ExitCode
where
    A: clap::Parser,
    E: Into<Box<dyn Error + Send + Sync>>,
{
    let args = match A::try_parse() {
        Ok(args) => args,
        Err(error) => return usage_error(&error, &A::command()),
    };
    let mut out = Console::stdout();
    let passed = match run(&args, &mut out) {
        Ok(passed) => passed,
        Err(error) => {
            // What was found before the failure is worth seeing.
            let _ = out.flush();
            print_error(&one_line(error.into().as_ref()));
            return ExitCode::from(2);
        }
    };
    match out.flush() {
        Ok(()) => ExitCode::from(u8::from(!passed)),
        Err(error) => {
            print_error(&format!("cannot write to standard output: {}", one_line(&error)));
            ExitCode::from(2)
        }
    }
}

/// The chain of causes as one line, joined with `: `.
pub fn one_line(error: &(dyn Error + 'static)) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text.push_str(&format!(": {error}"));
        cause = error.source();
    }
    without_numbers_of_errors(&join_lines(&text))
}

/// Without the numbers that the standard library puts behind the system's words: ` (os error 2)`.
fn without_numbers_of_errors(text: &str) -> String {
    const MARK: &str = " (os error ";
    let mut parts = text.split(MARK);
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| all + part.split_once(')').map_or(part, |(_, rest)| rest))
}

/// Prints `error: MESSAGE` to standard error; says nothing when that is closed.
pub fn print_error(message: &str) {
    let _ = writeln!(io::stderr(), "error: {message}");
}

/// Prints `warning: MESSAGE` to standard error; says nothing when that is closed.
pub fn print_warning(message: &str) {
    let _ = writeln!(io::stderr(), "warning: {message}");
}

/// Prints help and version as clap lays them out (exit code 0), the overview if nothing was asked for, and a usage error as one line
/// (exit code 2).
fn usage_error(error: &clap::Error, root: &clap::Command) -> ExitCode {
    use clap::error::ErrorKind;
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            let mut out = Console::stdout();
            let printed = write!(out, "{}", error.render()).and_then(|()| out.flush());
            if printed.is_ok() { ExitCode::SUCCESS } else { ExitCode::from(2) }
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = write!(io::stderr(), "{}", error.render());
            ExitCode::from(2)
        }
        _ => {
            let words: Vec<_> = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
            print_error(&usage::message(error, root, &words));
            ExitCode::from(2)
        }
    }
}

fn join_lines(text: &str) -> String {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Fails(ErrorKind);

    impl Write for Fails {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(self.0.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Err(self.0.into())
        }
    }

    #[test]
    fn a_closed_pipe_is_quiet_and_a_full_disk_is_not() {
        let mut closed = Console::new(Fails(ErrorKind::BrokenPipe));
        closed.write_all(b"text").unwrap();
        closed.flush().unwrap();
        let mut full = Console::new(Fails(ErrorKind::StorageFull));
        full.write_all(b"text").unwrap_err();
        full.flush().unwrap_err();
    }

    #[test]
    fn causes_are_joined() {
        #[derive(Debug, thiserror::Error)]
        #[error("cannot\n  start")]
        struct Outer(#[source] std::fmt::Error);
        let cause = std::fmt::Error;
        assert_eq!(one_line(&Outer(cause)), format!("cannot start: {cause}"));
        let missing = io::Error::from_raw_os_error(2);
        assert_eq!(one_line(&missing), "No such file or directory");
    }
}
