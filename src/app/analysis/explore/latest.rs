//! Questions that are asked anew with each movement of a handle, answered on a thread of their own:
//! a newer question replaces one that waits, and a long answer is given up for it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use eframe::egui::Context;

use crate::app::analysis::job::panic_text;

/// An answer that takes longer is given up when a newer question waits. Shorter ones are finished,
/// so that a drag shows all its responses.
const MAX_OUTDATED_WORK: Duration = Duration::from_millis(120);

/// Work that answers questions, one after the other; it may keep what it has prepared.
pub trait Answers: Default + Send + 'static {
    /// What is asked.
    type Question: PartialEq + Send + Sync + 'static;
    /// What is answered.
    type Answer: Send + Sync + 'static;
    /// Name of the thread.
    const NAME: &'static str;

    /// The answer. `go_on` says whether it is still of use.
    ///
    /// # Errors
    /// Why there is none, for the person.
    fn answer(
        &mut self,
        question: &Self::Question,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Self::Answer, String>;
}

/// A question with its answer.
pub struct Answered<W: Answers> {
    /// What was asked.
    pub question: Arc<W::Question>,
    /// What was answered.
    pub answer: Result<W::Answer, String>,
    /// How long it took.
    pub cost: Duration,
}

struct Slots<W: Answers> {
    question: Option<Arc<W::Question>>,
    answer: Option<Arc<Answered<W>>>,
    quit: bool,
}

struct Shared<W: Answers> {
    slots: Mutex<Slots<W>>,
    wake: Condvar,
}

impl<W: Answers> Shared<W> {
    /// A poisoned lock only says that a panic happened elsewhere; the data are plain slots.
    fn lock(&self) -> MutexGuard<'_, Slots<W>> {
        self.slots.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn next(&self) -> Option<Arc<W::Question>> {
        let mut slots = self.lock();
        loop {
            if slots.quit {
                return None;
            }
            if let Some(question) = slots.question.take() {
                return Some(question);
            }
            slots = self
                .wake
                .wait(slots)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Ends the thread with the last handle.
struct Link<W: Answers>(Arc<Shared<W>>);

impl<W: Answers> Drop for Link<W> {
    fn drop(&mut self) {
        self.0.lock().quit = true;
        self.0.wake.notify_one();
    }
}

/// The newest question and the newest answer.
pub struct Latest<W: Answers> {
    link: Option<Arc<Link<W>>>,
    asked: Option<Arc<W::Question>>,
    answered: Option<Arc<Answered<W>>>,
}

impl<W: Answers> Default for Latest<W> {
    fn default() -> Self {
        Self {
            link: None,
            asked: None,
            answered: None,
        }
    }
}

impl<W: Answers> Clone for Latest<W> {
    fn clone(&self) -> Self {
        Self {
            link: self.link.clone(),
            asked: self.asked.clone(),
            answered: self.answered.clone(),
        }
    }
}

impl<W: Answers> std::fmt::Debug for Latest<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct(W::NAME).finish_non_exhaustive()
    }
}

impl<W: Answers> Latest<W> {
    /// Asks, unless just that was asked last. A thread that cannot be started is an answer that
    /// says so.
    pub fn ask(&mut self, question: W::Question, context: &Context) {
        if self.asked.as_deref() == Some(&question) {
            return;
        }
        let question = Arc::new(question);
        self.asked = Some(Arc::clone(&question));
        if self.link.is_none() {
            match start::<W>(context) {
                Ok(link) => self.link = Some(Arc::new(link)),
                Err(error) => {
                    let text = format!("no thread could be started: {error}; close other programs");
                    self.answered = Some(Arc::new(Answered {
                        question,
                        answer: Err(text),
                        cost: Duration::ZERO,
                    }));
                    return;
                }
            }
        }
        if let Some(link) = &self.link {
            link.0.lock().question = Some(question);
            link.0.wake.notify_one();
        }
    }

