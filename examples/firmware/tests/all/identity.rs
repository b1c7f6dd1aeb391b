//! Whose data a board keeps: the shipped spindle's identity, and the changes of its file that keep it.

use super::spindle::{MONITOR, SPINDLE};
use mock::flash::FailingFlash;
use spindle_file::spindles::SpindleFile;
use spindle_firmware::spindle;
use spindle_monitor::board::ResetCause;
use spindle_monitor::enumset::EnumSet;
use spindle_monitor::estimator::{KEPT, Kept};
use spindle_monitor::retained::Recovery;
use spindle_monitor::tick::Core;
use spindle_monitor::{Alarm, Identity, Judgement, Life, Store};
use std::fs::read_to_string;
use std::path::Path;

/// As an STM32F405 has it, with smaller sectors.
type Words = FailingFlash<4, 4096>;

/// Identity of the shipped spindle, with words of its file in the place of others, or behind it.
fn shipped(changes: &[(&str, &str)]) -> Identity {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut text = read_to_string(folder.join("spindle.toml")).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = match *from {
            "" => text + to,
            _ => text.replacen(from, to, 1),
        };
    }
    let file = SpindleFile::parse("spindle.toml", &text, folder).unwrap();
    Identity::of(file.bearings_checksum(), file.displacements_checksum())
}

/// Firmware that is built again keeps the life: these numbers change with the shipped spindle alone. They were worked out by
/// `zlib.crc32` of Python, of the file's numbers as single floats.
#[test]
fn the_shipped_spindle_has_this_identity() {
    let identity = Identity::of(0xf9a2_cded, 0x497e_093e);
    assert_eq!(shipped(&[]), identity);
    assert_eq!(spindle::IDENTITY, identity);
}

/// They are below what reads the file.
#[test]
fn the_monitors_tests_have_the_shipped_spindle() {
    let of_file = (
        spindle::SPINDLE,
        spindle::monitor_settings(&Core::STM32F405),
    );
    let by_hand = (SPINDLE, &MONITOR);
    assert_eq!(format!("{by_hand:?}"), format!("{of_file:?}"));
}

#[test]
fn another_support_keeps_the_life_and_drops_the_estimates_and_another_design_drops_both() {
    use Recovery::{OtherSpindle, Recovered};
    const BEARING: &str = "bearing = \"../spindle_file/bearings/b7005c.toml\"";
    const DESIGN: &str = "design = { name = \"of the study\", balls = 16, ball_diameter_mm = 6.35, pitch_diameter_mm = 36.0, \
                          inner_groove_factor = 0.515, outer_groove_factor = 0.525, contact_angle_deg = 15, \
                          inner_shoulder_deg = 48, outer_shoulder_deg = 47.5, bore_mm = 25 }";
    let steeper = DESIGN.replace("_deg = 15", "_deg = 15.1");
    let lower = DESIGN.replace("_deg = 48", "_deg = 46");
    let probe = "\n[[probe]]\nname = \"nose\"\nposition_mm = -10\nangle_deg = 90\n";
    let accurate = format!("{probe}accuracy_um = 0.1\n");
    let aside = probe.replace("-10", "-11");
    let with_probe = shipped(&[("", probe)]);
    let (mut store, _) = Store::open(Words::new(2), with_probe, ResetCause::PowerOn);
    let mut judgement = Judgement::default();
    judgement.latch(Alarm::Overload.into());
    let estimates = Some(Kept([1; KEPT]));
    let kept = ((1 << 50, 1 << 40), judgement.unacknowledged());
    let (used, revolutions) = kept.0;
    let life = Life::resume(used, revolutions);
    assert!(store.power_fails(0, &judgement, &life, estimates));
    let flash = store.into_flash();
    let start = |identity| Store::open(flash.clone(), identity, ResetCause::PowerOn);
    let both = [Recovered; 2];
    let life = [Recovered, OtherSpindle];
    let neither = [OtherSpindle; 2];
    type Changes<'c> = &'c [(&'c str, &'c str)];
    let cases: [(Changes<'_>, [Recovery; 2]); 25] = [
        (&[], both),
        (&[("name = \"two B7005C on", "name = \"a pair on")], both),
        (&[("# The housing.", "#")], both),
        (&[("preload_n = 250", "preload_n = 2.5e2")], both),
        (&[("from_mm = 0,", "from_mm = -0.0,")], both),
        (&[("arrangement = \"back-to-back\"", "")], both),
        (&[("[heat]", "[heat]\nring_per_k = 11.5e-6")], both),
        (&[("fx_n = [-1700, 1700]", "fx_n = [-1500, 1500]")], both),
        (
            &[("[nose]\nposition_mm = 0", "[nose]\nposition_mm = -60")],
            both,
        ),
        (&[(BEARING, DESIGN)], both),
        (&[(probe, &accurate)], both),
        (&[("axial_n_per_um = 400", "axial_n_per_um = 380")], life),
        (&[("radial_n_per_um = 300", "radial_n_per_um = 310")], life),
        (&[("preload_n = 250", "preload_n = 240")], life),
        (&[("preload_n = 250", "mounted_preload_n = 250")], life),
        (&[("position_mm = 130", "position_mm = 131")], life),
        (&[("outer_mm = 25", "outer_mm = 26")], life),
        (&[("grow_with_speed = true", "")], life),
        (&[("reference_c = 20", "reference_c = 22")], life),
        (&[("[heat]", "[heat]\nring_per_k = 12e-6")], life),
        (
            &[("facing = \"+x\"", "facing = \"+x\"\nradial_growth_um = 1")],
            life,
        ),
        (&[(probe, &aside)], life),
        (&[(BEARING, &steeper)], neither),
        (&[(BEARING, &lower)], neither),
        (&[(BEARING, "bearing = \"gmn:S6005C\"")], neither),
    ];
    for (changes, expected) in cases {
        let identity = shipped(&[&[("", probe)], changes].concat());
        let (store, past) = start(identity);
        let report = store.report();
        assert_eq!([report.recovery, report.estimates], expected, "{changes:?}");
        let expected_past = match expected[0] {
            Recovered => kept,
            _ => ((0, 0), EnumSet::new()),
        };
        assert_eq!((past.life, past.start.alarms), expected_past);
        let found = past.estimates;
        assert_eq!(found, estimates.filter(|_| expected[1] == Recovered));
        assert_eq!(past.start.boots, 2);
    }
    // Facings, and the place of loads.
    let turned = [
        ("\"back-to-back\"", "\"face-to-face\""),
        ("\"+x\"", "\"-X\""),
        ("\"-x\"", "\"+x\""),
        ("\"-X\"", "\"-x\""),
    ];
    let facing = |to| start(to).0.report().recovery;
    assert_eq!(
        facing(shipped(&[&[("", probe)], &turned[..]].concat())),
        OtherSpindle
    );
    let loaded = shipped(&[("", probe), ("", "[load]\nposition_mm = -60\n")]);
    let report = start(loaded).0.report();
    assert_eq!([report.recovery, report.estimates], life);
    let belt = shipped(&[
        ("", probe),
        ("", "[[constant_load]]\nposition_mm = 150\nfy_n = -300\n"),
    ]);
    let report = start(belt).0.report();
    assert_eq!([report.recovery, report.estimates], life);
}
