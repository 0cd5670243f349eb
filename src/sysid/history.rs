//! The history of a replay: one comma-separated row per estimate.

use std::collections::BTreeMap;
use std::io::{self, Write};

use planesman_identifier::{Account, IdentifierParameters, Pair, pair};
use planesman_msgs::planesman_msgs::msg::ModelEstimate;

/// Columns before the parameters.
const FIRST: &str = "time,pair,samples,valid,event,fit,noise_deviation,steady_state_gain";

/// Writes estimates as they arrive.
pub(crate) struct History<W> {
    to: W,
    /// Number of columns for the coefficients of a, b and c.
    widths: [usize; 3],
    /// Event counts of each pair at its previous row.
    accounts: BTreeMap<String, Account>,
    frozen: BTreeMap<String, bool>,
    /// The first write error; nothing is written after this error.
    result: io::Result<()>,
}

impl<W: Write> History<W> {
    /// Writes the header, with as many columns as the widest pair needs.
    ///
    /// # Errors
    /// Refused parameters, or a file that cannot be written.
    pub(crate) fn new(mut to: W, parameters: &IdentifierParameters) -> anyhow::Result<Self> {
        let mut widths = [0; 3];
        for (name, own) in pair::described(parameters)? {
            let model = Pair::new(name, &own)?.model();
            let moments = if own.first_moment { model.b.len() } else { 0 };
            let own = [model.a.len(), model.b.len(), moments];
            widths = std::array::from_fn(|i| widths[i].max(own[i]));
        }
        let names: Vec<String> = (["a", "b", "c"].into_iter().zip(widths))
            .flat_map(|(letter, width)| (1..=width).map(move |i| format!("{letter}{i}")))
            .chain(["bias".to_owned()])
            .collect();
        let deviations = names.iter().map(|it| format!("{it}_deviation"));
        let columns: Vec<String> = names.iter().cloned().chain(deviations).collect();
        writeln!(to, "{FIRST},{}", columns.join(","))?;
        Ok(Self {
            to,
            widths,
            accounts: BTreeMap::new(),
            frozen: BTreeMap::new(),
            result: Ok(()),
        })
    }

    /// Writes one row.
    pub(crate) fn take(&mut self, estimate: &ModelEstimate, pair: &Pair) {
        if self.result.is_ok() {
            self.result = self.write(estimate, pair);
        }
    }

    /// The file, if every row was written.
    ///
    /// # Errors
    /// The first write error.
    pub(crate) fn finish(self) -> io::Result<W> {
        self.result.map(|()| self.to)
    }

    fn write(&mut self, estimate: &ModelEstimate, pair: &Pair) -> io::Result<()> {
        let stamp = estimate.header.stamp.nanos();
        let gain = estimate.has_steady_state_gain;
        let gain = gain.then(|| estimate.steady_state_gain.to_string());
        let events = self.events(estimate, pair);
        write!(
            self.to,
            "{}.{:09},{},{},{},{},{},{},{}",
            stamp.div_euclid(1_000_000_000),
            stamp.rem_euclid(1_000_000_000),
            estimate.name,
            estimate.samples,
            u8::from(estimate.valid),
            events,
            estimate.fit,
            estimate.noise_variance.max(0.0).sqrt(),
            gain.unwrap_or_default(),
        )?;
        let lists = [&estimate.a, &estimate.b, &estimate.c];
        let count: usize = lists.iter().map(|it| it.len()).sum();
        // A constant is a row of the covariance where it is estimated.
        let width = estimate.covariance.len().isqrt();
        let bias = (width > count).then_some(estimate.bias);
        let deviation = |at: usize| {
            let variance = estimate.covariance.get(at * width + at)?;
            Some(variance.max(0.0).sqrt())
        };
        let (mut values, mut deviations, mut at) = (Vec::new(), Vec::new(), 0);
        for (list, columns) in lists.into_iter().zip(self.widths) {
            for i in 0..columns {
                let value = list.get(i);
                values.push(value.copied());
                deviations.push(value.and_then(|_| deviation(at + i)));
            }
            at += list.len();
        }
        values.push(bias);
        deviations.push(bias.and_then(|_| deviation(at)));
        for number in values.into_iter().chain(deviations) {
            match number {
                Some(number) => write!(self.to, ",{number}")?,
                None => write!(self.to, ",")?,
            }
        }
        writeln!(self.to)
    }

    /// The pair's events since its previous row, as text.
    fn events(&mut self, estimate: &ModelEstimate, pair: &Pair) -> String {
        let now = pair.account();
        let name = &estimate.name;
        let before = self.accounts.insert(name.clone(), now).unwrap_or_default();
        let was_frozen = self.frozen.insert(name.clone(), estimate.frozen);
        let is_jump = pair
            .jump()
            .is_some_and(|it| it.stamp == estimate.header.stamp.nanos());
        let events = [
            (is_jump, "jump"),
            (now.gaps != before.gaps, "gap"),
            (now.restarts != before.restarts, "restart"),
            (estimate.frozen && was_frozen != Some(true), "frozen"),
            (!estimate.frozen && was_frozen == Some(true), "released"),
        ];
        let happened = events
            .into_iter()
            .filter(|(is, _)| *is)
            .map(|(_, word)| word);
        happened.collect::<Vec<_>>().join(" ")
    }
}
