//! The numbers that decide whether a reading has a fault. All are in samples, shares or standard
//! deviations of the recording's own noise.
//! Check with `cargo test --lib recording::instrument_faults`.

/// Places that are listed \[places\]: more are counted.
pub const MAX_PLACES: usize = 50;
/// Samples around a step of the voltage in which spikes and jumps of a reading are left alone: they
/// may follow from it, by physics or by coupling of the cables.
pub const VOLTAGE_EDGE_SAMPLES: usize = 4;
/// Share of the voltage's span that is a step \[-\].
pub const VOLTAGE_EDGE_SHARE: f64 = 0.2;
/// Noise below this share of the span is the rounding of a simulation, whose mass may rest exactly \[-\]. A
/// recorder of sixteen bits has more.
pub const MIN_NOISE_SHARE_OF_SPAN: f64 = 4e-6;

// The end of the range.
/// Equal extreme values in a row from which they are the end of a sensor's range \[samples\]. Noise
/// repeats a value a few times at most.
pub const CLIPPED_MIN_RUN: usize = 6;
/// Share of equal neighbours from which a reading is noiseless, coarse or held \[-\]. Noise finer
/// than the steps has less.
pub const MAX_EQUAL_NEIGHBOUR_SHARE: f64 = 0.05;

/// Noise above this share of the span may be fast motion \[-\].
pub const MAX_NOISE_SHARE_OF_SPAN: f64 = 2e-2;
/// The same at the lowest reading \[-\]: a mass that is sampled a few times a period rests on the ground as
/// exactly in a simulation, and its flight looks like noise.
pub const MAX_NOISE_SHARE_OVER_GROUND: f64 = 1e-3;

// Held readings.
/// Share of rows that repeat a reading of the proof mass from which they are dropped \[-\]: what is
/// left is a recording of a lower rate, whose noise can be estimated.
pub const MAX_MISSING_ROW_SHARE: f64 = 0.3;
/// Expected number of runs of equal readings by chance, below which one is a fault: one recording
/// in ten thousand.
pub const EQUAL_RUN_CHANCE: f64 = 1e-4;
/// Unusable samples from which the noise is estimated anew without them, as a share \[-\]: medians do not
/// notice fewer.
pub const MAX_UNNOTICED_SHARE: f64 = 0.02;
/// Readings on either side from which it is known how much they differ there.
pub const HELD_NEIGHBOURS: usize = 6;
/// Readings around differ by so many standard deviations of the noise at least: a quarter of the
/// differences of noise is below 0.45, and a simulation that has settled is far below.
pub const HELD_MIN_STEP_SIGMAS: f64 = 0.15;
/// Readings up to so far apart are compared with each other for the chance that two are equal.
pub const RECURRENCE_LAGS: usize = 4;
/// Share of values that recur, up to which a recorder has more levels than are read \[-\].
pub const MAX_RECURRING_SHARE: f64 = 0.01;
/// Equal readings in a row that a jump at their end may prove held \[samples\]. Two show no speed.
pub const HELD_MIN_RUN: usize = 3;
/// The jump exceeds so many standard deviations of the noise.
pub const HELD_JUMP_SIGMAS: f64 = 8.0;
/// The jump exceeds so many steps of the recorder: a slow motion goes by one at a time.
pub const HELD_JUMP_LATTICE_STEPS: f64 = 3.5;
/// The jump's speed and that around it differ by this factor at most \[-\]. A mass that stops and
/// starts has gone a third or less of that way.
pub const HELD_JUMP_MAX_RATIO: f64 = 1.6;

// Spikes.
/// Samples in a row that may be one spike: more are a pulse or a motion.
pub const MAX_SPIKE_SAMPLES: usize = 4;
/// A spike is off by so many standard deviations of the noise: chance in one of 1e15 samples.
pub const SPIKE_SIGMAS: f64 = 8.0;
/// A single sample is off by so many times what the motion bends around it \[-\]. The sharpest bend
/// of a motion, a hop between two samples, has twice.
pub const SPIKE_BENDS: f64 = 4.0;
/// It is also off by so many times what a sudden turn between the speeds before and after could make \[-\].
pub const SPIKE_TURNS: f64 = 3.0;
/// And by so many times what the reading is shifted by behind it \[-\]: a step is off by half of it.
pub const SPIKE_RETURNS: f64 = 1.5;
/// Bends next to a spike that count in full: an event of the motion has its others there.
pub const ADJACENT_BENDS: usize = 3;
/// Of several samples the nearest is so far off at least, as a share of the farthest \[-\]. A hop of three
/// samples has 0.75.
pub const SPIKE_FLATNESS: f64 = 0.8;
/// Samples on either side in which the motion's bends are looked at: a series of bounces has the
/// bounce before within them.
pub const BEND_NEIGHBOURHOOD: usize = 16;
/// Share of samples up to which outliers are spikes \[-\]: more of them are the signal.
pub const MAX_SPIKE_SHARE: f64 = 0.05;
/// Heights of a voltage's pulses differ by this share at most \[-\].
pub const PULSE_SIZE_SPREAD: f64 = 0.1;

