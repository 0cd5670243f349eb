//! Tables 2-1, 3-2, 4-2 and 4-3 and the limit cycles of IBM 66-L03-005, simulated with a surrogate of the lost missile and compared with the
//! printed values.

use std::fmt::Write as _;

use crate::book::{Book, Verdict};
use crate::ibm_1966::procedure::{
    ANALOG_GAIN_TESTS, analog_gain_limit, analog_is_stable, analog_step_limit,
};
use crate::ibm_1966::tables::{Row, TABLE_2_1, TABLE_3_2, TABLE_4_2};
use crate::ibm_1966::{Case, Surrogate};
use planesman_hydraulics::actuator_file::ActuatorFileError;
use planesman_units::DEGREE;

use planesman_text::number;

planesman_text::choices! {
    /// A table of the report that is simulated.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Table {
        T21 = "2-1": "Phase III against Phase I",
        T32 = "3-2": "The laboratory hardware's parameters",
        T42 = "4-2": "The Polaris flight simulation",
        T43 = "4-3": "The analog flight control",
        LimitCycles = "limit-cycles": "Limit cycles after half a degree",
    }
}

/// Columns of [`BenchRun::numbers`].
pub const COLUMNS: [&str; 6] = [
    "table",
    "case",
    "quantity",
    "printed",
    "verdict",
    "simulated",
];

/// A table as text, and its numbers.
pub struct BenchRun {
    /// The table as in the report, each cell with the simulated value.
    pub text: String,
    /// One row per number, with the columns [`COLUMNS`].
    pub numbers: Vec<[String; 6]>,
}

impl BenchRun {
    /// This table followed by another.
    fn and(mut self, further: Self) -> Self {
        self.text = format!("{}\n{}", self.text, further.text);
        self.numbers.extend(further.numbers);
        self
    }
}

/// Description of the tables, and how to read a cell.
#[must_use]
pub fn heading(surrogate: Surrogate) -> String {
    format!(
        "Missile: surrogate {surrogate}. The report's own missile is lost; all results are those of the surrogate,\n\
         calibrated on {}.\n\
         Each cell is 'printed mark simulated'; the mark is = for equal, ~ for within one test step, x for a larger difference.\n",
        surrogate.calibrated_on()
    )
}

/// Simulates a table.
///
/// # Errors
/// A built-in actuator cannot be read.
pub fn flown(
    table: Table,
    surrogate: Surrogate,
    book: &Book,
) -> Result<BenchRun, ActuatorFileError> {
    let hardware = Case::table_3_1(surrogate)?;
    let polaris = Case::table_4_1(surrogate)?;
    Ok(match table {
        Table::T21 => rows(
            book,
            ("2-1", "2-1  K = 0, no leakage"),
            "T2-1",
            &TABLE_2_1,
            &polaris,
        ),
        Table::T32 => {
            let as_is = rows(
                book,
                (
                    "3-2",
                    "3-2  the hardware's parameters (Table 3-1), unchanged",
                ),
                "T3-2",
                &TABLE_3_2,
                &hardware,
            );
            let adjusted = rows(
                book,
                (
                    "3-2 adjusted",
                    "3-2  with T_D = 10 ms and 8 % more friction (a conjecture)",
                ),
                "T3-2",
                &TABLE_3_2,
                &hardware.adjusted(),
            );
            let d1 = book.errata().get("D1").map_or("", String::as_str);
            let mut both = as_is.and(adjusted);
            both.text += &format!("{d1}\n");
            both
        }
        Table::T42 => rows(
            book,
            ("4-2", "4-2  Polaris flight simulation (Table 4-1)"),
            "T4-2",
            &TABLE_4_2,
            &polaris,
        ),
        Table::T43 => analog(book, surrogate),
        Table::LimitCycles => limit_cycles(book, &polaris),
    })
}

