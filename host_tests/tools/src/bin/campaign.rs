//! `cargo campaign`: see `cargo campaign --help`.

use anyhow::{Context, bail};
use clap::Parser;
use host_tests::campaign::families::{Family, Trial};
use host_tests::campaign::{self, Plan, detail, report};
use std::fs::File;
use std::path::PathBuf;
use tools::arguments::family;
use tools::bar::Bar;

/// The page that `--write` writes.
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/campaign.md");

/// Solves very many bearings of every kind and has every answer judged
#[derive(Debug, Parser)]
#[command(name = "cargo campaign")]
struct Args {
    /// Solves of each precision, over all families
    #[arg(long, default_value_t = Plan::SOLVES)]
    cases: usize,
    /// Seed of the cases
    #[arg(long, default_value_t = Plan::SEED)]
    seed: u64,
    /// Only this family, with its share of the solves; may be given several times
    #[arg(long, value_parser = family())]
    family: Vec<Family>,
    /// Prints one case in full instead; needs one family
    #[arg(long, value_name = "INDEX")]
    case: Option<usize>,
    /// Refusals of a family that the reference build looks into by itself: a second or two each
    #[arg(long, value_name = "N", default_value_t = Plan::SEARCHES)]
    searches: usize,
    /// Has the reference build look into every refusal
    #[arg(long, conflicts_with = "searches")]
    judge_all: bool,
    /// Every so many-th case is followed from rest to its speed, to tell which equilibrium its answer is
    #[arg(long, value_name = "N", default_value_t = Plan::FOLLOWED, value_parser = followed)]
    followed: usize,
    /// Writes docs/campaign.md
    #[arg(long)]
    write: bool,
    /// Writes a row for every solve that is worth a look
    #[arg(long, value_name = "FILE.csv")]
    list_failures: Option<PathBuf>,
}

/// Which cases are followed.
fn followed(text: &str) -> Result<usize, String> {
    text.parse::<std::num::NonZeroUsize>()
        .map(usize::from)
        .map_err(|e| e.to_string())
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    if let Some(index) = args.case {
        let [family] = args.family[..] else {
            bail!("--case needs one --family");
        };
        print!("{}", detail::in_full(&Trial::new(args.seed, family, index)));
        return Ok(());
    }
    if args.write && !args.family.is_empty() {
        bail!("the page is about all families");
    }
    let plan = Plan {
        seed: args.seed,
        solves: args.cases,
        families: if args.family.is_empty() {
            Family::ALL.to_vec()
        } else {
            args.family.clone()
        },
        searches: (!args.judge_all).then_some(args.searches),
        followed: args.followed,
    };
    // They are counted; a message each would tear the bar.
    std::panic::set_hook(Box::new(|_| {}));
    let bar = Bar::new("{bar:40} {pos} of {len} solves, {msg}, {eta} left")?;
    let records = campaign::run(&plan, &bar);
    bar.finish();
    let _ = std::panic::take_hook();

    let page = report::page(&plan, &records);
    if args.write {
        let searches = plan
            .searches
            .map_or("--judge-all".to_owned(), |n| format!("--searches {n}"));
        let first = format!(
            "<!-- Made by `cargo campaign --cases {} --seed {} {searches} --followed {} --write`. -->\n\n",
            args.cases, args.seed, args.followed
        );
        std::fs::write(PAGE, first + &page).with_context(|| format!("cannot write {PAGE}"))?;
    }
    println!("{page}\n{}", report::worst(&records));
    if let Some(path) = &args.list_failures {
        let file =
            File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
        report::list_failures(&records, file)?;
    }
    Ok(())
}
