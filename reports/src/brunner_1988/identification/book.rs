//! Recomputed numbers of Table 9 of Brunner 1988 (pp. 97-99): models identified from runs 7/3 to 9/2.
//!
//! The table prints each model twice, by its coefficients and by its roots in z:
//!
//! ```text
//!    b1 z^(n-1) + ... + bn
//! ---------------------------,   volts over volts, T = 0.05 s
//! z^n + a1 z^(n-1) + ... + an
//! ```
//! The coefficients give roots, poles `s = ln(z) / T`, zeros and steady-state gain. For the second-order models of pitch rate the table also has
//! the theory without restoring moment:
//!
//! ```text
//!   q          M'delta U^2
//! ----- = Cf1 -------------
//! delta        J s - M'q U
//! ```
//! `data/brunner_1988/identification.json` names the entries `Tab9.RUN.MODEL.QUANTITY`. The model is `qd` (pitch rate over plane angle), `zq`
//! (depth over pitch rate) or `zd` (depth over plane angle), followed by its order.

use std::sync::LazyLock;

use crate::book::{Book, BookError};
use planesman_identification::Model;
use planesman_linear::{Complex, ComplexFunctions as _, Domain, TransferFunction, polynomial};

const ENTRIES: &str = include_str!("../../../data/brunner_1988/identification.json");
const ERRATA: &str = include_str!("../../../data/brunner_1988/errata.json");

/// Sampling interval of the runs, s (p. 97).
const SAMPLE_TIME: f64 = 0.05;

/// Resolution of the printed coefficients.
const LAST_DIGIT: f64 = 1e-4;

/// The book in a static variable, so that values may borrow the entries' names.
static BOOK: LazyLock<Option<Book>> = LazyLock::new(|| book().ok());

/// Numbers of Table 9, with the errata.
///
/// # Errors
/// [`BookError`]; a test reads the compiled-in file.
pub fn book() -> Result<Book, BookError> {
    Book::parse(ENTRIES, ERRATA)
}

/// Recomputed numbers of Table 9: name and value, in the entry's unit. The coefficients came from records that are lost; they are recomputed
/// only where the printed roots contradict them.
#[must_use]
pub fn recomputed() -> Vec<(&'static str, f64)> {
    BOOK.iter()
        .flat_map(|book| book.entries().iter().map(move |entry| (book, &entry.id)))
        .filter_map(|(book, id)| {
            let (row, quantity) = Row::of(book, id)?;
            Some((id.as_str(), row.value(quantity)?))
        })
        .collect()
}

/// The model of a run (such as `7/3`) in Table 9: `qd2`, `qd3`, `zq2`, `zq4` or `zd4`; `None` if not printed. A misprinted coefficient is replaced by
/// the value that the printed roots imply.
#[must_use]
pub fn table_9(run: &str, model: &str) -> Option<Model> {
    let book = BOOK.as_ref()?;
    let row = Row {
        book,
        run: &format!("Tab9.{run}"),
        name: &format!("Tab9.{run}.{model}"),
    };
    row.model().filter(|model| !model.a.is_empty())
}

/// One model of the table.
struct Row<'b> {
    book: &'b Book,
    /// `Tab9.RUN`.
    run: &'b str,
    /// `Tab9.RUN.MODEL`.
    name: &'b str,
}

impl<'b> Row<'b> {
    /// The row of the entry `id`, and the entry's name within the row; `None` for an entry that does not belong to one model.
    fn of(book: &'b Book, id: &'b str) -> Option<(Self, &'b str)> {
        let mut dots = id.match_indices('.').map(|(at, _)| at).skip(1);
        let (run, name) = (dots.next()?, dots.next()?);
        let row = Self {
            book,
            run: &id[..run],
            name: &id[..name],
        };
        Some((row, &id[name + 1..]))
    }

    fn printed(&self, quantity: &str) -> Option<f64> {
        self.book.printed(&format!("{}.{quantity}", self.name))
    }

