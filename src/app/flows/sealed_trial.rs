//! The sealed trial from start to end: its recordings replace the person's own, the
//! envelope is opened and scored, and the person's own setup comes back.

use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::load_example;
use crate::app::analysis::job::Job;
use crate::app::analysis::sealed_trial::{
    Made, Opened, Own, Sealed, Suspended, is_right, scored_form,
};
use crate::app::files::built_in;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::notice::Notice;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::app::state::State;
use crate::model::preset::Preset;
use crate::trial::score;
use crate::trial::score::{Mark, may_also_name, score};

/// Starts a trial that was generated, and ends one whose recordings were undone.
pub(crate) fn poll(state: &mut State, last: &mut OverlayId) {
    let making = &mut state.diagnosing.trial.making;
    if making.as_ref().is_some_and(Job::is_cancelled) {
        // Its thread cannot be stopped; what it brings is not wanted any more.
        *making = None;
        state.diagnosing.trial.suspended = None;
    }
    if let Some(made) = state.diagnosing.trial.making.as_ref().and_then(Job::take) {
        state.diagnosing.trial.making = None;
        let suspended = state.diagnosing.trial.suspended.take();
        match (made, suspended) {
            (Ok(made), None) => begin(state, made, last),
            (Ok(made), Some(suspended)) => resume(state, made, *suspended, last),
            (Err(error), _) => state.diagnosing.trial.error = Some(error),
        }
    }
    let is_gone = |sealed: &Sealed| {
        let mut overlays = state.setup.overlays.iter();
        !overlays.any(|o| sealed.recordings.contains(&o.id))
    };
    if state.diagnosing.trial.sealed.as_ref().is_some_and(is_gone) {
        // Undo has brought the person's own setup back, and a reset has put another one there;
        // neither brings back the answers. After the last recording was removed by hand the
        // setup is still that of the trial.
        if state.setup.overlays.is_empty() {
            end(state);
        } else {
            close(state);
        }
    }
}

/// Loads a trial's recordings in place of the person's own, which are stored until it ends.
pub(crate) fn begin(state: &mut State, (recordings, envelope, draw): Made, last: &mut OverlayId) {
    end(state);
    let setup = built_in::from_preset(Preset::default());
    let own = Box::new(Own {
        setup: std::mem::replace(&mut state.setup, setup),
        automatic: state.diagnosing.automatic.take(),
        by_hand: state.diagnosing.by_hand.take(),
    });
    state.diagnosing.picked = None;
    state.diagnosing.error = None;
    if let Some(running) = state.diagnosing.running.take() {
        running.job.cancel();
    }
    let ids = load_example::add(&mut state.setup, recordings, false, last);
    state.selected = None;
    state.diagnosing.trial.sealed = Some(Sealed {
        draw,
        seal: envelope.seal().to_owned(),
        guess: None,
        opened: None,
        envelope,
        recordings: ids,
        own,
    });
}

/// Goes on with a trial of a session that was drawn again.
fn resume(state: &mut State, made: Made, suspended: Suspended, last: &mut OverlayId) {
    if made.1.seal() != suspended.seal {
        let text = format!(
            "The session's sealed trial of seed {} cannot go on: this version of the program draws another one from it. Your own recordings are open; start a new trial",
            suspended.draw.seed
        );
        state.notices.push(Notice::new(true, text));
        return;
    }
    // What is shown of the answers came back with the session.
    let diagnosing = &state.diagnosing;
    let (look, picked) = (diagnosing.look.clone(), diagnosing.picked.clone());
    begin(state, made, last);
    if let Some(setup) = suspended.setup {
        take_over(&mut state.setup, setup);
    }
    let diagnosing = &mut state.diagnosing;
    (diagnosing.look, diagnosing.picked) = (look, picked);
    (diagnosing.automatic, diagnosing.by_hand) = (suspended.automatic, suspended.by_hand);
    diagnosing.complete(&state.setup);
    let Some(sealed) = &mut diagnosing.trial.sealed else {
        return;
    };
    sealed.guess = suspended.guess;
    // The tally of the session has these marks already.
    sealed.opened = suspended
        .marks
        .map(|(tool, person)| contents(sealed, tool, person));
}

