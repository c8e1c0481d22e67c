//! What a simulation returns: uniformly sampled motion, events, contacts, forces.

/// What happened at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// The mass hit the ground and bounced.
    Impact,
    /// The mass hit the ground and stuck, or touched a compliant ground.
    Stick,
    /// The structure pulled the mass off the ground, or it left a compliant one.
    Release,
    /// The drive stepped, or the hysteresis branch changed with a step in force.
    DriveStep,
}

impl EventKind {
    /// Name as written in files and on screen.
    pub fn name(self) -> &'static str {
        match self {
            EventKind::Impact => "impact",
            EventKind::Stick => "stick",
            EventKind::Release => "release",
            EventKind::DriveStep => "drive step",
        }
    }
}

/// One event, located to 1 ns or better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// When \[s\].
    pub time: f64,
    /// What.
    pub kind: EventKind,
    /// Velocity of the proof mass just before [m/s].
    pub velocity_before: f64,
    /// Velocity of the proof mass just after [m/s].
    pub velocity_after: f64,
    /// Pull-off force, eq (13) \[N\]: after the hypothesised bounce at an impact, at
    /// break-off at a release, 0 in flight.
    pub pull_off_force: f64,
    /// Length of the contact that ends here \[s\]; 0 but at a release.
    pub contact_duration: f64,
}

/// Forces at each sample \[N\]; positive is up. Same length as the trace.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ForceTraces {
    /// Piezo drive on the cantilever, `eta gc`.
    pub drive: Vec<f64>,
    /// Gas film on the proof mass; 0 in contact.
    pub film: Vec<f64>,
    /// All effects' forces on the proof mass, friction included.
    pub effects: Vec<f64>,
    /// Adhesion that the ground can exert at this contact time; 0 in flight.
    pub adhesion: Vec<f64>,
    /// Force of the ground on the held mass, or on one that has sunk into it; 0 in flight.
    /// Negative: it holds it down.
    pub ground: Vec<f64>,
    /// Force with which the structure pulls the held mass off, eq (13); 0 in flight.
    pub pull_off: Vec<f64>,
}

/// A simulated run, sampled every `dt` from `t0`. All vectors have the same length;
/// displacements are as the sensor shows them (offsets included), SI.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// Time of the first sample \[s\].
    pub t0: f64,
    /// Sample interval \[s\].
    pub dt: f64,
    /// Drive voltage \[V\].
    pub voltage: Vec<f64>,
    /// Reading of the proof mass \[m\].
    pub proof_mass: Vec<f64>,
    /// Reading of the cantilever's centre \[m\]; empty for a device without that point.
    pub cantilever: Vec<f64>,
    /// Velocity of the proof mass [m/s].
    pub proof_mass_velocity: Vec<f64>,
    /// Velocity of the cantilever's centre [m/s]; empty likewise.
    pub cantilever_velocity: Vec<f64>,
    /// Events in order of time.
    pub events: Vec<Event>,
    /// Stretches in contact, start and end \[s\]; the last may still be open at the end
    /// of the run, and then ends with it.
    pub contacts: Vec<(f64, f64)>,
    /// Level of the ground as the sensor shows it \[m\], if there is a ground.
    pub ground_level: Option<f64>,
    /// Forces, if asked for.
    pub forces: Option<ForceTraces>,
    /// Steps that were taken, for judging cost.
    pub steps: u64,
}