    /// The question that was asked last.
    pub fn asked(&self) -> Option<&W::Question> {
        self.asked.as_deref()
    }

    /// The newest answer, to the present question or to an earlier one.
    pub fn newest(&mut self) -> Option<Arc<Answered<W>>> {
        if let Some(link) = &self.link
            && let Some(answer) = link.0.lock().answer.take()
        {
            self.answered = Some(answer);
        }
        self.answered.clone()
    }

    /// Whether the newest answer is still to come.
    pub fn is_waiting(&self) -> bool {
        match (&self.asked, &self.answered) {
            (Some(asked), Some(answered)) => !Arc::ptr_eq(asked, &answered.question),
            (asked, _) => asked.is_some(),
        }
    }
}

fn start<W: Answers>(context: &Context) -> std::io::Result<Link<W>> {
    let shared = Arc::new(Shared::<W> {
        slots: Mutex::new(Slots {
            question: None,
            answer: None,
            quit: false,
        }),
        wake: Condvar::new(),
    });
    let (of_thread, context) = (Arc::clone(&shared), context.clone());
    std::thread::Builder::new()
        .name(W::NAME.to_owned())
        .spawn(move || serve(&of_thread, &context))?;
    Ok(Link(shared))
}

fn serve<W: Answers>(shared: &Shared<W>, context: &Context) {
    let mut work = W::default();
    while let Some(question) = shared.next() {
        let started = Instant::now();
        let given_up = std::cell::Cell::new(false);
        let go_on = || {
            let slots = shared.lock();
            let outdated = slots.question.is_some() && started.elapsed() > MAX_OUTDATED_WORK;
            let stop = slots.quit || outdated;
            given_up.set(given_up.get() || stop);
            !stop
        };
        let answer = catch_unwind(AssertUnwindSafe(|| work.answer(&question, &go_on)));
        let answer = answer.unwrap_or_else(|panic| {
            // What it had prepared may be half done.
            work = W::default();
            let text = panic_text(panic.as_ref());
            Err(format!("internal error: {text}"))
        });
        if given_up.get() && answer.is_err() {
            continue;
        }
        shared.lock().answer = Some(Arc::new(Answered {
            question,
            answer,
            cost: started.elapsed(),
        }));
        context.request_repaint();
    }
}

#[cfg(test)]
mod tests {
    use super::super::latest::*;

    #[derive(Default)]
    struct Square;

    impl Answers for Square {
        type Question = i32;
        type Answer = i32;
        const NAME: &'static str = "square";

        fn answer(&mut self, n: &i32, go_on: &dyn Fn() -> bool) -> Result<i32, String> {
            match *n {
                0 => panic!("on purpose"),
                // Works until it is outdated.
                1 => {
                    while go_on() {
                        std::thread::sleep(Duration::from_millis(2));
                    }
                    Err("given up".to_owned())
                }
                n => Ok(n * n),
            }
        }
    }

    fn wait(latest: &mut Latest<Square>) -> Result<i32, String> {
        for _ in 0..2000 {
            let newest = latest.newest();
            if !latest.is_waiting() {
                return newest.unwrap().answer.clone();
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        panic!("no answer");
    }

    #[test]
    fn the_newest_question_is_answered_long_ones_are_given_up_and_panics_are_errors() {
        let context = Context::default();
        let mut latest = Latest::<Square>::default();
        assert!(!latest.is_waiting() && latest.newest().is_none());
        latest.ask(1, &context);
        latest.ask(2, &context);
        latest.ask(3, &context);
        assert_eq!(wait(&mut latest), Ok(9));
        latest.ask(0, &context);
        assert!(wait(&mut latest).unwrap_err().contains("on purpose"));
        // The thread lives on.
        latest.ask(4, &context);
        assert_eq!(wait(&mut latest), Ok(16));
        let clone = latest.clone();
        drop(latest);
        assert_eq!(clone.asked(), Some(&4));
    }
}
