use crate::recording::events::*;

const LEVEL: f64 = -58e-6;

/// A ball thrown at the ground with restitution: `(t, x)` in closed form.
/// Falls from 20 um, bounces with factor `e`, rests below a speed, and is pulled off
/// at `release`.
fn bouncing(rate: f64, e: f64, release: f64) -> (Vec<f64>, Vec<(f64, f64)>) {
    let g = 2000.0;
    let mut impacts = Vec::new();
    let (mut t0, mut h0, mut v0) = (0.0, 20e-6, 0.0);
    let mut pieces = Vec::new();
    loop {
        let hit = (v0 + f64::sqrt(v0 * v0 + 2.0 * g * h0)) / g;
        let v = v0 - g * hit;
        pieces.push((t0, t0 + hit, h0, v0));
        let stays = impacts.len() == 2;
        impacts.push((t0 + hit, v));
        t0 += hit;
        h0 = 0.0;
        v0 = -e * v;
        if stays {
            break;
        }
    }
    let n = (0.02 * rate) as usize;
    let x = (0..n)
        .map(|i| {
            let t = i as f64 / rate;
            if t > release {
                // It is pulled off at once, and stops at twice the height of its fall.
                return LEVEL + (500.0 * (t - release).powi(2)).min(40e-6);
            }
            pieces
                .iter()
                .find(|p| t >= p.0 && t < p.1)
                .map_or(LEVEL, |p| {
                    let s = t - p.0;
                    LEVEL + p.2 + p.3 * s - 0.5 * g * s * s
                })
        })
        .collect();
    (x, impacts)
}

#[test]
fn impacts_and_contact_of_a_bouncing_mass() {
    let (x, truth) = bouncing(50e3, 0.8, 10e-3);
    let axis = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
    let options = EventOptions::for_data(LEVEL, axis, &x);
    let events = find_events(axis, &x, &options);
    assert_eq!(events.impacts.len(), 3, "{events:?}");
    for (k, (found, (t, v))) in events.impacts.iter().zip(&truth).enumerate() {
        assert!((found.time - t).abs() < 2e-6, "{found:?} {t}");
        assert!((found.v_before / v - 1.0).abs() < 0.02, "{found:?} {v}");
        let after = if k == 2 { 0.0 } else { -0.8 * v };
        assert!(
            (found.v_after - after).abs() < 0.02 * v.abs(),
            "{found:?} {after}"
        );
    }
    // The first hop rises by 0.64 of 20 um, the second by 0.41: both above 5 um.
    assert_eq!(events.contacts.len(), 3, "{events:?}");
    let rest = events.contacts[2];
    assert!(
        (rest.start - truth[2].0).abs() < 2e-6 && (rest.end - 10e-3).abs() < 2e-5,
        "{rest:?}"
    );
}

#[test]
fn small_hops_are_merged() {
    let (x, truth) = bouncing(50e3, 0.4, 10e-3);
    let axis = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
    let events = find_events(axis, &x, &EventOptions::for_data(LEVEL, axis, &x));
    assert_eq!(events.contacts.len(), 1);
    assert!((events.contacts[0].start - truth[0].0).abs() < 2e-6);
    assert!(!events.contacts[0].cut);
}

#[test]
fn a_smooth_turn_above_the_ground_is_no_contact() {
    let x: Vec<f64> = (0..1000)
        .map(|i| LEVEL + 1e-6 + 30e-6 * (1.0 - (i as f64 * 0.02).cos()))
        .collect();
    let axis = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
    let events = find_events(axis, &x, &EventOptions::for_data(LEVEL, axis, &x));
    assert_eq!(events, Events::default());
}

#[test]
fn gaps_and_ends_cut_a_contact() {
    let mut x = vec![LEVEL; 100];
    x[50] = f64::NAN;
    let axis = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
    let events = find_events(
        axis,
        &x,
        &EventOptions {
            contact_level: LEVEL,
            noise: 0.0,
            hop: HOP_HEIGHT,
        },
    );
    assert_eq!(events.contacts.len(), 2);
    assert!(events.contacts.iter().all(|c| c.cut));
    let none = find_events(
        axis,
        &[],
        &EventOptions {
            contact_level: LEVEL,
            noise: 0.0,
            hop: HOP_HEIGHT,
        },
    );
    assert_eq!(none, Events::default());
}

#[test]
fn many_visits_of_a_long_axis_take_no_longer_each() {
    // A mass that taps every millisecond for 20 s: 20,000 visits among 1e6 samples.
    let n = 1_000_000;
    let time: Vec<f64> = (0..n).map(|i| 2e-5 * f64::from(i)).collect();
    let xp: Vec<f64> = time
        .iter()
        .map(|t| LEVEL + 40e-6 * (std::f64::consts::PI * 1e3 * t).sin().abs())
        .collect();
    let options = EventOptions {
        contact_level: LEVEL,
        noise: 1e-9,
        hop: HOP_HEIGHT,
    };
    let begun = std::time::Instant::now();
    let events = find_events(TimeAxis::Samples(&time), &xp, &options);
    let took = begun.elapsed();
    println!("{} impacts in {took:.2?}", events.impacts.len());
    assert!(events.impacts.len() > 15_000, "{}", events.impacts.len());
    assert!(took.as_secs_f64() < 10.0, "{took:.2?}");
}
