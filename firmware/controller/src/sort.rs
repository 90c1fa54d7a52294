//! Sorting of the few things that fit a fixed list, in place.

use core::cmp::Ordering;

/// Sorts by insertion; equal items keep their order. Work grows with the square of the length: for some dozens of
/// items this is as fast as the library's sort, without its kilobytes of code and of scratch space on the stack.
pub fn insertion_sort<T>(items: &mut [T], mut order: impl FnMut(&T, &T) -> Ordering) {
    for end in 1..items.len() {
        for at in (1..=end).rev() {
            match items.get(at - 1..=at) {
                Some([before, item]) if order(item, before) == Ordering::Less => items.swap(at - 1, at),
                _ => break,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_result_is_that_of_the_librarys_stable_sort(items in proptest::collection::vec((0_u8..6, 0_u8..), 0..40)) {
            let (mut ours, mut librarys) = (items.clone(), items);
            insertion_sort(&mut ours, |a, b| a.0.cmp(&b.0));
            librarys.sort_by_key(|item| item.0);
            prop_assert_eq!(ours, librarys);
        }
    }
}