impl Trace {
    /// Moves everything `by` \[s\] later.
    pub fn shift(&mut self, by: f64) {
        if by == 0.0 {
            return;
        }
        self.t0 += by;
        self.events.iter_mut().for_each(|e| e.time += by);
        for (start, end) in &mut self.contacts {
            *start += by;
            *end += by;
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.proof_mass.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.proof_mass.is_empty()
    }

    /// Time of sample `i` \[s\].
    pub fn time(&self, i: usize) -> f64 {
        self.t0 + i as f64 * self.dt
    }

    /// Times of all samples \[s\].
    pub fn times(&self) -> Vec<f64> {
        (0..self.len()).map(|i| self.time(i)).collect()
    }

    /// Time of the last sample \[s\].
    pub fn end(&self) -> f64 {
        self.time(self.len().saturating_sub(1))
    }

    /// Whether the mass is in contact at `t` \[s\].
    ///
    /// # Examples
    /// ```
    /// use impactscope::model::{drive::Waveform, preset::Preset};
    /// use impactscope::sim::{EventKind, Options, simulate};
    ///
    /// let model = Preset::default().model;
    /// let drive = Waveform::parse("square:50Hz:7V", 0.04)?;
    /// let trace = simulate(&model, &drive, 0.04, &Options::default())?;
    /// for event in trace.events.iter().filter(|e| e.kind == EventKind::Impact) {
    ///     assert!(event.velocity_before < 0.0); // it came from above
    /// }
    /// assert!(!trace.in_contact(0.0)); // it starts above the ground
    /// let held: f64 = trace.contacts.iter().map(|(start, end)| end - start).sum();
    /// assert!((0.0..0.04).contains(&held));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn in_contact(&self, t: f64) -> bool {
        let after = self.contacts.partition_point(|&(start, _)| start <= t);
        after > 0 && t < self.contacts[after - 1].1
    }

    /// All sample vectors, for what is done to each alike.
    fn columns(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let forces = self.forces.as_mut().map(|f| {
            [
                &mut f.drive,
                &mut f.film,
                &mut f.effects,
                &mut f.adhesion,
                &mut f.ground,
                &mut f.pull_off,
            ]
        });
        [
            &mut self.voltage,
            &mut self.proof_mass,
            &mut self.cantilever,
            &mut self.proof_mass_velocity,
            &mut self.cantilever_velocity,
        ]
        .into_iter()
        .chain(forces.into_iter().flatten())
    }

    /// Samples `from..to` with the events and contacts of that time.
    pub fn piece(&self, from: usize, to: usize) -> Trace {
        let to = to.min(self.len());
        let from = from.min(to);
        let mut piece = self.clone_samples(from..to);
        let (start, end) = (piece.t0, piece.end());
        let first = self.events.partition_point(|e| e.time < start);
        let last = self.events.partition_point(|e| e.time <= end);
        piece.events = self.events[first..last].to_vec();
        let first = self.contacts.partition_point(|c| c.1 < start);
        let last = self.contacts.partition_point(|c| c.0 <= end);
        piece.contacts = self.contacts[first..last.max(first)].to_vec();
        piece
    }

    fn clone_samples(&self, range: std::ops::Range<usize>) -> Trace {
        let cut = |column: &Vec<f64>| column.get(range.clone()).unwrap_or_default().to_vec();
        Trace {
            t0: self.time(range.start),
            dt: self.dt,
            voltage: cut(&self.voltage),
            proof_mass: cut(&self.proof_mass),
            cantilever: cut(&self.cantilever),
            proof_mass_velocity: cut(&self.proof_mass_velocity),
            cantilever_velocity: cut(&self.cantilever_velocity),
            events: Vec::new(),
            contacts: Vec::new(),
            ground_level: self.ground_level,
            forces: self.forces.as_ref().map(|f| ForceTraces {
                drive: cut(&f.drive),
                film: cut(&f.film),
                effects: cut(&f.effects),
                adhesion: cut(&f.adhesion),
                ground: cut(&f.ground),
                pull_off: cut(&f.pull_off),
            }),
            steps: self.steps,
        }
    }

    /// Drops the first `samples` and what happened before.
    pub fn forget(&mut self, samples: usize) {
        let samples = samples.min(self.len());
        self.t0 = self.time(samples);
        for column in self.columns() {
            column.drain(..samples.min(column.len()));
        }
        let start = self.t0;
        self.events.retain(|event| event.time >= start);
        self.contacts.retain(|contact| contact.1 >= start);
    }

    /// Makes room for `samples` and the few more that the last step may bring.
    pub(super) fn reserve(&mut self, samples: usize) {
        self.columns()
            .for_each(|column| column.reserve(samples + 64));
    }

    /// Cuts off what lies beyond `samples` and `end` \[s\].
    pub(super) fn truncate(&mut self, samples: usize, end: f64) {
        self.columns().for_each(|column| column.truncate(samples));
        self.events.retain(|event| event.time <= end);
        self.contacts.retain(|contact| contact.0 <= end);
        if let Some(last) = self.contacts.last_mut() {
            last.1 = last.1.min(end);
        }
    }
}
