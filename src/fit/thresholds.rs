//! Every number that decides what a fit accepts, doubts or reports, in one place.
//!
//! Each entry states its unit and why it has this value. Iteration counts, steps of
//! differences and sizes of starts stay where they are used: they change how long a fit
//! takes, not what it says. The values were set on simulated recordings of the paper's
//! device; `cargo test --test identification` holds what follows from them.

// What a recording must show to be fitted.

/// Fewest samples of a recording. Unit: samples. Fewer do not hold one period of the first mode
/// at any usable rate.
pub const MIN_SAMPLES: usize = 20;

/// Share of the samples at one extreme value from which a quantised reading is saturated, where
/// they come in runs. Unit: 1. A ring spends less than this at its turning points.
pub const SATURATED_SHARE: f64 = 0.02;

/// The same for a reading whose noise is finer than its steps. Unit: 1. Noise never stays at one
/// value, so that far fewer samples suffice.
pub const SATURATED_SHARE_IN_NOISE: f64 = 0.002;

/// Longest run at the extreme that a quantised reading may show. Unit: samples. A slow turning
/// point within one step of the recorder stays shorter.
pub const MAX_EXTREME_RUN: usize = 20;

/// Largest difference of the ground's levels in recordings of one device. Unit: m. The zeros of
/// badly adjusted sensors differ by less.
pub const MAX_LEVEL_DIFFERENCE: f64 = 15e-6;

/// The same within one fit. Unit: m. Zeros may be off by some micrometres, and the scales by a
/// percent.
pub const MAX_LEVEL_DIFFERENCE_IN_A_FIT: f64 = 8e-6;

/// Share of its one extreme that a voltage reaches on the other side. Unit: 1. The paper's drives
/// are symmetric; a clipped one is not.
pub const MIN_VOLTAGE_SYMMETRY: f64 = 0.95;

/// Noise below this share of the motion is the rounding of a simulation. Unit: 1. No recorder
/// resolves as much.
pub const NOISELESS_SHARE: f64 = 1e-6;

/// Factor between the recorded ground level and the starting value, or between the recorded
/// voltage and the known ones, from which the unit is wrong. Unit: 1. Units differ by a factor of
/// 1000, devices by less than 10.
pub const OTHER_UNIT_FACTOR: f64 = 300.0;

/// Voltage up to which the branches of the piezo film were measured. Unit: V. Figs. 3 and 4 of
/// the paper.
pub const KNOWN_VOLTAGE: f64 = 8.0;

/// Voltage span below which there is no drive. Unit: V. It holds for V and mV alike: the
/// amplifier's own noise is larger.
pub const MIN_DRIVE_VOLTAGE: f64 = 1e-3;

/// Fewest samples in a period of the first mode. Unit: samples. With fewer than two the ring is
/// aliased.
pub const MIN_SAMPLES_PER_PERIOD: f64 = 3.0;

/// Shortest recording. Unit: periods of the first mode. Below that a wrong unit of time is the
/// likelier cause.
pub const MIN_RECORDED_PERIODS: f64 = 0.5;

/// A reading this many times farther out than all others is a spike. Unit: 1. A bad cell or an
/// overflow is that far out; no motion is.
pub const SPIKE_FACTOR: f64 = 1e3;

/// Up to so many such readings are spikes. Unit: samples. More of them are a signal.
pub const MAX_SPIKES: usize = 5;

/// The same as a share of all samples, for long recordings. Unit: 1.
pub const MAX_SPIKE_SHARE: f64 = 1e-3;

/// Levels this close are the same ground, read with the same zero. Unit: m. Zeros of one session
/// drift by less.
pub const SAME_LEVEL_DISTANCE: f64 = 2e-6;

/// Fewest stays of two samples or more at the lowest reading that make it the ground. Unit:
/// stays. One or two are chance.
pub const MIN_STAYS: usize = 3;

/// A drift that has been shown up to this share of a recording's end is extrapolated to the end.
/// Unit: 1.
pub const MIN_SHOWN_DRIFT_SHARE: f64 = 0.9;

/// Smallest noise that is assumed, as a share of the motion. Unit: 1. The simulation and the
/// recorder's digits are no better.
pub const MIN_NOISE_SHARE: f64 = 1e-5;

/// A ring is searched for up to this factor above and below the device's first frequency. Unit: 1.
/// A factor of 3 would take in the next mode.
pub const RING_SEARCH_FACTOR: f64 = 2.5;

