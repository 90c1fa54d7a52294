//! Where questions to the advisor are worked on: at once while the world waits, or beside it while time goes on.

use crate::advisor::{Advisor, Question, Reply};
use std::collections::VecDeque;
use std::thread::JoinHandle;

/// The advisor, at its desk or out on a question.
enum Advising {
    Free(Box<Advisor>),
    Out(JoinHandle<(Box<Advisor>, Reply)>),
    /// It panicked: no question is answered any more, and the controller's own time limits see to it.
    Gone,
}

/// The advisor with the questions that wait for it.
pub struct Desk {
    advisor: Advising,
    waiting: VecDeque<Question>,
}

impl Desk {
    /// A desk with nothing on it.
    pub fn new(advisor: Advisor) -> Self {
        Self { advisor: Advising::Free(Box::new(advisor)), waiting: VecDeque::new() }
    }

    /// Puts a question on it.
    pub fn ask(&mut self, question: Question) {
        self.waiting.push_back(question);
    }

    /// Answers the next question here and now, to take effect at tick `effective`.
    pub fn answer_now(&mut self, effective: u32) -> Option<Reply> {
        let Advising::Free(advisor) = &mut self.advisor else { return None };
        let question = self.waiting.pop_front()?;
        Some(advisor.answer(&question, effective))
    }

    /// Is there a question to be answered?
    pub fn has_questions(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// An answer that has become ready, and the next question on its way; never waits.
    pub fn poll(&mut self, effective: u32) -> Option<Reply> {
        let reply = match &self.advisor {
            Advising::Out(work) if work.is_finished() => self.fetch(),
            _ => None,
        };
        if matches!(self.advisor, Advising::Free(_))
            && let Some(question) = self.waiting.pop_front()
            && let Advising::Free(mut advisor) = std::mem::replace(&mut self.advisor, Advising::Gone)
        {
            self.advisor = Advising::Out(std::thread::spawn(move || {
                let reply = advisor.answer(&question, 0);
                (advisor, reply)
            }));
        }
        let mut reply = reply?;
        match &mut reply {
            Reply::Plan(answer) => answer.effective = effective,
            Reply::Rollout(result) => result.effective = effective,
        }
        Some(reply)
    }

    fn fetch(&mut self) -> Option<Reply> {
        let Advising::Out(work) = std::mem::replace(&mut self.advisor, Advising::Gone) else { return None };
        let (advisor, reply) = work.join().ok()?;
        self.advisor = Advising::Free(advisor);
        Some(reply)
    }
}
