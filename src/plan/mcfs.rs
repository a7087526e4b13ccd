//! Options of the planner `mcfs` on the command line.

use anyhow::{Result, ensure};
use clap::{Args, ValueEnum};
use planner::{
    isograph::{Isolines, Selector, SpiralOptions, TreeCover},
    mcfs::McfsOptions,
};

/// With any of the first five, `mcfs` plans by the paper's own pipeline.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Options of --planner mcfs: the paper's pipeline, when one of the first five is given")]
pub struct McfsArgs {
    /// Where isolines are stitched together
    #[arg(long, value_enum)]
    selector: Option<SelectorName>,
    /// Join isolines over up to so many layers (isograph augmentation; 1: neighbours only)
    #[arg(long, value_name = "LAYERS", value_parser = clap::value_parser!(u32).range(1..=16))]
    augment: Option<u32>,
    /// Split isolines among robots (solution refinement)
    #[arg(long)]
    refine: bool,
    /// Where isolines come from
    #[arg(long, value_enum)]
    isolines: Option<IsolinesName>,
    /// How isolines are given to robots
    #[arg(long, value_enum)]
    mmrtc: Option<TreeCoverName>,
    /// Share of the ground to be swept, of the default pipeline
    #[arg(long, value_name = "SHARE", value_parser = share)]
    coverage_target: Option<f64>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SelectorName {
    /// Any of them
    Random,
    /// Beside the stitch before: a staircase
    Cfs,
    /// Where the path turns least
    Mcs,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum IsolinesName {
    /// Offsets of the polygon, the first half a tool from the walls
    Exact,
    /// Contours of a distance field, the first a tool from the walls
    MarchingSquares,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum TreeCoverName {
    /// The optimum, for up to 16 isolines
    Mip,
    /// Local search
    Search,
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err("expected a share above 0 and up to 1".to_owned()),
    }
}

impl McfsArgs {
    /// The planner's options.
    ///
    /// # Errors
    ///
    /// When they are given to another planner, or do not go together.
    pub fn options(&self, planner: &str) -> Result<McfsOptions> {
        let is_papers = self.refine
            || self.selector.is_some()
            || self.augment.is_some()
            || self.isolines.is_some()
            || self.mmrtc.is_some();
        ensure!(
            planner == "mcfs" || !(is_papers || self.coverage_target.is_some()),
            "--selector, --augment, --refine, --isolines, --mmrtc and --coverage-target are options of --planner mcfs, \
             not of `{planner}`"
        );
        ensure!(
            !(is_papers && self.coverage_target.is_some()),
            "the paper's pipeline covers all isolines: leave out --coverage-target, or the other options of mcfs"
        );
        let paper = is_papers.then(|| self.paper());
        Ok(McfsOptions { coverage_target: self.coverage_target, paper, ..McfsOptions::default() })
    }

    fn paper(&self) -> SpiralOptions {
        SpiralOptions {
            isolines: match self.isolines {
                Some(IsolinesName::Exact) => Isolines::Exact,
                Some(IsolinesName::MarchingSquares) | None => Isolines::MarchingSquares,
            },
            selector: match self.selector {
                Some(SelectorName::Random) => Selector::Random,
                Some(SelectorName::Cfs) => Selector::Cfs,
                Some(SelectorName::Mcs) | None => Selector::Mcs,
            },
            hops_max: self.augment.unwrap_or(1),
            refine: self.refine,
            tree_cover: match self.mmrtc {
                Some(TreeCoverName::Mip) => TreeCover::Exact,
                Some(TreeCoverName::Search) | None => TreeCover::Search,
            },
            ..SpiralOptions::default()
        }
    }
}
