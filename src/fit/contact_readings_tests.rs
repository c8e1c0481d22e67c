//! Readings of bounces from numbers made up here.

use crate::fit::contact_readings::*;

#[test]
fn a_ratio_is_corrected_by_the_height_between_approach_and_departure() {
    // Ratio and height are wrong together, but for a share of the ratio.
    const TRUE_RATIO: f64 = 0.37;
    const MISS_COUPLING: f64 = -0.05;
    const RATIO_NOISE: f64 = 0.01;
    let bounce_at = |off: f64, own: f64| Bounce {
        recording: 0,
        time: 0.1,
        approach: 0.03,
        departure: 0.03 * (TRUE_RATIO + MISS_COUPLING * off + own),
        ratio: TRUE_RATIO + MISS_COUPLING * off + own,
        error: MISS_COUPLING.hypot(RATIO_NOISE),
        miss: 60e-9 * off,
        miss_error: 60e-9,
        shared: MISS_COUPLING * 60e-9,
        flight: 14.0,
    };
    for off in [-2.0, 0.0, 1.0] {
        let (ratio, error) = bounce_at(off, RATIO_NOISE).at_once(0.0, (0.0, 0.0));
        assert!(
            (ratio - TRUE_RATIO - RATIO_NOISE).abs() < 1e-12,
            "{off}: {ratio}"
        );
        assert!((error - RATIO_NOISE).abs() < 1e-9, "{off}: {error}");
    }
    // A lower ground changes the height by as much.
    let mut lower = bounce_at(1.0, RATIO_NOISE);
    lower.miss -= 80e-9;
    let (ratio, _) = lower.at_once(0.0, (-80e-9, 0.0));
    assert!((ratio - TRUE_RATIO - RATIO_NOISE).abs() < 1e-12, "{ratio}");
    // If the departure may be much later, or the ground level is unknown, the
    // height says nothing.
    let bounce = bounce_at(1.0, 0.0);
    for corrected in [
        bounce.at_once(1e-3, (0.0, 0.0)),
        bounce.at_once(0.0, (0.0, 1e-10)),
    ] {
        assert!((corrected.0 - bounce.ratio).abs() < 1e-4);
        assert!((corrected.1 - bounce.error).abs() < 1e-4);
    }
}
