//! What the picture of the device shows: one instant of a run, and the extremes of the run.

use std::hash::{Hash, Hasher};

use crate::app::setup::drive_choice::DriveChoice;
use crate::app::simulation::snapshot::Snapshot;
use crate::app::state::State;
use crate::model::film::SqueezeFilm;
use crate::model::ground::Ground;
use crate::model::parameter::ParameterId;
use crate::model::unit::{format_number, format_quantity, prefix_for};
use crate::sim::{EventKind, Trace};

/// Most samples searched for the extremes, so that a long live run costs no more than a
/// short one.
const MAX_EXTREME_SAMPLES: usize = 20_000;

/// Film force with an arrow of full length if the run has no recorded forces \[N\]. The
/// paper's abstract gives 50 to 130 nN.
const TYPICAL_FILM_FORCE: f64 = 1e-7;

/// The device at one time. Displacements are those of the device, without sensor offsets.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moment {
    /// Time \[s\].
    pub time: f64,
    /// Drive voltage \[V\].
    pub voltage: Option<f64>,
    /// Displacement of the proof mass \[m\].
    pub xp: f64,
    /// The same as the sensor and the curves show it \[m\].
    pub reading: f64,
    /// Displacement of the cantilever's centre \[m\].
    pub xc: Option<f64>,
    /// Velocity of the proof mass [m/s].
    pub velocity: f64,
    /// Start of the present contact \[s\].
    pub contact_since: Option<f64>,
    /// Piezo drive \[N\].
    pub drive: Option<f64>,
    /// Gas film on the mass \[N\].
    pub film: Option<f64>,
    /// Adhesion limit at this time \[N\]; only in contact.
    pub adhesion: Option<f64>,
    /// Force of the ground on the mass \[N\]; only in contact.
    pub ground: Option<f64>,
    /// Force with which the structure pulls the mass off \[N\]; only in contact.
    pub pull_off: Option<f64>,
    /// All effects on the mass \[N\].
    pub effects: Option<f64>,
    /// Their name: that of the only one, or "effects".
    pub effects_name: &'static str,
}

/// Two neighbouring samples and a position between them.
struct Place {
    i: usize,
    weight: f64,
    /// Whether to interpolate between the two: not across the start or end of a contact.
    smooth: bool,
}

impl Place {
    /// Value between the two samples; `None` where there is none or it is not finite.
    fn of(&self, values: &[f64]) -> Option<f64> {
        let a = *values.get(self.i)?;
        let b = values.get(self.i + 1).copied().unwrap_or(a);
        let value = match (self.smooth, self.weight) {
            (_, 0.0) => a,
            (true, w) => a + (b - a) * w,
            // Across an impact or a release the nearer sample is used.
            (false, w) if w < 0.5 => a,
            _ => b,
        };
        value.is_finite().then_some(value)
    }
}

/// Start of the contact at time `t` \[s\]. A contact without end lasts to the end of the run.
fn contact_since(trace: &Trace, t: f64) -> Option<f64> {
    let after = trace.contacts.partition_point(|&(start, _)| start <= t);
    let &(start, end) = trace.contacts.get(after.checked_sub(1)?)?;
    let slack = 1e-6 * trace.dt;
    let open = after == trace.contacts.len()
        && end >= trace.end() - slack
        && !trace
            .events
            .last()
            .is_some_and(|e| e.kind == EventKind::Release && e.time >= end - slack);
    (t < end || open).then_some(start)
}

