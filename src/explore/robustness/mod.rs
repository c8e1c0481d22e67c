//! Robustness: what becomes of a response when the coefficients of the device are not what they
//! seem, and waveforms that keep it.
//!
//! # Interface
//! An [`Ensemble`] draws devices: coefficients from ranges, or from the normal distribution that a
//! fit leaves. A [`Wish`] says which response is wanted. [`compute`] gives for each point of a map the
//! probability of the wish, quantiles of measures, and the coefficient that breaks it first
//! ([`Robustness`]); a point that is impossible for each member is a hole with its reason.
//! [`find_robust_waveform`] searches numbers of the drive for the highest probability. All take a flag
//! that cancels them and keep what they have, and give the same bits for the same seed, whatever the
//! number of threads: each point sees the same members.
//!
//! # Examples
//! ```
//! use std::sync::atomic::AtomicBool;
//! use impactscope::explore::map::{Axis, MapRequest};
//! use impactscope::explore::measures::MeasureId;
//! use impactscope::explore::robustness::{
//!     CoefficientRange, Ensemble, RobustnessRequest, Spread, Wish, compute,
//! };
//! use impactscope::model::{drive::Waveform, preset::Preset};
//!
//! let model = Preset::default().model;
//! let drive = Waveform::parse("square:50Hz:7V", 0.02)?;
//! let axis = Axis::new("V", (&model, &drive), (3.0, 8.0), 2)?;
//! let ranges = vec![CoefficientRange::relative("Ca0", 0.5, 2.0)];
//! let request = RobustnessRequest {
//!     map: MapRequest::new(model, drive, vec![axis], vec![MeasureId::ContactShare]),
//!     ensemble: Ensemble { spread: Spread::Ranges(ranges), members: 4, seed: 1 },
//!     wish: Wish::in_contact(0.05, 0.5),
//! };
//! let map = compute(&request, &AtomicBool::new(false), &|_| {})?;
//! assert!(map.points.iter().flatten().all(|p| p.is_ok()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod compute;
mod ensemble;
mod error;
mod evaluate;
mod result;
mod search;
mod search_setup;
#[cfg(test)]
mod tests;
mod wish;

pub use self::compute::{RobustUpdate, RobustnessMap, RobustnessRequest, compute, compute_points};
pub use self::ensemble::{Change, CoefficientRange, Ensemble, Member, NormalSpread, Spread};
pub use self::error::RobustnessError;
pub use self::evaluate::evaluate;
pub use self::result::{Breaker, Quantiles, Robustness};
pub use self::search::{FoundWaveform, SearchProgress, SearchResult, find_robust_waveform};
pub use self::search_setup::{SearchedNumber, WaveformSearch};
pub use self::wish::{MeasureBound, Wish};