// Fringe jumps.
/// Samples of the parabolas on either side: six leave three for the check.
pub const FRINGE_SIDE_SAMPLES: usize = 6;
/// A jump exceeds so many standard deviations of the noise. The parabolas' ends are good to 2.3
/// together.
pub const FRINGE_SIGMAS: f64 = 14.0;
/// A jump exceeds so many times what a tenth of the steps differ from their neighbours \[-\]: noise
/// has 3.7 standard deviations there.
pub const FRINGE_USUAL_STEPS: f64 = 4.0;
/// Smaller jumps down to this share of the least are counted, too \[-\]: where these are more, all
/// are noise.
pub const FRINGE_SMALLER_SHARE: f64 = 0.6;
/// What the parabolas leave, as a share of the jump at most \[-\], beyond twice the noise.
pub const FRINGE_MAX_MISFIT: f64 = 0.08;
/// Change of the slope over a sample, as a share of the jump at most \[-\], beyond the noise. An
/// impact has twice the jump that its parabolas leave.
pub const FRINGE_MAX_TURN: f64 = 0.25;
/// A jump exceeds so many times what a step differs from its neighbours around it \[-\].
pub const FRINGE_MIN_PROMINENCE: f64 = 3.0;
/// A jump may differ from a multiple of the common size by this share of it, beyond the noise \[-\].
pub const FRINGE_ALIKE: f64 = 0.15;
/// Largest multiple that still shows: 8 times 0.15 is more than one.
pub const FRINGE_MAX_MULTIPLE: f64 = 4.0;
/// A single jump is so many times larger than the least of several: nothing else confirms it.
pub const LONE_JUMP_FACTOR: f64 = 2.0;
/// And it stands out so many times from the steps around it \[-\]: an impact within a fast
/// vibration has 2.6.
pub const LONE_JUMP_PROMINENCE: f64 = 6.0;
/// Share of the jumps that are multiples \[-\]: the rest are events read wrongly.
pub const FRINGE_MIN_AGREEMENT: f64 = 0.8;
/// Speed in a sample from which the mass moves \[noise of a sample\].
pub const FRINGE_MIN_SPEED_SIGMAS: f64 = 1.0;

// Stays.
/// Samples in a block: a line through them is good to a fifth of the noise.
pub const QUIET_BLOCK_SAMPLES: usize = 32;
/// Blocks of a stay at least.
pub const STAY_MIN_BLOCKS: usize = 3;
/// Blocks that are looked at: time.
pub const MAX_QUIET_BLOCKS: usize = 4096;
/// Root mean square around the line at most \[noise of a sample\]. 32 samples exceed it in one
/// of ten thousand.
pub const MAX_QUIET_RMS: f64 = 1.5;
/// Speed at most, as a share of that which a tenth of the blocks exceed \[-\].
pub const MAX_QUIET_SPEED_SHARE: f64 = 0.1;

// Lines in the reading.
/// Height of the ground's stays over the lowest reading, as a share of the span \[-\].
pub const GROUND_MAX_HEIGHT_SHARE: f64 = 0.1;
/// Periods of a line in the longest stay: fewer are a level that creeps.
pub const LINE_MIN_PERIODS: f64 = 0.7;
/// Frequencies tried within the resolution of the recording.
pub const LINES_PER_RESOLUTION: f64 = 4.0;
/// Amplitude at least, in its standard errors: the largest of ten thousand frequencies has five.
pub const LINE_SIGMAS: f64 = 10.0;
/// Share of the levels' variance that the line explains \[-\]. A creep or a drift leaves more.
pub const LINE_MIN_EXPLAINED: f64 = 0.8;
/// A line so near to one of the drive may be motion \[resolutions of the recording\]: a line that
/// stands out is known better than that.
pub const DRIVE_LINE_RESOLUTIONS: f64 = 0.3;

// AC coupling.
/// Blocks at least.
pub const AC_MIN_BLOCKS: usize = 24;
/// Share of the slopes' variance that is proportional to the reading \[-\].
pub const AC_MIN_EXPLAINED: f64 = 0.8;
/// Level to which the reading decays, as a share of its span at most \[-\].
pub const AC_MAX_ZERO_SHARE: f64 = 0.1;
/// Spread of the levels as a share of the span at least \[-\].
pub const AC_MIN_LEVEL_SPREAD_SHARE: f64 = 0.01;
/// Spread of the voltages as a share of theirs at least \[-\]: with one voltage the mass itself may
/// relax, unless it was stopped.
pub const AC_MIN_VOLTAGE_SPREAD_SHARE: f64 = 0.5;
/// Stays that begin with a sudden stop, at least: a ground holds the mass there.
pub const AC_MIN_STOPS: usize = 3;
/// Speed before a sudden stop over that after it at least \[-\].
pub const AC_STOP_SPEED_RATIO: f64 = 10.0;

// Coarse steps.
/// Steps over the span of a reading up to which they are worth a word: those of twelve bits change
/// nothing that is seen.
pub const MAX_COARSE_STEPS: f64 = 4096.0;
/// Share of samples at which readings in steps bend \[-\]: a noiseless ramp does so at its corners alone.
pub const MIN_BENT_SHARE: f64 = 0.1;
/// The same for a voltage: at twenty samples a period the corners of a noiseless ramp are a fifth of them.
pub const MIN_BENT_VOLTAGE_SHARE: f64 = 0.35;