/// Relative difference of two ring frequencies from which the devices are different. Unit: 1. A
/// strong cubic spring or friction changes one device's frequency by less.
pub const OTHER_DEVICE_FREQUENCY_SHARE: f64 = 0.14;

/// Relative difference from which two devices may be different. Unit: 1. Above what amplitude and
/// damping explain.
pub const DOUBTFUL_FREQUENCY_SHARE: f64 = 0.03;

/// A difference of frequencies below this counts as none. Unit: standard errors. High, because
/// neighbouring modes bias the estimate.
pub const FREQUENCY_DIFFERENCE_SIGMAS: f64 = 5.0;

/// Voltages that differ by less than this share are the same. Unit: 1. Accuracy of an amplifier.
pub const SAME_VOLTAGE_SHARE: f64 = 0.01;

/// Heights of rest that differ by more than this share and this length are different. Units: 1
/// and m. Scales are off by a percent, and a piezo creeps.
pub const REST_HEIGHT_TOLERANCE: (f64, f64) = (0.02, 1.5e-6);

/// A measured velocity that changes so many times more than around it, and than noise allows, has
/// jumped. Unit: 1.
pub const VELOCITY_JUMP_FACTOR: f64 = 3.0;

// Voltage, events and segments.

/// A jump of the voltage is this many times steeper than its neighbours. Unit: 1. A fast sine
/// changes its slope by less from sample to sample.
pub const JUMP_STEEPNESS: f64 = 4.0;

/// Smallest jump, as a share of the voltage's span. Unit: 1. A smaller one moves the mass by less
/// than the noise.
pub const MIN_JUMP_SHARE: f64 = 0.02;

/// Distance from the extreme at which the sides of a turn are read. Unit: tolerances of the
/// voltage. Closer to the extreme, noise decides.
pub const TURN_DEPTH_TOLERANCES: f64 = 10.0;

/// Turns whose sides differ by more than this factor are timed by their sample. Unit: 1. The
/// parabola through them has no meaning there.
pub const MAX_TURN_ASYMMETRY: f64 = 3.0;

/// Change of the drive that is a jump rather than a turn, as a share of its voltage. Unit: 1.
pub const MIN_DRIVE_JUMP_SHARE: f64 = 0.02;

/// Fewest samples at the ground's level that count as a stay. Unit: samples. A bounce shows at
/// most two.
pub const MIN_STAY_SAMPLES: usize = 3;

/// Samples at the level on both sides of a single one that is off: then that one is noise. Unit:
/// samples.
pub const LONG_STAY_SAMPLES: usize = 10;

/// Ratio of departure and arrival speed below which there is no bounce. Unit: 1. Slower
/// departures cannot be distinguished from the noise of a stay.
pub const MIN_BOUNCE_RATIO: f64 = 0.12;

/// Fewest samples of a segment. Unit: samples. It has at least four unknowns of its own.
pub const MIN_SEGMENT_SAMPLES: usize = 6;

/// After so many time constants a held cantilever has come to rest. Unit: time constants. A
/// thousandth of its ring is left.
pub const SETTLED_TIME_CONSTANTS: f64 = 7.0;

/// Exponent by which a sensor's memory may fade from sample to sample and still count. Unit: 1. A
/// twentieth is left at 3.
pub const MAX_SENSOR_FADE: f64 = 3.0;

/// An edge of the drive this close to a release may be its cause. Unit: samples. Both instants
/// are known to about one.
pub const RELEASE_EDGE_SAMPLES: f64 = 3.0;

/// A stay below this length is short. Unit: samples. Its begin and end are uncertain by a good
/// part of it.
pub const SHORT_STAY_SAMPLES: f64 = 6.0;

/// Factor on the standard deviation of the pull-off force after a short stay. Unit: 1.
pub const SHORT_STAY_FORCE_FACTOR: f64 = 30.0;

/// Standard deviation of the laws of the ground, as a share of what the noise leaves. Unit: 1.
/// The laws hold much better than the readings show.
pub const GROUND_LAW_NOISE_SHARE: f64 = 0.1;

// Search.

/// Threshold of the robust loss. Unit: standard deviations. Gaussian noise hardly reaches it: 0.3
/// % of the samples are beyond (Huber 1964).
pub const HUBER_THRESHOLD: f64 = 3.0;

