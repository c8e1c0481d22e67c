//! The total misfit before and after the last change, so that a person sees whether it was one for
//! the better.

/// A change of less than this share is neither better nor worse.
const EQUAL_SHARE: f64 = 5e-4;

/// Total misfits in units of the noise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MisfitHistory {
    /// When the pointer was last up.
    settled: Option<f64>,
    /// Before the change that led to `settled`.
    before: Option<f64>,
    /// Number of the result that `settled` is of.
    generation: u64,
}

impl MisfitHistory {
    /// Takes the misfit of the newest result, number `generation`; `dragging` while a change is still
    /// going on. A result that becomes better known keeps its number: that is no change.
    pub fn follow(&mut self, now: Option<f64>, generation: u64, dragging: bool) {
        if dragging || now == self.settled {
            return;
        }
        let is_same = std::mem::replace(&mut self.generation, generation) == generation;
        // What was not computed is nothing to compare with.
        if !is_same && now.is_some() && self.settled.is_some() {
            self.before = self.settled;
        }
        self.settled = now.or(self.settled);
    }

    /// The misfit to compare `now` with: before the drag, or before the last change.
    pub fn reference(&self, now: f64) -> Option<f64> {
        if self.settled == Some(now) {
            self.before
        } else {
            self.settled
        }
    }

    /// `now` against what it was, in words: `better, was 5.3`.
    pub fn text(&self, now: f64) -> Option<String> {
        let before = self.reference(now)?;
        let word = if (now - before).abs() <= EQUAL_SHARE * before {
            "unchanged"
        } else if now < before {
            "better"
        } else {
            "worse"
        };
        let was = crate::model::unit::format_number(before, 3);
        Some(if word == "unchanged" {
            word.to_owned()
        } else {
            format!("{word}, was {was}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_tells_better_from_worse_than_before_the_drag() {
        let mut history = MisfitHistory::default();
        history.follow(Some(5.0), 1, false);
        assert_eq!(history.text(5.0), None);
        for (now, generation) in [(4.0, 2), (3.0, 3)] {
            history.follow(Some(now), generation, true);
            assert_eq!(history.text(now).unwrap(), "better, was 5");
        }
        history.follow(Some(7.0), 4, true);
        assert_eq!(history.text(7.0).unwrap(), "worse, was 5");
        history.follow(Some(2.0), 5, false);
        assert_eq!(history.text(2.0).unwrap(), "better, was 5");
        // The readings decide what the voltage leaves open.
        history.follow(Some(1.9), 5, false);
        assert_eq!(history.text(1.9).unwrap(), "better, was 5");
        history.follow(None, 6, false);
        history.follow(Some(1.9), 7, false);
        assert_eq!(history.text(1.9).unwrap(), "better, was 5");
        assert_eq!(history.text(1.9004).unwrap(), "unchanged");
    }
}
