//! Findings of the probes, in words: for the view, and for `cargo replay --response`.

use spindle_monitor::estimator::{Constants, Estimate, State};
use spindle_monitor::telemetry::{ProbeReport, ProbesReport};

/// Load steps until commissioning can end.
pub const fn steps_to_go(report: &ProbesReport) -> u32 {
    Constants::USUAL.steps.saturating_sub(report.steps)
}

/// Knowledge that commissioning lacks, besides load steps; none where all is known well enough.
pub fn lacking(report: &ProbesReport) -> Option<String> {
    let [preload, gain] = Constants::USUAL.known;
    let (what, known, due) = match report.preload {
        Some(Estimate { value, error }) => ("preload", error / value, preload),
        None => {
            let follow = report.probes.iter();
            let follow = follow.filter(|probe| probe.state != State::Probe);
            let errors = follow.map(|probe| probe.gain.error);
            ("a gain", errors.fold(0.0, f32::max), gain)
        }
    };
    let [is, should] = [known, due].map(|part| (100.0 * part).ceil());
    (known > due).then(|| {
        format!("loads of another direction or size: {what} known to {is} %, {should} % is due")
    })
}

/// The motion that a probe has measured over the computed one, and what a strange one looks like.
pub fn raw_ratio(probe: &ProbeReport) -> String {
    let Some(ratio) = probe.ratio else {
        return "no load step".into();
    };
    let looks_like = match ratio {
        0.2..5.0 => "",
        5e-4..2e-3 => ": mm for um?",
        5e2..2e3 => ": nm for um?",
        -0.2..0.2 => ": cut off, frozen, or across the motion?",
        r if r < 0.0 => ": does it look the other way?",
        _ => ": another unit?",
    };
    format!("{ratio:.4} of the computed motion{looks_like}")
}

/// How the spindle stands by its probes.
pub fn of_spindle(report: &ProbesReport) -> String {
    let [change, error] = report
        .change
        .map_or([0.0; 2], |of| [of.value, of.error].map(|part| 100.0 * part));
    let words = match report.state {
        State::Probe => "no probe follows the loads".into(),
        State::PreloadLoss => {
            format!("{:.1} +- {error:.1} % of the preload is lost", -change)
        }
        State::PreloadGrowth => format!("{change:.1} +- {error:.1} % more preload"),
        State::StiffnessLoss => "a probe sees more motion than the preload explains".into(),
        State::StiffnessGain => "a probe sees less motion than the preload explains".into(),
        State::Unexplained => "neither preload nor gains explain the load steps".into(),
        State::Learning => {
            let to_go = Some(steps_to_go(report)).filter(|steps| *steps > 0);
            let to_go = to_go.map(|steps| format!("{steps} load steps to go"));
            let lacks: Vec<_> = to_go.into_iter().chain(lacking(report)).collect();
            return match lacks.is_empty() {
                true => "commissioned with the next load step".into(),
                false => lacks.join("; "),
            };
        }
        State::Unknown => {
            format!("the change of preload is known to +- {error:.1} % alone: it takes load steps")
        }
        State::Ok => "as at commissioning".into(),
    };
    format!("{words}, {} load steps", report.steps)
}

/// How a probe stands.
pub fn of_probe(probe: &ProbeReport) -> String {
    let Estimate { value, error } = probe.gain;
    match probe.state {
        State::Probe => format!("does not follow the loads: {}", raw_ratio(probe)),
        State::Learning => raw_ratio(probe),
        _ => format!("gain {value:.3} +- {error:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strange_ratio_is_told_by_its_likely_cause() {
        for (ratio, words) in [
            (1.053, "1.0530 of the computed motion"),
            (0.001, "0.0010 of the computed motion: mm for um?"),
            (980.0, "980.0000 of the computed motion: nm for um?"),
            (
                -0.97,
                "-0.9700 of the computed motion: does it look the other way?",
            ),
            (
                0.03,
                "0.0300 of the computed motion: cut off, frozen, or across the motion?",
            ),
            (25.4, "25.4000 of the computed motion: another unit?"),
        ] {
            let probe = ProbeReport {
                state: State::Probe,
                gain: Estimate::default(),
                ratio: Some(ratio),
            };
            assert_eq!(raw_ratio(&probe), words);
        }
    }
}
