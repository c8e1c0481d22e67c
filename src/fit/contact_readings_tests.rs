//! Readings of bounces from numbers made up here.

use crate::fit::contact_readings::*;

#[test]
fn a_ratio_is_corrected_by_how_far_the_departure_misses_the_approach() {
    // Ratio and height are wrong together, but for a share of the ratio.
    const TRUE: f64 = 0.37;
    const LINKED: f64 = -0.05;
    const OWN: f64 = 0.01;
    let read = |off: f64, own: f64| Bounce {
        recording: 0,
        time: 0.1,
        approach: 0.03,
        departure: 0.03 * (TRUE + LINKED * off + own),
        ratio: TRUE + LINKED * off + own,
        error: LINKED.hypot(OWN),
        miss: 60e-9 * off,
        miss_error: 60e-9,
        shared: LINKED * 60e-9,
        flight: 14.0,
    };
    for off in [-2.0, 0.0, 1.0] {
        let (ratio, error) = read_contacts_at(off, OWN).at_once(0.0, (0.0, 0.0));
        assert!((ratio - TRUE - OWN).abs() < 1e-12, "{off}: {ratio}");
        assert!((error - OWN).abs() < 1e-9, "{off}: {error}");
    }
    // A ground that lies elsewhere is missed by as much.
    let mut lower = read_contacts_at(1.0, OWN);
    lower.miss -= 80e-9;
    let (ratio, _) = lower.at_once(0.0, (-80e-9, 0.0));
    assert!((ratio - TRUE - OWN).abs() < 1e-12, "{ratio}");
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