impl Moment {
    /// The run at `time` \[s\], held within the run; its last sample if `None`. `None` for
    /// a run without a finite displacement there.
    pub fn new(state: &State, snapshot: &Snapshot, time: Option<f64>) -> Option<Self> {
        let trace = &*snapshot.trace;
        let parameters = &snapshot.model.parameters;
        let last = trace.len().checked_sub(1)?;
        let position = match time {
            Some(t) if trace.dt > 0.0 && t.is_finite() => {
                ((t - trace.t0) / trace.dt).clamp(0.0, last as f64)
            }
            _ => last as f64,
        };
        if !position.is_finite() {
            return None;
        }
        let i = (position.floor() as usize).min(last);
        let t = trace.t0 + position * trace.dt;
        let mut place = Place {
            i,
            weight: position - i as f64,
            smooth: true,
        };
        let reading = place.of(&trace.proof_mass)?;
        let xp = reading - parameters[ParameterId::OffsetP];
        let xc = place
            .of(&trace.cantilever)
            .map(|x| x - parameters[ParameterId::OffsetC]);
        let velocity = place.of(&trace.proof_mass_velocity).unwrap_or(0.0);
        let since = contact_since(trace, t);
        place.smooth = contact_since(trace, trace.time(i)).is_some()
            == contact_since(trace, trace.time((i + 1).min(last))).is_some();

        let forces = trace.forces.as_ref();
        let read = |values: Option<&Vec<f64>>| values.and_then(|v| place.of(v));
        let ground = snapshot
            .model
            .has_ground
            .then(|| Ground::new(parameters))
            .filter(|_| since.is_some());
        let mut moment = Self {
            time: t,
            voltage: place.of(&trace.voltage),
            xp,
            reading,
            xc,
            velocity,
            contact_since: since,
            drive: read(forces.map(|f| &f.drive)),
            film: read(forces.map(|f| &f.film)),
            // Computed from the law, so that a run without recorded forces shows it too.
            adhesion: ground.and_then(|g| Some(g.adhesion(t - since?))),
            ground: read(forces.map(|f| &f.ground)).filter(|_| since.is_some()),
            pull_off: read(forces.map(|f| &f.pull_off)).filter(|_| since.is_some()),
            effects: read(forces.map(|f| &f.effects)).filter(|f| *f != 0.0),
            effects_name: match snapshot.model.effects.as_slice() {
                [only] => only.spec.name,
                _ => "effects",
            },
        };
        if forces.is_none() {
            moment.film = (snapshot.model.has_ground && since.is_none())
                .then(|| SqueezeFilm::new(parameters).force(xp, velocity))
                .filter(|f| f.is_finite());
            moment.drive = moment.drive_of(state, snapshot);
        }
        Some(moment)
    }

    /// The drive force computed from the waveform, for a run without recorded forces.
    fn drive_of(&self, state: &State, snapshot: &Snapshot) -> Option<f64> {
        let piezo = snapshot.model.piezo.as_ref()?;
        let DriveChoice::Waveform(waveform) = &state.setup.drive else {
            return None;
        };
        waveform.check().ok()?;
        let segment = waveform.segment(waveform.index_at(self.time));
        let gain = piezo.gain(self.voltage?, segment.branch);
        Some(snapshot.model.parameters[ParameterId::Eta] * gain).filter(|f| f.is_finite())
    }

    /// In words: in flight, in contact and for how long, or how strongly it is pulled off.
    pub fn regime(&self) -> String {
        let Some(since) = self.contact_since else {
            return "in flight".to_owned();
        };
        match (self.pull_off, self.adhesion) {
            (Some(pull), Some(holds)) if pull > 0.0 => {
                let (prefix, factor) = prefix_for(holds, "N");
                let number = |force: f64| format_number(force / factor, 3);
                format!(
                    "pull-off force {} of {} {prefix}N",
                    number(pull),
                    number(holds)
                )
            }
            _ => format!(
                "in contact for {}",
                format_quantity(self.time - since, "s", 3)
            ),
        }
    }
}

/// Extremes of a run, computed once per generation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extremes {
    key: (u64, usize),
    /// Hash of the device's name: another device has a scale of its own.
    device: u64,
    /// Lowest and highest level that must fit the picture \[m\].
    pub low: f64,
    /// See `low`.
    pub high: f64,
    /// Largest film force \[N\].
    pub film: f64,
    /// Largest drive force \[N\].
    pub drive: f64,
    /// Largest of the other forces on the mass \[N\].
    pub contact: f64,
    /// Largest speed of the mass [m/s].
    pub speed: f64,
}

/// Identifies a run by its number and its address in memory (tests and sessions may count
/// from 1 again).
fn key(snapshot: &Snapshot) -> (u64, usize) {
    let trace: *const Trace = &*snapshot.trace;
    (snapshot.generation, trace as usize)
}

