//! The longest tick so far.

/// Keeps the longest of the ticks that it is told of, in the board's own unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Meter {
    /// Ticks measured.
    pub ticks: u32,
    /// The longest.
    pub worst: u32,
    /// Which it was, counted from 1.
    pub worst_at: u32,
    /// Sum of all.
    pub sum: u64,
}

impl Meter {
    /// Nothing measured.
    pub const fn new() -> Self {
        Self { ticks: 0, worst: 0, worst_at: 0, sum: 0 }
    }

    /// Adds a tick.
    pub fn add(&mut self, length: u32) {
        self.ticks = self.ticks.saturating_add(1);
        self.sum = self.sum.saturating_add(u64::from(length));
        if length > self.worst {
            self.worst = length;
            self.worst_at = self.ticks;
        }
    }

    /// Mean, rounded down; 0 of nothing.
    pub fn mean(&self) -> u32 {
        u32::try_from(self.sum / u64::from(self.ticks.max(1))).unwrap_or(u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_tick_is_kept_with_its_place() {
        let mut meter = Meter::new();
        assert_eq!(meter.mean(), 0);
        [30, 90, 10, 90].into_iter().for_each(|length| meter.add(length));
        assert_eq!(meter, Meter { ticks: 4, worst: 90, worst_at: 2, sum: 220 });
        assert_eq!(meter.mean(), 55);
    }
}
