//! The numbers that decide what a measured voltage was, each with the test that fails where it is
//! far off. Tests are those of `measured_drive::tests`, where no other is named; `survey` means both
//! surveys of `fit::experiment::tests`.

// The error of samples.

/// Times of samples may be off by so many sampling intervals: rounding. A jump so near to a sample
/// lies before or after it. `what_was_set_is_found_at_every_rate_and_noise`: edges at samples.
pub const CLOCK_INTERVALS: f64 = 1e-4;
/// Steps of a digitiser by which a sample may be off: half a step of rounding, and half of that for the
/// noise below it, whose size is not known. `what_was_set_is_found_at_every_rate_and_noise`: 80 mV.
pub const ROUNDING_REACH_STEPS: f64 = 0.75;
/// Smallest error of a sample, as a share of the voltage's span: where a file has no noise at all,
/// rounding in sums and text must not count as a misfit. The same test, without noise.
pub const MIN_ERROR_SHARE: f64 = 1e-7;
/// Samples in a block of the test for what a curve leaves: a lasting deviation of a tenth of the
/// noise shows in 64 together. `pieces_follow_one_another_and_meet_the_samples`.
pub const BLOCK_SAMPLES: usize = 64;
/// Standard deviations by which the blocks' mean square may exceed its expectation: chance in one
/// of a million. `odd_settings_are_met_within_what_the_samples_allow`.
pub const MAX_BLOCK_EXCESS_SIGMAS: f64 = 5.0;
/// Extra standard deviations of a single sample beyond the largest expected of so many: chance in
/// one of a thousand recordings. The same test.
pub const SINGLE_SAMPLE_MARGIN_SIGMAS: f64 = 1.5;
/// The error of a sample, known from the samples alone, may be wrong by this share of itself: so
/// exact is the noise of 64 samples. The same test.
pub const NOISE_ESTIMATE_ERROR_SHARE: f64 = 0.15;
/// Most samples that a fit of a few numbers uses: more cost time and gain nothing that is seen.
/// `time_of_ten_million_samples`.
pub const MAX_FIT_SAMPLES: usize = 200_000;

/// An interval that differs from the usual by more than this share of it is no digitiser's.
/// `corners_that_somebody_typed_are_joined_by_straight_lines`.
pub const UNEVEN_INTERVAL_SHARE: f64 = 0.5;
/// Share of such intervals up to which samples are a digitiser's: some may be lost. The same test.
pub const MAX_UNEVEN_SHARE: f64 = 0.2;
/// Error of a digitiser's samples at most, as a share of their span: where neighbours differ by more,
/// nothing is known between them, unless all of them are one level. The same test; recordings have 0.03 at most in the survey.
pub const MAX_DIGITISER_ERROR_SHARE: f64 = 0.05;
/// Noise of a level at most \[V\]: corners at random look like noise about a level, but no recorder
/// has so much. The same test.
pub const MAX_LEVEL_NOISE_VOLTS: f64 = 0.2;

// Round numbers.

/// Greatest share of the distance of numbers as round that an interval may cover: one so round lies
/// in it by accident that often. `a_setting_is_found_and_an_accident_is_not`.
pub const MAX_ACCIDENT_SHARE: f64 = 0.04;
/// Standard deviations within which a value is taken for a round one: a setting is missed in one of
/// four hundred. `what_was_set_is_found_at_every_rate_and_noise`.
pub const ROUNDING_SIGMAS: f64 = 3.0;

// Straight lines.

