use std::sync::atomic::{AtomicUsize, Ordering};

use image::AnimationDecoder;
use image::codecs::gif::GifDecoder;

use super::*;
use crate::app::analysis::learning::presenting::{SavedScene, Shows};
use crate::learn::lesson::LessonPicture;
use crate::learn::run::Scene;
use crate::model::preset::Preset;

fn request(span: (f64, f64)) -> FilmRequest {
    let scene = Scene::of_preset(Preset::embedded("bouncing-ball").unwrap());
    let saved = SavedScene {
        scene,
        controls: Vec::new(),
        pictures: vec![LessonPicture::Device, LessonPicture::Trajectory],
        speed: 1.0,
        shows: Shows::default(),
    };
    FilmRequest::new(saved, span, true)
}

#[test]
fn a_film_shows_the_device_moving_over_the_chosen_span() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.gif");
    assert!(write(&request((0.1, 0.25)), &path, &|_| true).unwrap());
    let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
    let frames = GifDecoder::new(file).unwrap().into_frames();
    let frames = frames.collect_frames().unwrap();
    // 0.15 s at 25 pictures a second, and the last one.
    assert_eq!(frames.len(), 5);
    let [first, .., last] = &frames[..] else {
        panic!("too few")
    };
    assert_eq!(first.buffer().dimensions(), (FILM_SIZE[0], FILM_SIZE[1]));
    let differing = first.buffer().pixels().zip(last.buffer().pixels());
    let differing = differing.filter(|(a, b)| a != b).count();
    assert!(differing > 1000, "only {differing} pixels differ");
    let colors: std::collections::HashSet<_> = first.buffer().pixels().collect();
    assert!(colors.len() > 20, "only {} colours", colors.len());
}

#[test]
fn pictures_are_numbered_and_a_film_can_be_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.png");
    assert!(write(&request((0.0, 0.06)), &path, &|_| true).unwrap());
    for number in 1..=3 {
        let file = numbered(&path, number);
        assert!(image::open(&file).is_ok(), "{}", file.display());
    }
    assert!(!numbered(&path, 4).exists());
    let asked = AtomicUsize::new(0);
    let path = folder.path().join("cancelled.gif");
    let go_on = |share: f32| {
        asked.fetch_add(1, Ordering::Relaxed);
        share == 0.0
    };
    assert!(!write(&request((0.0, 2.0)), &path, &go_on).unwrap());
    assert!(!path.exists());
}

#[test]
fn a_span_without_pictures_or_with_too_many_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.gif");
    let beyond = write(&request((5.0, 6.0)), &path, &|_| true).unwrap_err();
    assert!(matches!(beyond, FilmError::EmptySpan), "{beyond}");
    let mut slow = request((0.0, 2.0));
    slow.saved.speed = 1e-3;
    let error = write(&slow, &path, &|_| true).unwrap_err();
    assert!(matches!(error, FilmError::TooLong), "{error}");
}
