//! The force that is missing, measured point by point without a name ([`super::generic`]),
//! and how much of the misfit such forces could take away at all.

use super::residual_map::calm_since;
use crate::diagnose::diagnosis::ForceCurve;
use crate::diagnose::score_test::basis_forces::{Against, side_by_side, window};
use crate::diagnose::score_test::linearized::{Linearized, SegmentGram};
use crate::diagnose::score_test::scan::ScoreScan;
use crate::diagnose::score_test::state_range::spans;
use crate::diagnose::shooting::fitted::Fitted;
use crate::model::effects::ActiveEffect;
use crate::sim::SimError;

/// Size of a trial force \[N\].
const FORCE: f64 = 1e-10;
/// Size of a trial damping \[N s/m\].
const DAMPING: f64 = 1e-10;
/// Size of a trial stiffness \[N/m\].
const STIFFNESS: f64 = 1e-5;
/// Size of a trial change of `gc`.
const GAIN: f64 = 1e-3;

/// Width of a window that no height leaves \[m\].
const WIDE: f64 = 1e6;
/// Groups of stretches by the time since contact.
const AGES: usize = 8;
/// Fewest stretches in each.
const EACH: usize = 4;
/// What a force curve is drawn against in which the time since contact is.
pub(crate) const SINCE_CONTACT: &str = "time since contact";

/// What forces without a name would bring.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// Fall of chi2 if all were added at once, less what chance would bring.
    pub joint: f64,
    /// Force against height, velocity, voltage and time since contact.
    pub curves: Vec<ForceCurve>,
    /// The quantity against which they bring most, and how much.
    pub strongest: Option<(Against, f64)>,
}

/// Weighs forces without a name at a fit.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn measure(fitted: &Fitted) -> Result<Evidence, SimError> {
    let linear = Linearized::new(fitted)?;
    let spans = spans(fitted);
    let mut probes: Vec<ActiveEffect> = Vec::new();
    let mut groups: Vec<(Against, std::ops::Range<usize>, Vec<f64>, f64)> = Vec::new();
    for against in Against::ALL {
        let (range, count, size) = match against {
            Against::Height => (spans.0, 9, FORCE),
            Against::DampingAtHeight => (spans.0, 5, DAMPING),
            Against::Velocity => (spans.1, 7, FORCE),
            Against::Voltage => (spans.2, 6, FORCE),
            Against::DampingAtVoltage => (spans.2, 4, DAMPING),
            Against::StiffnessAtVoltage => (spans.2, 4, STIFFNESS),
            Against::Drive => (spans.2, 6, GAIN),
        };
        let Some((at, width)) = side_by_side(range, count) else {
            continue;
        };
        let first = probes.len();
        probes.extend(at.iter().map(|&u| window(against, u, width, size)));
        groups.push((against, first..probes.len(), at, size));
    }
    let scan = ScoreScan::of(&linear, &fitted.model, &probes)?;
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
    curves.extend(since_contact(&linear, fitted)?);
    Ok(Evidence {
        joint: whole.map_or(0.0, |w| w.gain - w.rank as f64),
        curves,
        strongest,
    })
}

/// Force against the time that the mass has been off the ground: one that is the same all
/// through each stretch, weighed in groups of stretches of like age. None where few stretches
/// of flight follow a contact.
fn since_contact(linear: &Linearized<'_>, fitted: &Fitted) -> Result<Option<ForceCurve>, SimError> {
    if !fitted.model.has_ground {
        return Ok(None);
    }
    let segments = &fitted.point.segments;
    let calm = calm_since(&fitted.problem, segments);
    let everywhere = window(Against::Height, 0.0, WIDE, FORCE);
    let products = linear.products(&fitted.model, &[everywhere])?;
    let age = |p: &SegmentGram| {
        let (begin, after_event) = calm[p.segment];
        (after_event && !segments[p.segment].starts_held).then_some(p.middle - begin)
    };
    let mut ages: Vec<f64> = products.iter().filter_map(age).collect();
    if ages.len() < AGES * EACH {
        return Ok(None);
    }
    ages.sort_by(f64::total_cmp);
    // As many stretches in each group.
    let first = |group: usize| ages[group * ages.len() / AGES];
    let spread: Vec<SegmentGram> = products
        .iter()
        .map(|p| {
            let group = age(p).map(|age| (1..AGES).filter(|&g| first(g) <= age).count());
            p.spread(group, AGES)
        })
        .collect();
    let scan = ScoreScan::gather(linear, &spread, AGES);
    let all: Vec<usize> = (0..AGES).collect();
    let middle = |group: usize| {
        let own = &ages[group * ages.len() / AGES..(group + 1) * ages.len() / AGES];
        own[own.len() / 2]
    };
    Ok(scan.joint(&all).map(|own| ForceCurve {
        against: SINCE_CONTACT,
        unit: "s",
        at: (0..AGES).map(middle).collect(),
        force: own.theta.iter().map(|t| t * FORCE).collect(),
        std_error: own.errors.iter().map(|e| e * FORCE).collect(),
        law: Vec::new(),
    }))
}