/// A motion below this share of the range of the picture makes the range smaller. At a third
/// the device still moves over a readable height.
const SMALL_SHARE: f64 = 0.33;

/// A hash of the device's name.
fn device_of(snapshot: &Snapshot) -> u64 {
    let mut hasher = std::hash::DefaultHasher::new();
    snapshot.model.name.hash(&mut hasher);
    hasher.finish()
}

impl Extremes {
    /// Whether these are the extremes of `snapshot`.
    pub fn are_of(&self, snapshot: &Snapshot) -> bool {
        self.key == key(snapshot)
    }

    /// Computes the extremes of a run. `previous`, of the same device, steadies the range: every
    /// frame of a live run, and every step of a slider, brings a slightly different run.
    pub fn new(snapshot: &Snapshot, previous: Option<&Self>) -> Self {
        let trace = &*snapshot.trace;
        let parameters = &snapshot.model.parameters;
        let stride = trace.len().div_ceil(MAX_EXTREME_SAMPLES).max(1);
        let range = |values: &[f64]| {
            values
                .iter()
                .step_by(stride)
                .filter(|x| x.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| {
                    (a.min(x), b.max(x))
                })
        };
        let size = |values: &[f64]| {
            let (a, b) = range(values);
            a.abs().max(b.abs()).max(0.0)
        };
        let shifted = |values: &[f64], offset| {
            let (a, b) = range(values);
            (a - offset, b - offset)
        };
        let p = shifted(&trace.proof_mass, parameters[ParameterId::OffsetP]);
        let c = shifted(&trace.cantilever, parameters[ParameterId::OffsetC]);
        let ground = trace
            .ground_level
            .map_or(f64::INFINITY, |g| g - parameters[ParameterId::OffsetP]);
        let mut low = p.0.min(c.0).min(ground).min(0.0);
        let mut high = p.1.max(c.1).max(0.0);
        if !(low.is_finite() && high.is_finite() && high > low) {
            (low, high) = (-1e-6, 1e-6);
        }
        let device = device_of(snapshot);
        let steady = previous.filter(|old| old.device == device);
        if let Some(old) = steady {
            // A changing scale is hard to read. So the range grows only when it must, and then to
            // twice the motion. It does not shrink in a live run, which often swings little for
            // a while, and for a whole span only if the motion is much smaller.
            let fits = old.low <= low && old.high >= high;
            let is_small = high - low < SMALL_SHARE * (old.high - old.low);
            if fits && (snapshot.live.is_some() || !is_small) {
                (low, high) = (old.low, old.high);
            } else if !fits {
                let (bottom, top) = (low.min(old.low), high.max(old.high));
                // Below the ground nothing moves.
                if low < old.low && low < ground {
                    low = bottom - 0.5 * (top - bottom);
                } else {
                    low = bottom;
                }
                high = if top > old.high {
                    top + 0.5 * (top - bottom)
                } else {
                    top
                };
            }
        }
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        let forces = trace.forces.as_ref();
        let of = |values: Option<&Vec<f64>>| finite(values.map_or(0.0, |v| size(v)));
        // In a live run the largest force so far, so that arrows do not change with what leaves
        // the view.
        let lasting = |now: f64, before: fn(&Self) -> f64| match steady {
            Some(old) if snapshot.live.is_some() => now.max(before(old)),
            _ => now,
        };
        let film = match forces {
            Some(f) => finite(size(&f.film)),
            None => TYPICAL_FILM_FORCE,
        };
        let drive = match forces {
            Some(f) => finite(size(&f.drive)),
            None => 5.0 * parameters[ParameterId::Eta].abs(),
        };
        let contact = of(forces.map(|f| &f.ground))
            .max(of(forces.map(|f| &f.adhesion)))
            .max(of(forces.map(|f| &f.pull_off)))
            .max(of(forces.map(|f| &f.effects)));
        Self {
            key: key(snapshot),
            device,
            low,
            high,
            film: lasting(film, |old| old.film),
            drive: lasting(drive, |old| old.drive),
            contact: lasting(contact, |old| old.contact),
            speed: lasting(finite(size(&trace.proof_mass_velocity)), |old| old.speed),
        }
    }
}
