//! `cargo campaign`: see `cargo campaign --help`.

use anyhow::{Context, ensure};
use clap::Parser;
use clap::builder::TypedValueParser;
use cli::arguments::by_name;
use judge::campaign::families::Family;
use judge::campaign::{Plan, contract, in_full, page, run};
use lab::bar::Bar;
use std::io::Write;
use std::path::PathBuf;

/// The pages that `--write` writes.
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/campaign.md");
const PAGE_OF_SETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/campaign_sets.md");

/// Refusals of a family that the reference build looks into: a second or two each.
const SEARCHES: usize = 10;

/// A family of the campaign's cases.
fn family() -> impl TypedValueParser<Value = Family> {
    by_name(Family::ALL.map(|family| (family.name(), "", family)))
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
    /// Writes docs/campaign.md, or docs/campaign_sets.md
    #[arg(long, conflicts_with = "family")]
    write: bool,
    /// Writes a line for every solve that is worth a look.
    #[arg(long, value_name = "FILE")]
    list_failures: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
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
