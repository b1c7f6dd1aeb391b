//! A recording as the records that the board receives.

use anyhow::{Result, bail};
use host_tests::loads;
use spindle_bearing::record::LoadRecord;

/// Reads the records of the first `seconds` of a recording, all of them if that is `None`.
pub fn read(path: &str, seconds: Option<f64>) -> Result<Vec<LoadRecord>> {
    let mut records = Vec::new();
    let mut start = None;
    for row in loads::read(path)? {
        let row = row?;
        let start = *start.get_or_insert(row.time_s);
        if seconds.is_some_and(|limit| row.time_s - start >= limit) {
            break;
        }
        let time_ms = (row.time_s * 1e3).round();
        if !(0.0..=f64::from(u32::MAX)).contains(&time_ms) {
            bail!(
                "{path}: time_s is {}, but must lie between 0 and 4294967",
                row.time_s
            );
        }
        let [fx, fy, fz, my, mz] = row.load.map(|x| x as f32);
        records.push(LoadRecord {
            sequence: u32::try_from(records.len())?,
            time_ms: time_ms as u32,
            fx,
            fy,
            fz,
            my,
            mz,
            speed_rpm: row.speed_rpm as f32,
        });
    }
    if records.is_empty() {
        bail!("{path} holds no records");
    }
    Ok(records)
}
