//! Every number that decides what a fit accepts, doubts or reports, in one place.
//!
//! Each entry says what is compared, its unit and why it has this value; "Judgement" means that it
//! was set by judgement on simulated recordings of the paper's device and that no statistic was
//! recorded for it. Each group names the command that checks it. Gains and costs are parts of chi2,
//! which has no unit. Iteration counts, steps of differences and sizes of starts stay where they
//! are used: they change how long a fit takes, not what it says.

// Known values of parameters.
// Check with `cargo test --lib fit::uncertainty::contradiction`.
/// Distance between a known value and the one that the recordings need, from which they contradict
/// each other \[standard errors of both together\]. Judgement: by chance once in 16,000, and errors are
/// often stated too small by a factor of up to 2.
pub const KNOWN_MAX_Z: f64 = 4.0;

// What a recording must show to be fitted.
// Check with `cargo test --lib fit::inspect::preconditions`.
/// Fewest samples of a recording \[samples\]. With fewer, two unknowns a mode, the nuisances and a
/// parameter are hardly overdetermined.
pub const MIN_SAMPLES: usize = 20;
/// Share of the samples at one extreme value from which a quantised reading is saturated, where
/// they come in runs \[-\]. A ring spends less than this at its turning points.
pub const SATURATED_SHARE: f64 = 0.02;
/// The same for a reading whose noise is finer than its steps \[-\]. Noise never stays at one
/// value, so that far fewer samples suffice.
pub const SATURATED_SHARE_IN_NOISE: f64 = 0.002;
/// Longest run at the extreme that a quantised reading may show \[samples\]. A slow turning point
/// within one step of the recorder stays shorter.
pub const MAX_EXTREME_RUN: usize = 20;
/// Largest difference of the ground's levels in recordings of one device \[m\]. The zeros of badly
/// adjusted sensors differ by less.
pub const MAX_LEVEL_DIFFERENCE: f64 = 15e-6;
/// The same within one fit \[m\]. Zeros may be off by some micrometres, and the scales by a
/// percent.
pub const MAX_LEVEL_DIFFERENCE_IN_A_FIT: f64 = 8e-6;
/// Both limits are no less than this share of the travel \[-\]. A device that moves by decimetres has
/// its ground no better known. Below 160 um of travel the limits above hold.
pub const MIN_LEVEL_DIFFERENCE_SHARE: f64 = 0.05;
/// Share of its one extreme that a voltage reaches on the other side \[-\]. The paper's drives are
/// symmetric; a clipped one is not.
pub const MIN_VOLTAGE_SYMMETRY: f64 = 0.95;
/// Noise below this share of the motion is the rounding of a simulation \[-\]. No recorder
/// resolves as much.
pub const NOISELESS_SHARE: f64 = 1e-6;
/// Share of the samples at the end of a reading's range that may be left out \[-\]. With more, most
/// of the motion is missing.
pub const MAX_CLIPPED_SHARE: f64 = 0.1;

// Whether anything moves.
// Check with `cargo test --lib fit::inspect::motion`.
/// Deviation of a reading from its mean up to which nothing moves \[noise of a sample\]. A motion
/// as large as the noise has 1.4.
pub const MAX_STILL_DEVIATION: f64 = 1.3;
/// Correlation of neighbours, beyond chance, up to which they do not go together \[-\]. A motion of
/// a fifth of the noise's variance has 0.17.
pub const MAX_NOISE_CORRELATION: f64 = 0.1;
/// The same by chance \[standard deviations\]. Several lags are looked at, so that 2 would be
/// reached often.
pub const NOISE_CORRELATION_SIGMAS: f64 = 4.0;
/// Neighbours that are looked at \[samples\]. A motion near the sampling rate shows in some of them.
pub const NOISE_CORRELATION_LAGS: usize = 8;
/// Shape of a mode at a recorded point below which it does not show \[-\]. The paper's has some tenths.
pub const MIN_VISIBLE_MODE_SHAPE: f64 = 1e-2;

