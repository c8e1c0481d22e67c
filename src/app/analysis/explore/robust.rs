//! Robustness: the ensemble and the wish of the choices, the answer for one drive, the map of
//! probabilities, and the search for a robust waveform.

use eframe::egui::Context;

use super::latest::{Answers, Latest};
use super::mapping::axis_of;
use super::run::Run;
use crate::app::setup::explore::{RobustnessChoices, WishChoices};
use crate::explore::map::MapRequest;
use crate::explore::measures::{MeasureId, Regime};
use crate::explore::robustness::{
    CoefficientRange, Ensemble, MeasureBound, NormalSpread, Robustness, RobustnessMap,
    RobustnessRequest, SearchProgress, SearchResult, SearchedNumber, Spread, WaveformSearch, Wish,
    compute, evaluate, find_robust_waveform,
};
use crate::explore::waveform::{DriveLimits, parameters};
use crate::fit::FitResult;
use crate::model::Model;
use crate::model::drive::{Cycle, PeriodicDrive, Waveform};

/// Measures whose quantiles are shown.
const SHOWN_MEASURES: [MeasureId; 3] = [
    MeasureId::ContactShare,
    MeasureId::LargestImpactSpeed,
    MeasureId::Bounces,
];
/// Id of the number that scales all handles of a drawn period: searched beside them, it would move
/// the same things twice.
const AMPLITUDE_ID: &str = "amplitude";

/// What an ensemble around the present device says of one drive.
#[derive(Debug, Clone, PartialEq)]
pub struct PointQuestion {
    /// Device, measures and options; without axes.
    pub point: MapRequest,
    /// The devices.
    pub ensemble: Ensemble,
    /// What is wanted.
    pub wish: Wish,
}

/// The worker behind [`Robusting::point`].
#[derive(Default)]
pub struct PointWork;

impl Answers for PointWork {
    type Question = PointQuestion;
    type Answer = Robustness;
    const NAME: &'static str = "robustness";

