//! Tables 1 and 2 of the MCFS paper by its own pipeline: selectors, variants, and grid planners on overlay grids.

use super::{
    authors::Authors,
    evaluator::{PathFigures, evaluate},
    overlay_grid::{self, BASELINES},
    polygon_instances::{NAMES, load_with_nominal_starts},
};
use crate::{
    BenchmarkError, Options, Progress, Table, content,
    cpu::timed,
    tables::{mean, ratio},
};
use planner::{
    isograph::{Selector, SpiralOptions, Spirals, TreeCover, plan_spirals},
    mcfs::PolygonInstance,
};

const SELECTORS: [(Selector, &str); 4] = [
    (Selector::Random, "random"),
    (Selector::Cfs, "CFS"),
    (Selector::Mcs, "MCS"),
    (Selector::McsAsPrinted, "arg max of eq. 3"),
];
/// The random selector is run with so many seeds.
const SEEDS: u64 = 5;
/// δ of the paper: the robots, 4 at most.
const HOPS_MAX: u32 = 4;

/// A variant of table 2: its name, whether the isograph is augmented, whether the solution is refined.
const VARIANTS: [(&str, bool, bool); 4] =
    [("NONE", false, false), ("REF", false, true), ("AUG", true, false), ("BOTH", true, true)];

/// All tables.
pub(crate) fn tables(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let authors = Authors::load(&options.instances)?;
    let names = if options.quick { &NAMES[..1] } else { &NAMES[..] };
    let [table_2, makespans] = table_2(options, &authors, names, progress)?;
    Ok(vec![table_1(options, &authors, names, progress)?, makespans, table_2])
}

fn planned(
    name: &str,
    instance: &PolygonInstance,
    options: &SpiralOptions,
) -> Result<(Spirals, f64), BenchmarkError> {
    let (spirals, cpu_s) = timed(|| plan_spirals(instance, options));
    spirals.map(|spirals| (spirals, cpu_s)).map_err(|error| content(name.as_ref(), error.to_string()))
}

fn table_1(
    options: &Options,
    authors: &Authors,
    names: &[&str],
    progress: Progress<'_>,
) -> Result<Table, BenchmarkError> {
    let mut table = Table::new(
        "mcfs_table_1",
        "Table 1: turning of one robot's path by selector",
        &format!(
            "Isolines by marching squares, one robot. Turning: all turns ÷ length, rad/m (`random`: mean of {SEEDS} \
             seeds). The paper's figures are mean curvatures by its own program, clipped at reversals, and in another \
             unit: compare the ratios. Equation 3 says arg max, the text minimises; the arg max turns more than random."
        ),
        &["instance", "selector", "turning rad/m", "÷ random", "paper's curvature", "paper's ÷ random"],
    );
    for &name in names {
        let mut instance = load_with_nominal_starts(&options.instances, name)?;
        instance.starts.truncate(1);
        let mut random = f64::NAN;
        for (selector, label) in SELECTORS {
            progress(&format!("Table 1: {name} {label}"));
            let seeds = if selector == Selector::Random { SEEDS } else { 1 };
            let turning = (0..seeds).map(|seed| turning(name, &instance, selector, seed));
            let turning = mean(&turning.collect::<Result<Vec<_>, _>>()?);
            if selector == Selector::Random {
                random = turning;
            }
            let printed =
                |label: &str| authors.printed("Table 1", name, &format!("CFS-selector-{label}"), "curvature");
            table.push(vec![
                name.to_owned(),
                label.to_owned(),
                ratio(turning),
                ratio(turning / random),
                printed(label).map(|value| format!("({value:.3})")).unwrap_or_default(),
                printed(label)
                    .zip(printed("random"))
                    .map(|(a, b)| format!("({:.3})", a / b))
                    .unwrap_or_default(),
            ]);
        }
    }
    Ok(table)
}

fn turning(
    name: &str,
    instance: &PolygonInstance,
    selector: Selector,
    seed: u64,
) -> Result<f64, BenchmarkError> {
    let options = SpiralOptions { selector, seed, hops_max: 1, refine: false, ..SpiralOptions::default() };
    let (spirals, _) = planned(name, instance, &options)?;
    Ok(evaluate(&instance.ground, instance.tool_width_m, &spirals.paths).turning_rad_per_m)
}