/// Numbers of a table, and how many of them agree.
#[derive(Default)]
struct Score {
    table: &'static str,
    numbers: Vec<[String; 6]>,
    exact: usize,
    near: usize,
    all: usize,
}

impl Score {
    fn of(table: &'static str) -> Self {
        Self {
            table,
            ..Self::default()
        }
    }

    /// Stores a number.
    fn keep(&mut self, case: &str, quantity: &str, printed: &str, verdict: &str, found: &str) {
        let row = [self.table, case, quantity, printed, verdict, found];
        self.numbers.push(row.map(str::to_owned));
    }

    /// Table cell 'printed, mark, simulated' of entry `id`; also records and counts it.
    fn cell(&mut self, book: &Book, id: &str, [case, quantity]: [&str; 2], value: f64) -> String {
        let entry = book.entry(id);
        let Some((printed, verdict)) = entry.and_then(|e| Some((e.printed?, e.judge(value)?)))
        else {
            self.keep(case, quantity, "", "", &value.to_string());
            return format!("- {value}");
        };
        self.keep(
            case,
            quantity,
            &printed.to_string(),
            &verdict.to_string(),
            &value.to_string(),
        );
        self.all += 1;
        let mark = match verdict {
            Verdict::Agrees => {
                self.exact += 1;
                self.near += 1;
                '='
            }
            Verdict::Approximate => {
                self.near += 1;
                '~'
            }
            Verdict::Contradicts => 'x',
        };
        format!("{printed} {mark} {value}")
    }

    fn line(&self) -> String {
        format!(
            "{} of {} equal, {} within one test step\n",
            self.exact, self.all, self.near
        )
    }
}

fn rows(
    book: &Book,
    (name, title): (&'static str, &str),
    family: &str,
    rows: &[Row],
    base: &Case,
) -> BenchRun {
    let mut score = Score::of(name);
    let mut text = format!(
        "Table {title}\n{:<26} {:>12} {:>12} {:>12} {:>12}  remarks\n",
        "", "+step", "-step", "stable K_g", "from 7 rams"
    );
    for row in rows {
        let case = row.of(base);
        let outcome = case.outcome();
        let mut cell = |id: &str, what: &str, value| {
            let id = format!("{family}.{}.{id}", row.id);
            score.cell(book, &id, [row.label, what], value)
        };
        let plus = cell("max_pos_step", "+step", f64::from(outcome.plus));
        let minus = cell("max_neg_step", "-step", f64::from(outcome.minus));
        let gain = cell("Kg_stable", "stable K_g", outcome.gain);
        let (low, high) = case.gain_limit_scatter();
        let gaps: Vec<String> = [outcome.plus, outcome.minus]
            .into_iter()
            .flat_map(|largest| case.gaps_below(largest))
            .map(|n| format!("{n:+} is not stable"))
            .collect();
        let scatter = format!("{low} to {high}");
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "{:<26} {plus:>12} {minus:>12} {gain:>12} {scatter:>12}  {}",
            row.label,
            gaps.join(", ")
        );
    }
    text += &score.line();
    let numbers = score.numbers;
    BenchRun { text, numbers }
}