    fn answer(
        &mut self,
        question: &PointQuestion,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Robustness, String> {
        let PointQuestion {
            point,
            ensemble,
            wish,
        } = question;
        let of = (&point.model, &point.drive);
        match evaluate(point, of, ensemble, wish, go_on) {
            Ok(Some(found)) => Ok(found),
            Ok(None) => Err("given up".to_owned()),
            Err(error) => Err(error.to_string()),
        }
    }
}

/// A search while it goes on, and its result.
#[derive(Debug, Clone, Default)]
pub struct SearchView {
    /// How far it is.
    pub progress: Option<SearchProgress>,
    /// What it found.
    pub result: Option<SearchResult>,
}

/// State of the robustness panel.
#[derive(Debug, Clone, Default)]
pub struct Robusting {
    /// The present drive.
    pub point: Latest<PointWork>,
    /// Why nothing is asked of it.
    pub refusal: Option<String>,
    /// Probabilities over two numbers.
    pub map: Run<RobustnessRequest, RobustnessMap>,
    /// Whether the map was stopped by hand.
    pub is_stopped: bool,
    /// The search.
    pub search: Run<WaveformSearch, SearchView>,
}

/// The devices of the choices.
///
/// # Errors
/// Why there are none.
pub fn ensemble_of(
    choices: &RobustnessChoices,
    fit: Option<&FitResult>,
) -> Result<Ensemble, String> {
    let spread = if choices.from_fit {
        let fit = fit.ok_or(
            "there is no fit whose covariance could be taken; fit in Tune, or take ranges",
        )?;
        normal_of(fit)?
    } else {
        let ranges = choices.coefficients.iter();
        Spread::Ranges(
            ranges
                .map(|c| CoefficientRange::relative(&*c.id, 1.0 / c.factor, c.factor))
                .collect(),
        )
    };
    Ok(Ensemble {
        spread,
        members: choices.members,
        seed: choices.seed,
    })
}

/// The parameters that a fit determines, jointly normal.
fn normal_of(fit: &FitResult) -> Result<Spread, String> {
    let all = fit.parameters.iter().enumerate();
    let known: Vec<usize> = all
        .filter(|(_, p)| p.std_error.is_finite() && p.std_error > 0.0)
        .map(|(i, _)| i)
        .collect();
    if known.is_empty() {
        return Err("the fit determines no parameter, so it has no covariance".to_owned());
    }
    let each = |of: &dyn Fn(usize) -> f64| known.iter().map(|i| of(*i)).collect();
    Ok(Spread::Normal(NormalSpread {
        ids: known
            .iter()
            .map(|i| fit.parameters[*i].id.clone())
            .collect(),
        means: each(&|i| fit.parameters[i].value),
        std_errors: each(&|i| fit.parameters[i].std_error),
        correlation: known
            .iter()
            .map(|i| known.iter().map(|j| fit.correlations[(*i, *j)]).collect())
            .collect(),
    }))
}

/// The wish of the choices.
#[must_use]
pub fn wish_of(choices: &WishChoices) -> Wish {
    let codes = choices.regimes.iter();
    let bound = |measure, low, high| MeasureBound { measure, low, high };
    let share = choices.contact_share;
    let share = share.map(|(a, b)| bound(MeasureId::ContactShare, Some(a), Some(b)));
    let speed = choices.impact_speed;
    let speed = speed.map(|most| bound(MeasureId::LargestImpactSpeed, None, Some(most)));
    Wish {
        regimes: codes.filter_map(|code| Regime::from_code(*code)).collect(),
        bounds: share.into_iter().chain(speed).collect(),
    }
}

fn measures(model: &Model) -> Vec<MeasureId> {
    if model.has_ground {
        SHOWN_MEASURES.into()
    } else {
        vec![MeasureId::Peak]
    }
}

/// What is asked of the present drive.
///
/// # Errors
/// What is wrong with the choices.
pub fn point_question(
    choices: &RobustnessChoices,
    fit: Option<&FitResult>,
    (model, drive): (&Model, &Waveform),
) -> Result<PointQuestion, String> {
    let ensemble = ensemble_of(choices, fit)?;
    let wish = wish_of(&choices.wish);
    let text = |error: &dyn std::error::Error| error.to_string();
    ensemble.check(model).map_err(|error| text(&error))?;
    wish.check().map_err(|error| text(&error))?;
    Ok(PointQuestion {
        point: MapRequest::new(model.clone(), drive.clone(), Vec::new(), measures(model)),
        ensemble,
        wish,
    })
}

/// What is asked of the map.
///
/// # Errors
/// What is wrong with the choices.
pub fn map_question(
    choices: &RobustnessChoices,
    fit: Option<&FitResult>,
    of: (&Model, &Waveform),
) -> Result<RobustnessRequest, String> {
    let point = point_question(choices, fit, of)?;
    let axis = |choice| axis_of(choice, of, choices.points).map_err(|error| error.to_string());
    let request = RobustnessRequest {
        map: MapRequest {
            axes: vec![axis(&choices.x)?, axis(&choices.y)?],
            ..point.point
        },
        ensemble: point.ensemble,
        wish: point.wish,
    };
    let points = request.map.points() as u128;
    request
        .check_for(points)
        .map_err(|error| error.to_string())?;
    Ok(request)
}

/// Ids of the numbers of a drive that can be searched.
#[must_use]
pub fn searchable(drive: &Waveform) -> Vec<(String, String)> {
    let is_drawn =
        PeriodicDrive::of(drive).is_some_and(|drive| matches!(drive.cycle, Cycle::Drawn(_)));
    let all = parameters(drive).into_iter();
    all.filter(|p| !(is_drawn && p.id == AMPLITUDE_ID))
        .map(|p| (p.id, p.name))
        .collect()
}

/// What is asked of the search.
///
/// # Errors
/// What is wrong with the choices.
pub fn search_question(
    choices: &RobustnessChoices,
    fit: Option<&FitResult>,
    limits: DriveLimits,
    (model, drive): (&Model, &Waveform),
) -> Result<WaveformSearch, String> {
    let point = point_question(choices, fit, (model, drive))?;
    let ids: Vec<String> = searchable(drive).into_iter().map(|(id, _)| id).collect();
    let limit = limits.voltage.unwrap_or(f64::INFINITY);
    let numbers = parameters(drive)
        .into_iter()
        .filter(|p| ids.contains(&p.id) && !choices.held.contains(&p.id))
        .map(|p| {
            let is_voltage = p.unit == "V";
            let (low, high) = p.range;
            SearchedNumber {
                id: p.id,
                low: if is_voltage { low.max(-limit) } else { low },
                high: if is_voltage { high.min(limit) } else { high },
            }
        });
    let search = WaveformSearch {
        limits,
        population: choices.population,
        generations: choices.generations,
        seed: choices.seed,
        ..WaveformSearch::new(
            (model.clone(), drive.clone()),
            numbers.collect(),
            point.wish,
            point.ensemble,
        )
    };
    search.check().map_err(|error| error.to_string())?;
    Ok(search)
}

impl Robusting {
    /// Begins the map.
    pub fn start_map(&mut self, request: Result<RobustnessRequest, String>, context: &Context) {
        let request = match request {
            Ok(request) => request,
            Err(reason) => return self.map.refuse(reason),
        };
        self.is_stopped = false;
        let empty = RobustnessMap::pending(&request);
        self.map
            .start("robustness", request, empty, context, |request, parts| {
                let found = compute(request, parts.cancel, &|update| {
                    let share = update.done as f64 / update.total.max(1) as f64;
                    parts.add(share, |map| map.apply(&update));
                });
                found.map(|_| ()).map_err(|error| error.to_string())
            });
    }

