//! Where the energy of a run is, and where it goes: stored, put in, and lost, against time.

use crate::sim::{Event, EventKind, Integrals, Runner, SimError, Trace};

/// Instants at which energies are noted over a run. A bar of a picture needs no more.
pub const ENERGY_POINTS: usize = 600;

/// Energies at one instant \[J\]. Work and losses count from the beginning of the run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// Kinetic energy of the structure.
    pub kinetic: f64,
    /// Elastic energy of the structure.
    pub elastic: f64,
    /// Work of the drive so far.
    pub drive_work: f64,
    /// Work of the effects' forces so far, such as weight.
    pub effect_work: f64,
    /// Lost in the gas film.
    pub film: f64,
    /// Lost in impacts after which the mass bounced.
    pub bounces: f64,
    /// Lost in impacts after which adhesion held the mass.
    pub sticking: f64,
    /// Lost in the damping of the modes.
    pub damping: f64,
    /// Lost in friction and in a compliant ground.
    pub other: f64,
}

impl Energies {
    /// All that was lost \[J\].
    pub fn lost(&self) -> f64 {
        self.film + self.bounces + self.sticking + self.damping + self.other
    }

    /// Stored now, less what was stored at the beginning and came in, with what was lost: zero but
    /// for the errors of the integration \[J\].
    pub fn imbalance(&self, at_start: &Self) -> f64 {
        let stored = self.kinetic + self.elastic - at_start.kinetic - at_start.elastic;
        stored + self.lost() - self.drive_work - self.effect_work
    }

    fn between(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        Self {
            kinetic: mix(self.kinetic, other.kinetic),
            elastic: mix(self.elastic, other.elastic),
            drive_work: mix(self.drive_work, other.drive_work),
            effect_work: mix(self.effect_work, other.effect_work),
            film: mix(self.film, other.film),
            bounces: mix(self.bounces, other.bounces),
            sticking: mix(self.sticking, other.sticking),
            damping: mix(self.damping, other.damping),
            other: mix(self.other, other.other),
        }
    }
}

/// Energies of a run at instants in order of time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EnergyTrace {
    /// Instant \[s\] and energies.
    pub points: Vec<(f64, Energies)>,
}

impl EnergyTrace {
    /// The energies at `t` \[s\], held within the run; `None` without any.
    pub fn at(&self, t: f64) -> Option<Energies> {
        let after = self.points.partition_point(|(time, _)| *time <= t);
        let Some((later, next)) = self.points.get(after) else {
            return self.points.last().map(|(_, energies)| *energies);
        };
        let Some((earlier, before)) = after.checked_sub(1).and_then(|i| self.points.get(i)) else {
            return Some(*next);
        };
        Some(before.between(next, (t - earlier) / (later - earlier)))
    }

    /// The largest sum of what is stored and what is lost \[J\]: the common scale of the bars.
    pub fn largest(&self) -> f64 {
        let all = self.points.iter().map(|(_, e)| {
            let parts = [e.kinetic, e.elastic, e.lost(), e.effect_work.abs()];
            parts.into_iter().fold(0.0, f64::max)
        });
        all.fold(0.0, f64::max)
    }

    /// The last energies; zero for an empty trace.
    pub fn last(&self) -> Energies {
        self.points.last().map_or_else(Energies::default, |p| p.1)
    }
}

/// Sums of a run in progress.
pub(super) struct EnergyBook {
    sums: Integrals,
    bounces: f64,
    sticking: f64,
    events_seen: usize,
    trace: EnergyTrace,
}

impl EnergyBook {
    /// Opens the book of a run at its beginning.
    pub(super) fn open(runner: &mut Runner) -> Self {
        runner.start_notes(true);
        let mut book = Self {
            sums: Integrals::default(),
            bounces: 0.0,
            sticking: 0.0,
            events_seen: 0,
            trace: EnergyTrace::default(),
        };
        book.note(runner, &[]);
        book
    }

    /// Notes the energies now; `events` are those of the whole run so far.
    pub(super) fn note(&mut self, runner: &mut Runner, events: &[Event]) {
        if let Some(new) = runner.take_notes().integrals {
            self.sums.drive_work += new.drive_work;
            self.sums.film_loss += new.film_loss;
            self.sums.structure_loss += new.structure_loss;
            self.sums.friction_loss += new.friction_loss;
            self.sums.ground_loss += new.ground_loss;
            self.sums.effect_work += new.effect_work;
        }
        let is_compliant = runner.has_compliant_ground();
        for event in events.iter().skip(self.events_seen) {
            let (before, after) = (event.velocity_before, event.velocity_after);
            // The kinetic energy that an impulse on the mass takes: (v-^2 - v+^2) / (2 phi_p phi_p^T).
            let lost = 0.5 * runner.impact_mass() * (before * before - after * after);
            match event.kind {
                EventKind::Impact => self.bounces += lost,
                EventKind::Stick if !is_compliant => self.sticking += lost,
                _ => {}
            }
        }
        self.events_seen = events.len();
        let (kinetic, elastic) = runner.mechanical_energy();
        let now = Energies {
            kinetic,
            elastic,
            drive_work: self.sums.drive_work,
            effect_work: self.sums.effect_work,
            film: self.sums.film_loss,
            bounces: self.bounces,
            sticking: self.sticking,
            damping: self.sums.structure_loss,
            other: self.sums.friction_loss + self.sums.ground_loss,
        };
        self.trace.points.push((runner.time(), now));
    }

    /// The noted energies.
    pub(super) fn close(self) -> EnergyTrace {
        self.trace
    }
}

/// Runs to `end` \[s\] and notes energies on the way; `None` if `go_on` said no.
pub(super) fn run_with_energies(
    runner: &mut Runner,
    trace: &mut Trace,
    end: f64,
    go_on: &dyn Fn() -> bool,
) -> Result<Option<EnergyTrace>, SimError> {
    let mut book = EnergyBook::open(runner);
    for i in 1..=ENERGY_POINTS {
        runner.advance_to(end * i as f64 / ENERGY_POINTS as f64, trace)?;
        book.note(runner, &trace.events);
        if !go_on() {
            return Ok(None);
        }
    }
    Ok(Some(book.close()))
}
