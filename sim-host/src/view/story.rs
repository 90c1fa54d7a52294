//! What happened when: phases, and marks on the time line.

use super::payload::{Mark, MarkKind, PhaseSpan};
use tactus_common::message::Phase;

/// Phases and marks, as they are read.
#[derive(Clone, Debug)]
pub struct Story {
    phases: Vec<PhaseSpan>,
    marks: Vec<Mark>,
}

impl Default for Story {
    fn default() -> Self {
        let first = PhaseSpan { name: format!("{:?}", Phase::Initialise), from_s: 0.0, to_s: 0.0 };
        Self { phases: vec![first], marks: Vec::new() }
    }
}

impl Story {
    /// A phase begins.
    pub fn phase(&mut self, at_s: f32, name: &str) {
        self.end(at_s);
        self.phases.push(PhaseSpan { name: name.to_owned(), from_s: at_s, to_s: at_s });
    }

    /// Is the object carried, or put down already? What was believed of it is then out of date.
    pub fn is_carried(&self) -> bool {
        let carried = [Phase::Transport, Phase::Release, Phase::Done].map(|phase| format!("{phase:?}"));
        self.phases.last().is_some_and(|phase| carried.contains(&phase.name))
    }

    /// Something happened; the log's next line says what.
    pub fn mark(&mut self, at_s: f32, kind: MarkKind) {
        self.marks.push(Mark { at_s, kind, text: String::new() });
    }

    /// A line of the log: about the mark before it, or a thing of its own.
    pub fn say(&mut self, at_s: f32, text: &str) {
        match self.marks.last_mut() {
            Some(mark) if mark.text.is_empty() => mark.text = text.to_owned(),
            _ => self.marks.push(Mark { at_s, kind: MarkKind::Other, text: text.to_owned() }),
        }
    }

    /// The end of the recording, or of the phase before.
    fn end(&mut self, at_s: f32) {
        if let Some(phase) = self.phases.last_mut() {
            phase.to_s = at_s;
        }
    }

    /// Phases without empty ones, and marks.
    pub fn finish(mut self, at_s: f32) -> (Vec<PhaseSpan>, Vec<Mark>) {
        self.end(at_s);
        self.phases.retain(|phase| phase.to_s > phase.from_s);
        (self.phases, self.marks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_follow_one_another_without_gaps_and_empty_ones_are_left_out() {
        let mut story = Story::default();
        for (at_s, name) in [(0.0, "Plan"), (1.0, "Trial"), (1.0, "Update"), (2.0, "Transport")] {
            story.phase(at_s, name);
        }
        assert!(story.is_carried());
        let (phases, _) = story.finish(3.0);
        let spans: Vec<_> = phases.iter().map(|p| (p.name.as_str(), p.from_s, p.to_s)).collect();
        assert_eq!(spans, [("Plan", 0.0, 1.0), ("Update", 1.0, 2.0), ("Transport", 2.0, 3.0)]);
    }

    #[test]
    fn a_line_of_the_log_belongs_to_the_mark_before_it_or_stands_for_itself() {
        let mut story = Story::default();
        story.mark(1.0, MarkKind::Touch);
        story.say(1.0, "Touch 7");
        story.say(2.0, "Grasp");
        let (_, marks) = story.finish(3.0);
        let told: Vec<_> = marks.iter().map(|m| (m.kind, m.text.as_str())).collect();
        assert_eq!(told, [(MarkKind::Touch, "Touch 7"), (MarkKind::Other, "Grasp")]);
    }
}
