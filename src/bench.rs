//! `oxplow bench`: the planners on the instances of the papers, side by side with the printed figures.

mod people;

use crate::say::say;
use anyhow::{Context as _, Result, bail};
use benchmark::{BENCHMARKS, Benchmark, Options, Table};
use clap::{Args, builder::PossibleValuesParser};
use indicatif::{ProgressBar, ProgressStyle};
use std::{
    io::Write as _,
    path::{Path, PathBuf},
    process::ExitCode,
    time::Duration,
};

/// Runs a benchmark and prints its tables
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  oxplow bench tmstc --quick              does it work at all?
  oxplow bench grid --out target/bench    tables as CSV and Markdown files
  oxplow bench tmstc --docs docs/benchmarks.md   writes the section of this page anew

The instances are no part of this repository: --instances names the folder that holds tmstc/, grid/, …")]
pub struct BenchArgs {
    /// Which one
    #[arg(value_name = "NAME", value_parser = PossibleValuesParser::new(names()))]
    name: String,
    /// Folder of the instances
    #[arg(long, value_name = "DIR", default_value = "../shared/instances")]
    instances: PathBuf,
    /// A few small instances only
    #[arg(long)]
    quick: bool,
    /// Effort of planners that improve their answer
    #[arg(long, value_name = "N", default_value_t = 1)]
    effort: u32,
    /// Write each table as .csv and .md into this folder, and pictures where there are some
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Put the tables between the marks of this benchmark in this Markdown file, and pictures into `bench/` beside it
    #[arg(long, value_name = "FILE.md")]
    docs: Option<PathBuf>,
}

/// Those of planners alone, and those that need the fleet.
fn benchmarks() -> impl Iterator<Item = &'static Benchmark> {
    BENCHMARKS.iter().chain([&people::PEOPLE])
}

fn names() -> impl Iterator<Item = &'static str> {
    benchmarks().map(|benchmark| benchmark.name)
}

/// Runs the command.
///
/// # Errors
///
/// When instances cannot be read or results cannot be written.
pub fn run(args: &BenchArgs) -> Result<ExitCode> {
    let benchmark = benchmarks().find(|benchmark| benchmark.name == args.name);
    let benchmark = benchmark.expect("clap takes names of the table only");
    let options = Options { instances: args.instances.clone(), quick: args.quick, effort: args.effort };
    let bar = ProgressBar::new_spinner()
        .with_style(ProgressStyle::with_template("{spinner} {wide_msg} {elapsed}")?);
    bar.enable_steady_tick(Duration::from_millis(200));
    let tables = (benchmark.run)(&options, &mut |what: &str| show(&bar, what));
    bar.finish_and_clear();
    let tables = tables?;
    for table in &tables {
        say!("{}", table.markdown());
    }
    if let Some(folder) = &args.out {
        write_files(folder, &tables)?;
    }
    if let Some(path) = &args.docs {
        write_section(path, benchmark, args, &tables)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Shows what is being measured: in place on a terminal, else as a line with the seconds since the start.
fn show(bar: &ProgressBar, what: &str) {
    if bar.is_hidden() {
        // Nobody has to read this: a closed pipe ends nothing.
        let _ = writeln!(std::io::stderr(), "{:6.0} s  {what}", bar.elapsed().as_secs_f64());
    } else {
        bar.set_message(what.to_owned());
    }
}

fn write_files(folder: &Path, tables: &[Table]) -> Result<()> {
    let cannot = || format!("{}: cannot be written", folder.display());
    std::fs::create_dir_all(folder).with_context(cannot)?;
    for table in tables {
        std::fs::write(folder.join(format!("{}.csv", table.name)), table.csv()).with_context(cannot)?;
        let markdown = table.markdown_with_pictures("");
        std::fs::write(folder.join(format!("{}.md", table.name)), markdown).with_context(cannot)?;
    }
    write_pictures(folder, tables)
}

/// Writes the pictures of tables into a folder, if there are some.
fn write_pictures(folder: &Path, tables: &[Table]) -> Result<()> {
    let cannot = || format!("{}: cannot be written", folder.display());
    for picture in tables.iter().flat_map(|table| &table.pictures) {
        std::fs::create_dir_all(folder).with_context(cannot)?;
        std::fs::write(folder.join(picture.file_name()), &picture.svg).with_context(cannot)?;
    }
    Ok(())
}

/// Replaces what stands between `<!-- bench NAME -->` and `<!-- end NAME -->`; pictures go to `bench/` beside the page.
fn write_section(path: &Path, benchmark: &Benchmark, args: &BenchArgs, tables: &[Table]) -> Result<()> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("{}: cannot be read", path.display()))?;
    let name = benchmark.name;
    let (begin, end) = (format!("<!-- bench {name} -->"), format!("<!-- end {name} -->"));
    let (Some(from), Some(to)) = (text.find(&begin), text.find(&end)) else {
        bail!("{}: the marks `{begin}` and `{end}` are not there", path.display());
    };
    let quick = if args.quick { " --quick" } else { "" };
    let body: Vec<String> = tables.iter().map(|table| table.markdown_with_pictures("bench")).collect();
    let head = format!("```sh\noxplow bench {name}{quick}\n```\n");
    let section = format!("{begin}\n## {name}: {}\n\n{head}\n{}\n", benchmark.about, body.join("\n"));
    write_pictures(&path.with_file_name("bench"), tables)?;
    let whole = format!("{}{section}{}", &text[..from], &text[to..]);
    std::fs::write(path, whole).with_context(|| format!("{}: cannot be written", path.display()))
}
