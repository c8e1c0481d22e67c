//! A simulated run as CSV: time, voltage and readings as in a recording, so that the file can be
//! opened as one, and then velocities and forces.

use crate::app::simulation::snapshot::Snapshot;
use crate::recording::TimeAxis;
use crate::recording::csv::write_csv;
use crate::sim::{ForceTraces, Options, Trace, simulate};

/// A force's name in the header, and its values.
type ForceColumn = (&'static str, fn(&ForceTraces) -> &Vec<f64>);

/// The forces in the order of their columns \[N\].
const FORCES: [ForceColumn; 6] = [
    ("F_drive", |f| &f.drive),
    ("F_film", |f| &f.film),
    ("F_effects", |f| &f.effects),
    ("F_adhesion", |f| &f.adhesion),
    ("F_ground", |f| &f.ground),
    ("F_pull_off", |f| &f.pull_off),
];

/// Why a run is not written without its forces.
const MISSING_FORCES_REASON: &str =
    "the forces of this run cannot be computed again; show the plot Forces and export once more";

/// Largest difference of a reading between a run and its repetition \[m\]: a thousandth of what any
/// sensor resolves. The times of the samples may differ in their last digit.
const REPEATED_RUN_TOLERANCE: f64 = 1e-12;

/// The run in view as CSV: `t [s],V [V],xp [um],xc [um]` as for a recording, then velocities
/// [m/s] and forces \[N\]. A run whose forces no picture needed is simulated again with them.
///
/// # Errors
/// Why the run cannot be written.
pub fn text(snapshot: &Snapshot) -> Result<Vec<u8>, String> {
    let trace = &*snapshot.trace;
    match &trace.forces {
        Some(forces) => table(trace, forces),
        None => match forces_of(snapshot) {
            Some(forces) => table(trace, &forces),
            None => Err(MISSING_FORCES_REASON.to_owned()),
        },
    }
}

/// The forces of a run that was simulated without; `None` if it cannot be repeated.
fn forces_of(snapshot: &Snapshot) -> Option<ForceTraces> {
    let (drive, duration) = snapshot.run_of.as_ref()?;
    let rate = 1.0 / snapshot.trace.dt;
    // The rate that was asked for is one of these: its reciprocal was rounded.
    let rates = [rate.round(), rate, rate.next_up(), rate.next_down()];
    let near = rates.into_iter().filter(|r| (r - rate).abs() < 1e-9 * rate);
    near.into_iter().find_map(|rate| {
        let options = Options {
            rate,
            forces: true,
            ..Options::default()
        };
        let again = simulate(&snapshot.model, drive, *duration, &options).ok()?;
        let (now, before) = (&again.proof_mass, &snapshot.trace.proof_mass);
        let mut pairs = now.iter().zip(before);
        let is_same = now.len() == before.len()
            && pairs.all(|(now, before)| (now - before).abs() <= REPEATED_RUN_TOLERANCE);
        is_same.then_some(again.forces).flatten()
    })
}

fn table(trace: &Trace, forces: &ForceTraces) -> Result<Vec<u8>, String> {
    let mut readings = Vec::new();
    let cantilever = (!trace.cantilever.is_empty()).then_some(trace.cantilever.as_slice());
    write_csv(
        &mut readings,
        TimeAxis::Samples(&trace.times()),
        Some(&trace.voltage),
        &trace.proof_mass,
        cantilever,
    )
    .map_err(|error| error.to_string())?;
    let mut columns: Vec<(&str, &str, &[f64])> = vec![("vp", "m/s", &trace.proof_mass_velocity)];
    if cantilever.is_some() {
        columns.push(("vc", "m/s", &trace.cantilever_velocity));
    }
    for (name, values) in FORCES {
        columns.push((name, "N", values(forces)));
    }
    let mut text = Vec::with_capacity(2 * readings.len() + 256);
    for (line, cells) in readings.split(|&byte| byte == b'\n').enumerate() {
        if cells.is_empty() {
            continue;
        }
        text.extend_from_slice(cells);
        for (name, unit, values) in &columns {
            let cell = match line.checked_sub(1).map(|row| values.get(row)) {
                None => format!(",{name} [{unit}]"),
                Some(Some(value)) if value.is_finite() => format!(",{value:e}"),
                Some(_) => ",NaN".to_owned(),
            };
            text.extend_from_slice(cell.as_bytes());
        }
        text.push(b'\n');
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use super::super::trace_csv::*;
    use crate::model::drive::Waveform;
    use crate::model::preset::Preset;
    use crate::recording::csv::import_bytes_auto;

    fn snapshot(forces: bool) -> Snapshot {
        let model = Arc::new(Preset::default().model);
        let drive = Waveform::parse("square:50Hz:8V", 0.02).unwrap();
        let options = Options {
            forces,
            ..Options::default()
        };
        let trace = simulate(&model, &drive, 0.02, &options).unwrap();
        let mut snapshot = Snapshot::new(1, &model, Arc::new(trace), &[], Duration::ZERO);
        snapshot.run_of = Some((drive, 0.02));
        snapshot
    }

    #[test]
    fn velocities_and_forces_are_written_whatever_pictures_are_shown() {
        for forces in [true, false] {
            let snapshot = snapshot(forces);
            let bytes = text(&snapshot).unwrap();
            let written = String::from_utf8(bytes).unwrap();
            let mut lines = written.lines();
            assert_eq!(
                lines.next().unwrap(),
                "t [s],V [V],xp [um],xc [um],vp [m/s],vc [m/s],F_drive [N],F_film [N],\
                 F_effects [N],F_adhesion [N],F_ground [N],F_pull_off [N]"
            );
            let row: Vec<f64> = lines
                .nth(700)
                .unwrap()
                .split(',')
                .map(|cell| cell.parse().unwrap())
                .collect();
            let trace = &snapshot.trace;
            assert_eq!(row.len(), 12);
            assert_eq!(row[4], trace.proof_mass_velocity[700]);
            assert_eq!(row[5], trace.cantilever_velocity[700]);
            assert!(row[6] != 0.0, "the piezo drive");
            if let Some(forces) = &trace.forces {
                assert_eq!(row[7], forces.film[700]);
            }
        }
    }

    #[test]
    fn the_file_opens_as_a_recording_with_the_same_readings() {
        let snapshot = snapshot(true);
        let bytes = text(&snapshot).unwrap();
        let recording = import_bytes_auto("trace.csv", &bytes).unwrap();
        assert_eq!(recording.proof_mass, snapshot.trace.proof_mass);
        assert_eq!(
            recording.cantilever.as_deref(),
            Some(snapshot.trace.cantilever.as_slice())
        );
        assert_eq!(
            recording.voltage.as_deref(),
            Some(snapshot.trace.voltage.as_slice())
        );
    }
}