// Connections: signs and orders of magnitude of slow motion.
// Check with `cargo test --lib fit::inspect::connections`.
/// Time over which slow motion is averaged \[periods of the first mode\]. Its ring is gone then,
/// also where f1 is off by half.
pub const CONNECTION_BLOCK_PERIODS: f64 = 4.0;
/// Time that is looked at \[periods of the first mode\]. More would only take longer.
pub const CONNECTION_MAX_PERIODS: f64 = 400.0;
/// Instants of the voltage for the model's own run \[per period of the first mode\]. More would
/// only take longer.
pub const CONNECTION_STEPS_PER_PERIOD: f64 = 20.0;
/// How many are looked at \[recordings\]. They have the same connections.
pub const CONNECTION_MAX_RECORDINGS: usize = 3;
/// Fewest averages that say anything \[blocks\]. A correlation of 0.6 in ten is no chance.
pub const CONNECTION_MIN_BLOCKS: usize = 10;
/// Share of the voltage's deviation that is slow, at least \[-\]. Faster drives move the mass by
/// its dynamics.
pub const CONNECTION_MIN_SLOW_SHARE: f64 = 0.4;
/// Correlation of slow motion with the voltage, in recording and model, from which a sign is read
/// \[-\]. Devices off by up to 60 % have more.
pub const CONNECTION_MIN_CORRELATION: f64 = 0.6;
/// Part of the known voltage below which the film's hysteresis decides on the direction of slow
/// motion \[-\]. That turns over at 1.5 V.
pub const HYSTERESIS_VOLTAGE_PARTS: f64 = 3.0;
/// Factor by which xc over xp is nearer to the inverse of the model's than to it \[-\]. Devices off
/// by up to 60 % have 0.8 to 1.4 times the model's.
pub const EXCHANGED_MARGIN: f64 = 1.5;
/// Ratio of slow motion in the recording to that of the model from which the voltage is a monitor's
/// \[-\]. A device with f1 and eta off by 60 % has 6.4.
pub const MIN_MONITOR_RATIO: f64 = 8.0;
/// Factors of the monitors of amplifiers \[-\]. Makers offer these.
pub const MONITOR_FACTORS: [f64; 4] = [10.0, 20.0, 50.0, 100.0];
/// Misfit of the motion at the nearest of these factors, at most \[-\]. A device that is another
/// one altogether leaves more.
pub const MAX_MONITOR_MISFIT: f64 = 2.5;
/// Factor within which the voltage at the device is that of the known ones \[-\]. A weaker drive is
/// no monitor.
pub const KNOWN_VOLTAGE_MARGIN: f64 = 1.5;

// Units of the columns, and cells that are no readings.
// Check with `cargo test --lib fit::inspect::plausible_units`.
/// Factor between the recorded ground level and the starting value, or between the recorded
/// voltage and the known ones, from which the unit is wrong \[-\]. Units differ by a factor of
/// 1000, devices by less than 10.
pub const OTHER_UNIT_FACTOR: f64 = 300.0;
/// Voltage up to which the branches of the piezo film were measured \[V\]. Figs. 3 and 4 of the
/// paper.
pub const KNOWN_VOLTAGE: f64 = 8.0;
/// Voltage span below which there is no drive \[V\]. A drive of volts whose column is wrongly read
/// as mV still moves more, and gets the message about its unit.
pub const MIN_DRIVE_VOLTAGE: f64 = 1e-3;
/// Fewest samples in a period of the first mode \[samples\]. With fewer than two the ring is
/// aliased.
pub const MIN_SAMPLES_PER_PERIOD: f64 = 3.0;
/// Shortest recording \[periods of the first mode\]. Below that a wrong unit of time is the
/// likelier cause.
pub const MIN_RECORDED_PERIODS: f64 = 0.5;
/// A reading this many times farther out than all others is a spike \[-\]. A bad cell or an
/// overflow is that far out; no motion is.
pub const SPIKE_FACTOR: f64 = 1e3;
/// Up to so many such readings are spikes \[samples\]. More of them are a signal.
pub const MAX_SPIKES: usize = 5;
/// The same as a share of all samples, for long recordings \[-\]. 0.1 %: more cells are a signal.
pub const MAX_SPIKE_SHARE: f64 = 1e-3;