/// Gives a trial's setup the device, the drive and the settings of the recordings that it had.
fn take_over(setup: &mut Setup, former: Setup) {
    let before = |name: &str| {
        let mut overlays = former.overlays.iter();
        overlays.find(|overlay| overlay.recording.name == name)
    };
    // A recording that the person has removed stays away, unless none would be left.
    if !former.overlays.is_empty() {
        setup
            .overlays
            .retain(|overlay| before(&overlay.recording.name).is_some());
    }
    let mut drive = former.drive.clone();
    for overlay in &mut setup.overlays {
        let Some(former) = before(&overlay.recording.name) else {
            continue;
        };
        if drive == DriveChoice::Recorded(former.id) {
            drive = DriveChoice::Recorded(overlay.id);
        }
        *overlay = Overlay {
            id: overlay.id,
            recording: Arc::clone(&overlay.recording),
            ..former.clone()
        };
    }
    (setup.preset, setup.original) = (former.preset, former.original);
    (setup.drive, setup.duration, setup.locked) = (drive, former.duration, former.locked);
}

/// The contents of the envelope, with marks that were given.
fn contents(sealed: &Sealed, tool: Option<Mark>, person: Option<Mark>) -> Opened {
    let (truth, text) = sealed.envelope.clone().open();
    let hash: String = Sha256::digest(text.as_bytes())
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    Opened {
        seal_holds: hash == sealed.seal,
        truth,
        tool,
        person,
    }
}

/// The running trial as a session keeps it; without the truth.
pub(crate) fn suspended(state: &State) -> Option<Suspended> {
    let diagnosing = &state.diagnosing;
    let Some(sealed) = &diagnosing.trial.sealed else {
        return diagnosing.trial.suspended.as_deref().cloned();
    };
    let opened = sealed.opened.as_ref();
    Some(Suspended {
        draw: sealed.draw,
        seal: sealed.seal.clone(),
        guess: sealed.guess.clone(),
        marks: opened.map(|opened| (opened.tool, opened.person)),
        setup: Some(state.setup.clone()),
        automatic: diagnosing.automatic.clone(),
        by_hand: diagnosing.by_hand.clone(),
    })
}

/// Ends the trial and restores the person's own recordings, device and answers.
pub fn end(state: &mut State) {
    if let Some(setup) = close(state) {
        state.setup = setup;
        state.selected = state.setup.overlays.first().map(|overlay| overlay.id);
    }
}

/// Ends the trial and restores the person's own answers. Returns the person's own setup.
fn close(state: &mut State) -> Option<Setup> {
    let diagnosing = &mut state.diagnosing;
    let sealed = diagnosing.trial.sealed.take()?;
    let own = *sealed.own;
    if let Some(running) = diagnosing.running.take() {
        running.job.cancel();
    }
    diagnosing.automatic = own.automatic;
    diagnosing.by_hand = own.by_hand;
    diagnosing.picked = None;
    diagnosing.error = None;
    if let Some(answer) = diagnosing.shown().cloned() {
        diagnosing.look.begin(&answer);
    }
    Some(own.setup)
}

/// The person's own setup, even during a trial: a session has the trial among its results.
pub fn own_setup(state: &State) -> &Setup {
    match &state.diagnosing.trial.sealed {
        Some(sealed) => &sealed.own.setup,
        None => &state.setup,
    }
}

/// Opens the envelope, scores the guess and the diagnosis, and adds them to the tally.
pub fn open(state: &mut State) {
    let diagnosing = &mut state.diagnosing;
    let answer = diagnosing.automatic.clone();
    let trial = &mut diagnosing.trial;
    let Some(sealed) = trial.sealed.as_mut().filter(|s| s.opened.is_none()) else {
        return;
    };
    let may_add = may_also_name(sealed.draw.beam);
    let truth = sealed.envelope.clone().open().0;
    let mark = |answer: &score::Diagnosis| score(&truth, answer, may_add).mark;
    let tool = answer.map(|answer| mark(&score::Diagnosis::from(&answer.diagnosis)));
    let person = sealed.guess.as_ref().map(|guess| mark(&scored_form(guess)));
    let count = |(right, of): &mut (usize, usize), mark: Option<Mark>| {
        *of += usize::from(mark.is_some());
        *right += usize::from(mark.is_some_and(is_right));
    };
    count(&mut trial.tally.tool, tool);
    count(&mut trial.tally.person, person);
    sealed.opened = Some(contents(sealed, tool, person));
}
