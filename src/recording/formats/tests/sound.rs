//! WAV files as Python's `wave`, SciPy and hound write them.

use super::helpers::{INTERVAL, clock, notes_say, refusal, table, test_file, times, v, values, xp};

#[test]
fn bits_and_channels() {
    let full = |bits: i32, values: &[f64]| times(values, 0.5f64.powi(bits - 1));
    let read = table(test_file!("wav/pcm16.wav"));
    assert_eq!(read.clock, clock(0.0, INTERVAL));
    assert_eq!(values(&read, "Channel 1"), full(16, &times(&v(), 1000.0)));
    assert_eq!(values(&read, "Channel 2"), full(16, &times(&xp(), 100.0)));
    assert!(notes_say(&read, &["16 bits", "full scale is 1.0"]));
    let read = table(test_file!("wav/pcm24.wav"));
    assert_eq!(values(&read, "Channel 1"), full(16, &times(&v(), 1000.0)));
    let read = table(test_file!("wav/pcm32.wav"));
    assert_eq!(
        values(&read, "Channel 1"),
        full(32, &times(&v(), 1_048_576.0))
    );
    let read = table(test_file!("wav/pcm8.wav"));
    // Eight bits are unsigned: 128 is 0.
    assert_eq!(
        values(&read, "Channel 1")[..3],
        [-1.0, -108.0 / 128.0, -88.0 / 128.0]
    );
    let read = table(test_file!("wav/float.wav"));
    assert_eq!(values(&read, "Channel 1"), v());
    assert_eq!(values(&read, "Channel 2"), xp());
}

#[test]
fn what_is_written_is_read() {
    let spec = hound::WavSpec {
        channels: 3,
        sample_rate: 48_000,
        bits_per_sample: 32,
        sample_format: hound::SampleFormat::Float,
    };
    let samples: Vec<f32> = (0..900).map(|i| (i as f32).sin()).collect();
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = hound::WavWriter::new(&mut bytes, spec).unwrap();
    samples
        .iter()
        .for_each(|s| writer.write_sample(*s).unwrap());
    writer.finalize().unwrap();
    let bytes = bytes.into_inner();
    let read = table(("a.wav", &bytes));
    assert_eq!(read.clock, clock(0.0, 1.0 / 48_000.0));
    for (index, column) in read.columns.iter().enumerate() {
        let expected = samples.iter().skip(index).step_by(3).map(|s| f64::from(*s));
        assert_eq!(column.values, expected.collect::<Vec<_>>());
    }
    // Cut off: whole rows are read, and it is said.
    let read = table(("a.wav", &bytes[..bytes.len() - 30]));
    assert_eq!(read.rows(), 297);
    assert!(notes_say(&read, &["cut off", "300", "297"]));
}

#[test]
fn other_kinds_are_refused() {
    assert!(refusal(("a.wav", b"RIFX\0\0\0\x04WAVE")).contains("RIFX"));
    assert!(refusal(("a.wav", b"RIFF\x04\0\0\0WAVE")).contains("WAV file cannot be read"));
}
