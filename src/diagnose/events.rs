//! View 2: what happens at the ground. Bounces, releases and stays are read with the
//! model of flight as fitted and no law of the ground; the laws are then fitted to the
//! readings, and each that the model lacks is a hypothesis like any other.

use super::bench::{Bench, Fitted, Side};
use super::options::DiagnoseError;
use crate::fit::prepare::Prepared;
use crate::fit::readings::{self, Readings};
use crate::fit::robust::Huber;
use crate::fit::solve::{Point, settle};

/// Longest stretch around events \[s\]: few events in each, so that one that is misread
/// spoils no others.
const LONGEST: f64 = 1.2e-3;
/// Errors of the readings are not believed below this share of the quantity: instants of
/// neighbouring events share what is left of the model's error.
const LEAST_RATIO_ERROR: f64 = 2e-3;
/// See above, for forces \[N\].
const LEAST_FORCE_ERROR: f64 = 5e-11;

/// Readings at the ground on both sides.
#[derive(Debug, Clone, Default)]
pub struct Ground {
    /// Of the fitted recordings.
    pub train: Readings,
    /// Of those kept out.
    pub held_out: Readings,
    /// Mass that the ground feels \[kg\].
    pub mass: f64,
}

/// Reads the events of both sides with the models as fitted.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn read(
    bench: &Bench,
    train: &Fitted,
    held_out: Option<&Fitted>,
) -> Result<Ground, DiagnoseError> {
    if !train.model.has_ground {
        return Ok(Ground::default());
    }
    let other = match (held_out, &bench.held_out) {
        (Some(fitted), Some(side)) => side_readings(bench, side, fitted)?,
        _ => Readings::default(),
    };
    Ok(Ground {
        train: side_readings(bench, &bench.train, train)?,
        held_out: other,
        mass: 1.0 / train.model.structure().mobility(),
    })
}

fn side_readings(bench: &Bench, side: &Side, fitted: &Fitted) -> Result<Readings, DiagnoseError> {
    let (prepared, point) = around_events(bench, side, fitted)?;
    let mut found = readings::read(&prepared, &point)?;
    log::debug!(
        "{} bounces and {} releases read, {} and {} not, {:.2} off",
        found.bounces.len(),
        found.releases.len(),
        found.unread,
        found.unread_releases,
        found.off.read
    );
    for b in &mut found.bounces {
        b.error = b.error.hypot(LEAST_RATIO_ERROR);
    }
    for r in &mut found.releases {
        r.error = r.error.hypot(LEAST_FORCE_ERROR);
    }
    Ok(found)
}

/// Short stretches of one side with what happens at the ground in them, told by the model as
/// fitted and no law of the ground.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn around_events(
    bench: &Bench,
    side: &Side,
    fitted: &Fitted,
) -> Result<(Prepared, Point), DiagnoseError> {
    let mut prepared = bench.with_events(side, &fitted.model, LONGEST)?;
    let own = &fitted.problem;
    for (data, known) in prepared.problem.data.iter_mut().zip(&own.data) {
        data.sigmas = known.sigmas;
        data.sigmas.velocity *= readings::LOOSE;
        data.sigmas.force *= readings::LOOSE;
        data.sigmas.height *= readings::LOOSE;
        data.epoch = known.epoch;
    }
    prepared.problem.space = own.space.clone();
    let x = &fitted.point.x;
    let used: Vec<bool> = prepared.segments.iter().map(|s| s.has_events()).collect();
    let point = settle(
        &prepared.problem,
        x,
        &prepared.segments,
        &used,
        Huber(1e3),
        6,
    )?;
    let point = settle(&prepared.problem, x, &point.segments, &used, Huber(6.0), 5)?;
    Ok((prepared, point))
}
