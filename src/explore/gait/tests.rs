//! Gaits against closed forms and what must not change them.

use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;

const PERIOD: f64 = 0.02;

/// A foot of one contact from the start of its cycle, for `duty` of the drive's period.
fn foot(delay: f64, duty: f64) -> Foot {
    Foot {
        name: "foot".to_owned(),
        delay,
        cycle: PERIOD,
        contacts: vec![(0.0, duty * PERIOD)],
    }
}

fn gait(feet: &[Foot]) -> Gait {
    Gait::new(feet, PERIOD).unwrap_or_else(|error| panic!("{error}"))
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

#[test]
fn two_alternating_feet_in_closed_form() {
    for duty in [0.1, 0.3, 0.5, 0.7, 0.95] {
        let gait = gait(&[foot(0.0, duty), foot(0.5, duty)]);
        let both = f64::max(2.0 * duty - 1.0, 0.0);
        let none = f64::max(1.0 - 2.0 * duty, 0.0);
        let expected = [none, 1.0 - both - none, both];
        for (own, expected) in gait.shares.iter().zip(expected) {
            assert!(near(*own, expected), "{duty}: {:?}", gait.shares);
        }
        assert!(gait.duty_factors.iter().all(|d| near(*d, duty)));
        // A contact over the end of the cycle is cut, and says so.
        let second = &gait.bars[1];
        assert_eq!(second.len(), if duty > 0.5 { 2 } else { 1 });
        assert_eq!(second.last().unwrap().goes_on, duty > 0.5);
        assert_eq!(second[0].is_from_before, duty > 0.5);
    }
}

#[test]
fn evenly_spaced_feet_in_closed_form() {
    // n feet a share d down, one after another: d n feet on average, never more or fewer than
    // the whole numbers beside it.
    for feet in 2..=6 {
        for duty in [0.15, 0.4, 0.62, 0.9] {
            let delays = GaitPreset::Wave.delays(feet).unwrap();
            let all: Vec<Foot> = delays.into_iter().map(|d| foot(d, duty)).collect();
            let gait = gait(&all);
            let mean = duty * feet as f64;
            let (low, part) = (mean.floor() as usize, mean.fract());
            for (k, share) in gait.shares.iter().enumerate() {
                let expected = match k {
                    k if k == low => 1.0 - part,
                    k if k == low + 1 => part,
                    _ => 0.0,
                };
                assert!(near(*share, expected), "{feet} {duty}: {:?}", gait.shares);
            }
            assert!(near(gait.share_with_fewer_than(low + 1), 1.0 - part));
        }
    }
}

#[test]
fn presets_are_the_known_gaits() {
    let delays = |preset: GaitPreset, n| preset.delays(n).unwrap();
    assert_eq!(delays(GaitPreset::InPhase, 3), [0.0; 3]);
    assert_eq!(delays(GaitPreset::Alternating, 4), [0.0, 0.5, 0.0, 0.5]);
    // Left front and right rear together, and so on.
    assert_eq!(delays(GaitPreset::Tripod, 4), [0.0, 0.5, 0.5, 0.0]);
    assert_eq!(
        delays(GaitPreset::Tripod, 6),
        [0.0, 0.5, 0.5, 0.0, 0.0, 0.5]
    );
    assert_eq!(delays(GaitPreset::Wave, 4), [0.25, 0.75, 0.0, 0.5]);
    for preset in GaitPreset::ALL {
        for n in 2..=6 {
            let delays = delays(preset, n);
            assert_eq!(delays.len(), n);
            assert!(delays.iter().all(|d| (0.0..1.0).contains(d)));
        }
        assert_eq!(preset.delays(1), Err(GaitError::Count { found: 1 }));
        assert_eq!(preset.delays(7), Err(GaitError::Count { found: 7 }));
    }
    // A tripod that is half the time down has three feet down at any time.
    let tripod: Vec<Foot> = delays(GaitPreset::Tripod, 6)
        .into_iter()
        .map(|d| foot(d, 0.5))
        .collect();
    let gait = gait(&tripod);
    assert!(near(gait.shares[3], 1.0), "{:?}", gait.shares);
    assert_eq!(gait.support.len(), 1, "{:?}", gait.support);
}

#[test]
fn feet_of_several_periods_are_drawn_over_all_of_them() {
    let long = |periods: f64, contacts: &[(f64, f64)]| Foot {
        name: format!("of {periods}"),
        delay: 0.0,
        cycle: periods * PERIOD,
        contacts: contacts
            .iter()
            .map(|(a, b)| (a * PERIOD, b * PERIOD))
            .collect(),
    };
    let all = gait(&[
        long(2.0, &[(0.0, 0.5)]),
        long(3.0, &[(1.0, 3.0)]),
        foot(0.0, 0.0),
    ]);
    assert_eq!(all.periods, 6);
    assert!(near(all.cycle, 6.0 * PERIOD));
    assert_eq!(all.bars.iter().map(Vec::len).collect::<Vec<_>>(), [3, 2, 0]);
    for (own, expected) in all.duty_factors.iter().zip([0.25, 2.0 / 3.0, 0.0]) {
        assert!(near(*own, expected));
    }
    // By hand: of the first at 0, 2 and 4, half a period each; the second is up in 0..1 and 3..4.
    assert!(near(all.shares[2], 1.0 / 6.0), "{:?}", all.shares);
    let error = Gait::new(&[long(7.0, &[]), long(11.0, &[])], PERIOD).unwrap_err();
    assert!(
        error.to_string().contains("only after 77 periods"),
        "{error}"
    );
}

#[test]
fn what_is_wrong_is_said() {
    let says = |feet: &[Foot], period: f64, words: &str| {
        let error = Gait::new(feet, period).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let good = foot(0.0, 0.3);
    says(
        std::slice::from_ref(&good),
        PERIOD,
        "1 feet; a gait has 2 to 6",
    );
    says(
        &[good.clone(), good.clone()],
        0.0,
        "the drive's period of 0 s",
    );
    let with = |change: &dyn Fn(&mut Foot)| {
        let mut bad = good.clone();
        bad.name = "left".to_owned();
        change(&mut bad);
        [good.clone(), bad]
    };
    says(
        &with(&|f| f.delay = f64::NAN),
        PERIOD,
        "foot \"left\": a delay of NaN",
    );
    says(
        &with(&|f| f.cycle = 0.033),
        PERIOD,
        "no whole number of the drive's periods",
    );
    says(&with(&|f| f.cycle = 0.0), PERIOD, "no whole number");
    says(
        &with(&|f| f.contacts = vec![(0.1, 0.05)]),
        PERIOD,
        "its end must come after",
    );
    says(
        &with(&|f| f.contacts = vec![(0.0, 0.05)]),
        PERIOD,
        "longer than the cycle",
    );
}

#[test]
fn the_extremes_of_contact() {
    let always = Foot {
        contacts: vec![(0.3 * PERIOD, 1.3 * PERIOD)],
        ..foot(0.77, 0.0)
    };
    let never = Foot {
        contacts: Vec::new(),
        ..foot(0.1, 0.0)
    };
    let gait = gait(&[always, never]);
    assert_eq!(gait.duty_factors, [1.0, 0.0]);
    assert_eq!(gait.shares, [0.0, 1.0, 0.0]);
    assert_eq!(
        [0, 1, 2, 3, 9].map(|k| gait.share_with_fewer_than(k)),
        [0.0, 0.0, 1.0, 1.0, 1.0]
    );
    let csv = contacts_csv(&gait);
    assert_eq!(csv.lines().nth(1), Some("foot,0.77,1,0,0.02"));
    assert_eq!(csv.lines().nth(2), Some("foot,0.1,0,,"));
}

#[test]
fn a_delayed_drive_is_the_same_later() {
    for text in [
        "square:15Hz:8V",
        "sine:50Hz:8V:burst=2/3:phase=40deg",
        "ramped:5Hz:8V:0.2",
    ] {
        let waveform = Waveform::parse(text, 1.0).unwrap();
        let period = waveform.period().unwrap();
        let late = delayed(&waveform, 0.3).unwrap();
        assert_eq!(late.period(), Some(period));
        for k in 0..300 {
            let t = period * (1.0 + 0.0101 * f64::from(k));
            let off = late.voltage(t + 0.3 * period) - waveform.voltage(t);
            assert!(off.abs() < 1e-8, "{text} at {t}: {off}");
        }
    }
    assert!(delayed(&Waveform::Rest, 0.3).is_err());
    assert!(delayed(&Waveform::parse("sine:5Hz:1V", 1.0).unwrap(), f64::NAN).is_err());
}

#[test]
fn feet_of_one_device_are_solved_once() {
    let device = |name: &str| Arc::new(Preset::embedded(name).unwrap().model);
    let shared = device("paper");
    let feet: Vec<FootDevice> = [
        shared.clone(),
        device("oscillator"),
        device("paper"),
        shared,
    ]
    .into_iter()
    .map(|model| FootDevice {
        name: "foot".to_owned(),
        model,
        delay: 0.0,
    })
    .collect();
    assert_eq!(FootDevice::groups(&feet), [vec![0, 2, 3], vec![1]]);
}

/// Feet with cycles of 1 to 3 periods and a few contacts, which may overlap.
fn feet() -> impl Strategy<Value = Vec<Foot>> {
    let contact = (0.0..3.0f64, 0.0..1.0f64);
    let foot = (0.0..1.0f64, 1..4u8, prop::collection::vec(contact, 0..4));
    prop::collection::vec(foot, 2..7).prop_map(|feet| {
        feet.into_iter()
            .map(|(delay, periods, contacts)| Foot {
                name: "a, b".to_owned(),
                delay,
                cycle: f64::from(periods) * PERIOD,
                contacts: contacts
                    .into_iter()
                    .map(|(start, length)| (start * PERIOD, (start + length) * PERIOD))
                    .collect(),
            })
            .collect()
    })
}

/// Whether a foot is down at `t` periods.
fn is_down(foot: &Foot, t: f64) -> bool {
    let cycle = foot.cycle / PERIOD;
    foot.contacts.iter().any(|(start, end)| {
        let since = (t - foot.delay - start / PERIOD).rem_euclid(cycle);
        since < (end - start) / PERIOD
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn shares_are_shares(feet in feet(), shift in -3.0..3.0f64) {
        let gait = gait(&feet);
        prop_assert!(near(gait.shares.iter().sum(), 1.0));
        // As many feet a share of the time as each foot is down, summed.
        let mean: f64 = gait.shares.iter().enumerate().map(|(k, s)| k as f64 * s).sum();
        prop_assert!(near(mean, gait.duty_factors.iter().sum()));
        prop_assert_eq!(gait.support[0].start, 0.0);
        prop_assert_eq!(gait.support[gait.support.len() - 1].end, 1.0);
        prop_assert!(gait.support.windows(2).all(|w| w[0].end == w[1].start && w[0].feet != w[1].feet));
        // Later by the same, nothing changes but the start.
        let later: Vec<Foot> = feet.iter()
            .map(|f| Foot { delay: f.delay + shift, ..f.clone() }).collect();
        let later = Gait::new(&later, PERIOD).unwrap();
        for (a, b) in gait.shares.iter().zip(&later.shares) {
            prop_assert!(near(*a, *b));
        }
        for (a, b) in gait.duty_factors.iter().zip(&later.duty_factors) {
            prop_assert!(near(*a, *b));
        }
    }

    #[test]
    fn bars_and_support_are_what_sampling_finds(feet in feet()) {
        let gait = gait(&feet);
        for k in 0..500 {
            let share = (f64::from(k) + 0.123) / 500.0;
            let t = share * gait.periods as f64;
            let down: Vec<bool> = feet.iter().map(|foot| is_down(foot, t)).collect();
            for (bars, down) in gait.bars.iter().zip(&down) {
                let in_bar = bars.iter().any(|b| b.start <= share && share < b.end);
                prop_assert_eq!(in_bar, *down, "{} {:?}", share, bars);
            }
            let support = gait.support.iter().find(|s| s.start <= share && share < s.end);
            let count = down.iter().filter(|d| **d).count();
            prop_assert_eq!(support.map(|s| s.feet), Some(count));
        }
    }

    #[test]
    fn csv_holds_all_contacts(feet in feet()) {
        let gait = gait(&feet);
        let text = contacts_csv(&gait);
        let mut reader = ::csv::Reader::from_reader(text.as_bytes());
        let mut total = 0.0;
        for row in reader.records() {
            let row = row.unwrap();
            prop_assert_eq!(&row[0], "a, b");
            if !row[3].is_empty() {
                let (start, end): (f64, f64) = (row[3].parse().unwrap(), row[4].parse().unwrap());
                prop_assert!(start < end);
                total += (end - start) / gait.cycle;
            }
        }
        prop_assert!(near(total, gait.duty_factors.iter().sum()));
        let text = support_csv(&gait);
        let mut reader = ::csv::Reader::from_reader(text.as_bytes());
        let rows: Vec<(f64, f64, usize)> = reader.deserialize().map(Result::unwrap).collect();
        prop_assert_eq!(rows.len(), gait.support.len());
    }
}