fn table_2(
    options: &Options,
    authors: &Authors,
    names: &[&str],
    progress: Progress<'_>,
) -> Result<[Table; 2], BenchmarkError> {
    let mut rows = Table::new(
        "mcfs_table_2",
        "Table 2: the paper's variants, and grid planners on its overlay grids",
        "Exact figures by the polygon evaluator (`benchmark/src/mcfs/evaluator.rs`); in brackets the same of the authors' \
         program where it was run. Closed paths; as in the paper a path may begin anywhere on its robot's lines, the \
         column *with drives* adds the way from the nominal start (there and back). TMSTC* and TMC: our `tmstc-star` and \
         `msa-mtsp` on `<name>.stc.map` and `<name>.map`, grids that match the polygons to 79–86 % only; they return to \
         their starts. Bound: makespan below which no cover by whole isolines comes; proven optimal where the five \
         letters say so. CPU: user seconds here, the paper's on an M2 laptop in brackets.",
        &[
            "instance",
            "variant",
            "makespan m",
            "with drives",
            "coverage %",
            "overlap %",
            "turning rad/m",
            "η",
            "outside %",
            "CPU s",
            "tree cover",
            "bound",
        ],
    );
    let columns =
        ["instance", "NONE", "AUG", "REF", "BOTH", "BOTH ÷ NONE", "BOTH ÷ paper's", "coverage − theirs"];
    let mut makespans = Table::new(
        "mcfs_table_2_makespans",
        "Table 2 in short: makespans of the variants, metres",
        "The paper's in brackets. Last column: exact coverage of BOTH less that of the authors' stored paths, points.",
        &columns,
    );
    for &name in names {
        let instance = load_with_nominal_starts(&options.instances, name)?;
        let mut made = Vec::new();
        for (variant, augment, refine) in VARIANTS {
            progress(&format!("Table 2: {name} {variant}"));
            let hops_max = if augment { HOPS_MAX.min(instance.starts.len() as u32) } else { 1 };
            let tree_cover = TreeCover::Exact;
            let chosen = SpiralOptions { hops_max, refine, tree_cover, ..SpiralOptions::default() };
            let (spirals, cpu_s) = planned(name, &instance, &chosen)?;
            let figures = evaluate(&instance.ground, instance.tool_width_m, &spirals.paths);
            let trips = spirals.round_trips();
            let with_drives_m = trips.iter().map(|trip| length_m(trip)).fold(0.0, f64::max);
            let method = format!("MCFS-{variant}");
            let mut row = vec![name.to_owned(), variant.to_owned()];
            row.extend(exact_cells(authors, name, &method, &figures, &format!("{with_drives_m:.2}")));
            row.push(cpu_cell(authors, name, &method, cpu_s));
            row.extend([format!("{:.2}", spirals.trees_m), format!("{:.2}", spirals.trees_bound_m)]);
            rows.push(row);
            made.push(figures);
        }
        makespans.push(makespan_row(authors, name, &made));
        for baseline in BASELINES {
            progress(&format!("Table 2: {name} {}", baseline.planner));
            let (paths, cpu_s) = overlay_grid::paths(&options.instances, name, baseline)?;
            let figures = evaluate(&instance.ground, instance.tool_width_m, &paths);
            let mut row = vec![name.to_owned(), baseline.planner.to_owned()];
            row.extend(exact_cells(authors, name, baseline.method, &figures, ""));
            row.push(cpu_cell(authors, name, baseline.method, cpu_s));
            row.extend([String::new(), String::new()]);
            rows.push(row);
        }
    }
    Ok([rows, makespans])
}

fn length_m(path: &[terrain::Point]) -> f64 {
    path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

fn exact_cells(
    authors: &Authors,
    name: &str,
    method: &str,
    figures: &PathFigures,
    with_drives: &str,
) -> Vec<String> {
    let theirs = authors.measured(name, method);
    let beside = |own: String, theirs: Option<String>| match theirs {
        Some(theirs) => format!("{own} ({theirs})"),
        None => own,
    };
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let makespan = theirs.map(|row| row.makespan_closed);
    let makespan = makespan.or_else(|| authors.printed("Table 2", name, method, "makespan"));
    vec![
        beside(format!("{:.2}", figures.makespan_m), makespan.map(|value| format!("{value:.2}"))),
        with_drives.to_owned(),
        beside(percent(figures.coverage), theirs.map(|row| percent(row.coverage_exact))),
        beside(percent(figures.overlap), theirs.map(|row| percent(row.overlap_two_robots_exact))),
        beside(
            format!("{:.2}", figures.turning_rad_per_m),
            theirs.map(|row| format!("{:.2}", row.turning_per_length)),
        ),
        beside(ratio(figures.efficiency), theirs.map(|row| ratio(row.efficiency))),
        format!("{:.2}", 100.0 * figures.swept_outside),
    ]
}

fn cpu_cell(authors: &Authors, name: &str, method: &str, cpu_s: f64) -> String {
    let theirs = authors.printed("Table 2", name, method, "runtime");
    let theirs = theirs.map(|value| format!(" ({value})")).unwrap_or_default();
    format!("{cpu_s:.2}{theirs}")
}

fn makespan_row(authors: &Authors, name: &str, made: &[PathFigures]) -> Vec<String> {
    let [none, refined, augmented, both] = made else { unreachable!("four variants are run") };
    let cell = |variant: &str, figures: &PathFigures| {
        let printed = authors.printed("Table 2", name, &format!("MCFS-{variant}"), "makespan");
        format!(
            "{:.2}{}",
            figures.makespan_m,
            printed.map(|value| format!(" ({value:.2})")).unwrap_or_default()
        )
    };
    let printed = authors.printed("Table 2", name, "MCFS-BOTH", "makespan");
    let stored = authors.measured(name, "MCFS-BOTH");
    vec![
        name.to_owned(),
        cell("NONE", none),
        cell("AUG", augmented),
        cell("REF", refined),
        cell("BOTH", both),
        ratio(both.makespan_m / none.makespan_m),
        printed.map(|value| ratio(both.makespan_m / value)).unwrap_or_default(),
        stored.map(|row| format!("{:+.1}", 100.0 * (both.coverage - row.coverage_exact))).unwrap_or_default(),
    ]
}
