//! Keeps the present curve, to compare later ones with.

use std::sync::Arc;

use crate::app::services::Services;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::kept_curve::{
    KeptCurve, MAX_KEPT_CURVES, RunOrigin, distinct_name, free_color, numbered_name, same_origin,
};
use crate::app::simulation::kept::KeptRun;
use crate::app::simulation::snapshot::Snapshot;
use crate::app::workspaces::tune::differences::differences;
use crate::model::Model;
use crate::model::drive::DriveReading;

/// Most parameters that a name is made of.
const MAX_NAMED_PARAMETERS: usize = 3;

/// Keeps the present curve with what it was computed from.
pub fn keep(services: &mut Services) {
    let Some(snapshot) = services.state.snapshot.clone() else {
        return;
    };
    let origin = Arc::new(origin(services, &snapshot));
    let kept = &services.state.setup.kept;
    if let Some(same) = kept.iter().find(|c| same_origin(&c.origin, &origin)) {
        let text = format!(
            "This curve is kept already, as {:?}: change a parameter or the drive first.",
            same.name
        );
        return services.notice(false, text);
    }
    if kept.len() >= MAX_KEPT_CURVES {
        let text = format!(
            "{MAX_KEPT_CURVES} curves are kept, more are not possible: remove one under Kept curves first."
        );
        return services.notice(true, text);
    }
    let curve = KeptCurve {
        name: usual_name(kept, &services.state.setup.original.model, &snapshot.model),
        color: free_color(kept),
        visible: true,
        origin: Arc::clone(&origin),
    };
    let state = &mut services.state;
    state.setup.kept.push(curve);
    // It is drawn at once; its numbers follow in the background, those of a live run never.
    let is_complete = origin.live.is_some();
    state.kept_runs.put(KeptRun {
        origin,
        run: Ok(snapshot),
        is_complete,
    });
}

/// What is needed to compute the curve again.
fn origin(services: &Services, snapshot: &Snapshot) -> RunOrigin {
    let setup = &services.state.setup;
    let mut preset = setup.preset.clone();
    preset.model = snapshot.model.as_ref().clone();
    let Some((drive, duration)) = snapshot.run_of.clone() else {
        return RunOrigin {
            preset,
            drive: setup.drive.clone(),
            shift: 0.0,
            reading: DriveReading::default(),
            duration: setup.duration,
            live: Some(snapshot.generation),
        };
    };
    let recorded = match &setup.drive {
        DriveChoice::Recorded(id) => {
            let making = services.recorded_drive.making_of(*id, &drive);
            making.map(|making| (*id, making))
        }
        DriveChoice::Waveform(_) => None,
    };
    let (drive, shift, reading) = match recorded {
        Some((id, making)) => (DriveChoice::Recorded(id), making.shift, making.reading),
        None => (DriveChoice::Waveform(drive), 0.0, DriveReading::default()),
    };
    RunOrigin {
        preset,
        drive,
        shift,
        reading,
        duration,
        live: None,
    }
}

/// A name for a curve of `model`: by what differs from the preset, else by what differs from the
/// curve kept last, else a number.
fn usual_name(kept: &[KeptCurve], preset: &Model, model: &Model) -> String {
    let last = kept.last().map(|curve| &curve.origin.preset.model);
    let of = |before: &Model| {
        let rows = differences(before, model);
        let is_short = (1..=MAX_NAMED_PARAMETERS).contains(&rows.len());
        let part = |[symbol, _, value]: &[String; 3]| format!("{symbol} {value}");
        let name = rows.iter().map(part).collect::<Vec<_>>().join(", ");
        let is_taken = kept.iter().any(|curve| curve.name == name);
        (is_short && !is_taken).then_some(name)
    };
    let name = of(preset).or_else(|| last.and_then(of));
    let name = name.unwrap_or_else(|| numbered_name(kept));
    distinct_name(kept, None, &name)
}

#[cfg(test)]
mod tests {
    use super::super::kept_curves::*;
    use crate::app::files::built_in;
    use crate::app::files::open::Files;
    use crate::app::setup::view::View;
    use crate::app::state::State;
    use crate::model::drive::Waveform;
    use crate::model::parameter::ParameterId;
    use crate::sim::Trace;
    use std::time::Duration;

    /// A window's services that show a run of the present device.
    fn services() -> Services {
        let state = State::new(built_in::setup(), View::default());
        Services::new(state, Files::new(|| {}))
    }

    /// Sets a parameter and shows a run of the device.
    fn run(services: &mut Services, id: ParameterId, value: f64) {
        let state = &mut services.state;
        state.setup.preset.model.parameters.set(id, value);
        let model = Arc::new(state.setup.preset.model.clone());
        let trace = Arc::new(Trace::default());
        let mut snapshot = Snapshot::new(1, &model, trace, Vec::new(), Duration::ZERO);
        snapshot.run_of = Some((Waveform::Rest, 0.4));
        state.snapshot = Some(Arc::new(snapshot));
    }

    fn names(services: &Services) -> Vec<&str> {
        let kept = &services.state.setup.kept;
        kept.iter().map(|curve| curve.name.as_str()).collect()
    }

    #[test]
    fn a_curve_is_named_by_what_differs_from_the_preset() {
        let mut services = services();
        keep(&mut services);
        assert!(names(&services).is_empty(), "nothing is simulated yet");
        run(&mut services, ParameterId::Alpha, 0.378);
        keep(&mut services);
        run(&mut services, ParameterId::Cs, 2.1e-21);
        keep(&mut services);
        run(&mut services, ParameterId::Gp, 30e-6);
        keep(&mut services);
        let found = names(&services);
        assert_eq!(found[0], "kept 1");
        assert!(found[1].starts_with("Cs 2.1e-21"), "{found:?}");
        assert!(found[2].starts_with("Cs 2.1e-21"), "{found:?}");
        assert!(found[2].ends_with("gp 30 \u{b5}m"), "{found:?}");
        let colors: Vec<usize> = services.state.setup.kept.iter().map(|c| c.color).collect();
        assert_eq!(colors, [0, 1, 2]);
    }

    #[test]
    fn the_same_curve_is_not_kept_twice_and_the_limit_is_said() {
        let mut services = services();
        run(&mut services, ParameterId::Alpha, 0.5);
        keep(&mut services);
        run(&mut services, ParameterId::Alpha, 0.5);
        keep(&mut services);
        assert_eq!(names(&services).len(), 1);
        let said = |services: &Services| services.state.notices.last().unwrap().text.clone();
        assert!(
            said(&services).contains("kept already"),
            "{}",
            said(&services)
        );
        for i in 1..=MAX_KEPT_CURVES {
            run(&mut services, ParameterId::Alpha, 0.5 + 0.01 * i as f64);
            keep(&mut services);
        }
        assert_eq!(names(&services).len(), MAX_KEPT_CURVES);
        assert!(
            said(&services).contains("remove one under Kept curves"),
            "{}",
            said(&services)
        );
    }
}