// What the ground and the noise are.
// Check with `cargo test --lib fit::inspect::recording_summary`.
/// Levels this close are the same ground, read with the same zero \[m\]. Zeros of one session
/// drift by less.
pub const SAME_LEVEL_DISTANCE: f64 = 2e-6;
/// Fewest stays of two samples or more at the lowest reading that make it the ground \[stays\].
/// One or two are chance.
pub const MIN_STAYS: usize = 3;
/// A drift that has been shown up to this share of a recording's end is extrapolated to the end
/// \[-\]. The last tenth follows from a smooth course.
pub const MIN_SHOWN_DRIFT_SHARE: f64 = 0.9;
/// Smallest noise that is assumed, as a share of the motion \[-\]. The simulation and the
/// recorder's digits are no better.
pub const MIN_NOISE_SHARE: f64 = 1e-5;

// Whether recordings are of one device.
// Check with `cargo test --lib fit::inspect::same_device`.
/// A ring is searched for up to this factor above and below the device's first frequency \[-\].
/// Devices that differ by more are refused as another unit or another f1. Judgement.
pub const RING_SEARCH_FACTOR: f64 = 2.5;
/// Relative difference of two ring frequencies from which the devices are different \[-\]. A
/// strong cubic spring or friction changes one device's frequency by less.
pub const OTHER_DEVICE_FREQUENCY_SHARE: f64 = 0.14;
/// Relative difference from which two devices may be different \[-\]. Above what amplitude and
/// damping explain.
pub const DOUBTFUL_FREQUENCY_SHARE: f64 = 0.03;
/// A difference of frequencies below this counts as none \[standard errors\]. High, because
/// neighbouring modes bias the estimate.
pub const FREQUENCY_DIFFERENCE_SIGMAS: f64 = 5.0;
/// Voltages that differ by less than this share are the same \[-\]. Accuracy of an amplifier.
pub const SAME_VOLTAGE_SHARE: f64 = 0.01;
/// Heights of rest that differ by more than this share and this length are different \[-, m\].
/// Scales are off by a percent, and a piezo creeps.
pub const REST_HEIGHT_TOLERANCE: (f64, f64) = (0.02, 1.5e-6);

// Measured motion.
// Check with `cargo test --lib fit::problem::measured_motion`.
/// A measured velocity that changes so many times more than around it, and than noise allows, has
/// jumped \[-\]. Smooth motion changes evenly from sample to sample.
pub const VELOCITY_JUMP_FACTOR: f64 = 3.0;

// Voltage as smooth pieces.
// Check with `cargo test --lib fit::segment::voltage_track`.
/// A jump of the voltage is this many times steeper than its neighbours \[-\]. A fast sine changes
/// its slope by less from sample to sample.
pub const JUMP_STEEPNESS: f64 = 4.0;
/// Smallest jump, as a share of the voltage's span \[-\]. Below it a step is followed well enough
/// by the straight pieces of the voltage. Judgement.
pub const MIN_JUMP_SHARE: f64 = 0.02;
/// Distance from the extreme at which the sides of a turn are read \[tolerances of the voltage\].
/// Closer to the extreme, noise decides.
pub const TURN_DEPTH_TOLERANCES: f64 = 10.0;
/// Turns whose sides differ by more than this factor are timed by their sample \[-\]. The parabola
/// through them has no meaning there.
pub const MAX_TURN_ASYMMETRY: f64 = 3.0;

// Jumps of the voltage within a segment.
// Check with `cargo test --lib diagnose::data::misread_segments`.
/// Change of the drive that is a jump rather than a turn, as a share of its voltage \[-\]. As
/// `MIN_JUMP_SHARE`. Judgement.
pub const MIN_DRIVE_JUMP_SHARE: f64 = 0.02;

