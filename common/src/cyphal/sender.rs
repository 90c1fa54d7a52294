//! Sends transfers: one transfer-ID counter per subject.

use super::{Frames, Header, NodeId, Priority, SubjectId, TRANSFER_ID_MODULO};
use crate::can::Mtu;

/// Error returned by [`Sender::send`]. No counter has moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SendError {
    /// The subject is not one that the sender was made with.
    UnknownSubject(SubjectId),
}

impl core::fmt::Display for SendError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::UnknownSubject(subject) => write!(f, "subject {} has no transfer-ID counter", subject.get()),
        }
    }
}

impl core::error::Error for SendError {}

/// One counter: the subject, and the transfer-ID that its next transfer gets.
#[derive(Clone, Copy, Debug)]
struct Counter {
    subject: SubjectId,
    next: u8,
}

/// The sending side of a node that publishes `SUBJECTS` subjects.
///
/// Counters start at zero and live as long as the sender (specification, section 4.1.1.7).
#[derive(Clone, Debug)]
pub struct Sender<const SUBJECTS: usize> {
    source: NodeId,
    counters: [Counter; SUBJECTS],
}

impl<const SUBJECTS: usize> Sender<SUBJECTS> {
    /// A sender for node `source` that may publish these subjects.
    pub fn new(source: NodeId, subjects: [SubjectId; SUBJECTS]) -> Self {
        Self { source, counters: subjects.map(|subject| Counter { subject, next: 0 }) }
    }

    /// Cuts `payload` into frames, to be sent in the order in which they come. The transfer-ID is used up even if the
    /// frames are not sent, so that receivers notice the gap.
    ///
    /// # Errors
    /// [`SendError::UnknownSubject`].
    pub fn send<'a>(
        &mut self,
        subject: SubjectId,
        priority: Priority,
        payload: &'a [u8],
        mtu: Mtu,
    ) -> Result<Frames<'a>, SendError> {
        let counter = self
            .counters
            .iter_mut()
            .find(|counter| counter.subject == subject)
            .ok_or(SendError::UnknownSubject(subject))?;
        let transfer_id = counter.next;
        counter.next = (transfer_id + 1) % TRANSFER_ID_MODULO;
        let header = Header { priority, subject, source: self.source };
        Ok(Frames::new(header.id(), transfer_id, payload, mtu))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cyphal::TailByte;

    #[test]
    fn each_subject_counts_its_own_transfers_modulo_32() {
        let [a, b] = [1, 2].map(|value| SubjectId::new(value).unwrap());
        let mut sender = Sender::new(NodeId::new(5).unwrap(), [a, b]);
        let mut transfer_id = |subject| {
            let frame = sender.send(subject, Priority::Nominal, &[], Mtu::Fd).unwrap().next().unwrap();
            TailByte::parse(frame.data()[0]).transfer_id
        };
        assert!((0..40).all(|n| transfer_id(a) == n % 32));
        assert_eq!([transfer_id(b), transfer_id(b), transfer_id(a)], [0, 1, 8]);
    }

    #[test]
    fn a_subject_without_counter_is_refused() {
        let [known, unknown] = [1, 2].map(|value| SubjectId::new(value).unwrap());
        let mut sender = Sender::new(NodeId::new(5).unwrap(), [known]);
        let error = sender.send(unknown, Priority::Nominal, &[], Mtu::Fd).err();
        assert_eq!(error, Some(SendError::UnknownSubject(unknown)));
    }
}
