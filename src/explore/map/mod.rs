//! Maps: measures of the steady response over one or two axes.
//!
//! An axis is a number of the drive ([`crate::explore::waveform::parameters`]) or a parameter of the
//! model or of its effects. Each point is the steady response of a device that is switched on from
//! rest (or from another start, the same for all points), and nothing else: it does not depend on its neighbours, on
//! the number of threads, or on which part of a map is computed. So maps, parts of maps and single points agree to
//! the last bit. What coexists with it is shown by [`crate::explore::orbit`] and
//! [`crate::explore::basin`].
//!
//! # Interface
//! [`MapRequest`] says what is asked; [`MapRequest::check`] refuses what makes no sense, such as sizes out of
//! memory. [`compute`] answers. While it works it hands over batches ([`MapUpdate`]) from its
//! threads; [`MapResult::apply`] puts them into a result of one's own. `cancel` ends it soon, with the
//! points solved so far. The order is: a coarse lattice; where the regime changes, finer and finer;
//! all others, unless [`Refinement::WhereRegimeChanges`] is asked. Points between coarse ones of one
//! regime are first filled: marked [`PointState::Filled`], categories as around, numbers
//! interpolated. [`solve_point`] solves one of them on demand, with its whole response.
//!
//! A point that cannot be computed is a hole with its reason ([`MapResult::holes`]). A measure that a
//! response does not have (an impact speed without contact) is NaN at a point that is no hole.
//!
//! # Examples
//! ```
//! use std::sync::atomic::AtomicBool;
//! use impactscope::explore::map::{Axis, MapRequest, compute};
//! use impactscope::explore::measures::MeasureId;
//! use impactscope::model::{drive::Waveform, preset::Preset};
//!
//! let model = Preset::default().model;
//! let drive = Waveform::parse("square:50Hz:7V", 0.02)?;
//! let frequency = Axis::new("f", (&model, &drive), (40.0, 60.0), 3)?;
//! let amplitude = Axis::new("V", (&model, &drive), (2.0, 8.0), 2)?;
//! let request = MapRequest::new(model, drive, vec![frequency, amplitude], vec![MeasureId::Regime]);
//! let map = compute(&request, &AtomicBool::new(false), &|_| {})?;
//! assert_eq!((map.values[0].len(), map.is_complete()), (6, true));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod axis;
mod compute;
mod error;
mod lattice;
mod point;
mod request;
mod result;
#[cfg(test)]
mod tests;

pub use self::axis::{Axis, AxisOf};
pub use self::compute::{compute, compute_points, solve_point};
pub use self::error::MapError;
pub use self::lattice::progressive_order;
pub use self::point::{PointFault, PointSolver};
pub use self::request::{MapRequest, MapStart, Refinement};
pub use self::result::{MapPoint, MapResult, MapUpdate, Pass, PointState};