// Events and segments.
// Check with `cargo test --test identification` and `impactscope trial --conceal none`.
/// Fewest samples at the ground's level that count as a stay \[samples\]. A bounce shows at most
/// two.
pub const MIN_STAY_SAMPLES: usize = 3;
/// Samples at the level on both sides of a single one that is off: then that one is noise
/// \[samples\]. A bounce in a long stay shows more than one sample.
pub const LONG_STAY_SAMPLES: usize = 10;
/// Ratio of departure and arrival speed below which there is no bounce \[-\]. Slower departures
/// cannot be distinguished from the noise of a stay.
pub const MIN_BOUNCE_RATIO: f64 = 0.12;
/// Fewest samples of a segment \[samples\]. Two unknowns a free mode, one or two more for each
/// event.
pub const MIN_SEGMENT_SAMPLES: usize = 6;
/// After so many time constants a held cantilever has come to rest \[time constants\]. A
/// thousandth of its ring is left.
pub const SETTLED_TIME_CONSTANTS: f64 = 7.0;
/// Exponent by which a sensor's memory may fade from sample to sample and still count \[-\]. A
/// twentieth is left at 3.
pub const MAX_SENSOR_FADE: f64 = 3.0;
/// An edge of the drive this close to a release may be its cause \[samples\]. Both instants are
/// known to about one.
pub const RELEASE_EDGE_SAMPLES: f64 = 3.0;
/// A stay below this length is short \[samples\]. Its begin and end are uncertain by a good part
/// of it.
pub const SHORT_STAY_SAMPLES: f64 = 6.0;
/// Factor on the standard deviation of the pull-off force after a short stay \[-\]. Such a force
/// then carries almost no weight.
pub const SHORT_STAY_FORCE_FACTOR: f64 = 30.0;
/// Standard deviation of the laws of the ground, as a share of what the noise leaves \[-\]. The
/// laws hold much better than the readings show.
pub const GROUND_LAW_NOISE_SHARE: f64 = 0.1;

// Search.
// Check with `cargo test --test identification` and `impactscope trial --conceal none`.
/// Threshold of the robust loss \[standard deviations\]. Gaussian noise hardly reaches it: 0.3 %
/// of the samples are beyond (Huber 1964).
pub const HUBER_THRESHOLD: f64 = 3.0;
/// Cost per row, plus the share of segments set aside, below which no other start is tried \[-\].
/// Noise alone gives 1.
pub const GOOD_START_SCORE: f64 = 1.5;
/// Share of a recording in use below which its nuisances are estimated from the start again
/// \[-\]. The nuisances then rest on too little.
pub const MIN_USED_SHARE: f64 = 0.2;
/// Mean cost per row above which a segment's events are suspect \[-\]. Noise alone gives 1.
pub const SUSPECT_MEAN_COST: f64 = 1.6;
/// Length of the runs whose mean square is watched \[samples\]. About as long as a misread bounce
/// is wrong.
pub const SUSPECT_RUN_SAMPLES: usize = 8;
/// Mean square of such a run above which the events are suspect, however long the rest is
/// \[variances of the noise\]. p = 3e-9 for white Gaussian noise (chi2 of 8 above 56).
pub const SUSPECT_RUN_MEAN_SQUARE: f64 = 7.0;
/// Misfit above which events are not revised \[standard deviations of the noise\]. So far off, the
/// parameters are wrong rather than the events.
pub const MAX_REVISION_MISFIT: f64 = 10.0;
/// Another sequence of events must bring the misfit below this share \[-\]. Each has free instants
/// of its own, which lower it a little in any case.
pub const MAX_REVISED_MISFIT_RATIO: f64 = 0.8;
/// Fewest samples before the first event from which the state is known well enough for a
/// prediction \[samples\]. Judgement.
pub const MIN_SAMPLES_BEFORE_EVENT: usize = 12;

// Confidence intervals.
// Check with theory: the chi-square distribution of one degree of freedom.
/// Rise of the cost at the ends of the 95 % interval \[-\]. Chi-square of one degree of freedom;
/// profile likelihood (Raue et al., Bioinformatics 25, 1923, 2009).
pub const CHI2_95_ONE_DOF: f64 = 3.84;

