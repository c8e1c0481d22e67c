//! The table of measures.

/// Rows of the table of measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunMeasure {
    /// Name in a lesson.
    pub id: &'static str,
    /// SI unit; empty without one.
    pub unit: &'static str,
    /// What it is, in a sentence.
    pub meaning: &'static str,
    /// Whether there can be several, counted from 1: `impact_speed(2)`.
    pub is_counted: bool,
    pub(super) kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Impacts,
    Contacts,
    ArrivalTime,
    ImpactSpeed,
    ReboundSpeed,
    ReboundHeight,
    ContactTime,
    LongestContact,
    ReleaseForce,
    FilmForce,
    Highest,
    Lowest,
    PeakToPeak,
    EndDisplacement,
    Amplitude,
    Maximum,
    MaximumTime,
    SwingTime,
    LoopWidth,
    ContactShare,
    BothUpShare,
    FilmLoss,
    BounceLoss,
    StickingLoss,
    DampingLoss,
    DriveWork,
    Period,
    Duration,
    ProofMass,
    FirstFrequency,
    StaticGap,
}

const fn one(id: &'static str, unit: &'static str, kind: Kind, text: &'static str) -> RunMeasure {
    RunMeasure {
        id,
        unit,
        meaning: text,
        is_counted: false,
        kind,
    }
}

const fn each(id: &'static str, unit: &'static str, kind: Kind, text: &'static str) -> RunMeasure {
    RunMeasure {
        is_counted: true,
        ..one(id, unit, kind, text)
    }
}

/// All measures.
pub const RUN_MEASURES: [RunMeasure; 31] = [
    one(
        "impacts",
        "",
        Kind::Impacts,
        "arrivals at the ground, sticking ones included",
    ),
    one("contacts", "", Kind::Contacts, "contacts that last"),
    each(
        "arrival_time",
        "s",
        Kind::ArrivalTime,
        "when the mass arrives at the ground",
    ),
    each(
        "impact_speed",
        "m/s",
        Kind::ImpactSpeed,
        "speed just before an arrival",
    ),
    each(
        "rebound_speed",
        "m/s",
        Kind::ReboundSpeed,
        "speed just after an arrival; 0 if the mass sticks",
    ),
    each(
        "rebound_height",
        "m",
        Kind::ReboundHeight,
        "greatest height over the ground after an arrival, before the next one",
    ),
    each(
        "contact_time",
        "s",
        Kind::ContactTime,
        "length of a contact that has ended",
    ),
    one(
        "longest_contact",
        "s",
        Kind::LongestContact,
        "length of the longest contact that has ended",
    ),
    each(
        "release_force",
        "N",
        Kind::ReleaseForce,
        "pull-off force at a release",
    ),
    one(
        "film_force",
        "N",
        Kind::FilmForce,
        "largest force of the gas film",
    ),
    one("highest", "m", Kind::Highest, "highest reading of the mass"),
    one("lowest", "m", Kind::Lowest, "lowest reading of the mass"),
    one(
        "peak_to_peak",
        "m",
        Kind::PeakToPeak,
        "highest less lowest reading",
    ),
    one(
        "end_displacement",
        "m",
        Kind::EndDisplacement,
        "reading at the end of the run",
    ),
    one(
        "amplitude",
        "m",
        Kind::Amplitude,
        "half of highest less lowest over the last period of the drive, or the last tenth of the run",
    ),
    each(
        "maximum",
        "m",
        Kind::Maximum,
        "reading where the mass turns at the top",
    ),
    each(
        "maximum_time",
        "s",
        Kind::MaximumTime,
        "when the mass turns at the top",
    ),
    each(
        "swing_time",
        "s",
        Kind::SwingTime,
        "from one turn at the top to the next",
    ),
    one(
        "loop_width",
        "m",
        Kind::LoopWidth,
        "distance of the two branches of the last loop at 0 V",
    ),
    one(
        "contact_share",
        "",
        Kind::ContactShare,
        "share of the last period of the drive in contact",
    ),
    one(
        "both_up_share",
        "",
        Kind::BothUpShare,
        "share of the last period in which neither this foot nor one half a period later is down",
    ),
    one(
        "film_loss",
        "J",
        Kind::FilmLoss,
        "energy lost in the gas film",
    ),
    one(
        "bounce_loss",
        "J",
        Kind::BounceLoss,
        "energy lost in impacts that bounce",
    ),
    one(
        "sticking_loss",
        "J",
        Kind::StickingLoss,
        "energy lost in impacts that stick",
    ),
    one(
        "damping_loss",
        "J",
        Kind::DampingLoss,
        "energy lost in the damping of the modes",
    ),
    one("drive_work", "J", Kind::DriveWork, "work of the drive"),
    one("period", "s", Kind::Period, "period of the drive"),
    one("duration", "s", Kind::Duration, "length of the run"),
    one("proof_mass", "kg", Kind::ProofMass, "mass at the tip"),
    one(
        "ring_frequency",
        "Hz",
        Kind::FirstFrequency,
        "one over the time from the first turn at the top to the next",
    ),
    one(
        "film_at_contact",
        "m",
        Kind::StaticGap,
        "thickness of the gas film that is left at contact",
    ),
];

/// A measure by name.
pub fn find(id: &str) -> Option<&'static RunMeasure> {
    RUN_MEASURES.iter().find(|spec| spec.id == id)
}

/// The names of all measures, for messages.
pub fn names() -> String {
    let names: Vec<&str> = RUN_MEASURES.iter().map(|spec| spec.id).collect();
    names.join(", ")
}