fn analog(book: &Book, surrogate: Surrogate) -> BenchRun {
    let mut score = Score::of("4-3");
    let mut text = "Table 4-3  analog flight control\n".to_owned();
    let step = f64::from(analog_step_limit(surrogate));
    let line = |text: &mut String, what: &str, cell: String| {
        let _ = writeln!(text, "{what:<40} {cell:>16}");
    };
    line(
        &mut text,
        "C-14, largest stable step",
        score.cell(book, "T4-3.C-14", ["C-14", "largest stable step"], step),
    );
    for test in ANALOG_GAIN_TESTS {
        let gain = analog_gain_limit(surrogate, test.gain_step, test.steering);
        let what = format!("stable K_g, N_y = {}", test.steering);
        let id = format!("T4-3.{}A", test.run);
        let cell = score.cell(book, &id, [test.run, &what], gain);
        line(&mut text, &format!("{}, {what}", test.run), cell);
    }
    for (run, steering, yaw) in [
        ("C-16, psi_0 = 1/2 deg", 0.0, 0.5 * DEGREE),
        ("C-17, N_y = 10", 10.0, 0.0),
        ("C-18, N_y = 1", 1.0, 0.0),
    ] {
        let stable = analog_is_stable(surrogate, 1.0, steering, yaw);
        let (mark, verdict, found) = if stable {
            ("stable = stable", Verdict::Agrees, "stable")
        } else {
            ("stable x unstable", Verdict::Contradicts, "unstable")
        };
        score.keep(run, "stability", "stable", &verdict.to_string(), found);
        line(&mut text, run, mark.to_owned());
    }
    text += &score.line();
    let numbers = score.numbers;
    BenchRun { text, numbers }
}

fn limit_cycles(book: &Book, base: &Case) -> BenchRun {
    let mut score = Score::of("limit cycles");
    let mut text = format!(
        "Limit cycles  20 to 80 s after psi_0 = -1/2 deg (Section IV.B)\n{:<22} {:>11} {:>11} {:>11} {:>10}  reported\n",
        "", "psi pp", "mean psi", "nozzle pp", "pulses/s"
    );
    let printed = |id: &str| book.printed(id).map_or_else(String::new, |p| p.to_string());
    for row in &TABLE_4_2 {
        let case = row.of(base);
        let cycle = case.limit_cycle();
        let reported = match row.id {
            "base" => format!(
                "psi pp about {} deg, nozzle {} deg (I6)",
                printed("T4.psi_pp_leak"),
                printed("T4.nozzle_osc")
            ),
            "qL=qLC=0" => format!(
                "psi pp {} deg (I5: 0.067); lowest frequency",
                printed("T4.psi_pp_noleak")
            ),
            "worst" => "no noticeable difference".to_owned(),
            "K=2^-9" => format!("psi pp {} deg", printed("T4.psi_pp_K9")),
            "K=2^-16" => "a steady error of psi".to_owned(),
            _ => String::new(),
        };
        let _ = writeln!(
            text,
            "{:<22} {:>7.4} deg {:>+7.4} deg {:>7.3} deg {:>10.2}  {reported}",
            row.label,
            cycle.yaw / DEGREE,
            cycle.mean_yaw / DEGREE,
            cycle.nozzle / DEGREE,
            cycle.pulses,
        );
        for (quantity, value) in [
            ("psi pp, deg", cycle.yaw / DEGREE),
            ("mean psi, deg", cycle.mean_yaw / DEGREE),
            ("nozzle pp, deg", cycle.nozzle / DEGREE),
            ("pulses/s", cycle.pulses),
        ] {
            score.keep(row.label, quantity, "", "", &number(value));
        }
    }
    let _ = writeln!(
        text,
        "In the report the mean frequency is {} to {} Hz. {}",
        printed("T4.f0_low"),
        printed("T4.f0_high"),
        book.errata().get("D2").map_or("", String::as_str)
    );
    let numbers = score.numbers;
    BenchRun { text, numbers }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_analog_table_counts_what_agrees_and_says_that_the_missile_is_a_surrogate() {
        let book = crate::ibm_1966::book().expect("the book");
        let BenchRun { text, numbers } = flown(Table::T43, Surrogate::Ps2, &book).expect("flown");
        assert!(text.contains("12 = 12"), "{text}");
        assert!(
            text.contains("3 of 4 equal, 4 within one test step"),
            "{text}"
        );
        assert_eq!(numbers.len(), 7);
        assert_eq!(
            numbers[0][1..],
            ["C-14", "largest stable step", "12", "agrees", "12"]
        );
        assert!(heading(Surrogate::Ps2).contains("of the surrogate"));
    }
}
