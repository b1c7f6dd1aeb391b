//! Writes the synthetic recording `host_tests/records/milling_cycle.csv`, or the file named by the
//! only argument.

use anyhow::{Context, bail};
use host_tests::milling_cycle::{RECORD, milling_cycle, write_csv};

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1);
    let path = args.next().unwrap_or_else(|| RECORD.to_owned());
    if path.starts_with('-') || args.next().is_some() {
        bail!("usage: make_record [FILE.csv]");
    }
    let rows = milling_cycle();
    let mut text = Vec::new();
    write_csv(&rows, &mut text)?;
    std::fs::write(&path, text).with_context(|| format!("cannot write {path}"))?;
    println!("{path}: {} rows of a synthetic milling cycle", rows.len());
    Ok(())
}
