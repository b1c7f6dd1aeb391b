//! An estimate as a row of the table.

use spindle_monitor::telemetry::EstimateReport;

/// Names of the five freedoms, in their order.
const DIRECTIONS: [&str; 5] = ["x", "y", "z", "ty", "tz"];

/// Heads of the columns, names over units. Stiffness and coupling are those at the nose, 1 over the compliance there.
pub const HEADER: &str = "    time   speed      Kx      Ky      Kz     Kty     Ktz   coupling of     Q least Q largest  iter. age\n\
    \x20      s     rpm    N/um    N/um    N/um kNm/rad kNm/rad         SI              N         N            status, limits passed, doubts";

/// The row under them.
pub fn row(time_us: u64, report: &EstimateReport) -> String {
    let time = time_us as f64 * 1e-6;
    let rpm = f64::from(report.speed) * 30.0 / std::f64::consts::PI;
    let [kx, ky, kz, kty, ktz] = report.stiffness.map(f64::from);
    let direction = |index: u8| DIRECTIONS.get(usize::from(index)).unwrap_or(&"?");
    let pair = format!(
        "{},{}",
        direction(report.coupling_row),
        direction(report.coupling_column)
    );
    let limits: String = report.passed().map(|limit| format!(" {limit}")).collect();
    let marks: String = report
        .marks
        .iter()
        .map(|mark| format!(" {mark}?"))
        .collect();
    format!(
        "{time:8.3} {rpm:7.0} {:7.2} {:7.2} {:7.2} {:7.2} {:7.2} {:>10.3e} {pair:<6} {:7.2} {:9.2} {:>6} {:>3} {}{limits}{marks}",
        kx * 1e-6,
        ky * 1e-6,
        kz * 1e-6,
        kty * 1e-3,
        ktz * 1e-3,
        report.coupling,
        report.least_force,
        report.largest_force,
        report.iterations,
        report.age,
        report.status.name(),
    )
}
