//! Arguments of `pt study`.

use clap::{Args, Subcommand};
use pt_study::cell::{Filter, Shard};
use std::path::PathBuf;

/// `pt study`
#[derive(Clone, Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true, after_help = HELP)]
pub struct StudyArgs {
    /// Join shards, or write a report.
    #[command(subcommand)]
    pub command: Option<StudyCommand>,
    /// Study file (TOML).
    #[arg(value_name = "STUDY.toml", required = true)]
    pub file: Option<PathBuf>,
    /// Result folder; created if missing.
    #[arg(short, long, value_name = "DIR", required_unless_present = "dry_run")]
    pub output: Option<PathBuf>,
    /// List the cells, the estimated time and memory, and run nothing.
    #[arg(long)]
    pub dry_run: bool,
    /// Run the cells of one value: K is scene, camera, size, backend, seed, variant or an axis; may be repeated. Values of one K add up, several K
    /// restrict each other.
    #[arg(long, value_name = "K=V")]
    pub filter: Vec<Filter>,
    /// Go on with the results in DIR; cells that are finished are not run again.
    #[arg(long)]
    pub resume: bool,
    /// Run the I-th of N parts of the cells, I from 1; `pt study merge` joins the parts.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Folder of references that several studies share [default: DIR/references]
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Vulkan device, by index or part of its name [default: a discrete GPU before the CPU]
    #[arg(long, value_name = "D")]
    pub device: Option<String>,
    /// Run with the Vulkan validation layers; any message is an error.
    #[arg(long)]
    pub validation: bool,
    /// Run a study of a million cells or more.
    #[arg(long)]
    pub yes: bool,
}

/// What else can be done with studies.
#[derive(Clone, Debug, Subcommand)]
pub enum StudyCommand {
    /// Join the result folders of all shards of a study.
    Merge(MergeArgs),
    /// Print the summary of a result folder, and write its report again.
    Report(ReportArgs),
}

/// `pt study report`
#[derive(Clone, Debug, Args)]
pub struct ReportArgs {
    /// Result folder of a finished study.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Also write the summary as Markdown, for a page of findings.
    #[arg(long, value_name = "FILE.md")]
    pub markdown: Option<PathBuf>,
    /// Also draw the error of the first metric over GPU time, and over frames where there are many.
    #[arg(long, value_name = "FILE.svg")]
    pub figure: Option<PathBuf>,
}

/// `pt study merge`
#[derive(Clone, Debug, Args)]
pub struct MergeArgs {
    /// Result folders of the shards.
    #[arg(value_name = "DIR", required = true)]
    pub shards: Vec<PathBuf>,
    /// Result folder of the whole; created.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

const HELP: &str = "\
A study compares variants of the frame with the ground truth; pt-study/README.md (the page \"Studies\" of the book) describes the file.

Examples:
  pt study studies/frame.toml -o out/frame
  pt study studies/denoiser.toml --dry-run
  pt study studies/denoiser.toml -o out/denoiser --filter scene=cornell --resume
  pt study studies/denoiser.toml -o out/part1 --shard 1/4      one of four machines
  pt study report out/denoiser                                 once more, for instance after a new version
  pt study merge out/part1 out/part2 out/part3 out/part4 -o out/denoiser

Ctrl-C (SIGINT) ends the study after the cell in work; --resume goes on. Exit codes: 0 done, 2 wrong usage or environment.";
