//! The missing force, measured point by point without a law (`score_test::basis_forces`), and how
//! much of the misfit such forces could remove at all.

use super::residual_map::event_free_since;
use crate::diagnose::diagnosis::ForceCurve;
use crate::diagnose::score_test::basis_forces::{Against, window, window_grid};
use crate::diagnose::score_test::linearized::{Linearized, SegmentGram};
use crate::diagnose::score_test::scan::ScoreScan;
use crate::diagnose::score_test::state_range::state_ranges;
use crate::diagnose::shooting::fitted::Fitted;
use crate::model::effects::ActiveEffect;
use crate::sim::SimError;

/// Size of a trial force \[N\].
const TRIAL_FORCE: f64 = 1e-10;
/// Size of a trial damping \[N s/m\].
const TRIAL_DAMPING: f64 = 1e-10;
/// Size of a trial stiffness \[N/m\].
const TRIAL_STIFFNESS: f64 = 1e-5;
/// Size of a trial change of `gc`.
const TRIAL_DRIVE_GAIN: f64 = 1e-3;

/// Width of a window that contains every height \[m\].
const UNBOUNDED_WIDTH: f64 = 1e6;
/// Groups of segments by the time since contact.
const AGE_GROUPS: usize = 8;
/// Fewest segments in each group.
const MIN_SEGMENTS_PER_GROUP: usize = 4;
/// Abscissa of the force curve over the time since contact.
pub(crate) const SINCE_CONTACT: &str = "time since contact";

/// What forces without a law would bring.
#[derive(Debug, Clone)]
pub struct MissingForces {
    /// Fall of chi2 if all were added at once, less its expectation by chance (one per
    /// direction).
    pub joint: f64,
    /// Force against height, velocity, voltage and time since contact.
    pub curves: Vec<ForceCurve>,
    /// The quantity against which they bring most, and how much.
    pub strongest: Option<(Against, f64)>,
}

/// Measures forces without a law at a fit.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn measure(fitted: &Fitted) -> Result<MissingForces, SimError> {
    let linear = Linearized::new(fitted)?;
    let spans = state_ranges(fitted);
    let mut probes: Vec<ActiveEffect> = Vec::new();
    let mut groups: Vec<(Against, std::ops::Range<usize>, Vec<f64>, f64)> = Vec::new();
    for against in Against::ALL {
        let (range, count, size) = match against {
            Against::Height => (spans.0, 9, TRIAL_FORCE),
            Against::DampingAtHeight => (spans.0, 5, TRIAL_DAMPING),
            Against::Velocity => (spans.1, 7, TRIAL_FORCE),
            Against::Voltage => (spans.2, 6, TRIAL_FORCE),
            Against::DampingAtVoltage => (spans.2, 4, TRIAL_DAMPING),
            Against::StiffnessAtVoltage => (spans.2, 4, TRIAL_STIFFNESS),
            Against::Drive => (spans.2, 6, TRIAL_DRIVE_GAIN),
        };
        let Some((at, width)) = window_grid(range, count) else {
            continue;
        };
        let first = probes.len();
        probes.extend(at.iter().map(|&u| window(against, u, width, size)));
        groups.push((against, first..probes.len(), at, size));
    }
    let scan = ScoreScan::of_effects(&linear, &fitted.model, &probes)?;
    let all: Vec<usize> = (0..probes.len()).collect();
    let whole = scan.joint(&all);
    let mut curves = Vec::new();
    let mut strongest: Option<(Against, f64)> = None;
    for (against, range, at, size) in groups {
        let members: Vec<usize> = range.collect();
        let Some(own) = scan.joint(&members) else {
            continue;
        };
        let gain = own.gain - own.rank as f64;
        if strongest.is_none_or(|s| gain > s.1) {
            strongest = Some((against, gain));
        }
        if matches!(
            against,
            Against::Height | Against::Velocity | Against::Voltage
        ) {
            curves.push(ForceCurve {
                against: against.symbol(),
                unit: against.unit(),
                force: own.theta.iter().map(|t| t * size).collect(),
                std_error: own.errors.iter().map(|e| e * size).collect(),
                law: Vec::new(),
                at,
            });
        }
    }
    curves.extend(force_since_contact(&linear, fitted)?);
    Ok(MissingForces {
        joint: whole.map_or(0.0, |w| w.gain - w.rank as f64),
        curves,
        strongest,
    })
}

/// Force against the time that the mass has been off the ground. It is constant within each
/// segment and estimated in groups of segments of similar age. `None` where few flight segments
/// follow a contact.
fn force_since_contact(
    linear: &Linearized<'_>,
    fitted: &Fitted,
) -> Result<Option<ForceCurve>, SimError> {
    if !fitted.model.has_ground {
        return Ok(None);
    }
    let segments = &fitted.point.segments;
    let undisturbed = event_free_since(&fitted.problem, segments);
    let everywhere = window(Against::Height, 0.0, UNBOUNDED_WIDTH, TRIAL_FORCE);
    let products = linear.segment_grams(&fitted.model, &[everywhere])?;
    let age = |p: &SegmentGram| {
        let (begin, after_event) = undisturbed[p.segment];
        (after_event && !segments[p.segment].starts_held).then_some(p.middle - begin)
    };
    let mut ages: Vec<f64> = products.iter().filter_map(age).collect();
    if ages.len() < AGE_GROUPS * MIN_SEGMENTS_PER_GROUP {
        return Ok(None);
    }
    ages.sort_by(f64::total_cmp);
    // Equally many segments in each group.
    let first = |group: usize| ages[group * ages.len() / AGE_GROUPS];
    let spread: Vec<SegmentGram> = products
        .iter()
        .map(|p| {
            let group = age(p).map(|age| (1..AGE_GROUPS).filter(|&g| first(g) <= age).count());
            p.in_group(group, AGE_GROUPS)
        })
        .collect();
    let scan = ScoreScan::assemble(linear, &spread, AGE_GROUPS);
    let all: Vec<usize> = (0..AGE_GROUPS).collect();
    let middle = |group: usize| {
        let own = &ages[group * ages.len() / AGE_GROUPS..(group + 1) * ages.len() / AGE_GROUPS];
        own[own.len() / 2]
    };
    Ok(scan.joint(&all).map(|own| ForceCurve {
        against: SINCE_CONTACT,
        unit: "s",
        at: (0..AGE_GROUPS).map(middle).collect(),
        force: own.theta.iter().map(|t| t * TRIAL_FORCE).collect(),
        std_error: own.errors.iter().map(|e| e * TRIAL_FORCE).collect(),
        law: Vec::new(),
    }))
}
