//! The ensemble of a sweep.

use anyhow::{anyhow, bail};

use super::arguments::Arguments;
use super::grid;
use crate::explore::map::MapRequest;
use crate::explore::measures::Regime;
use crate::explore::robustness::{Ensemble, RobustnessRequest, Spread, Wish};

/// Devices of an ensemble without `--ensemble`.
const USUAL_MEMBERS: usize = 32;
/// Codes of regimes in which the mass touches the ground.
const REGIME_CODES: std::ops::Range<u32> = 1..64;

/// The ensemble over a map, if options ask for one.
pub fn request(args: &Arguments, map: &MapRequest) -> anyhow::Result<Option<RobustnessRequest>> {
    let ranges = grid::ranges(&args.over, &map.model)?;
    if ranges.is_empty() {
        if args.ensemble.is_some() || !args.want.is_empty() {
            bail!(
                "--ensemble and --want need coefficients that vary; write for example --over Cs:0.5x..2x"
            );
        }
        return Ok(None);
    }
    let wish = if args.want.is_empty() {
        any_contact()
    } else {
        grid::wish(&args.want)?
    };
    let ensemble = Ensemble {
        spread: Spread::Ranges(ranges),
        members: args.ensemble.unwrap_or(USUAL_MEMBERS),
        seed: args.seed,
    };
    ensemble
        .check(&map.model)
        .map_err(|error| anyhow!("--over, --ensemble: {error}"))?;
    wish.check().map_err(|error| anyhow!("--want: {error}"))?;
    Ok(Some(RobustnessRequest {
        map: map.clone(),
        ensemble,
        wish,
    }))
}

/// The wish without `--want`: a periodic response that touches the ground and lets go.
fn any_contact() -> Wish {
    let all = REGIME_CODES.filter_map(Regime::from_code);
    let wanted = all.filter(|own| !matches!(own, Regime::NeverLetsGo | Regime::NotPeriodic));
    Wish {
        regimes: wanted.collect(),
        bounds: Vec::new(),
    }
}
