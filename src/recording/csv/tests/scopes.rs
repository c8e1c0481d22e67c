//! Headers of oscilloscopes, in the forms of their makers' manuals.

use super::fails;
use crate::recording::Recording;
use crate::recording::csv::*;

/// Rows of a sine at 4 kHz from -2 ms: time, sample, two channels.
fn rows(line: impl Fn(f64, u32, f64, f64) -> String) -> String {
    (0..40u32)
        .map(|i| {
            let t = -2e-3 + 250e-6 * f64::from(i);
            line(
                t,
                i,
                if i % 10 < 5 { 8.0 } else { -8.0 },
                (0.4 * f64::from(i)).sin(),
            ) + "\n"
        })
        .collect()
}

/// Reads it with 50 um/V.
fn read(text: &str, columns: &[(&str, &str)], maker: Option<&str>) -> Recording {
    let error = fails(text.as_bytes()).to_string();
    assert!(error.contains("--scale xp="), "{error}");
    let preview = preview_bytes("x", text.as_bytes()).unwrap();
    assert_eq!(preview.written_by.as_deref(), maker);
    let own = |(a, b): &(&str, &str)| ((*a).to_owned(), (*b).to_owned());
    let choices = ReadingChoices {
        columns: columns.iter().map(own).collect(),
        scales: vec![own(&("xp", "50um/V"))],
        ..ReadingChoices::default()
    };
    import_bytes_chosen("x", text.as_bytes(), &choices).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn check(r: &Recording, has_voltage: bool) {
    assert_eq!(r.len(), 40);
    assert!((r.interval() - 250e-6).abs() < 1e-12, "{:e}", r.interval());
    assert!((r.origin.seconds() + 2e-3).abs() < 1e-9, "{}", r.origin);
    for (i, x) in r.proof_mass.iter().enumerate() {
        assert!(
            (x - 50e-6 * (0.4 * i as f64).sin()).abs() < 1e-9,
            "{i}: {x}"
        );
    }
    assert_eq!(r.voltage.is_some(), has_voltage);
    if let Some(v) = &r.voltage {
        assert_eq!((v[0], v[5]), (8.0, -8.0));
    }
}

#[test]
fn two_channels() {
    let both = |t: f64, _: u32, v: f64, x: f64| format!("{t:.6e},{v:.4e},{x:.8e}");
    let cases = [
        ("x-axis,1,2\nsecond,Volt,Volt\n".to_owned() + &rows(both), Some("Keysight InfiniiVision"), "1", "2"),
        (
            "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-2.000000e-03,2.500000e-04\n".to_owned()
                + &rows(|_, i, v, x| format!("{i},{v:.2e},{x:.8e},")),
            Some("Rigol"), "CH1", "CH2",
        ),
        (
            "Time(s),CH1V,CH2V,t0 =-2.0e-03,tInc = 2.5e-04,\n".to_owned() + &rows(both),
            Some("Rigol"), "CH1", "CH2",
        ),
        (
            "CH1V,CH2V,t0 =-2.0e-03,tInc = 2.5e-04,\n".to_owned()
                + &rows(|_, _, v, x| format!("{v:.2e},{x:.8e},,,")),
            Some("Rigol"), "CH1", "CH2",
        ),
        (
            "Record Length,Analog:40\nSample Interval,Analog:0.00025\nVertical Units,CH1:V,CH2:V\n\
             Model Number,SDS1104X-E\nSource,CH1,CH2\nSecond,Volt,Volt\n".to_owned() + &rows(both),
            Some("Siglent"), "CH1", "CH2",
        ),
        (
            "in s,C1 in V,C2 in V\n".to_owned() + &rows(both),
            Some("Rohde & Schwarz"), "C1", "C2",
        ),
        (
            "Model,MSO2024\nHorizontal Units,s\nSample Interval,2.5e-4\nVertical Units,V,V\nLabel,,\n\
             TIME,CH1,CH2\n".to_owned() + &rows(both),
            Some("Tektronix"), "CH1", "CH2",
        ),
        (
            "Revision:,0\nPoints:,40\nXInc:,2.5E-04\nXOrg:,-2.0E-03\nX Units:,second\nY Units:,Volt,Volt\n\
             Data:,\n".to_owned() + &rows(|_, _, v, x| format!("{v:.4e},{x:.8e}")),
            Some("Keysight Infiniium"), "Channel 1", "Channel 2",
        ),
        (
            "Time,Channel A,Channel B\n(ms),(V),(V)\n\n".to_owned()
                + &rows(|t, _, v, x| format!("{:.6},{v},{x:.8}", 1e3 * t)),
            Some("PicoScope"), "Channel A", "Channel B",
        ),
        (
            "Zeit;Kanal A;Kanal B\n(ms);(V);(mV)\n\n".to_owned()
                + &rows(|t, _, v, x| {
                    format!("{:.6};{v:.3};{:.6}", 1e3 * t, 1e3 * x).replace('.', ",")
                }),
            Some("PicoScope"), "Kanal A", "Kanal B",
        ),
        (
            "#Digilent WaveForms Oscilloscope Acquisition\n#Serial Number: SN:0\n\n\
             Time (s),Channel 1 (V),Channel 2 (V)\n".to_owned() + &rows(both),
            Some("Digilent WaveForms"), "Channel 1", "Channel 2",
        ),
        ("T [s],IN1 [V],IN2 [V]\n".to_owned() + &rows(both), Some("Red Pitaya"), "IN1", "IN2"),
        (
            "\"HIOKI MR8847\"\n\"Sampling\",\"250us\"\n\"Time[s]\",\"CH1[V]\",\"CH2[V]\"\n".to_owned()
                + &rows(|t, _, v, x| format!("\"{t:.6e}\",\"{v:.4e}\",\"{x:.8e}\"")),
            Some("Hioki"), "CH1", "CH2",
        ),
        (
            "\"File name\",\"WAVE0001.CSV\",\"V1.00\"\n\"Title comment\",\"\"\n\
             \"Start trigger time\",\"'10-06-30 15:53:03\"\n\"CH\",\"CH1\",\"CH2\",\"LA1\",\n\
             \"Mode\",\"DC\",\"DC\",\"LOGIC\",\n\"Range\",\"50V\",\"2V\",\"-\",\n\
             \"Comment\",\"\",\"meter output\",\"\",\n\"Scaling\",\"Off\",\"Off\",\"-\",\n\
             \"Time\",\"CH1[V]\",\"CH2[V]\",\"LA1\",\n".to_owned()
                + &rows(|t, _, v, x| format!("{t:.9E},{v:.5E},{x:.8E},1,")),
            Some("Hioki"), "CH1", "meter output",
        ),
        (
            "\"File name\",\"WAVE0001.CSV\",\"V 1.00\"\n\"Title comment\",\"\"\n\
             \"Trigger Time\",\"'12-07-01 09:14:03\"\n\
             \"Ch\",\"Mode\",\"Range\",\"Comment\",\"Scaling\",\"Ratio\",\"Offset\"\n\
             \"CH-1\",\"Voltage\",\"10V\",\"amplifier\",\"Off\",\"-\",\"-\"\n\
             \"CH-2\",\"Voltage\",\"1V\",\"\",\"Off\",\"-\",\"-\"\n\
             \"Time\",\"CH-1[V]\",\"CH-2[V]\"\n".to_owned()
                + &rows(|t, _, v, x| format!("{t:.9E},{v:.5E},{x:.8E}")),
            Some("Hioki"), "amplifier", "CH-2",
        ),
    ];
    for (text, maker, v, xp) in cases {
        check(&read(&text, &[("V", v), ("xp", xp)], maker), true);
    }
}

/// WaveForms writes no times where they are switched off: the rate says them.
#[test]
fn a_rate_in_the_comments_is_the_clock() {
    for rate in ["4000Hz", "4kHz", "4e3Hz"] {
        let text = format!(
            "#Digilent WaveForms Oscilloscope Acquisition\n#Sample rate: {rate}\n#Samples: 40\n\n\
             Channel 1 (V),Channel 2 (V)\n"
        ) + &rows(|_, _, v, x| format!("{v:.4e},{x:.8e}"));
        let r = read(
            &text,
            &[("V", "Channel 1"), ("xp", "Channel 2")],
            Some("Digilent WaveForms"),
        );
        assert_eq!(r.len(), 40, "{rate}");
        assert!((r.interval() - 250e-6).abs() < 1e-15, "{rate}");
    }
}

/// Volts or divisions of the screen: Red Pitaya does not say, so it is asked.
#[test]
fn inputs_without_a_unit_are_asked_about() {
    let text = "Time[ms], IN1, IN2\n".to_owned()
        + &rows(|t, _, v, x| format!("{:.6}, {v:.4}, {x:.8}", 1e3 * t));
    let error = fails(text.as_bytes()).to_string();
    assert!(error.contains("--column"), "{error}");
    let own = |a: &str, b: &str| (a.to_owned(), b.to_owned());
    let choices = ReadingChoices {
        columns: vec![own("V", "IN1"), own("xp", "IN2")],
        units: vec![own("V", "V"), own("xp", "V")],
        scales: vec![own("xp", "50um/V")],
        ..ReadingChoices::default()
    };
    check(
        &import_bytes_chosen("x", text.as_bytes(), &choices).unwrap(),
        true,
    );
    // Times below a millisecond are written in microseconds, as some versions do.
    let mixed = "Time[ms], IN1, IN2\n".to_owned()
        + &rows(|t, _, v, x| {
            let factor = if t.abs() < 0.9e-3 { 1e6 } else { 1e3 };
            format!("{:.6}, {v:.4}, {x:.8}", factor * t)
        });
    let error = import_bytes_chosen("x", mixed.as_bytes(), &choices).unwrap_err();
    assert!(error.to_string().contains("unit"), "{error}");
}

#[test]
fn one_channel() {
    let names = [
        "Record Length",
        "Sample Interval",
        "Source",
        "Vertical Units",
        "Horizontal Units",
    ];
    let values = ["40", "2.5e-04", "CH2", "V", "s"];
    let beside = rows(|t, i, _, x| {
        let i = i as usize;
        let name = names.get(i).copied().unwrap_or("");
        format!(
            "{name},{},,{t:.9},  {x:.8},",
            values.get(i).copied().unwrap_or("")
        )
    });
    check(&read(&beside, &[], Some("Tektronix TDS")), false);
    let head = "LECROYWS3024,1,Waveform\nSegments,1,SegmentSize,40\nSegment,TrigTime,TimeSinceSegment1\n\
        #1,01-Jan-2026 12:00:00,0                 \nTime,Ampl\n";
    let one = rows(|t, _, _, x| format!("{t:.9},{x:.8}"));
    check(&read(&format!("{head}{one}"), &[], Some("LeCroy")), false);
    // Two segments are two recordings.
    let choices = ReadingChoices {
        scales: vec![("xp".to_owned(), "50um/V".to_owned())],
        trial: Some(2),
        ..ReadingChoices::default()
    };
    let two = format!("{head}{one}{one}");
    check(
        &import_bytes_chosen("x", two.as_bytes(), &choices).unwrap(),
        false,
    );
}

#[test]
fn tracker_files_give_the_height() {
    let body = rows(|t, _, v, x| format!("{:.6E}\t{:.6E}\t{x:.6E}", t + 2e-3, 1e-3 * v));
    let r = import_bytes_auto("x", format!("mass A\nt\tx\ty\n{body}").as_bytes()).unwrap();
    assert!((r.proof_mass[1] - 0.4f64.sin()).abs() < 1e-6);
    assert!(r.warnings.iter().any(|w| w.message.contains("sideways")));
    // Without the program's lines the unit is not known.
    let error = fails(format!("t\tx\ty\n{body}").as_bytes()).to_string();
    assert!(error.contains("--unit xp="), "{error}");
}
