//! Decimation hides no spike, and its cost depends on the pixels only.

use proptest::prelude::*;

use crate::app::simulation::min_max_pyramid::Pyramid;

/// Every sample in view lies between the minimum and maximum of its column.
fn envelopes(pyramid: &Pyramid, times: &[f64], values: &[f64], view: (f64, f64), pixels: usize) {
    let (from, to) = view;
    let points = pyramid.draw(from, to, pixels);
    assert!(points.len() <= 6 * pixels + 16, "{}", points.len());
    let width = (to - from) / pixels as f64;
    for (&t, &value) in times.iter().zip(values) {
        if t < from || t > to || !value.is_finite() {
            continue;
        }
        let near = points.iter().filter(|p| (p[0] - t).abs() <= 1.01 * width);
        let (low, high) = near.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| {
            (a.min(p[1]), b.max(p[1]))
        });
        assert!(
            low <= value && value <= high,
            "{value} at {t}: {low}..{high}"
        );
    }
}

fn value() -> impl Strategy<Value = f64> {
    prop_oneof![20 => -1e3..1e3f64, 1 => Just(f64::NAN), 1 => -1e9..1e9f64]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_sample_is_in_the_drawn_envelope(
        values in prop::collection::vec(value(), 1..4000),
        view in (0.0..1.0f64, 0.0..1.0f64),
        pixels in 1..400usize,
    ) {
        let end = values.len() as f64 * 0.5;
        let view = (end * view.0.min(view.1) - 1.0, end * view.0.max(view.1) + 1.0);
        let times: Vec<f64> = (0..values.len()).map(|i| 0.5 * i as f64).collect();
        let even = Pyramid::new(0.0, 0.5, &values);
        envelopes(&even, &times, &values, view, pixels);
        let listed = Pyramid::xy(&times, &values);
        envelopes(&listed, &times, &values, view, pixels);
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let extremes = finite().fold(None, |e: Option<(f64, f64)>, v| {
            Some(e.map_or((v, v), |(a, b)| (a.min(v), b.max(v))))
        });
        prop_assert_eq!(even.extremes(), extremes);
        prop_assert_eq!(listed.extremes(), extremes);
    }

    #[test]
    fn the_range_in_view_is_that_of_its_samples(
        values in prop::collection::vec(-1e3..1e3f64, 2..5000),
        part in (0.0..1.0f64, 0.0..1.0f64),
    ) {
        let last = (values.len() - 1) as f64;
        let (a, b) = ((last * part.0.min(part.1)).floor(), (last * part.0.max(part.1)).ceil());
        let part = &values[a as usize..=b as usize];
        let low = part.iter().copied().fold(f64::INFINITY, f64::min);
        let high = part.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let pyramid = Pyramid::new(2.0, 1.0, &values);
        prop_assert_eq!(pyramid.value_range(2.0 + a, 2.0 + b), Some((low, high)));
    }
}

#[test]
fn few_samples_are_drawn_as_they_are() {
    let pyramid = Pyramid::new(0.0, 1.0, &[1.0, 2.0, f64::NAN, 4.0]);
    let points = pyramid.draw(-1.0, 9.0, 100);
    assert_eq!(points.len(), 4);
    assert_eq!((points[0], points[3]), ([0.0, 1.0], [3.0, 4.0]));
    assert!(points[2][0].is_nan());
    assert_eq!(pyramid.value_at(0.5), Some(1.5));
    assert_eq!(pyramid.value_at(1.5), None);
    assert_eq!(pyramid.value_at(3.1), None);
    assert_eq!(pyramid.value_at(-0.1), None);
}

#[test]
fn missing_samples_break_the_line() {
    let mut times: Vec<f64> = (0..1000).map(f64::from).collect();
    times.extend((2000..3000).map(f64::from));
    let pyramid = Pyramid::xy(&times, &vec![1.0; 2000]);
    for pixels in [10_000, 50] {
        let points = pyramid.draw(0.0, 3000.0, pixels);
        let breaks = points.iter().filter(|p| p[0].is_nan()).count();
        assert_eq!(breaks, 1, "{pixels}");
    }
    assert_eq!(pyramid.value_at(1500.0), None);
    assert_eq!(pyramid.value_at(500.5), Some(1.0));
}

#[test]
fn empty_and_invalid_series_draw_nothing() {
    assert!(Pyramid::default().draw(0.0, 1.0, 10).is_empty());
    assert_eq!(Pyramid::default().value_range(0.0, 1.0), None);
    assert_eq!(Pyramid::default().value_at(0.0), None);
    let one = Pyramid::new(0.0, 0.0, &[5.0]);
    assert_eq!(one.draw(-1.0, 1.0, 10), [[0.0, 5.0]]);
    assert_eq!(one.value_at(0.0), Some(5.0));
    assert!(one.draw(1.0, -1.0, 10).is_empty());
    assert!(one.draw(f64::NAN, 1.0, 10).is_empty());
    let never = Pyramid::new(0.0, 1.0, &[f64::NAN; 1000]);
    assert!(never.draw(0.0, 1000.0, 10).is_empty());
    assert_eq!(never.extremes(), None);
}

/// The cost of a picture depends on its pixels, not on the number of samples.
#[test]
fn ten_million_samples_are_drawn_as_a_few_thousand() {
    let values: Vec<f64> = (0..10_000_000).map(|i| f64::from(i % 1000)).collect();
    let pyramid = Pyramid::new(0.0, 2e-5, &values);
    for i in 0..100 {
        let points = pyramid.draw(f64::from(i) * 0.1, 199.0, 1000).len();
        assert!((1000..=4100).contains(&points), "{points}");
    }
}
