//! `docs/validation.md` and its pictures.

use anyhow::{Context, Result, bail, ensure};
use cli::chart::{self, Chart, Curve, Style};
use judge::validation::book::{Book, Measure, Panel, Picture, TEXT};
use judge::validation::cases::{Solved, solve};
use judge::validation::judge::{Line, factor, judge, lines};
use judge::validation::{PAGE, page};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// Makes the page and its pictures; writes them, or compares the page with the committed one.
pub fn run(check: bool) -> Result<()> {
    let book = Book::parse(TEXT)?;
    let (mut judged, mut pictures) = (Vec::new(), BTreeMap::new());
    for chapter in &book.chapter {
        let runs = solve(chapter)?;
        judged.push(judge(chapter, &runs)?);
        for picture in &chapter.picture {
            let svg = draw(picture, &runs).with_context(|| picture.title.clone())?;
            pictures.insert(format!("{}.svg", picture.file), svg);
        }
    }
    let claims = judged.iter().flatten();
    let complaints: Vec<String> = claims.filter_map(|claim| claim.complaint()).collect();
    ensure!(
        complaints.is_empty(),
        "claims of host_tests/judge/validation.toml are not as stated:\n{}",
        complaints.join("\n")
    );

    let made = page::page(&book, &judged, &cli::commit());
    let path = cli::root().join(PAGE);
    let folder = path.with_extension("");
    if check {
        let committed = fs::read_to_string(&path).context(PAGE)?;
        if let Some(line) = page::difference(&committed, &made) {
            bail!("{PAGE}, {line}\n`cargo reports validation` writes it");
        }
        let files = fs::read_dir(&folder)?;
        let files = files.map(|file| Ok(file?.file_name().to_string_lossy().into_owned()));
        let files = files.collect::<Result<BTreeSet<String>>>()?;
        ensure!(
            pictures.keys().eq(&files),
            "{PAGE} has the pictures {:?}, its folder {files:?}",
            pictures.keys()
        );
        println!("{PAGE}: {} lines are as made", committed.lines().count());
        return Ok(());
    }
    fs::create_dir_all(&folder)?;
    for (name, svg) in &pictures {
        fs::write(folder.join(name), svg).with_context(|| name.clone())?;
    }
    fs::write(&path, &made).context(PAGE)?;
    println!(
        "{PAGE}: {} lines, {} pictures",
        made.lines().count(),
        pictures.len()
    );
    Ok(())
}

fn draw(picture: &Picture, runs: &[Solved]) -> Result<String> {
    let panels = picture
        .panel
        .iter()
        .map(|panel| of_panel(picture, panel, runs));
    let panels: Result<_> = panels.collect();
    chart::svg(&Chart::new(&picture.title, picture.columns, panels?))
}

fn of_panel(picture: &Picture, panel: &Panel, runs: &[Solved]) -> Result<chart::Panel> {
    let curves: Result<Vec<_>> = panel
        .curve
        .iter()
        .map(|one| curves(picture, one, runs))
        .collect();
    let curves = curves?.concat();
    let mut made = chart::Panel::new(&panel.title, &picture.x_label, &panel.y_label, curves);
    made.x.logarithmic = picture.logarithmic;
    Ok(made)
}

/// A curve for each run.
fn curves(picture: &Picture, measure: &Measure, runs: &[Solved]) -> Result<Vec<Curve>> {
    let style = match measure.style.as_str() {
        "" => Style::Line,
        "dashed" => Style::Dashed,
        "dots" => Style::Dots,
        other => bail!("no style {other:?}"),
    };
    let unit = factor(&picture.x_unit)?;
    let curve = |line: Line<'_>| {
        let x = line.cases.iter().map(|case| case.get(&picture.x).copied());
        let points = x.zip(line.values).map(|(x, y)| Some((unit * x?, y)));
        let points: Option<_> = points.collect();
        let name = match measure.name.as_str() {
            "" => line.run,
            name => name,
        };
        Ok(Curve::new(name, style, points.context(picture.x.clone())?))
    };
    lines(measure, runs)?.into_iter().map(curve).collect()
}
