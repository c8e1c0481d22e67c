use crate::recording::*;

fn recording() -> Recording {
    Recording::new(
        "r",
        vec![0.0, 1.0, 2.0, 3.0, 13.0, 14.0],
        Some(vec![1.0, f64::NAN, 3.0, 4.0, 5.0, 6.0]),
        vec![0.0, 1.0, 2.0, 3.0, 13.0, 14.0],
        None,
    )
    .unwrap()
}

#[test]
fn slopes_make_a_grid_follow_a_fast_ring() {
    // The second mode at 50 kHz: straight lines miss its crests by 8 %.
    let (dt, w) = (2e-5, 2.0 * std::f64::consts::PI * 6424.0);
    let values: Vec<f64> = (0..200).map(|i| (w * dt * f64::from(i)).sin()).collect();
    let slopes: Vec<f64> = (0..200)
        .map(|i| w * (w * dt * f64::from(i)).cos())
        .collect();
    let worst = |slopes| {
        let grid = Grid {
            t0: 0.0,
            dt,
            values: &values,
            slopes,
        };
        (0..1990)
            .map(|i| 0.1 * dt * f64::from(i))
            .map(|t| (grid.value_at(t).unwrap() - (w * t).sin()).abs())
            .fold(0.0, f64::max)
    };
    assert!(worst(None) > 0.05);
    assert!(worst(Some(slopes.as_slice())) < 2e-3);
}

#[test]
fn times_and_rates() {
    let r = recording();
    assert_eq!(
        (r.len(), r.duration(), r.interval(), r.sampling_rate()),
        (6, 14.0, 1.0, 1.0)
    );
    assert!(!r.is_uniform() && !r.is_empty());
    assert_eq!(r.gaps(), [(3.0, 13.0)]);
    let even = Recording::new(
        "e",
        vec![0.0, 0.0666, 0.1333, 0.2],
        None,
        vec![0.0; 4],
        None,
    )
    .unwrap();
    assert!(even.is_uniform());
}

#[test]
fn values_between_samples_and_not_in_gaps() {
    let r = recording();
    let x = |t| r.value_at(Channel::ProofMass, t);
    assert_eq!(
        (x(0.0), x(0.5), x(14.0)),
        (Some(0.0), Some(0.5), Some(14.0))
    );
    assert_eq!(
        (x(-0.1), x(8.0), x(14.1), x(f64::NAN)),
        (None, None, None, None)
    );
    assert_eq!(x(3.0), Some(3.0), "the last sample before a gap is there");
    let v = |t| r.value_at(Channel::Voltage, t);
    assert_eq!(
        (v(0.0), v(0.5), v(1.0), v(1.5), v(2.0)),
        (Some(1.0), None, None, None, Some(3.0))
    );
    assert_eq!(r.value_at(Channel::Cantilever, 0.0), None);
}

#[test]
fn resampling_agrees_with_interpolation() {
    let r = recording();
    for channel in Channel::ALL {
        let grid = r.resampled(channel, -0.7, 0.1, 200);
        assert_eq!(grid.is_some(), r.channel(channel).is_some());
        for (i, value) in grid.into_iter().flatten().enumerate() {
            let expected = r.value_at(channel, -0.7 + i as f64 * 0.1);
            assert_eq!(value.is_finite().then_some(value), expected);
        }
    }
}

#[test]
fn the_sample_before_an_instant_is_found_however_uneven_the_samples_are() {
    let time = vec![0.0, 1.0, 1.1, 1.2, 2.0, 3.0, 9.0, 9.5, 10.0, 11.0];
    let r = Recording::new("uneven", time.clone(), None, vec![0.0; 10], None).unwrap();
    assert_eq!(r.sample_before(-0.1), None);
    assert_eq!(r.sample_before(f64::NAN), None);
    for (i, t) in time.iter().enumerate() {
        assert_eq!(r.sample_before(*t), Some(i));
        assert_eq!(r.sample_before(t + 0.05), Some(i));
    }
    assert_eq!(r.sample_before(1e300), Some(9));
}

