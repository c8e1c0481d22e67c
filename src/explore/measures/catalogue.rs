//! The table of measures: what can be drawn, written and asked for.

/// A measure of a steady response.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MeasureId {
    /// See [`super::Regime`].
    Regime,
    Multiple,
    ContactShare,
    ContactDuration,
    Bounces,
    Peak,
    FirstImpactSpeed,
    LargestImpactSpeed,
    MeanGroundForce,
    PullOffForce,
    EnergyLost,
    ImpactLoss,
    FilmLoss,
    StructureLoss,
    DriveWork,
    Margin,
    LargestMultiplier,
}

/// How a measure is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drawn {
    /// Categories with names: codes of [`super::Regime`].
    Category,
    /// Whole numbers.
    Count,
    /// Numbers on a linear scale.
    Linear,
    /// Positive numbers on a logarithmic scale.
    Logarithmic,
}

/// What a measure rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// What a response holds.
    Events,
    /// Integrals of forces: the cycle is simulated once more.
    Integrals,
}

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasureSpec {
    /// The measure.
    pub measure: MeasureId,
    /// Name in files and on the command line.
    pub id: &'static str,
    /// Name on screen.
    pub name: &'static str,
    /// SI unit; empty without one.
    pub unit: &'static str,
    /// What it is, in a sentence.
    pub meaning: &'static str,
    /// How it is drawn.
    pub drawn: Drawn,
    /// What it rests on.
    pub basis: Basis,
}

/// A row; `text` is id, name, unit and meaning.
const fn row(
    measure: MeasureId,
    text: [&'static str; 4],
    drawn: Drawn,
    basis: Basis,
) -> MeasureSpec {
    let [id, name, unit, meaning] = text;
    MeasureSpec {
        measure,
        id,
        name,
        unit,
        meaning,
        drawn,
        basis,
    }
}

/// All measures, in the order in which they are offered.
pub const MEASURES: [MeasureSpec; 17] = {
    use Basis::{Events, Integrals};
    use Drawn::{Category, Count, Linear, Logarithmic};
    use MeasureId as M;
    [
        row(
            M::Regime,
            [
                "regime",
                "regime",
                "",
                "how the mass meets the ground in one cycle",
            ],
            Category,
            Events,
        ),
        row(
            M::Multiple,
            [
                "multiple",
                "periods of the response",
                "",
                "periods of the drive after which the response repeats",
            ],
            Count,
            Events,
        ),
        row(
            M::ContactShare,
            [
                "contact_share",
                "contact share",
                "",
                "share of the time in contact (duty factor); bounces off a rigid ground take no time",
            ],
            Linear,
            Events,
        ),
        row(
            M::ContactDuration,
            [
                "contact_duration",
                "contact duration",
                "s",
                "mean length of a contact that is no bounce",
            ],
            Linear,
            Events,
        ),
        row(
            M::Bounces,
            [
                "bounces",
                "bounces per period",
                "",
                "bounces in a period of the drive",
            ],
            Linear,
            Events,
        ),
        row(
            M::Peak,
            [
                "peak",
                "peak-to-peak displacement",
                "m",
                "highest less lowest displacement of the proof mass",
            ],
            Linear,
            Events,
        ),
        row(
            M::FirstImpactSpeed,
            [
                "impact_speed_first",
                "first impact speed",
                "m/s",
                "speed of the arrival that ends the longest flight of the cycle",
            ],
            Linear,
            Events,
        ),
        row(
            M::LargestImpactSpeed,
            [
                "impact_speed_max",
                "largest impact speed",
                "m/s",
                "largest speed of arrival",
            ],
            Linear,
            Events,
        ),
        row(
            M::MeanGroundForce,
            [
                "ground_force_mean",
                "mean ground force",
                "N",
                "force of the ground on the mass, mean over the cycle with impacts; positive is up",
            ],
            Linear,
            Integrals,
        ),
        row(
            M::PullOffForce,
            [
                "pull_off_force",
                "pull-off force",
                "N",
                "largest pull-off force at a release",
            ],
            Linear,
            Events,
        ),
        row(
            M::EnergyLost,
            [
                "energy_lost",
                "energy lost",
                "J/period",
                "what impacts, film, structure, friction and a compliant ground take a period of the drive",
            ],
            Logarithmic,
            Integrals,
        ),
        row(
            M::ImpactLoss,
            [
                "impact_loss",
                "energy lost in impacts",
                "J/period",
                "kinetic energy that impacts on a rigid ground take a period of the drive",
            ],
            Logarithmic,
            Events,
        ),
        row(
            M::FilmLoss,
            [
                "film_loss",
                "energy lost in the film",
                "J/period",
                "work against the gas film a period of the drive",
            ],
            Logarithmic,
            Integrals,
        ),
        row(
            M::StructureLoss,
            [
                "structure_loss",
                "energy lost in the structure",
                "J/period",
                "what the damping of the modes takes a period of the drive",
            ],
            Logarithmic,
            Integrals,
        ),
        row(
            M::DriveWork,
            [
                "drive_work",
                "net work of the drive",
                "J/period",
                "work of the drive's force a period of the drive; what is lost, but for work of effects",
            ],
            Logarithmic,
            Integrals,
        ),
        row(
            M::Margin,
            [
                "margin",
                "margin to the next regime",
                "",
                "distance to the nearest change of events, from 0 at the change to about 1",
            ],
            Logarithmic,
            Events,
        ),
        row(
            M::LargestMultiplier,
            [
                "multiplier",
                "largest multiplier",
                "",
                "largest modulus of the multipliers of the response; 1 is the limit of stability",
            ],
            Linear,
            Events,
        ),
    ]
};

impl MeasureId {
    /// Its row.
    #[must_use]
    pub fn spec(self) -> &'static MeasureSpec {
        // The table is in the order of the ids, which a test checks.
        &MEASURES[self as usize]
    }

    /// The measure of an id.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        let row = MEASURES.iter().find(|row| row.id == id)?;
        Some(row.measure)
    }
}
