//! Readings of bounces from numbers made up here.

use crate::fit::contact_readings::*;

#[test]
fn a_ratio_is_corrected_by_the_height_between_approach_and_departure() {
    // Ratio and height are wrong together, but for a share of the ratio.
    const TRUE_RATIO: f64 = 0.37;
    const MISS_COUPLING: f64 = -0.05;
    const RATIO_NOISE: f64 = 0.01;
    let read = |off: f64, own: f64| Bounce {
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
        let (ratio, error) = read_contacts_at(off, RATIO_NOISE).at_once(0.0, (0.0, 0.0));
        assert!(
            (ratio - TRUE_RATIO - RATIO_NOISE).abs() < 1e-12,
            "{off}: {ratio}"
        );
        assert!((error - RATIO_NOISE).abs() < 1e-9, "{off}: {error}");
    }
    // A ground that lies elsewhere is missed by as much.
    let mut lower = read_contacts_at(1.0, RATIO_NOISE);
    lower.miss -= 80e-9;
    let (ratio, _) = lower.at_once(0.0, (-80e-9, 0.0));
    assert!((ratio - TRUE_RATIO - RATIO_NOISE).abs() < 1e-12, "{ratio}");
    // Where it may leave much later than it comes, or nobody knows where the ground is, the
    // height tells nothing.
    let bounce = read_contacts_at(1.0, 0.0);
    for told in [
        bounce.at_once(1e-3, (0.0, 0.0)),
        bounce.at_once(0.0, (0.0, 1e-10)),
    ] {
        assert!((told.0 - bounce.ratio).abs() < 1e-4);
        assert!((told.1 - bounce.error).abs() < 1e-4);
    }
}
