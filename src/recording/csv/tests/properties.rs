use proptest::prelude::*;

use super::{PLAIN, auto, same};
use crate::recording::csv::*;
use crate::recording::grid::TimeAxis;

fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![-1e-3..1e-3, -10.0..10.0, Just(0.0), prop::num::f64::NORMAL]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = import_bytes_auto("x", &bytes);
    }

    #[test]
    fn arbitrary_text_never_panics(text in "[-0-9tTVxp \\[\\]()um/,;.\t\n\r\"#%eE+nN]{0,300}") {
        let _ = import_bytes_auto("x", text.as_bytes());
        let _ = import_bytes_auto("x", format!("t [s],V [V],xp [um]\n{text}").as_bytes());
    }

    #[test]
    fn damaged_files_never_panic(at in 0usize..80, byte in any::<u8>(), cut in 0usize..80) {
        let mut bytes = PLAIN.as_bytes().to_vec();
        let n = bytes.len();
        bytes[at % n] = byte;
        bytes.truncate(cut.max(1) % n + 1);
        let _ = import_bytes_auto("x", &bytes);
    }

    #[test]
    fn what_is_written_reads_back_identical(
        rows in prop::collection::vec((1e-9..1.0f64, finite(), finite(), finite()), 2..40),
        with_v in any::<bool>(), with_xc in any::<bool>(), start in -10.0..10.0f64,
    ) {
        let mut t = start;
        let time: Vec<f64> = rows.iter().map(|r| { t += r.0; t }).collect();
        let v: Vec<f64> = rows.iter().map(|r| r.1).collect();
        let xp: Vec<f64> = rows.iter().map(|r| r.2 * 1e-10).collect();
        let xc: Vec<f64> = rows.iter().map(|r| r.3 * 1e-10).collect();
        let mut out = Vec::new();
        write_csv(&mut out, TimeAxis::Samples(&time), with_v.then_some(&v), &xp, with_xc.then_some(&xc)).unwrap();
        // With the file's own zero.
        let mut settings = preview_bytes("x", &out).unwrap().settings;
        settings.time_zero = TimeZero::File;
        let r = import_bytes("x", &out, &settings).unwrap();
        prop_assert_eq!(&r.time, &time);
        prop_assert_eq!(&r.proof_mass, &xp);
        prop_assert_eq!(r.voltage.clone(), with_v.then_some(v));
        prop_assert_eq!(r.cantilever.clone(), with_xc.then_some(xc));
        let mut again = Vec::new();
        write_recording(&mut again, &r).unwrap();
        prop_assert_eq!(again, out);
    }

    #[test]
    fn order_units_and_delimiter_do_not_matter(
        rows in prop::collection::vec((1u32..50, -9000i32..9000, -90000i32..90000, -90000i32..90000), 3..30),
        order in Just([0usize, 1, 2, 3]).prop_shuffle(),
        delimiter in 0usize..3, comma in any::<bool>(), crlf in any::<bool>(), mark in any::<bool>(),
        t_unit in 0usize..3, v_unit in 0usize..2, xp_unit in 0usize..4, xc_unit in 0usize..4,
    ) {
        // Whole numbers of us, mV and nm, so that every unit writes them exactly.
        let scaled = |value: i64, power: u32| {
            let (sign, value) = (if value < 0 { "-" } else { "" }, value.unsigned_abs());
            let ten = 10u64.pow(power);
            if power == 0 { format!("{sign}{value}") }
            else { format!("{sign}{}.{:0width$}", value / ten, value % ten, width = power as usize) }
        };
        let t_units = [("s", 6), ("ms", 3), ("us", 0)];
        let v_units = [("V", 3), ("mV", 0)];
        let x_units = [("m", 9), ("mm", 6), ("um", 3), ("nm", 0)];
        let d = [",", ";", "\t"][delimiter];
        let comma = comma && delimiter != 0;
        let end = if crlf { "\r\n" } else { "\n" };
        let line = |cells: [String; 4]| order.map(|i| cells[i].clone()).join(d) + end;
        let mut text = String::from(if mark { "\u{feff}" } else { "" });
        text += &line([
            format!("t [{}]", t_units[t_unit].0), format!("V ({})", v_units[v_unit].0),
            format!("xp / {}", x_units[xp_unit].0), format!("xc [{}]", x_units[xc_unit].0),
        ]);
        let mut plain = String::from("t [us],V [mV],xp [nm],xc [nm]\n");
        let mut t = 0i64;
        for (step, v, xp, xc) in rows {
            t += i64::from(step);
            let cells = [
                scaled(t, t_units[t_unit].1), scaled(v.into(), v_units[v_unit].1),
                scaled(xp.into(), x_units[xp_unit].1), scaled(xc.into(), x_units[xc_unit].1),
            ];
            let row = line(cells);
            text += &if comma { row.replace('.', ",") } else { row };
            plain += &format!("{t},{v},{xp},{xc}\n");
        }
        // Where each number has three digits behind its comma, the mark may be between thousands.
        let choices = ReadingChoices {
            decimal: Some(if comma { Decimal::Comma } else { Decimal::Point }),
            ..ReadingChoices::default()
        };
        same(&import_bytes_chosen("x", text.as_bytes(), &choices).unwrap(), &auto(&plain));
    }
}
