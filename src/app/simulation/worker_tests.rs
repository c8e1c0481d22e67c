use crate::app::files::built_in;
use crate::app::setup::setup::Setup;
use crate::app::simulation::worker::*;
use crate::model::drive::Waveform;
use crate::model::effects::{ActiveEffect, EffectSpec, Need};
use crate::model::parameter::ParameterId;

fn wish(setup: &Setup) -> SimulationRequest {
    SimulationRequest {
        model: Arc::new(setup.preset.model.clone()),
        drive: Waveform::parse("square:15Hz:8V", 0.1).unwrap(),
        duration: 0.1,
        forces: false,
        overlays: setup.overlays.clone(),
        mode: Mode::Window,
        slow_down: 0.1,
        paused: false,
        scrub: None,
        restarts: 0,
        steps: 0,
    }
}

/// Waits until `done` finds what it looks for in the news.
fn wait<T>(worker: &Worker, mut done: impl FnMut(&News) -> Option<T>) -> T {
    let started = Instant::now();
    while started.elapsed() < Duration::from_secs(60) {
        if let Some(found) = worker.news().iter().find_map(&mut done) {
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
fn the_newest_wish_wins() {
    let worker = Worker::start(|| {}).unwrap();
    let mut setup = built_in::setup();
    // A fast drag: hundreds of wishes within what one simulation takes.
    for i in 0..=300 {
        let value = 0.1 + 0.001 * f64::from(i);
        setup.preset.model.parameters.set(ParameterId::Alpha, value);
        worker.send(wish(&setup));
    }
    // The curve comes first, the slower numbers follow: both may be in one batch of news.
    let (mut shown, mut first) = (0, None);
    let complete = wait(&worker, |news| match news {
        News::Snapshot(snapshot) => {
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

static BROKEN: EffectSpec = EffectSpec {
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
fn a_panic_is_reported_and_the_worker_lives_on() {
    let worker = Worker::start(|| {}).unwrap();
    let setup = built_in::setup();
    let mut broken = setup.clone();
    broken.preset.model.effects.push(ActiveEffect::new(&BROKEN));
    for mode in [Mode::Window, Mode::Live] {
        worker.send(SimulationRequest {
            mode,
            ..wish(&broken)
        });
        let text = wait(&worker, |news| match news {
            News::Broken(text) => Some(text.clone()),
            _ => None,
        });
        assert_eq!(text, "on purpose");
        worker.send(wish(&setup));
        wait(&worker, |news| {
            matches!(news, News::Snapshot(_)).then_some(())
        });
    }
}

#[test]
fn nonsense_is_refused_with_the_parameter() {
    let worker = Worker::start(|| {}).unwrap();
    let mut setup = built_in::setup();
    setup.preset.model.parameters.set(ParameterId::Gp, 1e-6);
    worker.send(wish(&setup));
    let error = wait(&worker, |news| match news {
        News::Refused(error) => Some(error.clone()),
        _ => None,
    });
    assert_eq!(error.parameter(), Some("gp"));
}

#[test]
fn a_live_run_keeps_pace_takes_changes_and_stands_when_paused() {
    let worker = Worker::start(|| {}).unwrap();
    let mut setup = built_in::setup();
    let live = |setup: &Setup, paused| SimulationRequest {
        mode: Mode::Live,
        paused,
        ..wish(setup)
    };
    worker.send(live(&setup, false));
    let at = |news: &News| match news {
        News::Snapshot(snapshot) => snapshot.live.map(|live| (live.time, alpha(snapshot))),
        _ => None,
    };
    let (first, _) = wait(&worker, at);
    let (later, _) = wait(&worker, |news| at(news).filter(|(t, _)| *t > first + 0.02));
    setup.preset.model.parameters.set(ParameterId::Alpha, 0.5);
    worker.send(live(&setup, false));
    let (changed, _) = wait(&worker, |news| at(news).filter(|(_, alpha)| *alpha == 0.5));
    assert!(changed >= later, "the device ran on");
    worker.send(live(&setup, true));
    let stood = wait(&worker, |news| match news {
        News::Snapshot(snapshot) => {
            let live = snapshot.live.filter(|live| live.paused)?;
            assert!(snapshot.features.is_some(), "the run's features are there");
            Some(live)
        }
        _ => None,
    });
    worker.news();
    std::thread::sleep(Duration::from_millis(100));
    assert!(worker.news().is_empty(), "nothing is drawn while it stands");
    worker.send(SimulationRequest {
        steps: 1,
        ..live(&setup, true)
    });
    let (stepped, _) = wait(&worker, at);
    assert!(stepped > stood.time && stepped < stood.time + 1e-3);
}