/// Samples of a long voltage that are looked at first \[samples\]: a smooth one is then not cut into
/// thousands of lines. `time_of_ten_million_samples`.
pub const FIRST_LINE_SAMPLES: usize = 1 << 14;
/// A jump is so much steeper than the intervals before and after it: the steepest sine that is
/// sampled ten times a period is not. `what_was_set_is_found_at_every_rate_and_noise`: sines.
pub const JUMP_STEEPNESS: f64 = 4.0;
/// A jump is larger than this many times what the errors of two samples explain. The same test, with
/// noise.
pub const MIN_JUMP_REACHES: f64 = 1.5;
/// Fewest samples that a line takes on average, or the samples are no lines: a smooth curve is not
/// taken for a polygon. `pieces_follow_one_another_and_meet_the_samples`.
pub const MIN_SAMPLES_PER_LINE: usize = 8;
/// Most rounds in which corners and lines are improved in turn: they have then settled.
/// `odd_settings_are_met_within_what_the_samples_allow`.
pub const CORNER_ROUNDS: usize = 8;
/// A change of all corners by less than this many sampling intervals ends them; the estimate of the
/// whole cycle goes on from there. The same test.
pub const CORNERS_CONVERGED_INTERVALS: f64 = 1e-3;
/// Rounds after which spurious corners are no longer looked for: so many that lines are right.
/// `other_waveforms_are_known_too`: points.
pub const MERGE_ROUNDS: usize = 3;
/// A line with a slope of less than this many standard deviations is a level: one of two thousand
/// levels is missed. `many_edges_narrow_each_one`.
pub const FLAT_SIGMAS: f64 = 3.5;
/// Standard deviations between which each of thousands of corners lies.
/// `odd_settings_are_met_within_what_the_samples_allow`.
pub const CORNER_REACH_SIGMAS: f64 = 5.5;

// Cycles.

/// Most different knots in a period, or in half of one where the second half is the first turned
/// over: more are somebody's list of points. `other_waveforms_are_known_too`.
pub const MAX_CYCLE_KNOTS: usize = 64;
/// Standard deviations by which voltages at the same place of two periods may differ: of thousands
/// of pairs none is farther. `many_edges_narrow_each_one`.
pub const EQUAL_VOLTAGE_SIGMAS: f64 = 5.5;
/// Sampling intervals near the ends of the samples within which a corner can stay unseen: so few
/// samples show no slope. `a_shift_in_time_and_the_unit_change_nothing`.
pub const UNSEEN_CORNER_INTERVALS: f64 = 12.0;
/// Steps of the search for the period, and of the sums over those that fit.
/// `what_is_open_covers_the_truth`.
pub const PERIOD_STEPS: usize = 200;
/// Most Newton steps under one law of the samples: five are usual.
/// `what_is_open_covers_the_truth`.
pub const MAX_NEWTON_STEPS: usize = 12;
/// Shares of a Newton step that are tried: a corner that passes samples bends the way. The same test.
pub const NEWTON_STEP_SHARES: [f64; 5] = [1.0, 0.5, 0.2, 0.05, 0.01];
/// A rise of the likelihood's logarithm by less than this is the last: a twentieth of a standard
/// deviation. The same test.
pub const CONVERGED_LOG_LIKELIHOOD: f64 = 1e-3;
/// Half a digitiser's cell is at first this many times the noise in front of it: from so soft a cell
/// Newton's steps find the way. The same test.
pub const FIRST_SOFTNESS: f64 = 2.0;
/// Most halvings of that noise: to a hundred-thousandth of a cell. The same test.
pub const MAX_HARDENINGS: usize = 16;
/// A fall of the likelihood's logarithm by this much says that the noise is no smaller: two standard
/// deviations. The same test, with noise in front of the digitiser.
pub const NOISE_SHOWN_LOG_LIKELIHOOD: f64 = 2.0;
/// Most voltages on slopes from whose median error it is said how well they are known.
/// The same test.
pub const MAX_PICKED_ON_SLOPES: usize = 200;

// What stays open.

/// A jump late by this much \[s\] counts as its whole height: a motion of hundreds of Hz has followed
/// by then. It only orders what is open. Survey: squares.
pub const JUMP_RESPONSE_TIME: f64 = 1e-3;
/// Most joint changes of a cycle that are left open, those that move the voltage most: each costs
/// the readings a run. Survey: ramps have six.
pub const MAX_OPEN_DIRECTIONS: usize = 8;
/// A joint change that moves the voltage by less than this share of its span is not left open: it
/// moves the proof mass by less than a nanometre. Survey: no noise.
pub const UNNOTICED_DIRECTION_SHARE: f64 = 2e-6;
/// Standard deviations by which noise may have moved a number: chance in one of ten thousand.
/// `what_is_open_covers_the_truth`.
pub const NOISE_REACH_SIGMAS: f64 = 4.0;
/// The same of rounding, which reaches to 1.7 and no farther; the rest is for numbers that several
/// roundings move. The same test.
pub const ROUNDING_ERROR_REACH_SIGMAS: f64 = 2.0;
/// Steps of a coarse digitiser over the span of a square wave that shows none of them: eight bits of
/// which the wave uses half. Survey: the square in steps of 80 mV.
pub const UNSEEN_DIGITISER_STEPS: f64 = 128.0;