    /// Whether the printed roots contradict the printed `a` number `i`, from 1.
    fn is_misprinted(&self, i: usize) -> bool {
        let corrected = format!("{}.a{i}_corrected", self.name);
        self.book.entry(&corrected).is_some()
    }

    /// The model of the printed coefficients. A misprinted one is computed from the printed roots, rounded as in the table; a numerator shorter than
    /// the model's order is padded with leading zeros.
    fn model(&self) -> Option<Model> {
        let printed: Vec<f64> = (1..)
            .map_while(|i| self.printed(&format!("a{i}")))
            .collect();
        let order = printed.len();
        let a = printed
            .into_iter()
            .zip(1..)
            .map(|(a, i)| match self.is_misprinted(i) {
                true => self.implied_by_roots(order, i),
                false => Some(a),
            })
            .collect::<Option<_>>()?;
        let b = (1..=order)
            .map(|i| self.printed(&format!("b{i}")).unwrap_or(0.0))
            .collect();
        Some(Model {
            sample_time: SAMPLE_TIME,
            a,
            feedthrough: 0.0,
            b,
            c: Vec::new(),
            bias: 0.0,
        })
    }

    /// Coefficient `a` number `i`, from 1, of the polynomial with the printed roots.
    fn implied_by_roots(&self, order: usize, i: usize) -> Option<f64> {
        let roots = (1..=order)
            .map(|k| {
                let re = self.printed(&format!("root{k}.re"))?;
                let im = self.printed(&format!("root{k}.im")).unwrap_or(0.0);
                Some(Complex::new(re, im))
            })
            .collect::<Option<Vec<_>>>()?;
        let a = *polynomial::from_roots(&roots).ok()?.get(i)?;
        Some((a / LAST_DIGIT).round() * LAST_DIGIT)
    }

    /// Transfer function from plane angle to pitch rate without restoring moment, in s, with the polarity of the records.
    fn theory(&self) -> Option<TransferFunction> {
        let of_report = |name: &str| self.book.printed(&format!("Tab9.theory.{name}"));
        let speed = self.book.printed(&format!("{}.U", self.run))?;
        let gain = of_report("Cf1")? * of_report("Mdelta")?.abs() * speed.powi(2);
        let damping = -of_report("Mq")? * speed;
        TransferFunction::new(vec![gain], vec![of_report("J")?, damping]).ok()
    }

    /// Value of `quantity`; `None` if it is not computed.
    fn value(&self, quantity: &str) -> Option<f64> {
        let model = self.model()?;
        match quantity {
            "dc" => model.steady_state_gain(),
            "tau" => Some(-1.0 / model.dominant_pole()?.re),
            "slope" => Some(model.steady_state_gain()? * model.dominant_pole()?.modulus()),
            "dc_pred" => self.theory()?.steady_state_gain(Domain::Continuous).ok(),
            "pole_pred" => Some(self.theory()?.poles().ok()?.first()?.modulus()),
            _ => self.numbered_value(&model, quantity),
        }
    }

    /// Like `value`, for `a1`, `a1_corrected`, `root1.re`, `s1.im`, `zero1.re` and so on.
    fn numbered_value(&self, model: &Model, quantity: &str) -> Option<f64> {
        let (numbered, part) = quantity.split_once('.').unwrap_or((quantity, ""));
        let numbered = numbered.strip_suffix("_corrected").unwrap_or(numbered);
        let (kind, number) = numbered.split_at(numbered.find(|c: char| c.is_ascii_digit())?);
        let number: usize = number.parse().ok()?;
        let at = number.checked_sub(1)?;
        let place = match kind {
            "a" if self.is_misprinted(number) => return model.a.get(at).copied(),
            "root" => *model.poles().ok()?.get(at)?,
            "zero" => *model.zeros().ok()?.get(at)?,
            "s" => {
                // A frequency, for the lower of a pair too.
                let s = model.continuous(*model.poles().ok()?.get(at)?);
                Complex::new(s.re, s.im.abs())
            }
            _ => return None,
        };
        match part {
            "re" => Some(place.re),
            "im" => Some(place.im),
            _ => None,
        }
    }
}
