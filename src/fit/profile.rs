//! Profile likelihood: the best cost with one parameter held at a row of values.

use super::error::FitError;
use super::prepare::Prepared;
use super::solve::{Clock, Control, Plan, Point, improve, settle, threshold};

/// One point of a profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfilePoint {
    /// Value of the parameter, SI.
    pub value: f64,
    /// Rise of the cost above the best: 1 at one standard error, 3.84 at 95 %.
    pub rise: f64,
}

/// Profile of the parameter `id` at `best` over `shifts` of its coordinate (of its
/// logarithm, or of a tenth of its range), from the middle outwards being quickest.
///
/// # Errors
/// [`FitError`] if the parameter is not free or the model makes no sense.
pub fn profile(
    prepared: &Prepared,
    best: &Point,
    id: &str,
    shifts: &[f64],
    control: &Control<'_>,
) -> Result<Vec<ProfilePoint>, FitError> {
    let problem = &prepared.problem;
    let Some(at) = problem.space.position(id) else {
        let known: Vec<&str> = problem
            .space
            .entries
            .iter()
            .map(|e| e.id.as_str())
            .collect();
        return Err(FitError::UnknownParameter {
            id: id.to_owned(),
            known: known.join(", "),
        });
    };
    let huber = threshold(problem, best)?;
    let entry = &problem.space.entries[at];
    let mut out = Vec::with_capacity(shifts.len());
    let mut clock = Clock::new(6 * shifts.len());
    for shift in shifts {
        if control.cancelled() {
            break;
        }
        let mut x = best.x.clone();
        x[at] = (x[at] + shift).clamp(entry.low, entry.high);
        let point = settle(problem, &x, &best.segments, &best.used, huber, 2)?;
        let plan = Plan {
            stage: "profile",
            iterations: 6,
            locked: &[at],
            enough: 1e-6,
        };
        let point = improve(problem, point, &plan, control, &mut clock)?;
        out.push(ProfilePoint {
            value: problem.space.values(&point.x)[at],
            rise: point.cost - best.cost,
        });
    }
    Ok(out)
}