// Uncertainty and verdicts on a fit.
// Check with `cargo test --lib fit::uncertainty`.
/// Correlation from which two parameters cannot be distinguished \[-\]. Each error is then more
/// than three times what it would be alone.
pub const EXTREME_CORRELATION: f64 = 0.95;
/// A standard error of this many ranges of the parameter, or of its value, if that is larger,
/// means that it is not determined \[ranges of the slider\]. Judgement.
pub const UNDETERMINED_RANGES: f64 = 3.0;
/// Mean square of the residuals above which a fit is bad; with more than `MAX_SET_ASIDE_SHARE` set
/// aside, also the ratio of rms and noise \[-\]. The noise estimate is off by less than a factor of
/// two.
pub const BAD_FIT_CHI2: f64 = 3.0;
/// Share of a recording set aside above which the rest says nothing \[-\]. Judgement.
pub const UNUSABLE_SHARE: f64 = 0.99;
/// Ratio of rms and noise up to which readings are followed to the noise \[-\]. The noise estimate
/// is off by less.
pub const MAX_FOLLOWED_NOISE_RATIO: f64 = 1.5;
/// Share of a recording set aside above which more is wrong than events that are hard to read
/// \[-\]. Judgement.
pub const MAX_SET_ASIDE_SHARE: f64 = 0.5;
/// Standard error, as a share of the value, from which a parameter is hardly determined \[-\].
/// Judgement.
pub const VAGUE_ERROR_SHARE: f64 = 0.5;
/// Component of an eigenvector from which its parameter is named with it \[-\]. At most eleven
/// reach it; as a rule two or three do.
pub const MIN_DIRECTION_SHARE: f64 = 0.3;

// Curvature of the cost for added modes.
// Check with `cargo test --lib fit::uncertainty::sandwich_covariance`.
/// Smallest share of the linearized curvature that can be distinguished from zero; lower or
/// negative ones count as this one \[-\]. Judgement.
pub const MIN_CURVATURE_SHARE: f64 = 0.05;
/// Room to a bound that a difference of gradients needs \[standard errors\]. Judgement.
pub const MIN_BOUND_ROOM_SIGMAS: f64 = 0.1;
/// Variance of a coordinate from which it is not determined at all \[squares of the coordinate\].
/// No step of it changes anything.
pub const UNDETERMINED_VARIANCE: f64 = 1e4;

// Whether fits of single recordings agree.
// Check with `cargo test --lib fit::uncertainty::device_consistency`.
/// Values of two recordings farther apart than this are different, if they also differ by the
/// share below \[standard errors\]. The errors count what segments disagree about.
pub const DEVICE_DIFFERENCE_SIGMAS: f64 = 3.0;
/// Relative difference that values of different devices have at least \[-\]. Scales are off by a
/// percent or so.
pub const DEVICE_DIFFERENCE_SHARE: f64 = 0.03;
/// Chi2 that a recording counts for of which everything is set aside \[-\]. Larger than that of
/// any fit that follows.
pub const SET_ASIDE_CHI2: f64 = 100.0;