/// Most turns of a smoothed voltage that are left open, those known least: time.
/// `the_exact_device_leaves_the_noise_under_smooth_voltages`.
pub const MAX_OPEN_TURNS: usize = 256;
/// A turn's pieces meet within this share of what the voltage changes within the turn's reach, or it
/// is a jump. `a_turn_moves_and_the_voltage_stays`.
pub const MAX_TURN_STEP_SHARE: f64 = 1.0;
/// Standard deviations by which readings may move one of a cycle's joint changes where rounding and
/// intervals bound them: the region that is left is thin, and where the drive began with the first
/// sample, the truth is in its farthest corner. Survey: odd squares.
pub const BOUNDED_SPREAD_REACH_SIGMAS: f64 = 6.0;

// Sinusoids.

/// Share of half the span around the middle within which a crossing of it is not counted twice:
/// noise of a tenth of the span does not cross it. `other_waveforms_are_known_too`.
pub const CROSSING_HYSTERESIS_SHARE: f64 = 0.15;
/// Steps of a digitiser by which it falsifies amplitude and offset however many samples there are.
/// `what_was_set_is_found_at_every_rate_and_noise`: sines in steps of 80 mV.
pub const DIGITISER_BIAS_STEPS: f64 = 0.02;
/// Fewest crossings of the middle that tell a frequency; a sine with fewer is searched for.
/// `short_recordings_show_what_was_set`.
pub const MIN_CROSSINGS: usize = 3;
/// Step of that search in periods over all samples: a tenth of a period aside, least squares still
/// find the sine. The same test.
pub const SLOW_SEARCH_STEP: f64 = 0.1;
/// Samples that search looks at. The same test.
pub const SLOW_SEARCH_SAMPLES: usize = 200;
/// Most samples from which a start is looked for: enough for numbers good to a percent.
/// `time_of_ten_million_samples`.
pub const MAX_SEARCH_SAMPLES: usize = 3000;
/// Reaches of a sample's error within which a curve fitted to few samples must lie: all samples
/// decide afterwards. The same test.
pub const LIKELY_REACHES: f64 = 4.0;
/// Most sines in a sum: more are a smooth curve. `other_waveforms_are_known_too`: two.
pub const MAX_SINES: usize = 5;
/// Most samples of the spectrum in which a sum's frequencies are looked for: time.
/// `time_of_ten_million_samples`.
pub const MAX_SPECTRUM_SAMPLES: usize = 1 << 16;
/// A sine smaller than this many standard deviations of its amplitude is not there: the largest of
/// thousands of lines of noise is smaller. `other_waveforms_are_known_too`: noise of 20 mV.
pub const MIN_AMPLITUDE_SIGMAS: f64 = 6.0;
/// Most steps of Gauss and Newton: ten are usual. `other_waveforms_are_known_too`: sweep.
pub const MAX_GAUSS_NEWTON_STEPS: usize = 30;
/// A step below this many standard deviations of every parameter is the last. The same test.
pub const CONVERGED_STEP_SIGMAS: f64 = 1e-3;

// Pieces and edges.