/// Cost per row, plus the share of segments set aside, below which no other start is tried. Unit:
/// 1. Noise alone gives 1.
pub const GOOD_START_SCORE: f64 = 1.5;

/// Share of a recording in use below which its nuisances are estimated from the start again.
/// Unit: 1.
pub const MIN_USED_SHARE: f64 = 0.2;

/// Mean cost per row above which a segment's events are suspect. Unit: 1. Noise alone gives 1.
pub const SUSPECT_MEAN_COST: f64 = 1.6;

/// Length of the runs whose mean square is watched. Unit: samples. About as long as a misread
/// bounce is wrong.
pub const SUSPECT_RUN_SAMPLES: usize = 8;

/// Mean square of such a run above which the events are suspect, however long the rest is. Unit:
/// variances of the noise. Noise alone reaches it once in millions of runs.
pub const SUSPECT_RUN_MEAN_SQUARE: f64 = 7.0;

/// Misfit above which events are not revised. Unit: standard deviations of the noise. So far off,
/// the parameters are wrong rather than the events.
pub const MAX_REVISION_MISFIT: f64 = 10.0;

/// Another sequence of events must bring the misfit below this share. Unit: 1. Each has free
/// instants of its own, which lower it a little in any case.
pub const MAX_REVISED_MISFIT_RATIO: f64 = 0.8;

/// Fewest samples before the first event from which the state is known well enough for a
/// prediction. Unit: samples.
pub const MIN_SAMPLES_BEFORE_EVENT: usize = 12;

// Uncertainty and verdicts on a fit.

/// Rise of the cost at the ends of the 95 % interval. Unit: 1. Chi-square of one degree of
/// freedom; profile likelihood (Raue et al., Bioinformatics 25, 1923, 2009).
pub const CHI2_95_ONE_DOF: f64 = 3.84;

/// Correlation from which two parameters cannot be distinguished. Unit: 1. Each error is then
/// more than three times what it would be alone.
pub const EXTREME_CORRELATION: f64 = 0.95;

/// A standard error of this many ranges of the parameter means that it is not determined. Unit:
/// ranges of the slider.
pub const UNDETERMINED_RANGES: f64 = 3.0;

/// Mean square of the residuals, or square of rms over noise, above which a fit is bad. Unit: 1.
/// The noise estimate is off by less than a factor of two.
pub const BAD_FIT_CHI2: f64 = 3.0;

/// Share of a recording set aside above which the rest says nothing. Unit: 1.
pub const UNUSABLE_SHARE: f64 = 0.99;

/// Ratio of rms and noise up to which readings are followed to the noise. Unit: 1.
pub const MAX_FOLLOWED_NOISE_RATIO: f64 = 1.5;

/// Share of a recording set aside above which more is wrong than events that are hard to read.
/// Unit: 1.
pub const MAX_SET_ASIDE_SHARE: f64 = 0.5;

/// Standard error, as a share of the value, from which a parameter is hardly determined. Unit: 1.
pub const VAGUE_ERROR_SHARE: f64 = 0.5;

/// Component of an eigenvector from which its parameter is named with it. Unit: 1. At most eleven
/// reach it; as a rule two or three do.
pub const MIN_DIRECTION_SHARE: f64 = 0.3;

/// Smallest share of the linearized curvature that can be distinguished from zero; lower or
/// negative ones count as this one. Unit: 1.
pub const MIN_CURVATURE_SHARE: f64 = 0.05;

/// Room to a bound that a difference of gradients needs. Unit: standard errors.
pub const MIN_BOUND_ROOM_SIGMAS: f64 = 0.1;

/// Variance of a coordinate from which it is not determined at all. Unit: squares of the
/// coordinate. No step of it changes anything.
pub const UNDETERMINED_VARIANCE: f64 = 1e4;

/// Values of two recordings farther apart than this are different, if they also differ by the
/// share below. Unit: standard errors, which include the scatter of the segments.
pub const DEVICE_DIFFERENCE_SIGMAS: f64 = 3.0;

/// Relative difference that values of different devices have at least. Unit: 1. Scales are off by
/// a percent or so.
pub const DEVICE_DIFFERENCE_SHARE: f64 = 0.03;

/// Chi2 that a recording counts for of which everything is set aside. Unit: 1. Larger than that
/// of any fit that follows.
pub const SET_ASIDE_CHI2: f64 = 100.0;

// Steps of the paper.

