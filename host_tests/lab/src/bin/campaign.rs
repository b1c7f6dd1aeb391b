//! `cargo campaign`: see `cargo campaign --help`.

use anyhow::{Context, ensure};
use clap::Parser;
use judge::campaign::{self, Plan, contract, run};
use judge::preload::{Campaign, page};
use lab::bar::Bar;
use std::io::Write;

/// The pages that `--write` writes.
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/campaign.md");
const PAGE_OF_SETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/campaign_sets.md");

const PAGE_OF_PRELOADS: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../docs/campaign_preload.md"
);

/// Time of a run by ticks, s.
const SECONDS: u64 = 600;

/// Refusals of a family that the reference build looks into: a second or two each.
const SEARCHES: usize = 10;

/// Solves very many bearings of every kind and has every answer judged
#[derive(Debug, Parser)]
#[command(name = "cargo campaign")]
struct Args {
    /// Solves of each precision, over all families
    #[arg(long, default_value_t = 1_000_000)]
    cases: usize,
    /// Sets of bearings on one shaft in the place of bearings, each with a family's bearing and loads
    #[arg(long)]
    sets: bool,
    /// Measured preloads in the place of solves: this many runs of each row by load steps, a fiftieth of it by ticks, a fifth of it with
    /// each constant doubled
    #[arg(long, value_name = "RUNS", conflicts_with = "sets")]
    preload: Option<u64>,
    /// Seed of the cases
    #[arg(long, default_value_t = Plan::SEED)]
    seed: u64,
    /// Writes docs/campaign.md, docs/campaign_sets.md or docs/campaign_preload.md
    #[arg(long)]
    write: bool,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    if let Some(runs) = args.preload {
        return preloads(&args, runs);
    }
    let plan = Plan {
        seed: args.seed,
        solves: args.cases,
        of_sets: args.sets,
        families: Plan::all(args.sets).to_vec(),
        searches: SEARCHES,
        followed: 20,
    };
    // They are counted; a message each would tear the bar.
    std::panic::set_hook(Box::new(|_| {}));
    let bar = Bar::new("{bar:40} {pos} of {len} solves, {msg}, {eta} left")?;
    let records = run(&plan, &bar);
    bar.finish();
    let _ = std::panic::take_hook();

    let page = campaign::page::page(&plan, &records);
    if args.write {
        let first = format!(
            "<!-- Made from commit {} by `cargo campaign{} --cases {} --seed {} --write`. -->\n\n",
            cli::commit(),
            if args.sets { " --sets" } else { "" },
            args.cases,
            args.seed,
        );
        let path = if args.sets { PAGE_OF_SETS } else { PAGE };
        std::fs::write(path, first + &page).with_context(|| format!("cannot write {path}"))?;
    }
    // A reader that has seen enough is no failure.
    let _ = writeln!(std::io::stdout(), "{page}");
    let broken = contract::broken(&records, args.sets);
    ensure!(broken.is_empty(), "not kept:\n{}", broken.join("\n"));
    Ok(())
}

/// The campaign of measured preloads.
fn preloads(args: &Args, runs: u64) -> anyhow::Result<()> {
    let bar = Bar::new("{bar:40} {pos} of {len} runs, {eta} left")?;
    let campaign = |runs| Campaign::new(runs, args.seed);
    let blocks = campaign(runs).by_blocks(&bar).remove(0);
    let ticks = campaign(runs.div_ceil(50)).by_ticks(SECONDS, &bar);
    let doubling = page::doubling(&campaign(runs.div_ceil(5)), &bar);
    bar.finish();
    let page = page::page(&blocks, &ticks, &doubling);
    if args.write {
        let first = format!(
            "<!-- Made from commit {} by `cargo campaign --preload {runs} --seed {} --write`. -->\n\n",
            cli::commit(),
            args.seed
        );
        std::fs::write(PAGE_OF_PRELOADS, first + &page)
            .with_context(|| format!("cannot write {PAGE_OF_PRELOADS}"))?;
    }
    let _ = writeln!(std::io::stdout(), "{page}");
    Ok(())
}
