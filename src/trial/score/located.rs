//! Whether a diagnosis looks for the mismatch where the concealed effect acts.

use super::reported::Place;
use crate::diagnose::diagnosis::Regime;
use crate::trial::truth::Truth;

/// What the mass is doing where an effect acts; `None` for one that acts everywhere in
/// flight, or on the reading.
fn regimes(effect: &str) -> Option<&'static [Regime]> {
    use crate::diagnose::diagnosis::Regime::{
        Contact, Impact, NearGroundApproach, NearGroundDeparture, Release,
    };
    match effect {
        // The level shows while the mass lies on the ground and as it touches. It shows
        // before the step as well: a re-tuned ground lies between both levels.
        "gap_step" => Some(&[Impact, Contact, Release]),
        // Too weak or strong a hold ends the stay too early or too late.
        "adhesion_saturation" => Some(&[Contact, Release]),
        "velocity_restitution" => Some(&[Impact]),
        "compliant_ground" => Some(&[Impact, Contact, Release]),
        "film_spring" | "long_range_attraction" => {
            Some(&[NearGroundApproach, Impact, NearGroundDeparture])
        }
        _ => None,
    }
}

/// Share of the reported mismatch that lies where the concealed effects act; `None` where one
/// of them acts everywhere, nothing is concealed, or nothing is reported.
pub fn located(truth: &Truth, places: &[Place]) -> Option<f64> {
    let where_each: Vec<&[Regime]> = truth
        .effects
        .iter()
        .map(|e| regimes(&e.id))
        .collect::<Option<_>>()?;
    if where_each.is_empty() {
        return None;
    }
    let acts = |place: &&Place| where_each.iter().any(|list| list.contains(&place.regime));
    let whole: f64 = places.iter().map(|p| p.share).sum();
    let there: f64 = places.iter().filter(acts).map(|p| p.share).sum();
    (whole > 0.0).then(|| there / whole)
}

#[cfg(test)]
mod tests {
    use super::super::located::*;
    use crate::trial::draw::{Case, Mix, Settings};

    #[test]
    fn weight_counts() {
        let truth = |id: &str| {
            let settings = Settings {
                mix: Mix::Effect(id.to_owned()),
                rate: 2e3,
                ..Settings::default()
            };
            Case::draw(1, &settings).unwrap().into_parts().1.open().0
        };
        let place = |regime, share| Place {
            recording: "a".into(),
            regime,
            share,
        };
        let told = [
            place(Regime::Impact, 0.3),
            place(Regime::FarFlight, 0.1),
            place(Regime::Contact, 0.2),
        ];
        let of = |id: &str| located(&truth(id), &told);
        assert!((of("velocity_restitution").unwrap() - 0.5).abs() < 1e-12);
        assert!((of("gap_step").unwrap() - 5.0 / 6.0).abs() < 1e-12);
        assert_eq!(of("quadratic_drag"), None);
        assert_eq!(located(&truth("gap_step"), &[]), None);
    }
}