#[test]
fn drive_table_skips_missing_samples() {
    let (t, v) = recording().drive_table().unwrap();
    assert_eq!(
        (t, v),
        (
            vec![0.0, 2.0, 3.0, 13.0, 14.0],
            vec![1.0, 3.0, 4.0, 5.0, 6.0]
        )
    );
    let none = Recording::new("n", vec![0.0, 1.0], None, vec![0.0, 1.0], None).unwrap();
    assert!(none.drive_table().is_none());
}

#[test]
fn invalid_columns_are_refused() {
    let new = |t: &[f64], x: &[f64]| Recording::new("r", t.to_vec(), None, x.to_vec(), None);
    assert_eq!(
        new(&[0.0], &[0.0]).unwrap_err(),
        RecordingError::TooShort(1)
    );
    assert_eq!(
        new(&[0.0, 0.0], &[0.0; 2]).unwrap_err(),
        RecordingError::TimeNotIncreasing { sample: 1 }
    );
    assert_eq!(
        new(&[0.0, f64::INFINITY], &[0.0; 2]).unwrap_err(),
        RecordingError::TimeNotIncreasing { sample: 1 }
    );
    assert_eq!(
        new(&[f64::NAN, 1.0], &[0.0; 2]).unwrap_err(),
        RecordingError::TimeNotIncreasing { sample: 0 }
    );
    assert!(matches!(
        new(&[0.0, 1.0], &[0.0; 3]),
        Err(RecordingError::LengthMismatch { channel: "xp", .. })
    ));
}

#[test]
fn grids_interpolate_within_their_span() {
    let grid = Grid {
        t0: 1.0,
        dt: 0.5,
        values: &[0.0, 1.0, f64::NAN, 3.0],
        slopes: None,
    };
    assert_eq!(grid.end(), 2.5);
    assert_eq!(
        (grid.value_at(1.0), grid.value_at(1.25), grid.value_at(1.5)),
        (Some(0.0), Some(0.5), Some(1.0))
    );
    assert_eq!(
        (
            grid.value_at(1.75),
            grid.value_at(2.5),
            grid.value_at(2.6),
            grid.value_at(0.9)
        ),
        (None, Some(3.0), None, None)
    );
    assert_eq!(
        Grid {
            t0: 0.0,
            dt: 1.0,
            values: &[],
            slopes: None
        }
        .value_at(0.0),
        None
    );
    assert_eq!(
        Grid {
            t0: 0.0,
            dt: 1.0,
            values: &[7.0],
            slopes: None
        }
        .value_at(0.0),
        Some(7.0)
    );
    assert_eq!(
        Grid {
            t0: 0.0,
            dt: 0.0,
            values: &[7.0, 8.0],
            slopes: None
        }
        .value_at(0.0),
        None
    );
}

#[test]
fn axes_name_their_samples() {
    let times = [0.0, 1.0, 3.0, 4.0];
    let axis = TimeAxis::Samples(&times);
    assert_eq!(
        (axis.at(2), axis.at(9).is_nan(), axis.interval(4)),
        (3.0, true, 1.0)
    );
    assert!(axis.covers(4) && !axis.covers(5));
    assert!(!TimeAxis::Uniform { t0: 0.0, dt: 0.0 }.covers(1));
}

#[test]
fn a_drive_is_made_once_for_each_reading() {
    let r = recording();
    assert!(r.has_voltage());
    for (index, reading) in DriveReading::ALL.into_iter().enumerate() {
        assert_eq!(reading as usize, index);
        let first = r.drive(reading).unwrap().unwrap();
        let again = r.drive(reading).unwrap().unwrap();
        assert!(Arc::ptr_eq(&first, &again), "{reading:?}");
    }
    // A clone may get another voltage: it makes its own.
    let mut changed = r.clone();
    changed.voltage = Some(vec![f64::NAN, f64::NAN, 3.0, f64::NAN, f64::NAN, f64::NAN]);
    assert!(!changed.has_voltage());
    for reading in DriveReading::ALL {
        assert!(changed.drive(reading).is_none());
    }
}
