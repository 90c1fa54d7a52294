//! What ran where.

use std::time::Duration;

/// Rows of the table at the end.
#[derive(Debug, Default)]
pub struct Report {
    rows: Vec<[String; 4]>,
}

impl Report {
    /// One row.
    pub fn add(&mut self, what: &str, place: &str, passed: u32, took: Duration) {
        self.rows.push([what.to_owned(), passed.to_string(), format!("{:.0}", took.as_secs_f32()), place.to_owned()]);
    }

    /// Prints the table.
    pub fn print(&self) {
        println!("\n{}", self.text());
    }

    fn text(&self) -> String {
        let head = ["tests", "passed", "s", "where"].map(str::to_owned);
        let width = |column: usize| self.rows.iter().chain([&head]).map(|row| row[column].len()).max().unwrap_or(0);
        let (what, passed, took) = (width(0), width(1), width(2));
        let lines = [&head].into_iter().chain(&self.rows);
        lines.map(|[a, b, c, d]| format!("{a:what$}  {b:>passed$}  {c:>took$}  {d}\n")).collect()
    }
}

/// How many tests passed, if this line of a test binary tells.
pub fn count_passed(line: &str) -> u32 {
    let counts = line.strip_prefix("test result: ok. ").and_then(|rest| rest.split_once(" passed"));
    counts.and_then(|(passed, _)| passed.parse().ok()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_line_of_the_result_counts() {
        assert_eq!(count_passed("test result: ok. 14 passed; 0 failed; 3 ignored; 0 measured"), 14);
        assert_eq!(count_passed("test result: FAILED. 13 passed; 1 failed"), 0);
        assert_eq!(count_passed("test some::test ... ok"), 0);
    }

    #[test]
    fn the_table_is_aligned() {
        let mut report = Report::default();
        report.add("unit and property tests", "here", 1234, Duration::from_secs(7));
        report.add("socketcan", "in user-mode Linux", 9, Duration::from_secs(120));
        let text = report.text();
        assert_eq!(
            text.lines().collect::<Vec<_>>(),
            [
                "tests                    passed    s  where",
                "unit and property tests    1234    7  here",
                "socketcan                     9  120  in user-mode Linux",
            ]
        );
    }
}
