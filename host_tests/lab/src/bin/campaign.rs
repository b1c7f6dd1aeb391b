//! `cargo campaign`: see `cargo campaign --help`.

use anyhow::{Context, ensure};
use clap::Parser;
use clap::builder::TypedValueParser;
use cli::arguments::by_name;
use judge::campaign::families::Family;
use judge::campaign::{Plan, contract, in_full, page, run};
use judge::preload::{self, Campaign, constants};
use lab::bar::Bar;
use std::io::Write;
use std::path::PathBuf;

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

/// A family of the campaign's cases.
fn family() -> impl TypedValueParser<Value = Family> {
    by_name(Family::ALL.map(|family| (family.name(), "", family)))
}

/// A part of the campaign of measured preloads.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    Blocks,
    Ticks,
    Doubling,
}

impl Part {
    const ALL: [Self; 3] = [Self::Blocks, Self::Ticks, Self::Doubling];

    const fn name(self) -> &'static str {
        match self {
            Self::Blocks => "blocks",
            Self::Ticks => "ticks",
            Self::Doubling => "doubling",
        }
    }
}

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
    /// Only this part of `--preload`, with all of its runs
    #[arg(long, requires = "preload", conflicts_with = "write", value_parser = by_name(Part::ALL.map(|part| (part.name(), "", part))))]
    part: Option<Part>,
    /// Only the rows of `--preload` whose spindle and name contain this
    #[arg(
        long,
        value_name = "TEXT",
        default_value = "",
        requires = "preload",
        conflicts_with = "write"
    )]
    rows: String,
    /// Another constant of the estimator, but by ticks; may be given several times
    #[arg(
        long,
        value_name = "NAME=NUMBER",
        requires = "preload",
        conflicts_with = "write"
    )]
    set: Vec<String>,
    /// Seed of the cases
    #[arg(long, default_value_t = Plan::SEED)]
    seed: u64,
    /// Only this family, with its share of the solves; may be given several times
    #[arg(long, value_parser = family())]
    family: Vec<Family>,
    /// Prints one case in full instead; needs one family
    #[arg(long, value_name = "INDEX")]
    case: Option<usize>,
    /// Has the reference build look into every refusal, a second or two each.
    #[arg(long)]
    judge_all: bool,
    /// Writes docs/campaign.md, docs/campaign_sets.md or docs/campaign_preload.md
    #[arg(long, conflicts_with = "family")]
    write: bool,
    /// Writes a line for every solve that is worth a look.
    #[arg(long, value_name = "FILE")]
    list_failures: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    if let Some(runs) = args.preload {
        return preloads(&args, runs);
    }
    let all = Plan::all(args.sets);
    let is_drawn = args.family.iter().all(|family| all.contains(family));
    ensure!(is_drawn, "no sets are drawn of this family");
    let plan = Plan {
        seed: args.seed,
        solves: args.cases,
        of_sets: args.sets,
        families: if args.family.is_empty() {
            all.to_vec()
        } else {
            args.family
        },
        searches: (!args.judge_all).then_some(SEARCHES),
        followed: 20,
    };
    if let Some(index) = args.case {
        ensure!(plan.families.len() == 1, "--case needs one --family");
        print!("{}", in_full(&plan.trial(plan.families[0], index)));
        return Ok(());
    }
    // They are counted; a message each would tear the bar.
    std::panic::set_hook(Box::new(|_| {}));
    let bar = Bar::new("{bar:40} {pos} of {len} solves, {msg}, {eta} left")?;
    let records = run(&plan, &bar);
    bar.finish();
    let _ = std::panic::take_hook();

    let page = page::page(&plan, &records);
    if args.write {
        let first = format!(
            "<!-- Made from commit {} by `cargo campaign{} --cases {} --seed {}{} --write`. -->\n\n",
            cli::commit(),
            if args.sets { " --sets" } else { "" },
            args.cases,
            args.seed,
            if args.judge_all { " --judge-all" } else { "" },
        );
        let path = if args.sets { PAGE_OF_SETS } else { PAGE };
        std::fs::write(path, first + &page).with_context(|| format!("cannot write {path}"))?;
    }
    // A reader that has seen enough is no failure.
    let _ = writeln!(std::io::stdout(), "{page}");
    if let Some(path) = &args.list_failures {
        std::fs::write(path, page::failures(&records))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    // A promise is about all families.
    if plan.families == all {
        let broken = contract::broken(&records, args.sets);
        ensure!(broken.is_empty(), "not kept:\n{}", broken.join("\n"));
    }
    Ok(())
}

/// The campaign of measured preloads.
fn preloads(args: &Args, runs: u64) -> anyhow::Result<()> {
    let bar = Bar::new("{bar:40} {pos} of {len} runs, {eta} left")?;
    let campaign = |part: Part, runs: u64| -> anyhow::Result<Option<Campaign>> {
        let constants = constants::with(&args.set).map_err(anyhow::Error::msg)?;
        let campaign = Campaign {
            runs,
            seed: args.seed,
            rows: preload::rows(&args.rows),
            constants: vec![constants],
        };
        Ok(args
            .part
            .is_none_or(|only| only == part)
            .then_some(campaign))
    };
    let share = |part: u64| {
        if args.part.is_some() {
            runs
        } else {
            runs.div_ceil(part)
        }
    };
    let blocks = campaign(Part::Blocks, runs)?.map(|campaign| campaign.by_blocks(&bar).remove(0));
    let ticks = campaign(Part::Ticks, share(50))?.map(|campaign| campaign.by_ticks(SECONDS, &bar));
    let doubling = campaign(Part::Doubling, share(5))?
        .map(|campaign| preload::page::doubling(&campaign, &bar));
    bar.finish();
    let page = preload::page::page(blocks.as_deref(), ticks.as_deref(), doubling.as_deref());
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
