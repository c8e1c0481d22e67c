//! One small file for each form in which laboratories keep recordings, with what must come of it: read, asked
//! about, or refused with a reason. All hold the same recording.

use std::path::Path;

use impactscope::recording::Recording;
use impactscope::recording::csv::ReadingChoices;
use impactscope::recording::import::{import_chosen, trials};

/// Samples of the recording, and its interval \[s\].
const ROWS: usize = 60;
const INTERVAL: f64 = 250e-6;
/// How far a reading may be off: half of the last digit written \[m\].
const LAST_DIGIT: f64 = 6e-9;

/// What must come of a file.
enum Expect {
    /// Read, with the voltage.
    Read,
    /// Read without a voltage: there is none.
    WithoutVoltage,
    /// Read, and said with these words.
    Warns(&'static str),
    /// So many recordings in the file.
    Trials(usize),
    /// Not read: the message has these words.
    Says(&'static str),
}
use Expect::{Read, Says, Trials, Warns, WithoutVoltage};

struct Form {
    name: &'static str,
    file: &'static str,
    bytes: Vec<u8>,
    /// Options as `column xp=3`, separated by semicolons.
    options: &'static str,
    expect: Expect,
}

fn voltage(i: usize) -> f64 {
    if i % 20 < 10 { 8.0 } else { -8.0 }
}

fn micrometres(i: usize) -> f64 {
    (100.0 * 200.0 * (0.35 * i as f64).sin()).round() / 100.0
}

/// The rows, each made by `row` of time \[s\], volts and micrometres.
fn rows(row: impl Fn(usize, f64, f64, f64) -> String) -> String {
    let one = |i: usize| row(i, INTERVAL * i as f64, voltage(i), micrometres(i)) + "\n";
    (0..ROWS).map(one).collect()
}

/// Header and rows in milliseconds, volts and micrometres.
fn plain(header: &str, separator: &str) -> String {
    let body = rows(|_, t, v, x| {
        [format!("{:.2}", 1e3 * t), v.to_string(), x.to_string()].join(separator)
    });
    format!("{header}\n{body}")
}

fn comma(text: &str) -> String {
    text.replace('.', ",")
}

fn form(
    name: &'static str,
    text: impl Into<Vec<u8>>,
    options: &'static str,
    expect: Expect,
) -> Form {
    let bytes = text.into();
    Form {
        name,
        file: "x.csv",
        bytes,
        options,
        expect,
    }
}

fn latin1(text: &str) -> Vec<u8> {
    text.chars()
        .map(|c| u8::try_from(u32::from(c)).unwrap())
        .collect()
}

fn utf16(text: &str) -> Vec<u8> {
    let units = std::iter::once(0xfeff).chain(text.encode_utf16());
    units.flat_map(u16::to_le_bytes).collect()
}

const HEADER: &str = "t [ms],V [V],xp [um]";

fn text_hygiene() -> Vec<Form> {
    let base = plain(HEADER, ",");
    let quoted = plain("\"t [ms]\",\"V, drive [V]\",\"xp [um]\"", ",");
    vec![
        form("plain", base.clone(), "", Read),
        form("carriage returns alone", base.replace('\n', "\r"), "", Read),
        form("mixed line ends", base.replacen('\n', "\r\n", 9), "", Read),
        form("comma in a quoted name", quoted, "", Read),
        form("trailing delimiter", base.replace('\n', ",\n"), "", Read),
        form(
            "delimiter at the end of rows only",
            base.replace('\n', ",\n").replacen(",\n", "\n", 1),
            "",
            Read,
        ),
        form(
            "separator line of Excel",
            format!("sep=;\n{}", plain("t [ms];V [V];xp [um]", ";")),
            "",
            Read,
        ),
        form("pipes", plain("t [ms]|V [V]|xp [um]", "|"), "", Read),
        form("blanks", plain("t/ms V/V xp/um", "  "), "", Read),
        form(
            "fixed width",
            "   t [ms]    V [V]  xp [um]\n".to_owned()
                + &rows(|_, t, v, x| format!("{:9.2}{v:9.1}{x:9.2}", 1e3 * t)),
            "",
            Read,
        ),
        form(
            "label:value",
            rows(|_, t, v, x| format!("t:{:.2} V:{v} xp:{x}", 1e3 * t)),
            "unit t=ms;unit xp=um",
            Read,
        ),
        form(
            "semicolons, decimal comma, windows-1252",
            latin1(&comma(&plain("t [ms];V [V];xp [\u{b5}m]", ";"))),
            "",
            Warns("windows-1252"),
        ),
        form(
            "umlaut in a comment",
            [
                latin1("# gemessen f\u{fc}r uns\n"),
                base.clone().into_bytes(),
            ]
            .concat(),
            "",
            Read,
        ),
        form(
            "UTF-16 with tabulators",
            utf16(&plain("t [ms]\tV [V]\txp [um]", "\t")),
            "",
            Read,
        ),
        form(
            "zero bytes at the end",
            [base.clone().into_bytes(), vec![0; 64]].concat(),
            "",
            Warns("zero bytes"),
        ),
        form(
            "Fortran exponents",
            "t [ms],V [V],xp [um]\n".to_owned()
                + &rows(|_, t, v, x| format!("{:.4}D+00,{v}D0,{x}D+00", 1e3 * t)),
            "",
            Read,
        ),
        form(
            "footer",
            format!("{base}end of file\nchecked by nobody\n"),
            "",
            Warns("lines of text"),
        ),
        form(
            "header again on the way",
            base.replacen("7.50,", "t [ms],V [V],xp [um]\n7.50,", 1),
            "",
            Warns("of text"),
        ),
        form(
            "decimal comma beside commas",
            comma(&format!(
                "{HEADER}\n{}",
                rows(|_, t, v, x| format!("{:.2},{v:.1},{x:.2}", 1e3 * t))
            )),
            "",
            Says("decimal comma"),
        ),
        form(
            "names and units in two rows",
            plain("t,V,xp\nms,V,\u{3bc}m", ","),
            "",
            Read,
        ),
        form(
            "an unknown unit in the row of units",
            "t,V,n,xp\n(ms),(V),(furlong),(um)\n".to_owned()
                + &rows(|i, t, v, x| format!("{:.2},{v},{i},{x}", 1e3 * t)),
            "",
            Warns("furlong"),
        ),
        form(
            "units in words",
            plain(
                "time in milliseconds,voltage in volts,xp in micrometers",
                ",",
            ),
            "",
            Read,
        ),
        form(
            "French names",
            plain("temps (ms),tension (V),d\u{e9}placement (um)", ","),
            "",
            Read,
        ),
        form(
            "Chinese names",
            plain(
                "\u{65f6}\u{95f4} (ms),\u{7535}\u{538b} (V),\u{4f4d}\u{79fb} (um)",
                ",",
            ),
            "",
            Read,
        ),
    ]
}

fn marks_and_units() -> Vec<Form> {
    let nm = |row: &dyn Fn(f64, f64, i64) -> String, header: &str| {
        let body = rows(|_, t, v, x| row(1e6 * t, v, (1e3 * x).round() as i64));
        format!("{header}\n{body}")
    };
    let grouped = |x: i64, mark: &str| {
        let size = x.unsigned_abs();
        let sign = if x < 0 { "-" } else { "" };
        if size < 1000 {
            format!("{sign}{size}")
        } else {
            format!("{sign}{}{mark}{:03}", size / 1000, size % 1000)
        }
    };
    vec![
        form(
            "thousands quoted",
            nm(
                &|t, v, x| {
                    format!(
                        "\"{}\",{v},\"{}\"",
                        grouped(t.round() as i64, ","),
                        grouped(x, ",")
                    )
                },
                "t [us],V [V],xp [nm]",
            ),
            "",
            Warns("between thousands"),
        ),
        form(
            "European thousands",
            nm(
                &|t, v, x| {
                    format!(
                        "{};{};{}",
                        grouped(t.round() as i64, "."),
                        comma(&format!("{v:.1}")),
                        grouped(x, ".")
                    )
                },
                "t [us];V [V];xp [nm]",
            ),
            "",
            Warns("between thousands"),
        ),
        form(
            "thousands beside tabulators",
            nm(
                &|t, v, x| {
                    format!(
                        "{}\t{v:.1}\t{}.0",
                        grouped(t.round() as i64, ","),
                        grouped(x, ",")
                    )
                },
                "t [us]\tV [V]\txp [nm]",
            ),
            "",
            Warns("between thousands"),
        ),
        form(
            "kilovolts",
            plain("t [ms],V [kV],xp [um]", ",")
                .replace(",8,", ",0.008,")
                .replace(",-8,", ",-0.008,"),
            "",
            Read,
        ),
        form(
            "minutes",
            format!(
                "t [min],V [V],xp [um]\n{}",
                rows(|_, t, v, x| format!("{:e},{v},{x}", t / 60.0))
            ),
            "",
            Read,
        ),
        form(
            "metres without a unit",
            format!(
                "t,V,xp\n{}",
                rows(|_, t, v, x| format!("{t:.5},{v},{:e}", 1e-6 * x))
            ),
            "",
            Warns("names no unit"),
        ),
        form(
            "millimetres without a unit",
            format!(
                "t [s],V [V],xp\n{}",
                rows(|_, t, v, x| format!("{t:.5},{v},{}", 1e-3 * x))
            ),
            "",
            Says("--unit xp="),
        ),
        form(
            "pixels",
            plain("t [ms],V [V],xp [px]", ","),
            "",
            Says("--scale xp="),
        ),
        form(
            "pixels with a scale",
            plain("t [ms],V [V],xp [px]", ","),
            "scale xp=1um/px",
            Read,
        ),
        form(
            "volts of a displacement meter",
            plain("t [ms],drive [V],displacement [V]", ","),
            "",
            Says("--scale xp="),
        ),
        form(
            "volts with a sensitivity",
            plain("t [ms],drive [V],displacement [V]", ","),
            "scale xp=1um/V",
            Read,
        ),
        form(
            "per cent of a pulse width",
            plain("t [ms],V [%],xp [um]", ","),
            "",
            Says("--scale V="),
        ),
        form(
            "a monitor of 1/20",
            plain(HEADER, ",")
                .replace(",8,", ",0.4,")
                .replace(",-8,", ",-0.4,"),
            "scale V=20",
            Read,
        ),
        form(
            "positive downwards",
            plain(HEADER, ",")
                .lines()
                .map(|l| match l.rsplit_once(',') {
                    Some((a, x)) if x.parse::<f64>().is_ok() => {
                        format!("{a},{}\n", -x.parse::<f64>().unwrap())
                    }
                    _ => format!("{l}\n"),
                })
                .collect::<String>(),
            "sign xp=-1",
            Read,
        ),
        form(
            "two voltages",
            format!(
                "t [ms],Command [V],Monitor [V],xp [um]\n{}",
                rows(|_, t, v, x| format!("{:.2},{v},{v},{x}", 1e3 * t))
            ),
            "",
            Says("could each be V"),
        ),
        form(
            "another quantity beside",
            format!(
                "t [ms],V [V],xp [um],v (mm/s),f [Hz]\n{}",
                rows(|_, t, v, x| format!("{:.2},{v},{x},1.5,15", 1e3 * t))
            ),
            "",
            Read,
        ),
        form(
            "overrange",
            plain(HEADER, ",").replacen("0.25,8,", "0.25,9.9E+37,", 1),
            "",
            Warns("out of the instrument's range"),
        ),
    ]
}

fn times() -> Vec<Form> {
    let of = |header: &str, time: &dyn Fn(usize, f64) -> String| {
        format!(
            "{header}\n{}",
            rows(|i, t, v, x| format!("{},{v},{x}", time(i, t)))
        )
    };
    vec![
        form(
            "Unix seconds",
            of("t [s],V [V],xp [um]", &|_, t| {
                format!("{:.5}", 1_767_276_012.5 + t)
            }),
            "",
            Warns("count from the first row"),
        ),
        form(
            "Unix microseconds",
            of("t [us],V [V],xp [um]", &|i, _| {
                (1_767_276_012_500_000 + 250 * i).to_string()
            }),
            "",
            Warns("count from the first row"),
        ),
        form(
            "clock times",
            of("Time,V [V],xp [um]", &|_, t| {
                format!("14:03:{:08.5}", 12.5 + t)
            }),
            "",
            Warns("clock times"),
        ),
        form(
            "date and time",
            format!(
                "Date,Time,V [V],xp [um]\n{}",
                rows(|_, t, v, x| format!("2026-01-01,14:03:{:08.5},{v},{x}", 12.5 + t))
            ),
            "",
            Warns("clock times"),
        ),
        form(
            "days of a spreadsheet",
            of("Time,V [V],xp [um]", &|_, t| {
                format!("{:.12}", 46_023.5 + t / 86_400.0)
            }),
            "",
            Warns("day numbers"),
        ),
        form(
            "rounded to 3 digits",
            of("t [s],V [V],xp [um]", &|_, t| format!("{t:.3}")),
            "",
            Warns("rounded to the digits"),
        ),
        form(
            "newest first",
            {
                let text = plain(HEADER, ",");
                let mut lines: Vec<&str> = text.lines().collect();
                lines[1..].reverse();
                lines.join("\n")
            },
            "",
            Warns("turned round"),
        ),
        form(
            "rows out of order",
            {
                let text = plain(HEADER, ",");
                let mut lines: Vec<&str> = text.lines().collect();
                lines.swap(30, 32);
                lines.join("\n")
            },
            "",
            Warns("sorted by time"),
        ),
        form(
            "no times, rate in the header",
            format!(
                "# Sampling rate: 4 kHz\nV [V],xp [um]\n{}",
                rows(|_, _, v, x| format!("{v},{x}"))
            ),
            "",
            Warns("as the lines above say"),
        ),
        form(
            "no times, rate given",
            format!("V [V],xp [um]\n{}", rows(|_, _, v, x| format!("{v},{x}"))),
            "rate 4000",
            Read,
        ),
        form(
            "no times",
            format!("V [V],xp [um]\n{}", rows(|_, _, v, x| format!("{v},{x}"))),
            "",
            Says("--rate"),
        ),
        form(
            "sample numbers, rate in the header",
            of("# fs = 4000 Hz\nsample,V [V],xp [um]", &|i, _| {
                i.to_string()
            }),
            "",
            Warns("as the lines above say"),
        ),
        form(
            "unit of time changes",
            of(HEADER, &|_, t| {
                if t < 1e-3 {
                    format!("{:.3}", 1e6 * t)
                } else {
                    format!("{:.4}", 1e3 * t)
                }
            }),
            "",
            Says("unit of time changes"),
        ),
        form(
            "time last",
            format!(
                "xp [um],V [V],t [ms]\n{}",
                rows(|_, t, v, x| format!("{x},{v},{:.2}", 1e3 * t))
            ),
            "",
            Read,
        ),
        form(
            "no header",
            rows(|_, t, v, x| format!("{t:.5},{v},{x}")),
            "",
            Says("no header"),
        ),
        form(
            "no header, columns given",
            rows(|_, t, v, x| format!("{t:.5},{v},{x}")),
            "column t=1;column V=2;column xp=3;unit t=s;unit xp=um",
            Read,
        ),
        form(
            "index of a table",
            format!(
                ",t [ms],V [V],xp [um]\n{}",
                rows(|i, t, v, x| format!("{i},{:.2},{v},{x}", 1e3 * t))
            ),
            "",
            Read,
        ),
        form(
            "a spectrum",
            "Frequency (Hz),Magnitude (um)\n".to_owned() + &rows(|i, _, _, x| format!("{i},{x}")),
            "",
            Says("spectrum"),
        ),
    ]
}

fn several_and_makers() -> Vec<Form> {
    let one = plain(HEADER, ",");
    let both = |t: f64, v: f64, x: f64| format!("{t:.6e},{v},{x}");
    let channels = rows(|_, t, v, x| both(t, v, x));
    let answer = "column V=2;column xp=3;scale xp=1um/V";
    let beside: String = one.lines().map(|l| format!("{l},{l}\n")).collect();
    vec![
        form(
            "restarted clock with a header",
            format!("{one}{one}"),
            "",
            Trials(2),
        ),
        form(
            "restarted clock",
            format!("{one}{}", one.split_once('\n').unwrap().1),
            "",
            Trials(2),
        ),
        form("the second of two", format!("{one}{one}"), "trial 2", Read),
        form("side by side", beside, "", Trials(2)),
        form(
            "one time for three",
            format!(
                "t [ms],trial 1 [um],trial 2 [um],trial 3 [um]\n{}",
                rows(|_, t, _, x| format!("{:.2},{x},{x},{x}", 1e3 * t))
            ),
            "",
            Trials(3),
        ),
        form(
            "Keysight",
            format!("x-axis,1,2\nsecond,Volt,Volt\n{channels}"),
            "column V=1;column xp=2;scale xp=1um/Volt",
            Read,
        ),
        form(
            "Keysight, one column twice",
            format!("x-axis,1,2\nsecond,Volt,Volt\n{channels}"),
            "column V=2;column xp=3",
            Says("one column twice"),
        ),
        form(
            "Keysight, nothing said",
            format!("x-axis,1,2\nsecond,Volt,Volt\n{channels}"),
            "",
            Says("--scale xp="),
        ),
        form(
            "Rigol",
            "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,0,2.5e-04\n".to_owned()
                + &rows(|i, _, v, x| format!("{i},{v},{x},")),
            "column V=2;column xp=3;scale xp=1um/Volt",
            Read,
        ),
        form(
            "Siglent",
            format!("Record Length,60\nSource,CH1,CH2\nSecond,Volt,Volt\n{channels}"),
            "column V=2;column xp=3;scale xp=1um/Volt",
            Read,
        ),
        form(
            "Rohde & Schwarz",
            format!("in s,C1 in V,C2 in V\n{channels}"),
            answer,
            Read,
        ),
        form(
            "LeCroy",
            format!(
                "LECROYWS3024,1,Waveform\nSegments,1,SegmentSize,60\nSegment,TrigTime,TimeSinceSegment1\n#1,01-Jan-2026 12:00:00,0\nTime,Ampl\n{}",
                rows(|_, t, _, x| format!("{t:.6},{x}"))
            ),
            "scale xp=1um/V",
            WithoutVoltage,
        ),
        form(
            "Tektronix",
            format!(
                "Model,MSO2024\nHorizontal Units,s\nSample Interval,2.5e-4\nVertical Units,V,V\nTIME,CH1,CH2\n{channels}"
            ),
            answer,
            Read,
        ),
        form(
            "PicoScope",
            format!("Time,Channel A,Channel B\n(s),(V),(V)\n\n{channels}"),
            answer,
            Read,
        ),
        form(
            "Digilent",
            format!(
                "#Digilent WaveForms Oscilloscope Acquisition\n\nTime (s),Channel 1 (V),Channel 2 (V)\n{channels}"
            ),
            answer,
            Read,
        ),
        form(
            "Hioki",
            format!(
                "\"File name\",\"W.CSV\",\"V1.00\"\n\"Comment\",\"\",\"\"\n\"Time\",\"CH1[V]\",\"CH2[V]\"\n{channels}"
            ),
            answer,
            Read,
        ),
        form(
            "Red Pitaya",
            format!("Time[s],IN1[V],IN2[V]\n{channels}"),
            answer,
            Read,
        ),
        form(
            "Tracker",
            format!(
                "mass A\nt\tx\ty\n{}",
                rows(|_, t, v, x| format!("{t:.6E}\t{v:.3E}\t{:.8E}", 1e-6 * x))
            ),
            "",
            Warns("sideways"),
        ),
        form(
            "LDV with header lines",
            format!(
                "File: a.txt\nDate: today\nRange: 10\n{}",
                plain("t [ms]\tV [V]\txp [um]", "\t")
            ),
            "",
            Read,
        ),
    ]
}

/// Binary forms that are written here; those of other programs are in `assets/test_files/formats`.
fn binary() -> Vec<Form> {
    let base = plain(HEADER, ",");
    let gz = {
        use std::io::Write;
        let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        out.write_all(base.as_bytes()).unwrap();
        out.finish().unwrap()
    };
    let npy = {
        let header = format!(
            "{{'descr': [('t', '<f8'), ('V', '<f8'), ('xp', '<f8')], 'fortran_order': False, 'shape': ({ROWS},), }}\n"
        );
        let mut bytes = b"\x93NUMPY\x01\0".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        for i in 0..ROWS {
            for value in [INTERVAL * i as f64, voltage(i), 1e-6 * micrometres(i)] {
                bytes.extend(value.to_le_bytes());
            }
        }
        bytes
    };
    let wav = {
        let path = tempfile::tempdir().unwrap();
        let file = path.path().join("a.wav");
        let spec = hound::WavSpec {
            channels: 2,
            sample_rate: 4000,
            bits_per_sample: 32,
            sample_format: hound::SampleFormat::Float,
        };
        let mut out = hound::WavWriter::create(&file, spec).unwrap();
        for i in 0..ROWS {
            out.write_sample(voltage(i) as f32 / 10.0).unwrap();
            out.write_sample(micrometres(i) as f32 / 1000.0).unwrap();
        }
        out.finalize().unwrap();
        std::fs::read(file).unwrap()
    };
    let named = |name, file, bytes, options, expect| Form {
        name,
        file,
        bytes,
        options,
        expect,
    };
    vec![
        named("gzip", "x.csv.gz", gz, "", Read),
        named("NumPy with fields", "x.npy", npy, "", Warns("names no unit")),
        named("WAV", "x.wav", wav.clone(), "", Says("nothing says which")),
        named("WAV with scales", "x.wav", wav, "column V=2;column xp=3;scale V=10;scale xp=1000um/V", Read),
        named("LVM", "x.lvm", ("LabVIEW Measurement\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nMulti_Headings\tNo\nX_Columns\tOne\nTime_Pref\tAbsolute\n***End_of_Header***\n\nChannels\t2\nSamples\t60\t60\nY_Unit_Label\tV\tm\nX0\t0\t0\nDelta_X\t0.00025\t0.00025\n***End_of_Header***\nX_Value\tV\txp\tComment\n".to_owned()
            + &rows(|_, t, v, x| format!("{t:.6}\t{v}\t{:e}", 1e-6 * x))).into_bytes(), "", Read),
        named("Parquet", "x.parquet", b"PAR1\0\0\0\0PAR1".to_vec(), "", Says("Parquet")),
    ]
}

fn choices(options: &str) -> ReadingChoices {
    let mut choices = ReadingChoices::default();
    for option in options.split(';').filter(|o| !o.is_empty()) {
        let (name, value) = option.split_once(' ').unwrap();
        let pair = || {
            let (a, b) = value.split_once('=').unwrap();
            (a.to_owned(), b.to_owned())
        };
        match name {
            "column" => choices.columns.push(pair()),
            "unit" => choices.units.push(pair()),
            "scale" => choices.scales.push(pair()),
            "sign" => choices.signs.push((pair().0, pair().1.parse().unwrap())),
            "rate" => choices.interval = Some(1.0 / value.parse::<f64>().unwrap()),
            "trial" => choices.trial = Some(value.parse().unwrap()),
            _ => panic!("{option}"),
        }
    }
    choices
}

/// What is wrong with a recording.
fn difference(r: &Recording, has_voltage: bool) -> Option<String> {
    if r.len() != ROWS {
        return Some(format!("{} rows", r.len()));
    }
    if (r.interval() - INTERVAL).abs() > 1e-9 {
        return Some(format!("an interval of {:e} s", r.interval()));
    }
    // A cell that is out of range is missing.
    let wrong = |i: &usize| {
        let x = r.proof_mass[*i];
        x.is_finite() && (x - 1e-6 * micrometres(*i)).abs() > LAST_DIGIT
    };
    if let Some(i) = (0..ROWS).find(wrong) {
        return Some(format!("xp of {:e} m in row {i}", r.proof_mass[i]));
    }
    match (&r.voltage, has_voltage) {
        (None, true) => Some("no voltage".to_owned()),
        (Some(v), true) => {
            let off = |i: &usize| v[*i].is_finite() && (v[*i] - voltage(*i)).abs() > 1e-6;
            (0..ROWS)
                .find(off)
                .map(|i| format!("{} V in row {i}", v[i]))
        }
        _ => None,
    }
}

/// What came of a form, if it is not what must come.
fn failure(form: &Form, path: &Path) -> Option<String> {
    std::fs::write(path, &form.bytes).unwrap();
    let choices = choices(form.options);
    if let Trials(count) = form.expect {
        let found = trials(path).map(|names| names.len());
        return (found.as_ref().ok() != Some(&count)).then(|| format!("{found:?} recordings"));
    }
    match (import_chosen(path, &choices, None), &form.expect) {
        (Err(error), Says(words)) => {
            let text = error.to_string();
            (!text.contains(words) || !text.contains(form.file)).then_some(text)
        }
        (Err(error), _) => Some(error.to_string()),
        (Ok(_), Says(words)) => Some(format!("read without a word of \"{words}\"")),
        (Ok(r), Warns(words)) => {
            let said: Vec<&str> = r.warnings.iter().map(|w| w.message.as_str()).collect();
            if said.iter().any(|text| text.contains(words)) {
                let has_voltage = r.voltage.is_some();
                difference(&r, has_voltage)
            } else {
                Some(format!("says only {said:?}"))
            }
        }
        (Ok(r), WithoutVoltage) => difference(&r, false),
        (Ok(r), _) => difference(&r, true),
    }
}

#[test]
fn every_form_is_read_asked_about_or_refused_as_it_must() {
    let folder = tempfile::tempdir().unwrap();
    let all = [
        text_hygiene(),
        marks_and_units(),
        times(),
        several_and_makers(),
        binary(),
    ];
    let all: Vec<Form> = all.into_iter().flatten().collect();
    assert!(all.len() > 70);
    let check = |form: &Form| {
        let path = folder.path().join(form.file);
        failure(form, &path).map(|found| format!("{}: {found}", form.name))
    };
    let failures: Vec<String> = all.iter().filter_map(check).collect();
    assert!(
        failures.is_empty(),
        "{} forms:\n{}",
        failures.len(),
        failures.join("\n")
    );
}
