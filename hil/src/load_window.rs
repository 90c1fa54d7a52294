//! The busiest stretch of a run.

/// Length of the stretch, nanoseconds.
pub const WINDOW_NS: u64 = 100_000_000;
/// Bins per window: the window slides by a tenth of its length.
const BINS: usize = 10;
const BIN_NS: u64 = WINDOW_NS / BINS as u64;

/// Largest share of busy time over any 100 ms that begin at a multiple of 10 ms. What lies before time 0 counts as idle.
#[derive(Clone, Debug, Default)]
pub struct LoadWindow {
    /// Busy time in the last bins, a ring.
    busy_ns: [u64; BINS],
    /// Number of the newest bin since time 0.
    newest: u64,
    window_max_ns: u64,
}

impl LoadWindow {
    /// The wire was busy from `start_ns` to `end_ns`. Stretches come in order of time and do not overlap.
    pub fn busy(&mut self, start_ns: u64, end_ns: u64) {
        let mut from_ns = start_ns;
        while from_ns < end_ns {
            let bin = from_ns / BIN_NS;
            let to_ns = end_ns.min((bin + 1) * BIN_NS);
            self.move_to(bin);
            self.busy_ns[(bin % BINS as u64) as usize] += to_ns - from_ns;
            self.window_max_ns = self.window_max_ns.max(self.busy_ns.iter().sum());
            from_ns = to_ns;
        }
    }

    /// The largest share so far, 0..1.
    pub fn load_max(&self) -> f64 {
        self.window_max_ns as f64 / WINDOW_NS as f64
    }

    fn move_to(&mut self, bin: u64) {
        let passed = bin.saturating_sub(self.newest).min(BINS as u64);
        for n in 0..passed {
            self.busy_ns[((bin - n) % BINS as u64) as usize] = 0;
        }
        self.newest = self.newest.max(bin);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn even_load_is_measured_as_such() {
        let mut window = LoadWindow::default();
        (0..1_000).for_each(|tick| window.busy(tick * 2 * MS, tick * 2 * MS + MS / 2));
        assert!((window.load_max() - 0.25).abs() < 1e-9, "{}", window.load_max());
    }

    #[test]
    fn a_burst_is_found_wherever_it_lies_and_however_idle_the_rest_was() {
        for at in [0, 7 * MS, 95 * MS, 10_000 * MS + 1, 123_456_789] {
            let mut window = LoadWindow::default();
            window.busy(at, at + 30 * MS);
            window.busy(at + 5_000 * MS, at + 5_001 * MS);
            assert!((window.load_max() - 0.30).abs() < 1e-9, "{at}: {}", window.load_max());
        }
    }

    #[test]
    fn load_that_is_spread_wider_than_the_window_does_not_add_up() {
        let mut window = LoadWindow::default();
        window.busy(0, 40 * MS);
        window.busy(100 * MS, 140 * MS);
        assert!((window.load_max() - 0.40).abs() < 1e-9, "{}", window.load_max());
    }

    #[test]
    fn a_wire_that_is_never_idle_has_load_one() {
        let mut window = LoadWindow::default();
        (0..5_000).for_each(|n| window.busy(n * 123_457, (n + 1) * 123_457));
        assert!((window.load_max() - 1.0).abs() < 1e-9, "{}", window.load_max());
    }
}
