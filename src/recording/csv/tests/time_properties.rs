use proptest::prelude::*;

use super::auto;
use crate::recording::csv::*;
use crate::recording::{ExactTime, WarningKind};

/// `ticks` of `10^-places` of the file's unit, from `base` on, as decimal text.
fn written(base: i128, ticks: &[u64], places: u32, comma: bool) -> Vec<String> {
    let ten = 10i128.pow(places);
    let text = |n: i128| {
        let (sign, n) = (if n < 0 { "-" } else { "" }, n.abs());
        let width = places as usize;
        if places == 0 {
            format!("{sign}{n}")
        } else {
            format!("{sign}{}.{:0width$}", n / ten, n % ten)
        }
    };
    let texts = ticks.iter().map(|t| text(base + i128::from(*t)));
    texts
        .map(|t| if comma { t.replace('.', ",") } else { t })
        .collect()
}

fn file(unit: &str, times: &[String]) -> String {
    let mut text = format!("t [{unit}];xp [um]\n");
    for (i, t) in times.iter().enumerate() {
        text.push_str(&format!("{t};{}\n", i * i % 17));
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Whatever a file counts from, in whatever unit: the same bits, the same warnings.
    #[test]
    fn the_zero_of_a_file_changes_no_bit(
        base in -3_000_000_000_000_000_000i128..3_000_000_000_000_000_000,
        steps in prop::collection::vec(1u64..1000, 2..150), even in any::<bool>(),
        places in 0u32..12, unit in 0usize..4, comma in any::<bool>(),
    ) {
        let mut t = 0;
        let ticks: Vec<u64> = [0].into_iter().chain(steps.iter().map(|s| {
            t += if even { steps[0] } else { *s };
            t
        })).collect();
        let unit = ["s", "ms", "us", "ns"][unit];
        // A comma alone may also separate cells: only with decimals is it one.
        let comma = comma && places > 0;
        let zero = auto(&file(unit, &written(0, &ticks, places, comma)));
        let moved = auto(&file(unit, &written(base, &ticks, places, comma)));
        let bits = |r: &Recording| r.time.iter().map(|t| t.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&zero), bits(&moved));
        let said = |r: &Recording| {
            let own = r.warnings.iter().filter(|w| w.kind != WarningKind::TimeOrigin);
            own.map(|w| w.message.clone()).collect::<Vec<_>>()
        };
        prop_assert_eq!(said(&zero), said(&moved));
    }

    /// Any even clock, rounded to any decimals that still show it, comes back within the rounding,
    /// evenly; and what is not rounded is not changed.
    #[test]
    fn a_rounded_clock_comes_back(
        period in 1.0..9.99f64, power in -6i32..-2, rows in 200usize..600, extra in 1i32..4,
        single in any::<bool>(), from in 0.0..0.01f64,
    ) {
        let dt = period * 10f64.powi(power);
        let places = (extra - power) as usize;
        let exact = |i: usize| from + i as f64 * dt;
        let times: Vec<String> = (0..rows).map(|i| if single {
            format!("{}", exact(i) as f32)
        } else {
            format!("{:.places$}", exact(i))
        }).collect();
        let r = auto(&file("s", &times));
        prop_assert_eq!(r.len(), rows);
        let place = if single { 1e-6 * exact(rows) } else { 10f64.powi(-(places as i32)) };
        let mean = r.duration() / (rows - 1) as f64;
        for (i, t) in r.time.iter().enumerate() {
            prop_assert!((t + r.origin.seconds() - exact(i)).abs() <= 1.01 * place + 1e-15);
            prop_assert!((t - i as f64 * mean).abs() <= 4e-4 * dt, "{i}: {t} of {mean}");
        }
    }

    /// Rows whose times are really uneven keep them.
    #[test]
    fn uneven_times_are_kept(steps in prop::collection::vec(1u64..2000, 120..300)) {
        let mut t = 0;
        let ticks: Vec<u64> = [0].into_iter().chain(steps.iter().map(|s| { t += s; t })).collect();
        let r = auto(&file("us", &written(0, &ticks, 0, false)));
        for (time, tick) in r.time.iter().zip(&ticks) {
            prop_assert_eq!(*time, format!("{tick}e-6").parse::<f64>().unwrap());
        }
    }

    /// What is written reads back: the times, and the file's own time of the first row.
    #[test]
    fn the_origin_survives_writing(
        base in -1e10..1e10f64, steps in prop::collection::vec(1e-7..1e-3f64, 1..40),
    ) {
        let mut t = 0.0;
        let time: Vec<f64> = [0.0].into_iter().chain(steps.iter().map(|s| { t += s; t })).collect();
        let rows = time.len();
        let mut made = Recording::new("r", time, None, vec![1e-6; rows], None).unwrap();
        made.origin = ExactTime::from_seconds(base);
        let mut out = Vec::new();
        write_recording(&mut out, &made).unwrap();
        let read = import_bytes_auto("x", &out).unwrap();
        prop_assert_eq!(read.origin, made.origin);
        prop_assert_eq!(read.time, made.time);
    }
}
