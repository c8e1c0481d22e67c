use crate::app::files::built_in;
use crate::app::setup::current_setup::Setup;
use crate::app::simulation::worker::*;
use crate::model::drive::Waveform;
use crate::model::effects::{ActiveEffect, EffectSpec, Need};
use crate::model::parameter::ParameterId;

/// What the window asks for a setup under a square wave of 15 Hz.
pub fn request(setup: &Setup) -> SimulationRequest {
    SimulationRequest {
        model: Arc::new(setup.preset.model.clone()),
        drive: Waveform::parse("square:15Hz:8V", 0.1).unwrap(),
        duration: 0.1,
        forces: false,
        overlays: setup.overlays.clone(),
        from_steady: false,
        mode: Mode::WholeSpan,
        slow_down: 0.1,
        paused: false,
        scrub: None,
        restarts: 0,
        steps: 0,
    }
}

/// Waits until `done` finds what it looks for among the events.
fn wait<T>(worker: &Worker, mut done: impl FnMut(&WorkerEvent) -> Option<T>) -> T {
    let started = Instant::now();
    while started.elapsed() < Duration::from_secs(60) {
        if let Some(found) = worker.events().iter().find_map(&mut done) {
            return found;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("the worker has nothing to say");
}

fn alpha(snapshot: &Snapshot) -> f64 {
    snapshot.model.parameters[ParameterId::Alpha]
}

#[test]
fn the_newest_request_wins() {
    let worker = Worker::start(|| {}).unwrap();
    let mut setup = built_in::setup();
    // A fast drag: hundreds of requests during one simulation.
    for i in 0..=300 {
        let value = 0.1 + 0.001 * f64::from(i);
        setup.preset.model.parameters.set(ParameterId::Alpha, value);
        worker.send(request(&setup));
    }
    // The curve comes first and its features follow; both may be in one batch of events.
    let (mut shown, mut first) = (0, None);
    let complete = wait(&worker, |event| match event {
        WorkerEvent::Snapshot(snapshot) => {
            shown += 1;
            if alpha(snapshot) != 0.4 {
                return None;
            }
            first.get_or_insert_with(|| Arc::clone(snapshot));
            snapshot.features.is_some().then(|| Arc::clone(snapshot))
        }
        _ => None,
    });
    assert!(shown < 150, "{shown} of 301 wishes were worked off");
    let first = first.unwrap();
    assert!(first.comparisons[0].comparison.as_ref().unwrap().rms > 1e-8);
    assert_eq!(complete.generation, first.generation);
}

/// An effect that panics.
pub static BROKEN: EffectSpec = EffectSpec {
    id: "broken",
    name: "broken",
    sentence: "Panics.",
    law: "",
    source: "",
    needs: Need::Nothing,
    parameters: &[],
    build: |_, _| panic!("on purpose"),
    ..EffectSpec::DEFAULT
};

#[test]
fn a_panic_is_reported_and_the_worker_continues() {
    let worker = Worker::start(|| {}).unwrap();
    let setup = built_in::setup();
    let mut broken = setup.clone();
    broken.preset.model.effects.push(ActiveEffect::new(&BROKEN));
    for mode in [Mode::WholeSpan, Mode::Live] {
        worker.send(SimulationRequest {
            mode,
            ..request(&broken)
        });
        let text = wait(&worker, |event| match event {
            WorkerEvent::Broken(text) => Some(text.clone()),
            _ => None,
        });
        assert_eq!(text, "on purpose");
        worker.send(request(&setup));
        wait(&worker, |event| {
            matches!(event, WorkerEvent::Snapshot(_)).then_some(())
        });
    }
}

#[test]
fn an_invalid_value_is_refused_with_its_parameter() {
    let worker = Worker::start(|| {}).unwrap();
    let mut setup = built_in::setup();
    setup.preset.model.parameters.set(ParameterId::Gp, 1e-6);
    worker.send(request(&setup));
    let error = wait(&worker, |event| match event {
        WorkerEvent::Refused(error) => Some(error.clone()),
        _ => None,
    });
    assert_eq!(error.parameter(), Some("gp"));
}

#[test]
fn a_live_run_keeps_its_speed_applies_changes_and_can_be_paused() {
    let worker = Worker::start(|| {}).unwrap();
    let mut setup = built_in::setup();
    let live = |setup: &Setup, paused| SimulationRequest {
        mode: Mode::Live,
        paused,
        ..request(setup)
    };
    worker.send(live(&setup, false));
    let at = |event: &WorkerEvent| match event {
        WorkerEvent::Snapshot(snapshot) => snapshot.live.map(|live| (live.time, alpha(snapshot))),
        _ => None,
    };
    let (first, _) = wait(&worker, at);
    let (later, _) = wait(&worker, |event| {
        at(event).filter(|(t, _)| *t > first + 0.02)
    });
    setup.preset.model.parameters.set(ParameterId::Alpha, 0.5);
    worker.send(live(&setup, false));
    let (changed, _) = wait(&worker, |event| {
        at(event).filter(|(_, alpha)| *alpha == 0.5)
    });
    assert!(changed >= later, "the device ran on");
    worker.send(live(&setup, true));
    let stood = wait(&worker, |event| match event {
        WorkerEvent::Snapshot(snapshot) => {
            let live = snapshot.live.filter(|live| live.paused)?;
            assert!(snapshot.features.is_some(), "the run's features are there");
            Some(live)
        }
        _ => None,
    });
    worker.events();
    std::thread::sleep(Duration::from_millis(100));
    assert!(
        worker.events().is_empty(),
        "nothing is drawn while it stands"
    );
    worker.send(SimulationRequest {
        steps: 1,
        ..live(&setup, true)
    });
    let (stepped, _) = wait(&worker, at);
    assert!(stepped > stood.time && stepped < stood.time + 1e-3);
}
