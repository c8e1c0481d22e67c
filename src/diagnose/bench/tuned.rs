//! The baseline re-tuned, with the recordings cut again for it where they turn out to have been
//! misread: readings that are late, a mass that rests over the ground without touching it.

use super::{Bench, Fitted, Known, Side, clocks};
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::model::Model;

/// How often recordings are cut again for readings that are late.
const AGAIN: usize = 2;
/// Share of a recording's stays that must be misread for the mass to hover.
const MISREAD: f64 = 0.5;
/// Fewest of them.
const LEAST: usize = 3;
/// Chi2 per value may grow by this factor where stretches that were set aside come back.
const NO_WORSE: f64 = 1.02;

/// The re-tuned baseline.
#[derive(Debug)]
pub struct Tuned {
    /// The recordings as cut for it.
    pub bench: Bench,
    /// Its fit.
    pub train: Fitted,
    /// Those kept out, judged; `None` if there are none.
    pub held_out: Option<Fitted>,
    /// What was found out, in sentences.
    pub remarks: Vec<String>,
}

impl Fitted {
    /// Recordings whose stays on the ground were set aside as misread, most of them.
    fn doubtful(&self) -> Vec<usize> {
        let stays = |k: usize, aside: bool| {
            let all = self.point.segments.iter().zip(&self.point.used);
            all.filter(|(s, used)| s.recording == k && s.starts_held && !(aside && **used))
                .count()
        };
        (0..self.problem.data.len())
            .filter(|&k| {
                let (all, aside) = (stays(k, false), stays(k, true));
                aside >= LEAST && aside as f64 > MISREAD * all as f64
            })
            .collect()
    }

    /// Whether `other`, for which the recordings are cut in another way, has fewer stretches
    /// set aside and comes as near.
    fn yields_to(&self, other: &Self) -> bool {
        let nearer = other.per_value() < NO_WORSE * self.per_value().max(1.0);
        log::debug!(
            "flown through: {:.1} % aside in place of {:.1} %, chi2 per value {:.3} in place of {:.3}",
            100.0 * other.aside(),
            100.0 * self.aside(),
            other.per_value(),
            self.per_value()
        );
        other.aside() < self.aside() && nearer
    }
}

impl Bench {
    /// The baseline re-tuned from `model`, with the recordings cut for it again where their
    /// readings turn out to be late by more than stretches bear, and without stays in those
    /// in which flight through suits better.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a recording or the model cannot be used.
    pub fn tuned(
        self,
        model: &Model,
        options: &DiagnoseOptions,
        control: &DiagnoseControl<'_>,
    ) -> Result<Tuned, DiagnoseError> {
        let mut known = Known::default();
        let mut bench = self;
        let again = |bench: &Self, known: &Known| {
            let held_out = bench.held_out.as_ref().map_or(&[][..], |s| &s.parts);
            Self::of_known(model, (&bench.train.parts, held_out), options, known)
        };
        let mut train = bench.baseline(model, control)?;
        for _ in 0..AGAIN {
            let Some(late) = clocks::late(&train).filter(|_| !control.cancelled()) else {
                break;
            };
            known.late += late;
            log::debug!("readings are {:.1} us late", 1e6 * known.late);
            bench = again(&bench, &known)?;
            train = bench.baseline(model, control)?;
        }
        let mut remarks = Vec::new();
        let hovers = train.doubtful();
        if !hovers.is_empty() && !control.cancelled() {
            let mut flown = known.clone();
            flown.hovers.0 = hovers;
            let other = again(&bench, &flown)?;
            let fit = other.baseline(model, control)?;
            if train.yields_to(&fit) {
                remarks.extend(said(&other.train, &flown.hovers.0));
                (bench, train, known) = (other, fit, flown);
            }
        }
        let mut held_out = bench.judge(&train.model, (&train, None), control)?;
        let hovers = held_out.as_ref().map_or(Vec::new(), Fitted::doubtful);
        if !hovers.is_empty() && !control.cancelled() {
            let mut flown = known;
            flown.hovers.1 = hovers;
            let other = again(&bench, &flown)?;
            let judged = other.judge(&train.model, (&train, None), control)?;
            let pair = held_out.as_ref().zip(judged.as_ref());
            if pair.is_some_and(|(before, after)| before.yields_to(after)) {
                let side = other.held_out.as_ref();
                remarks.extend(side.into_iter().flat_map(|s| said(s, &flown.hovers.1)));
                (bench, held_out) = (other, judged);
            }
        }
        Ok(Tuned {
            bench,
            train,
            held_out,
            remarks,
        })
    }
}

/// That the mass hovers in some recordings of a side.
fn said(side: &Side, hovers: &[usize]) -> Vec<String> {
    let one = |&k: &usize| {
        format!(
            "{}: the mass comes to rest over the ground without touching it, and says nothing of contact",
            side.parts[k].recording.name
        )
    };
    hovers.iter().map(one).collect()
}
