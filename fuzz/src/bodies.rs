//! One function for each fuzz target: whatever the bytes are, it must come back soon, and what
//! it accepted must be sound. A panic is a find.

use impactscope::model::Model;
use impactscope::model::drive::Waveform;
use impactscope::model::effects::{ActiveEffect, CATALOGUE};
use impactscope::model::parameter::ParameterId;
use impactscope::model::preset::Preset;
use impactscope::recording::Recording;
use impactscope::recording::csv::{import_bytes, import_bytes_auto, preview_bytes};
use impactscope::recording::formats::{FORMATS, FormatContent};
use impactscope::sim::{Options, simulate};

/// Longest message on a file, whatever the file holds [bytes].
const MAX_MESSAGE_LENGTH: usize = 4000;
/// Segments of a drive that are walked.
const WALKED_SEGMENTS: usize = 200;
/// Frequencies of which instants are checked [Hz].
const PLAUSIBLE_FREQUENCIES: std::ops::Range<f64> = 1e-6..1e9;
/// Amplitudes of which voltages are checked [V].
const MAX_PLAUSIBLE_AMPLITUDE: f64 = 1e12;
/// Span that is simulated [s].
const SIMULATED_SPAN: f64 = 2e-3;

/// A CSV file: preview, import as previewed, import at once.
pub fn recordings(bytes: &[u8]) {
    match preview_bytes("fuzz.csv", bytes) {
        Ok(preview) => match import_bytes("fuzz.csv", bytes, &preview.settings) {
            Ok(recording) => check_recording(&recording),
            Err(error) => assert_says_something(&error.to_string()),
        },
        Err(error) => assert_says_something(&error.to_string()),
    }
    match import_bytes_auto("fuzz.csv", bytes) {
        Ok(recording) => check_recording(&recording),
        Err(error) => assert_says_something(&error.to_string()),
    }
}

/// A file of a binary or structured format, by every format that takes it for its own: the tables
/// that are read are sound.
pub fn formats(bytes: &[u8]) {
    for format in FORMATS {
        let extension = format.extensions().first().unwrap_or(&"");
        let name = format!("fuzz.{extension}");
        if !format.recognises(bytes, &name) {
            continue;
        }
        match format.read(&name, bytes) {
            Ok(FormatContent::Tables(tables)) => {
                assert!(!tables.is_empty(), "no tables and no error");
                for table in tables {
                    let rows = table.rows();
                    assert!(rows > 0, "a table without rows");
                    assert!(table.columns.iter().all(|c| c.values.len() == rows));
                    assert!(table.clock.is_none_or(|clock| clock.interval > 0.0));
                }
            }
            Ok(FormatContent::Inner { .. } | FormatContent::Several(_)) => {}
            Err(error) => assert_says_something(&error.to_string()),
        }
    }
}

fn check_recording(recording: &Recording) {
    let n = recording.len();
    assert!(n > 0, "a recording without samples");
    assert!(recording.time.iter().all(|t| t.is_finite()));
    assert!(
        recording.time.windows(2).all(|w| w[0] < w[1]),
        "time goes back"
    );
    assert_eq!(recording.proof_mass.len(), n);
    for channel in [&recording.voltage, &recording.cantilever]
        .into_iter()
        .flatten()
    {
        assert_eq!(channel.len(), n);
    }
}

/// A preset file: what is read can be written and read again as the same.
pub fn presets(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    match Preset::parse("fuzz.toml", text) {
        Ok(preset) => {
            let written = preset.to_toml();
            let again = Preset::parse("again.toml", &written);
            assert_eq!(again.map(|preset| preset.to_toml()), Ok(written));
        }
        Err(error) => assert_is_one_short_line(&error.to_string()),
    }
}

/// A session file: what is read can be written and read again.
#[cfg(feature = "gui")]
pub fn sessions(bytes: &[u8]) {
    use impactscope::app::files::session;
    use std::path::Path;

    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let path = Path::new("fuzz.impactscope.toml");
    match session::parse(path, text) {
        Ok(mut loaded) => {
            // What a person wrote may say more than is needed; what the program wrote does not.
            let mut texts = vec![text.to_owned()];
            for _ in 0..3 {
                let (setup, view) = (&loaded.setup, &loaded.view);
                let written = session::text(path, setup, view, &loaded.recordings)
                    .expect("a session that was read can be written");
                loaded = session::parse(path, &written).expect("and read again");
                texts.push(written);
            }
            let [.., second, third] = texts.as_slice() else {
                unreachable!("there are four");
            };
            assert_eq!(third, second);
        }
        Err(error) => assert_is_one_short_line(&error.to_string()),
    }
}

