//! The numbers that decide what a sweep tells. Check with `cargo test --lib fit::modal`.

/// Share of the largest power of the input above which a frequency counts as driven \[-\]. A sweep's
/// band falls off by far more within a few lines of its ends.
pub const MIN_DRIVEN_SHARE: f64 = 1e-3;
/// Highest over lowest driven frequency, at least \[-\]. A single sine or a narrow dither tells no
/// damping.
pub const MIN_BAND_RATIO: f64 = 1.15;
/// Driven lines of the spectrum, at least \[-\]. A square or a sine has only its harmonics.
pub const MIN_DRIVEN_LINES: usize = 24;
/// Share of the lines between the lowest and the highest driven one that are driven \[-\]: a comb of
/// harmonics is no sweep.
pub const MIN_DRIVEN_FILL: f64 = 0.5;
/// Share of `dp` down to which the mass is taken to stay clear of the ground \[-\]. The zero of the
/// reading may be off by a quarter of it.
pub const CLEAR_OF_GROUND: f64 = 0.75;
/// Shortest stretch between two contacts that is used \[periods of the lowest driven frequency\]. A
/// shorter one tells its own beginning and little more.
pub const MIN_STRETCH_PERIODS: f64 = 3.0;
/// Log-likelihood that one more mode must gain \[-\], on top of its number of unknowns: 30 is chance once
/// in 1e12 for noise that is white, and residuals of recordings are not quite.
pub const MIN_MODE_GAIN: f64 = 30.0;
/// Standard errors of the frequency and damping of an identified mode, at most \[share\]. Beyond, the
/// mode is seen but not determined.
pub const MAX_FREQUENCY_ERROR: f64 = 0.01;
/// The same for the damping.
pub const MAX_DAMPING_ERROR: f64 = 0.2;
/// Residue of an identified mode in one of the readings, at least \[standard errors\].
pub const MIN_RESIDUE_Z: f64 = 8.0;
/// Damping ratio above which a fitted mode is a background and no resonance \[-\].
pub const MAX_ZETA: f64 = 0.7;
/// How far outside the driven band a mode counts as identified \[half-widths of its resonance\].
pub const BAND_MARGIN_WIDTHS: f64 = 1.0;
/// Misfit over the noise from which the result says that the model does not follow \[-\]. Noise
/// estimates are good to 20 %.
pub const MAX_MISFIT_RATIO: f64 = 1.5;
/// Misfit over the noise up to which the modes found may be given to a device. Beyond, what is fitted is
/// mostly something else.
pub const MAX_RELIABLE_MISFIT_RATIO: f64 = 10.0;
/// Difference between circle fit and rational fit that is remarked on \[share of the frequency\].
pub const MAX_CIRCLE_FREQUENCY_DIFFERENCE: f64 = 0.005;
/// The same for the damping \[share\].
pub const MAX_CIRCLE_DAMPING_DIFFERENCE: f64 = 0.1;
