//! The table of planners. A new one is one file and one row here.

mod bc_sweep;
mod boustrophedon;
mod boustrophedon_lanes;
mod darp;
mod forest_search;
mod mcfs;
mod mcfs_rest;
mod mfc;
mod msa_mtsp;
mod mstc;
mod mstc_star;
mod stc;
mod tmstc_star;

use crate::{Instance, Plan, PlanError, PlanOptions};
pub(crate) use boustrophedon::completed;

/// One row of the table.
#[derive(Debug, Clone, Copy)]
pub struct Planner {
    /// Name in options, scenarios and `--help`.
    pub name: &'static str,
    /// Where it comes from.
    pub paper: &'static str,
    /// Whether its work grows much faster than the floor: benchmarks leave it out on large ones.
    pub is_slow: bool,
    /// Plans; the result is not yet verified.
    pub plan: fn(&Instance<'_>, &PlanOptions) -> Result<Plan, PlanError>,
}

impl Planner {
    /// Whether its lines leave the lattice, so that bounds in moves from cell to cell do not hold for it.
    pub fn leaves_lattice(&self) -> bool {
        !keeps_to_lattice(self.name)
    }
}

/// Every planner, in the order of the README's table.
pub const PLANNERS: &[Planner] = &[
    Planner { name: "forest-search", paper: "ours", is_slow: false, plan: forest_search::plan },
    Planner {
        name: "tmstc-star",
        paper: "Lu, Zeng, Tang, Lam and Wen 2023",
        is_slow: false,
        plan: tmstc_star::plan,
    },
    Planner { name: "mcfs", paper: "Tang and Ma 2024; ours", is_slow: true, plan: mcfs::plan },
    Planner { name: "mfc", paper: "Zheng, Jain, Koenig and Kempe 2005", is_slow: false, plan: mfc::plan },
    Planner { name: "mstc-star", paper: "Tang, Sun and Zhang 2021", is_slow: false, plan: mstc_star::plan },
    Planner { name: "mstc", paper: "Hazon and Kaminka 2005", is_slow: false, plan: mstc::plan },
    Planner {
        name: "mstc-optimized",
        paper: "Zheng, Jain, Koenig and Kempe 2005",
        is_slow: false,
        plan: mstc::plan_optimized,
    },
    Planner {
        name: "boustrophedon",
        paper: "Huang 2001; the paper on boustrophedon coverage with finite resources",
        is_slow: true,
        plan: boustrophedon::plan,
    },
    Planner {
        name: "bc-sweep-hybrid",
        paper: "Strimel and Veloso 2014",
        is_slow: true,
        plan: bc_sweep::plan_hybrid,
    },
    Planner {
        name: "bc-sweep-horizontal",
        paper: "Strimel and Veloso 2014",
        is_slow: true,
        plan: bc_sweep::plan_horizontal,
    },
    Planner {
        name: "bc-sweep-vertical",
        paper: "Strimel and Veloso 2014",
        is_slow: true,
        plan: bc_sweep::plan_vertical,
    },
    Planner {
        name: "boustrophedon-lanes",
        paper: "ours, after Choset 2000",
        is_slow: true,
        plan: boustrophedon_lanes::plan,
    },
    Planner { name: "darp", paper: "Kapoutsis and others 2017", is_slow: true, plan: darp::plan },
    Planner {
        name: "msa-mtsp",
        paper: "Vandermeulen, Groß and Kolling 2019",
        is_slow: true,
        plan: msa_mtsp::plan,
    },
    Planner { name: "stc", paper: "Gabriely and Rimon 2001", is_slow: false, plan: stc::plan },
];

/// The row with this name.
pub fn by_name(name: &str) -> Option<&'static Planner> {
    PLANNERS.iter().find(|planner| planner.name == name)
}

/// All names, for messages.
pub fn names() -> String {
    PLANNERS.iter().map(|planner| planner.name).collect::<Vec<_>>().join(", ")
}

/// Planners whose routes go from cell centre to cell centre and pass each cell to visit. All others may lead anywhere,
/// and sweep as much as is asked of them: they are planned for with room for a body that does not keep to its line
/// exactly.
const ON_LATTICE: &[&str] =
    &["forest-search", "tmstc-star", "mfc", "mstc-star", "mstc", "mstc-optimized", "darp", "msa-mtsp", "stc"];

/// Whether the planner with this name keeps to the lattice.
pub fn keeps_to_lattice(name: &str) -> bool {
    ON_LATTICE.contains(&name)
}