/// The text of a drive: its segments follow each other without end, and the voltage is a number
/// at any time.
pub fn drives(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    for duration in [0.4, 1e-9, 1e6] {
        let drive = match Waveform::parse(text, duration) {
            Ok(drive) => drive,
            Err(error) => {
                assert_says_something(&error.to_string());
                continue;
            }
        };
        let again = Waveform::parse(&drive.to_string(), duration);
        assert_eq!(again.as_ref(), Ok(&drive), "{text}");
        let plausible = is_plausible(&drive);
        for t in [0.0, 1e-3, 0.1, 1.0, 1e6, -1.0, 1e300, f64::MAX] {
            // However late or absurd, there is an answer.
            let voltage = drive.voltage(t);
            assert!(!(plausible && voltage.is_nan()), "{drive} at {t} s");
        }
        if !plausible {
            continue;
        }
        let first = drive.index_at(0.0);
        let mut end = f64::NEG_INFINITY;
        for index in first..first + WALKED_SEGMENTS {
            let segment = drive.segment(index);
            assert!(segment.end >= segment.start, "{drive}: {segment:?}");
            assert!(segment.end >= end, "{drive}: {segment:?} ends before {end}");
            end = segment.end;
            if !end.is_finite() {
                break;
            }
        }
    }
}

/// Whether frequencies and amplitude are such that doubles hold all instants of some seconds.
fn is_plausible(drive: &Waveform) -> bool {
    let (frequencies, amplitude) = match *drive {
        Waveform::Periodic(ref periodic) => ([periodic.drive().frequency; 2], periodic.amplitude()),
        Waveform::Sine {
            frequency,
            amplitude,
        }
        | Waveform::Square {
            frequency,
            amplitude,
        }
        | Waveform::Triangle {
            frequency,
            amplitude,
        }
        | Waveform::Ramped {
            frequency,
            amplitude,
            ..
        } => ([frequency; 2], amplitude),
        Waveform::Chirp {
            from,
            to,
            amplitude,
            ..
        } => ([from, to], amplitude),
        Waveform::Rest | Waveform::Table(_) => ([1.0; 2], 0.0),
    };
    let frequencies_hold = frequencies
        .iter()
        .all(|f| PLAUSIBLE_FREQUENCIES.contains(f));
    frequencies_hold && amplitude.abs() < MAX_PLAUSIBLE_AMPLITUDE
}

/// A device with any parameters and effects: the simulator ends within the steps it is given,
/// with numbers or with an error.
pub fn models(bytes: &[u8]) {
    let mut numbers = Numbers { bytes };
    let mut model = Preset::embedded(["paper", "oscillator", "faller"][numbers.below(3)])
        .map_or_else(|| Preset::default().model, |preset| preset.model);
    set_parameters(&mut model, &mut numbers);
    for _ in 0..numbers.below(3) {
        let spec = CATALOGUE[numbers.below(CATALOGUE.len())];
        let mut effect = ActiveEffect::new(spec);
        for value in &mut effect.values {
            if numbers.below(2) == 1 {
                *value = numbers.any();
            }
        }
        model.effects.push(effect);
    }
    let drives = [
        "rest",
        "square:1kHz:8V",
        "sine:3kHz:5V",
        "chirp:10Hz:9kHz:9V",
    ];
    let drive =
        Waveform::parse(drives[numbers.below(drives.len())], SIMULATED_SPAN).unwrap_or_default();
    let options = Options {
        max_steps: 5000,
        max_events: 2000,
        ..Options::default()
    };
    match simulate(&model, &drive, SIMULATED_SPAN, &options) {
        Ok(trace) => {
            assert!(trace.steps <= options.max_steps);
            let all = trace.proof_mass.iter().chain(&trace.cantilever);
            assert!(all.into_iter().all(|x| x.is_finite()), "{model:?}");
        }
        Err(error) => assert_says_something(&error.to_string()),
    }
}

fn set_parameters(model: &mut Model, numbers: &mut Numbers<'_>) {
    for _ in 0..numbers.below(8) {
        let id = ParameterId::ALL[numbers.below(ParameterId::ALL.len())];
        model.parameters.set(id, numbers.any());
    }
}

/// Numbers made of bytes; zeros after their end.
struct Numbers<'a> {
    bytes: &'a [u8],
}

impl Numbers<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.bytes.split_first() else {
            return 0;
        };
        self.bytes = rest;
        *first
    }

    fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count
    }

    /// Any bit pattern, a power of ten of either sign, or a plain number.
    fn any(&mut self) -> f64 {
        match self.below(4) {
            0 => f64::from_bits(u64::from_le_bytes(std::array::from_fn(|_| self.byte()))),
            1 => 10_f64.powi(i32::from(self.byte() as i8)),
            2 => -10_f64.powi(i32::from(self.byte() as i8)),
            _ => f64::from(self.byte()) / 64.0,
        }
    }
}

#[track_caller]
fn assert_says_something(message: &str) {
    assert!(!message.trim().is_empty());
}

#[track_caller]
fn assert_is_one_short_line(message: &str) {
    assert_says_something(message);
    assert!(
        message.len() <= MAX_MESSAGE_LENGTH,
        "{} bytes",
        message.len()
    );
    assert!(!message.contains(char::is_control), "{message:?}");
}
