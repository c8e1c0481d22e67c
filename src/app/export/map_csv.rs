//! A map as CSV: a row for each point, with the values of both axes and of all measures.

use std::fmt::Write;

use crate::explore::map::{MapRequest, MapResult, PointState};
use crate::explore::measures::{MeasureId, Regime};

/// The text. Lines that begin with # say what it is; a point that is impossible has its reason, one
/// that is only filled or not computed says so.
#[must_use]
pub fn text(request: &MapRequest, map: &MapResult) -> String {
    let mut text = format!(
        "# impactscope {} map\n# device: {}\n# drive: {}\n",
        env!("CARGO_PKG_VERSION"),
        request.model.name,
        request.drive
    );
    let with_unit = |name: &str, unit: &str| match unit {
        "" => name.to_owned(),
        unit => format!("{name} [{unit}]"),
    };
    let axes = map.axes.iter().map(|axis| with_unit(&axis.id, &axis.unit));
    let measures = map.measures.iter().map(|measure| {
        let spec = measure.spec();
        with_unit(spec.id, spec.unit)
    });
    let head: Vec<String> = axes.chain(measures).collect();
    text += &head.join(",");
    text += ",state,regime in words,reason\n";
    for (index, state) in map.states.iter().enumerate() {
        let own = request.values_at(index).into_iter().map(Some);
        let values = map
            .values
            .iter()
            .map(|all| Some(all[index]).filter(|v| v.is_finite()));
        for value in own.chain(values) {
            // Writing to a string does not fail.
            let _ = match value {
                Some(value) => write!(text, "{value},"),
                None => write!(text, ","),
            };
        }
        let state = match state {
            PointState::Pending => "pending",
            PointState::Filled => "filled",
            PointState::Solved => "solved",
            PointState::Hole => "impossible",
        };
        let regime = map.of(MeasureId::Regime).map(|all| all[index]);
        let regime = regime.filter(|code| code.is_finite());
        let regime = regime.and_then(|code| Regime::from_code(code as u32));
        let regime = regime.map_or_else(String::new, Regime::label);
        let reason = map.holes.get(&index).map_or("", String::as_str);
        let _ = writeln!(text, "{state},{},{}", quoted(&regime), quoted(reason));
    }
    text
}

/// A field with commas or quotes in quotes (RFC 4180).
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::super::map_csv::*;
    use crate::explore::map::{Axis, MapPoint, MapUpdate, Pass};
    use crate::model::drive::Waveform;
    use crate::model::preset::Preset;

    #[test]
    fn each_point_has_a_row_and_a_hole_its_reason() {
        let model = Preset::default().model;
        let drive = Waveform::parse("square:15Hz:8V", 0.1).unwrap();
        let of = (&model, &drive);
        let axes = vec![
            Axis::new("frequency", of, (10.0, 20.0), 2).unwrap(),
            Axis::new("amplitude", of, (4.0, 8.0), 2).unwrap(),
        ];
        let measures = vec![MeasureId::Regime, MeasureId::Peak];
        let request = MapRequest::new(model, drive, axes, measures);
        let mut map = MapResult::pending(&request);
        let point = |index, values| MapPoint {
            index,
            values,
            is_filled: false,
        };
        map.apply(&MapUpdate {
            pass: Pass::Rest,
            points: vec![
                point(0, Ok(vec![1.0, f64::NAN])),
                point(3, Err("no, \"never\"".to_owned())),
            ],
            solved: 2,
            total: 4,
        });
        let text = text(&request, &map);
        let rows: Vec<&str> = text.lines().filter(|l| !l.starts_with('#')).collect();
        assert!(rows[0].starts_with("frequency [Hz],amplitude [V],regime,peak [m],state"));
        assert_eq!(rows[1], "10,4,1,,solved,taps once,");
        assert_eq!(rows[2], "20,4,,,pending,,");
        assert_eq!(rows[4], "20,8,,,impossible,,\"no, \"\"never\"\"\"");
    }
}