/// Segments farther from the data than this are not read. Unit: standard deviations of the noise.
pub const MAX_SEGMENT_NOISE_RATIO: f64 = 3.0;

/// Median distance of the model from the segments above which contact readings depend on a model
/// that is wrong. Unit: standard deviations of the noise.
pub const MAX_READING_NOISE_RATIO: f64 = 1.3;

/// Median distance from segments in which hardly anything happens above which the device must be
/// fitted as a whole first. Unit: standard deviations of the noise.
pub const MAX_DEVICE_NOISE_RATIO: f64 = 5.0;

/// A shorter contact is a bounce rather than a stay. Unit: s. The held cantilever rings for about
/// as long.
pub const MIN_STAY_TIME: f64 = 0.5e-3;

/// Fewest samples of a ring. Unit: samples.
pub const MIN_RING_SAMPLES: usize = 12;

/// A ring that the ground ends earlier is not read. Unit: periods of the slowest mode. Its decay
/// would not show.
pub const MIN_RING_PERIODS: f64 = 0.5;

/// The voltage may move by this share of its span within a block. Unit: 1. Equation (9) is
/// static.
pub const MAX_BLOCK_VOLTAGE_SHARE: f64 = 0.05;

/// After a turn, a jump or a release so much of the ring is skipped. Unit: decay times of the
/// first mode.
pub const RING_DECAY_TIMES: f64 = 2.0;

/// Share of the voltage span over which a branch must have been seen. Unit: 1. A cubic through
/// less of it is an extrapolation.
pub const MIN_BRANCH_COVERAGE: f64 = 0.4;

/// Threshold of the robust loss of the branches. Unit: scatters of the blocks.
pub const BRANCH_HUBER_THRESHOLD: f64 = 2.0;

/// Fewest samples of a sustained contact. Unit: samples.
pub const MIN_CONTACT_SAMPLES: f64 = 8.0;

/// A pressure of so many standard errors at the release is one. Unit: standard errors.
pub const PRESSED_SIGMAS: f64 = 3.0;

/// Standard error of a force, as a share of the largest force, from which the noise hides it.
/// Unit: 1.
pub const MAX_FORCE_ERROR_SHARE: f64 = 0.3;

/// Fewest releases for a line with an error. Unit: releases. A line has two unknowns.
pub const MIN_RELEASES: usize = 3;

/// Ratio of the longest and the shortest contact that a slope needs. Unit: 1. Below it, the
/// errors of the times count as well.
pub const MIN_CONTACT_TIME_RATIO: f64 = 1.1;

/// Ratio of rms and noise up to which the rings are followed. Unit: 1.
pub const MAX_RING_NOISE_RATIO: f64 = 3.0;

/// Bounces whose ratio is less certain than this do not count. Unit: 1, as the ratio.
pub const MAX_RATIO_ERROR: f64 = 0.2;

/// Fewest bounces for a mean with a scatter. Unit: bounces.
pub const MIN_BOUNCES: usize = 3;

/// Ratio of the misfits after and before the shift above which the search starts again. Unit: 1.
pub const RESTART_MISFIT_RATIO: f64 = 1.2;

/// Relative change of a coefficient that counts as none. Unit: 1.
pub const INSENSITIVE_CHANGE_SHARE: f64 = 0.01;

/// A change below so many of its errors counts as none. Unit: standard errors.
pub const SENSITIVE_CHANGE_SIGMAS: f64 = 3.0;

/// Threshold of the robust loss of a line. Unit: standard deviations. 95 % efficiency on Gaussian
/// noise is at 1.345 (Huber 1981); few points favour a little more.
pub const LINE_HUBER_THRESHOLD: f64 = 1.5;

// Table A.1.

/// Relative error up to which a case is reproduced. Unit: 1. The paper's own limit in Table 3.
pub const MAX_GOOD_ERROR: f64 = 0.3;

/// A shorter contact per period is a touch in passing. Unit: s. The table has 0 for such cases.
pub const MIN_CONTACT_PER_PERIOD: f64 = 0.2e-3;

/// Errors beyond this many of their scales count linearly. Unit: scales. A case that the model
/// cannot reach must not decide the rest.
pub const TABLE_HUBER_THRESHOLD: f64 = 1.5;

/// Gain at the held-out frequencies, in its standard errors, from which an effect is supported.
/// Unit: standard errors. They are few, so that this is a weak test.
pub const MIN_GAIN_SIGMAS: f64 = 2.0;
