//! The published errors: predicted and felt contacts, compared entry by entry over time (Nikandrova 2011, eqs. 21-24).
//!
//! Both are contact matrices of one closing of the hand: a row per time instant, a column per hand link (nine), an entry
//! 1 where the link touches. These errors have no slope, are flat wherever the prediction does not change, and count
//! contacts, not metres: see [`super::geometric`] for one that does not.

use heapless::Vec;
use tactus_common::limits::{FINGERS, HAND_LINKS};
use tactus_common::message::ROLLOUT_INSTANTS;

/// Which hand links touch (bit i = link i of [`tactus_common::robot::HandLink`]), at equally spaced instants.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ContactMatrix {
    rows: Vec<u16, ROLLOUT_INSTANTS>,
}

impl ContactMatrix {
    /// A matrix of these rows; rows beyond [`ROLLOUT_INSTANTS`] and bits beyond the nine links are left out.
    pub fn new(rows: impl IntoIterator<Item = u16>) -> Self {
        let bits = (1 << HAND_LINKS) - 1;
        Self { rows: rows.into_iter().take(ROLLOUT_INSTANTS).map(|row| row & bits).collect() }
    }

    /// One more row; one too many is left out.
    pub fn push(&mut self, row: u16) {
        let _ = self.rows.push(row & ((1 << HAND_LINKS) - 1));
    }

    /// The matrix at `instants` of its [`ROLLOUT_INSTANTS`] instants, equally spaced, the last one kept: row i is the
    /// one at or before `(i + 1) / instants` of the way. As it is for as many or more.
    pub fn thinned(&self, instants: usize) -> Self {
        if instants >= self.rows.len() {
            return self.clone();
        }
        let rows = &self.rows;
        Self::new((1..=instants).filter_map(|i| rows.get((i * rows.len() / instants).saturating_sub(1)).copied()))
    }

    /// Rows, first instant first.
    pub fn rows(&self) -> &[u16] {
        &self.rows
    }

    /// Entries in which the matrices differ, by row. Where one has fewer rows, the other is compared with zeros.
    fn differences<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = u32> + 'a {
        let row = |of: &Self, t: usize| of.rows.get(t).copied().unwrap_or(0);
        let instants = self.rows.len().max(other.rows.len());
        (0..instants).map(move |t| (row(self, t) ^ row(other, t)).count_ones())
    }
}

/// What a closing of the hand feels like.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Closing {
    /// Contacts over time.
    pub contacts: ContactMatrix,
    /// Angles of the three inner (proximal) links when the hand is closed, radians.
    pub inner_rad: [f32; FINGERS],
}

/// Which of the published errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactError {
    /// `E_in` (eq. 21): every difference counts alike.
    Mismatch,
    /// `E_w` (eq. 23): the first difference counts most.
    Weighted,
    /// `E_mod` (eq. 24): the same, and the squared differences of the closed hand's angles, radians squared.
    Modified,
}

impl ContactError {
    /// The error between what was predicted and what was felt. `damping` is `a` of eq. 22 in instants, greater than 0:
    /// a row that comes `a` instants after the first difference weighs `1/e`. Never negative.
    pub fn between(self, predicted: &Closing, felt: &Closing, damping: f32) -> f32 {
        let differences = || predicted.contacts.differences(&felt.contacts);
        match self {
            Self::Mismatch => differences().sum::<u32>() as f32,
            Self::Weighted => weighted(differences(), damping),
            Self::Modified => weighted(differences(), damping) + angles(&predicted.inner_rad, &felt.inner_rad),
        }
    }
}

/// `sum_t exp(-(t - t_first) / a) n(t)` over the numbers of differences by row.
fn weighted(differences: impl Iterator<Item = u32>, damping: f32) -> f32 {
    // The factor of each further row, once there has been a difference.
    let factor = libm::expf(-1.0 / damping);
    let mut weight = None;
    let mut error = 0.0;
    for count in differences {
        if count > 0 || weight.is_some() {
            let now = weight.map_or(1.0, |before: f32| before * factor);
            error += now * count as f32;
            weight = Some(now);
        }
    }
    error
}

fn angles(predicted_rad: &[f32; FINGERS], felt_rad: &[f32; FINGERS]) -> f32 {
    predicted_rad.iter().zip(felt_rad).map(|(p, r)| (p - r) * (p - r)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn closing(rows: &[u16], inner_rad: [f32; 3]) -> Closing {
        Closing { contacts: ContactMatrix::new(rows.iter().copied()), inner_rad }
    }

    #[test]
    fn by_hand() {
        let predicted = closing(&[0b000, 0b001, 0b011, 0b011], [1.0, 1.0, 1.0]);
        let felt = closing(&[0b000, 0b000, 0b001, 0b111], [1.0, 0.9, 1.2]);
        let error = |which: ContactError| which.between(&predicted, &felt, 2.0);
        assert_eq!(error(ContactError::Mismatch), 3.0);
        // Differences in rows 1, 2, 3: weights 1, exp(-1/2), exp(-1).
        let expected = 1.0 + 0.606_530_66 + 0.367_879_44;
        assert!((error(ContactError::Weighted) - expected).abs() < 1e-6);
        assert!((error(ContactError::Modified) - (expected + 0.01 + 0.04)).abs() < 1e-6);
    }

    #[test]
    fn a_thinned_matrix_holds_the_instants_that_it_shares() {
        let matrix = ContactMatrix::new(0..16);
        assert_eq!(matrix.thinned(4).rows(), [3, 7, 11, 15]);
        assert_eq!(matrix.thinned(5).rows(), [2, 5, 8, 11, 15]);
        assert_eq!(matrix.thinned(1).rows(), [15]);
        assert_eq!(matrix.thinned(16), matrix);
        assert_eq!(matrix.thinned(0).rows(), []);
    }

    #[test]
    fn a_matrix_holds_nine_links_and_sixteen_instants() {
        let matrix = ContactMatrix::new([0xffff; 20]);
        assert_eq!(matrix.rows(), [0x1ff; 16]);
    }

    proptest! {
        #[test]
        fn an_error_is_zero_for_what_was_foretold_symmetric_and_never_more_than_unweighted(
            a in prop::collection::vec(0_u16..512, 0..16),
            b in prop::collection::vec(0_u16..512, 0..16),
            damping in 0.1_f32..100.0,
        ) {
            let (a, b) = (closing(&a, [0.5; 3]), closing(&b, [0.5; 3]));
            for which in [ContactError::Mismatch, ContactError::Weighted, ContactError::Modified] {
                prop_assert_eq!(which.between(&a, &a, damping), 0.0);
                prop_assert_eq!(which.between(&a, &b, damping), which.between(&b, &a, damping));
            }
            let weighted = ContactError::Weighted.between(&a, &b, damping);
            let mismatch = ContactError::Mismatch.between(&a, &b, damping);
            prop_assert!((0.0..=mismatch).contains(&weighted));
            prop_assert_eq!(weighted == 0.0, mismatch == 0.0, "the first difference weighs 1");
        }
    }
}