/// Least standard deviation of an edge in sampling intervals: what clocks differ. Survey: no noise.
pub const MIN_EDGE_SIGMA_INTERVALS: f64 = 0.01;
/// Standard deviations an edge may lie from its estimate: chance in one of ten thousand.
/// `turns_of_a_smooth_voltage_are_found_between_samples`.
pub const EDGE_REACH_SIGMAS: f64 = 4.0;
/// Pieces in which a turn of the fastest of several sines is written: cubics are then off by less
/// than 1e-7 of the amplitude. `other_waveforms_are_known_too`: two sines.
pub const PIECES_PER_TURN: f64 = 100.0;
/// Reversals of a smoothed voltage below this many of its standard deviations are noise: a branch
/// chosen by noise moves the proof mass by micrometres.
/// `turns_of_a_smooth_voltage_are_found_between_samples`.
pub const REVERSAL_SIGMAS: f64 = 5.0;
/// Standard deviations of the spline's turn by which a better estimate may move it, two intervals in
/// any case: farther is another turn. The same test.
pub const MAX_TURN_CHANGE_SIGMAS: f64 = 8.0;

// Smooth voltages. All of them: `the_exact_device_leaves_the_noise_under_smooth_voltages` of
// `fit::experiment::tests`.

/// Fewest samples between two knots of the spline: it has one free number for each interval.
pub const MIN_SAMPLES_PER_SPLINE_INTERVAL: usize = 2;
/// Samples of a long voltage on which the size of intervals is tried \[samples\].
/// `time_of_ten_million_samples`.
pub const TRIED_SPLINE_SAMPLES: usize = 1 << 14;
/// Intervals at the start; they are halved from there.
pub const FIRST_SPLINE_INTERVALS: usize = 8;
/// Standard deviations by which an interval's mean square may exceed its expectation: of a thousand
/// intervals none by chance.
pub const MAX_SPLINE_EXCESS_SIGMAS: f64 = 4.0;
/// Neighbouring intervals whose bends are judged together: a stiffness that one alone does not show.
pub const BEND_GROUP_INTERVALS: usize = 8;
/// Standard deviations by which their mean square may exceed its expectation: a needless knot costs
/// little, a missing one the shape.
pub const MAX_BEND_EXCESS_SIGMAS: f64 = 2.5;
/// Parts of an interval of which each must be followed in the mean.
pub const FOLLOWED_PARTS: usize = 4;
/// Degree of the polynomial around a turn.
pub const TURN_DEGREE: usize = 6;
/// Further degrees that must be insignificant in a window that the polynomial follows.
pub const CHECKED_TURN_DEGREES: usize = 2;
/// Standard deviations from which a further degree is significant: chance in one of eighty.
pub const SIGNIFICANT_DEGREE_SIGMAS: f64 = 2.5;
/// Windows in a row with a significant one that end the growth: one alone is chance.
pub const MAX_UNFOLLOWED_WINDOWS: usize = 3;
/// Samples on either side of a turn at first: more than the degrees of freedom.
pub const FIRST_TURN_HALF_SAMPLES: usize = 12;
/// Most samples on either side: time.
pub const MAX_TURN_HALF_SAMPLES: usize = 20_000;
/// Most bins of samples on either side: within one a polynomial of that degree is straight.
pub const MAX_TURN_HALF_BINS: usize = 80;
/// Growth of the window from try to try.
pub const TURN_WINDOW_GROWTH: f64 = 1.5;
/// Windows by which one is shorter that shows what the longest leaves uncertain: a deviation from the
/// polynomial is a hundred times smaller in it.
pub const SHORTER_TURN_WINDOWS: i32 = 2;
/// A turn whose curvature is not this many standard deviations is a level's.
pub const MIN_TURN_CURVATURE_SIGMAS: f64 = 8.0;

// Words.

/// Noise below this share of the span is not worth a word.
/// `what_was_set_is_found_at_every_rate_and_noise`.
pub const MIN_SAID_NOISE_SHARE: f64 = 1e-6;

/// Share of a step that the error of a number covers up to which it tells whether typed numbers are
/// multiples of that step. `a_typed_table_is_found_through_a_coarse_digitiser`.
pub const MAX_TYPED_SHARE: f64 = 0.5;
/// Probability up to which all of them are multiples of it by accident. The same test.
pub const MAX_TYPED_ACCIDENT: f64 = 1e-4;
/// Well-known numbers for each one that is no multiple. The same test.
pub const MIN_TYPED_PER_OTHER: usize = 4;
/// Decades below the largest number that are tried: nobody types more digits. The same test.
pub const TYPED_DECADES: i32 = 5;
