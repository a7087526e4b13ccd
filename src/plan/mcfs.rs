//! Options of the planner `mcfs` on the command line.

use anyhow::{Result, ensure};
use clap::{Args, ValueEnum};
use planner::{
    isograph::{Isolines, Selector, SpiralOptions, TreeCover},
    mcfs::McfsOptions,
};

/// With any of these, `mcfs` plans by the paper's own pipeline.
#[derive(Debug, Clone, Args)]
#[command(
    next_help_heading = "Options of --planner mcfs: with any of them it plans by the paper's own pipeline"
)]
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

impl McfsArgs {
    /// The planner's options.
    ///
    /// # Errors
    ///
    /// When they are given to another planner.
    pub fn options(&self, planner: &str) -> Result<McfsOptions> {
        let is_papers = self.refine
            || self.selector.is_some()
            || self.augment.is_some()
            || self.isolines.is_some()
            || self.mmrtc.is_some();
        ensure!(
            planner == "mcfs" || !is_papers,
            "--selector, --augment, --refine, --isolines and --mmrtc are options of --planner mcfs, not of `{planner}`"
        );
        let paper = is_papers.then(|| self.paper());
        Ok(McfsOptions { paper, ..McfsOptions::default() })
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