// Steps of the paper.
// Check with `cargo test --lib fit::paper_steps`.
/// Segments farther from the data than this are not read \[standard deviations of the noise\].
/// Judgement.
pub const MAX_SEGMENT_NOISE_RATIO: f64 = 3.0;
/// Median distance of the model from the segments above which contact readings depend on a model
/// that is wrong \[standard deviations of the noise\]. Judgement.
pub const MAX_READING_NOISE_RATIO: f64 = 1.3;
/// Median distance from segments in which hardly anything happens above which the device must be
/// fitted as a whole first \[standard deviations of the noise\]. Judgement.
pub const MAX_DEVICE_NOISE_RATIO: f64 = 5.0;
/// A shorter contact is a bounce rather than a stay \[s\]. The bounces of Fig. 8 are shorter.
/// Judgement.
pub const MIN_STAY_TIME: f64 = 0.5e-3;
/// Fewest samples of a ring \[samples\]. Judgement.
pub const MIN_RING_SAMPLES: usize = 12;
/// A ring that the ground ends earlier is not read \[periods of the slowest mode\]. Its decay
/// would not show.
pub const MIN_RING_PERIODS: f64 = 0.5;
/// The voltage may move by this share of its span within a block \[-\]. Equation (9) is static.
pub const MAX_BLOCK_VOLTAGE_SHARE: f64 = 0.05;
/// After a turn, a jump or a release so much of the ring is skipped \[decay times of the first
/// mode\]. Judgement.
pub const RING_DECAY_TIMES: f64 = 2.0;
/// Share of the voltage span over which a branch must have been seen \[-\]. A cubic through less
/// of it is an extrapolation.
pub const MIN_BRANCH_COVERAGE: f64 = 0.4;
/// Threshold of the robust loss of the branches \[scatters of the blocks\]. Judgement.
pub const BRANCH_HUBER_THRESHOLD: f64 = 2.0;
/// Fewest samples of a sustained contact \[samples\]. Judgement.
pub const MIN_CONTACT_SAMPLES: f64 = 8.0;
/// Pressure at a release from which it counts as one \[standard errors\]. Judgement.
pub const PRESSED_SIGMAS: f64 = 3.0;
/// Standard error of a force, as a share of the largest force, from which it is too uncertain
/// \[-\]. Judgement.
pub const MAX_FORCE_ERROR_SHARE: f64 = 0.3;
/// Fewest releases for a line with an error \[releases\]. A line has two unknowns.
pub const MIN_RELEASES: usize = 3;
/// Ratio of the longest and the shortest contact that a slope needs \[-\]. Below it, the errors of
/// the times count as well.
pub const MIN_CONTACT_TIME_RATIO: f64 = 1.1;
/// Ratio of rms and noise up to which the rings are followed \[-\]. Judgement.
pub const MAX_RING_NOISE_RATIO: f64 = 3.0;
/// Largest standard error of a ratio, as a share of it (of 0.1 for smaller ratios) \[-\].
/// Judgement.
pub const MAX_RATIO_ERROR: f64 = 0.2;
/// Fewest bounces for a mean with a scatter \[bounces\]. Judgement.
pub const MIN_BOUNCES: usize = 3;
/// Ratio of the misfits after and before the shift above which the search starts again \[-\].
/// Judgement.
pub const RESTART_MISFIT_RATIO: f64 = 1.2;
/// Relative change of a coefficient that counts as none \[-\]. Judgement.
pub const INSENSITIVE_CHANGE_SHARE: f64 = 0.01;
/// A change below so many of its errors counts as none \[standard errors\]. About 1 in 400 by
/// chance.
pub const SENSITIVE_CHANGE_SIGMAS: f64 = 3.0;

// Lines through the readings.
// Check with `cargo test --lib fit::paper_steps::line_fit`.
/// Threshold of the robust loss of a line \[standard deviations\]. 95 % efficiency on Gaussian
/// noise is at 1.345 (Huber 1981); few points favour a little more.
pub const LINE_HUBER_THRESHOLD: f64 = 1.5;

// Table A.1.
// Check with `impactscope validate` and `impactscope validate --suspects`.
/// Relative error up to which a peak or a contact counts as predicted \[-\]. The paper's own limit in
/// Table 3; it is said as "within 30 %".
pub const MAX_GOOD_ERROR: f64 = 0.3;
/// Relative error up to which a peak or a contact is called reproduced \[-\]. The table prints two or
/// three digits, and the peaks of its own two columns differ by some 20 %.
pub const MAX_REPRODUCED_ERROR: f64 = 0.05;
/// Half the last digit of a peak that the table prints \[m\]. An error below it does not show.
pub const PEAK_DIGIT: f64 = 0.5e-6;
/// Half the last digit of a contact that the table prints \[s\]. An error below it does not show.
pub const CONTACT_DIGIT: f64 = 0.05e-3;
/// Bounces up to which their number is right \[-\]. A mean over periods need not be whole.
pub const BOUNCE_DIGIT: f64 = 0.5;
/// A shorter contact per period is a touch in passing \[s\]. The table has 0 for such cases.
pub const MIN_CONTACT_PER_PERIOD: f64 = 0.2e-3;
/// Errors beyond this many of their scales count linearly \[scales\]. A case that the model cannot
/// reach must not decide the rest.
pub const TABLE_HUBER_THRESHOLD: f64 = 1.5;
/// Gain at the held-out frequencies from which an effect is supported \[its standard errors\].
/// They are few, so that this is a weak test.
pub const MIN_GAIN_SIGMAS: f64 = 2.0;

