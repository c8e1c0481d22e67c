//! What is exported, read back by readers of their own.

use std::collections::BTreeMap;

use super::*;

fn drive(text: &str) -> Waveform {
    Waveform::parse(text, 1.0).unwrap()
}

const DRIVES: [&str; 5] = [
    "square:15Hz:8V:duty=30%:offset=1V",
    "sine:40Hz:2.5V:phase=77deg",
    "ramped:5Hz:8V:0.25:burst=2/3",
    "drawn:12.5Hz:smooth:0.1/-2,0.25/1,0.3/5,0.55/5.5,0.6/-1,0.9/-6",
    "triangle:100kHz:1e-3V:offset=5V",
];

/// What the drive is at sample `i` of `n`, just after it.
fn expected(waveform: &Waveform, i: usize, n: usize) -> f64 {
    let period = waveform.period().unwrap();
    waveform.voltage(period * (3.0 + (i as f64 + 1e-7) / n as f64))
}

/// How far the drive moves in the share of a sample by which [`expected`] is late.
fn slack(waveform: &Waveform) -> f64 {
    1e-5 * waveform.amplitude()
}

#[test]
fn csv_is_exact() {
    for text in DRIVES {
        let waveform = drive(text);
        let written = export(&waveform, GeneratorFormat::Csv { has_header: true }, 1000).unwrap();
        let bare = export(&waveform, GeneratorFormat::Csv { has_header: false }, 1000).unwrap();
        assert_eq!(written.strip_prefix("t [s],V [V]\n"), Some(bare.as_str()));
        let mut reader = csv::Reader::from_reader(written.as_bytes());
        let rows: Vec<(f64, f64)> = reader.deserialize().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 1000);
        let period = waveform.period().unwrap();
        for (i, (t, v)) in rows.into_iter().enumerate() {
            assert!((t - period * i as f64 / 1000.0).abs() < 1e-12 * period);
            let off = (v - expected(&waveform, i, 1000)).abs();
            assert!(off < slack(&waveform), "{text} {i}: {off}");
        }
    }
}

#[test]
fn siglents_file_reads_back_within_a_step_of_14_bits() {
    const STEPS: f64 = 8192.0;
    for text in DRIVES {
        let waveform = drive(text);
        let written = export(&waveform, GeneratorFormat::Siglent, 2048).unwrap();
        let lines: Vec<&str> = written.lines().collect();
        assert_eq!(lines[12], "xpos,value");
        assert!(lines[5..12].iter().all(|line| *line == ","));
        let values: BTreeMap<&str, f64> = lines[..5]
            .iter()
            .map(|line| line.split_once(',').unwrap())
            .map(|(key, value)| (key, value.parse().unwrap()))
            .collect();
        assert_eq!(values["data length"], 2048.0);
        let frequency = 1.0 / waveform.period().unwrap();
        assert!((values["frequency"] / frequency - 1.0).abs() < 1e-12);
        let (half, offset) = (0.5 * values["amp"], values["offset"]);
        let rows = &lines[13..];
        assert_eq!(rows.len(), 2048);
        for (i, row) in rows.iter().enumerate() {
            let (t, v) = row.split_once(',').unwrap();
            let (t, v): (f64, f64) = (t.parse().unwrap(), v.parse().unwrap());
            assert!((t * frequency - i as f64 / 2048.0).abs() < 1e-6);
            let code = ((v - offset) / half * STEPS).round();
            assert!(code.abs() <= STEPS);
            let off = (offset + half * code / STEPS - expected(&waveform, i, 2048)).abs();
            assert!(
                off <= 0.5 * half / STEPS + 2e-9 + slack(&waveform),
                "{text} {i}: {off}"
            );
        }
    }
}

#[test]
fn keysights_file_reads_back_within_a_step_of_16_bits() {
    for text in DRIVES {
        let waveform = drive(text);
        let written = export(&waveform, GeneratorFormat::Keysight, 600).unwrap();
        let (head, data) = written.split_once("Data:\r\n").unwrap();
        let keys: BTreeMap<&str, &str> = head
            .lines()
            .map(|line| line.split_once(':').unwrap())
            .collect();
        assert_eq!(keys["File Format"], "1.10");
        assert_eq!(keys["Data Type"], "\"short\"");
        assert_eq!(keys["Data Points"], "600");
        let number = |key: &str| keys[key].parse::<f64>().unwrap();
        let rate = 600.0 / waveform.period().unwrap();
        assert!((number("Sample Rate") / rate - 1.0).abs() < 1e-12);
        let (high, low) = (number("High Level"), number("Low Level"));
        let codes: Vec<f64> = data.lines().map(|line| line.parse().unwrap()).collect();
        assert_eq!(codes.len(), 600);
        let largest = codes.iter().fold(0.0f64, |a, c| a.max(c.abs()));
        assert_eq!(largest, 32_767.0);
        let step = high / 32_767.0;
        for (i, code) in codes.into_iter().enumerate() {
            // Both readings of the codes.
            let of_span = low + (high - low) * (code + 32_767.0) / 65_534.0;
            let of_largest = high.abs().max(low.abs()) * code / 32_767.0;
            for v in [of_span, of_largest] {
                let off = (v - expected(&waveform, i, 600)).abs();
                assert!(
                    off <= 0.5 * step + 2e-9 + slack(&waveform),
                    "{text} {i}: {off}"
                );
            }
        }
    }
}

#[test]
fn what_a_generator_does_not_take_is_said() {
    let square = drive("square:15Hz:8V");
    let says = |waveform: &Waveform, format, samples, words: &str| {
        let error = export(waveform, format, samples).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let csv = GeneratorFormat::Csv { has_header: true };
    says(&square, csv, 1, "1 samples; a period takes 2 to 1000000");
    says(
        &square,
        GeneratorFormat::Siglent,
        20_000,
        "a period takes 2 to 16384",
    );
    says(&square, GeneratorFormat::Keysight, 7, "a period takes 8");
    says(&Waveform::Rest, csv, 100, "has no period; export a sine");
    let level = drive("square:15Hz:8V:duty=100%");
    says(
        &level,
        GeneratorFormat::Siglent,
        100,
        "set this voltage as DC",
    );
    says(
        &level,
        GeneratorFormat::Keysight,
        100,
        "set this voltage as DC",
    );
    let fast = drive("square:1MHz:8V");
    says(&fast, GeneratorFormat::Keysight, 1000, "take fewer");
}