    /// Begins the search.
    pub fn start_search(&mut self, search: Result<WaveformSearch, String>, context: &Context) {
        let search = match search {
            Ok(search) => search,
            Err(reason) => return self.search.refuse(reason),
        };
        let empty = SearchView::default();
        self.search.start(
            "robust waveform",
            search,
            empty,
            context,
            |search, parts| {
                let found = find_robust_waveform(search, parts.cancel, &|progress| {
                    let share = progress.generation as f64 / progress.generations.max(1) as f64;
                    parts.add(share, |view| view.progress = Some(progress));
                });
                let found = found.map_err(|error| error.to_string())?;
                parts.add(1.0, |view| view.result = Some(found));
                Ok(())
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::super::robust::*;
    use crate::app::setup::explore::ExploreChoices;
    use crate::model::preset::Preset;

    #[test]
    fn choices_become_questions_and_bad_ones_say_why() {
        let model = Preset::default().model;
        let explore = ExploreChoices::default();
        let drive = explore.drawn.waveform().unwrap();
        let of = (&model, &drive);
        let mut choices = explore.robustness;
        let point = point_question(&choices, None, of).unwrap();
        assert_eq!(point.ensemble.ids(), ["Cs", "gp", "Ca", "Ca0", "alpha"]);
        choices.points = 3;
        assert_eq!(map_question(&choices, None, of).unwrap().map.points(), 9);
        let limits = DriveLimits {
            voltage: Some(5.0),
            slew: None,
        };
        let search = search_question(&choices, None, limits, of).unwrap();
        assert!(
            search
                .numbers
                .iter()
                .all(|n| n.id != "amplitude" && n.id != "frequency")
        );
        let handle = search.numbers.iter().find(|n| n.id == "h1").unwrap();
        assert_eq!((handle.low, handle.high), (-5.0, 5.0));
        choices.from_fit = true;
        assert!(
            point_question(&choices, None, of)
                .unwrap_err()
                .contains("no fit")
        );
        choices.from_fit = false;
        choices.wish = WishChoices {
            contact_share: None,
            ..WishChoices::default()
        };
        assert!(
            point_question(&choices, None, of)
                .unwrap_err()
                .contains("wanted")
        );
    }
}
