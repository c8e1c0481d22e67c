//! What a run can note beside events: turns, arrivals, and what forces do.

/// The mass at rest for an instant in flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// When \[s\].
    pub time: f64,
    /// Where, without the sensor's offset \[m\].
    pub displacement: f64,
    /// Whether it comes from above.
    pub is_low: bool,
}

/// The mass arriving at the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// When \[s\].
    pub time: f64,
    /// Speed [m/s].
    pub speed: f64,
    /// Largest speed since it left the ground [m/s], or since the record began.
    pub fastest: f64,
    /// How clearly the mass bounces or sticks, from 0: what decides apart from its limit, as a share
    /// of both together; infinite where nothing is to be decided.
    pub decision_share: f64,
}

/// What forces do over a record. Losses are positive where motion loses energy.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Integrals {
    /// Work of the drive \[J\].
    pub drive_work: f64,
    /// What the film takes \[J\].
    pub film_loss: f64,
    /// What the damping of the modes takes \[J\].
    pub structure_loss: f64,
    /// What friction takes \[J\].
    pub friction_loss: f64,
    /// What a compliant ground takes \[J\]; rigid impacts are events.
    pub ground_loss: f64,
    /// Work of the effects' forces, and of the base \[J\].
    pub effect_work: f64,
    /// Impulse of the ground on the mass, but for rigid impacts \[N s\].
    pub ground_impulse: f64,
    /// Time integral of the displacement of the mass \[m s\].
    pub displacement: f64,
}

/// Notes of a run, from one call of [`Runner::take_notes`] to the next.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Notes {
    /// In order of time.
    pub turns: Vec<Turn>,
    /// In order of time.
    pub arrivals: Vec<Arrival>,
    /// Largest speed of the mass [m/s].
    pub top_speed: f64,
    /// Largest speed since the last arrival [m/s].
    pub fastest_since_arrival: f64,
    /// Least of what the adhesion still held, as a share of it, over the points of held steps
    /// that ended in no release; infinite without contact.
    pub least_hold_share: f64,
    /// If asked for.
    pub integrals: Option<Integrals>,
}

impl Notes {
    /// Empty ones.
    pub(super) fn new(integrals: bool) -> Self {
        Self {
            least_hold_share: f64::INFINITY,
            integrals: integrals.then(Integrals::default),
            ..Self::default()
        }
    }
}
