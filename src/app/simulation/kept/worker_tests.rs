use crate::app::files::built_in;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::Role;
use crate::app::setup::own_drive::OwnDrive;
use crate::app::simulation::experiments::compare_all;
use crate::app::simulation::kept::worker::*;
use crate::app::simulation::worker::tests::BROKEN;
use crate::model::drive::DriveReading;
use crate::model::effects::ActiveEffect;
use crate::model::parameter::ParameterId;

/// The device of a setup, as it is kept with its drive.
fn origin(setup: &Setup) -> Arc<RunOrigin> {
    Arc::new(RunOrigin {
        preset: setup.preset.clone(),
        drive: setup.drive.clone(),
        shift: 0.0,
        reading: Default::default(),
        duration: 0.1,
        live: None,
    })
}

fn request(origins: &[&Arc<RunOrigin>], overlays: &[Overlay]) -> KeptRequest {
    let task = |origin: &&Arc<RunOrigin>| KeptTask {
        origin: Arc::clone(origin),
        known: None,
    };
    KeptRequest {
        curves: origins.iter().map(task).collect(),
        overlays: overlays.to_vec(),
    }
}

/// The next complete result of `origin` that `is_it` accepts.
fn wait(
    worker: &KeptWorker,
    origin: &Arc<RunOrigin>,
    is_it: impl Fn(&Snapshot) -> bool,
) -> Result<Arc<Snapshot>, String> {
    let started = Instant::now();
    while started.elapsed() < Duration::from_secs(120) {
        let results = worker.results();
        let mut complete = results.into_iter().filter(|run| run.is_complete);
        let is_done = |run: &KeptRun| {
            same_origin(&run.origin, origin) && run.run.as_ref().ok().is_none_or(|run| is_it(run))
        };
        if let Some(found) = complete.find(is_done) {
            return found.run;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("no result");
}

#[test]
fn a_kept_curve_has_the_numbers_of_its_own_device_and_is_simulated_once() {
    let worker = KeptWorker::start(|| {}).unwrap();
    let mut setup = built_in::setup();
    setup.overlays.truncate(1);
    let mut other = setup.clone();
    other.preset.model.parameters.set(ParameterId::Alpha, 0.6);
    let (first, second) = (origin(&setup), origin(&other));
    worker.send(request(&[&first, &second], &setup.overlays));
    let is_compared = |run: &Snapshot| run.comparisons.len() == 1;
    // The second one is completed last; both results may be in one batch.
    let run = wait(&worker, &second, is_compared).unwrap();
    assert_eq!(run.model.parameters[ParameterId::Alpha], 0.6);
    assert!(run.features.is_some());
    let (drive, _) = run.run_of.clone().unwrap();
    let expected = compare_all(&run.model, &drive, &run.trace, &setup.overlays);
    let (own, expected) = (run.comparisons[0].misfit(), expected[0].misfit());
    // What the readings decide of the drive can only lower it.
    assert!(
        own.unwrap() <= expected.unwrap(),
        "{own:?} and {expected:?}"
    );
    assert!(
        own.unwrap() > 0.5 * expected.unwrap(),
        "{own:?} and {expected:?}"
    );
    let mut shifted = setup.overlays.clone();
    shifted[0].alignment.xp_offset += 3e-6;
    shifted[0].estimates.zeros = false;
    worker.send(request(&[&first, &second], &shifted));
    let moved = wait(&worker, &second, is_compared).unwrap();
    assert!(
        Arc::ptr_eq(&moved.trace, &run.trace),
        "it was simulated again"
    );
    assert_ne!(moved.comparisons[0].misfit(), own);
    let mut hidden = shifted;
    hidden[0].visible = false;
    worker.send(request(&[&second], &hidden));
    let alone = wait(&worker, &second, |run| run.comparisons.is_empty()).unwrap();
    assert!(Arc::ptr_eq(&alone.trace, &run.trace));
}

#[test]
fn a_known_run_is_not_simulated_again() {
    let worker = KeptWorker::start(|| {}).unwrap();
    let origin = origin(&built_in::setup());
    worker.send(request(&[&origin], &[]));
    let run = wait(&worker, &origin, |_| true).unwrap();
    let another = KeptWorker::start(|| {}).unwrap();
    let mut again = request(&[&origin], &[]);
    again.curves[0].known = Some(Arc::clone(&run));
    another.send(again);
    let known = wait(&another, &origin, |_| true).unwrap();
    assert!(Arc::ptr_eq(&known.trace, &run.trace));
}

#[test]
fn what_cannot_be_shown_gives_its_reason_and_the_thread_goes_on() {
    let worker = KeptWorker::start(|| {}).unwrap();
    let setup = built_in::setup();
    let mut broken = setup.clone();
    broken.preset.model.effects.push(ActiveEffect::new(&BROKEN));
    let broken = origin(&broken);
    worker.send(request(&[&broken], &[]));
    let reason = wait(&worker, &broken, |_| true).unwrap_err();
    assert!(reason.contains("on purpose"), "{reason}");
    let recorded = Arc::new(RunOrigin {
        drive: DriveChoice::Recorded(77),
        ..(*origin(&setup)).clone()
    });
    worker.send(request(&[&recorded], &setup.overlays));
    let reason = wait(&worker, &recorded, |_| true).unwrap_err();
    assert!(reason.contains("is missing"), "{reason}");
    let mut refused = setup.clone();
    refused.preset.model.parameters.set(ParameterId::Gp, 1e-6);
    let refused = origin(&refused);
    let good = origin(&setup);
    worker.send(request(&[&refused, &good], &setup.overlays));
    wait(&worker, &good, |_| true).unwrap();
}

#[test]
fn a_kept_curve_keeps_the_reading_of_its_voltage() {
    let mut setup = built_in::setup();
    let id = setup.overlays[0].id;
    let with = |reading| RunOrigin {
        drive: DriveChoice::Recorded(id),
        reading,
        ..(*origin(&setup)).clone()
    };
    let (points, recognised) = (
        with(DriveReading::PointByPoint),
        with(DriveReading::Recognised),
    );
    let before = drive_of(&points, &setup.overlays).unwrap();
    assert_ne!(before, drive_of(&recognised, &setup.overlays).unwrap());
    setup.overlays[0].drive = OwnDrive::Measured(DriveReading::Smoothed);
    assert_eq!(drive_of(&points, &setup.overlays).unwrap(), before);
}

#[test]
fn a_colour_or_a_role_asks_for_nothing_new() {
    let setup = built_in::setup();
    let origin = origin(&setup);
    let before = request(&[&origin], &setup.overlays);
    let mut after = before.clone();
    after.overlays[0].color += 1;
    after.overlays[0].role = Some(Role::HeldOut);
    assert_eq!(before, after);
    after.overlays[0].alignment.time_shift += 1e-4;
    assert_ne!(before, after);
}