// The start of a recording. Check with `cargo test --lib fit::experiment`.
/// Distance of the first reading from where the device would begin, from which the start is another
/// \[share of what the mass moves in the first stretch\]. Parameters that are wrong by a third mimic
/// less.
pub const START_DISTANCE_SHARE: f64 = 0.25;
/// Velocity of the first readings from which they move at once \[its standard errors\]. A cubic is not
/// all there is in them, so that five would come about by chance.
pub const START_VELOCITY_SIGMAS: f64 = 6.0;
/// What a cubic may leave of the first readings \[mean square in units of the noise\]. More samples
/// would sharpen the velocity and bend it.
pub const MAX_CUBIC_CHI2: f64 = 1.5;
/// What the model may leave of the first stretch from another start, if that is to count though the
/// readings alone do not demand it \[noise\]. A wrong device leaves more, and a free start would hide
/// it.
pub const MAX_FREE_START_REMAINDER: f64 = 1.5;
/// Fall of the whole run's residual from which such a start counts \[share left of it\]. Chance and a
/// slightly wrong device gain less.
pub const FREE_START_REMAINING_SHARE: f64 = 0.8;
/// What the model may leave of the first stretch where the drive is not known well yet \[noise\]. A
/// wrong device leaves more.
pub const MAX_DOUBTED_START_REMAINDER: f64 = 10.0;
/// Fall of the whole run's residual from which a start counts then \[share left of it\]. It is twice as
/// good at least.
pub const DOUBTED_START_REMAINING_SHARE: f64 = 0.5;

#[cfg(test)]
mod tests {
    use std::path::Path;

    /// Of the commands in a group's heading, those that name a module name one that has tests.
    #[track_caller]
    fn assert_can_be_run(heading: &str) {
        for command in heading.split('`').skip(1).step_by(2) {
            let Some(module) = command.strip_prefix("cargo test --lib ") else {
                let others = ["cargo test --test ", "impactscope "];
                assert!(others.iter().any(|o| command.starts_with(o)), "{command}");
                continue;
            };
            let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
            let place = source.join(module.replace("::", "/"));
            if !place.is_dir() {
                let text = std::fs::read_to_string(place.with_extension("rs")).unwrap();
                assert!(text.contains("#[cfg(test)]"), "{module} has no tests");
            }
        }
    }

    #[test]
    fn every_threshold_says_what_calibrates_it() {
        let text = include_str!("thresholds.rs");
        let text = text.split("#[cfg(test)]").next().unwrap();
        let (mut group, mut doc) = (String::new(), String::new());
        let mut count = 0;
        for line in text.lines() {
            if let Some(more) = line.strip_prefix("/// ") {
                doc.push_str(more);
                doc.push(' ');
            } else if let Some(more) = line.strip_prefix("// ") {
                group.push_str(more);
                group.push(' ');
            } else if line.is_empty() {
                group.clear();
            } else if let Some(rest) = line.strip_prefix("pub const ") {
                let name = rest.split(':').next().unwrap();
                assert!(group.contains("Check with "), "{name}");
                assert_can_be_run(&group);
                // What it is, with its unit, and then why.
                let (what, why) = doc.split_once(". ").unwrap();
                assert!(what.contains("\\[") && what.ends_with("\\]"), "{name}");
                assert!(
                    !why.trim().is_empty() && why.trim().ends_with('.'),
                    "{name}"
                );
                doc.clear();
                count += 1;
            }
        }
        assert!(count > 80, "{count}");
    }
}
