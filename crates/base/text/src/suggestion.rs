//! The name that was probably meant.

/// Similarity, 0 to 1, from which on a name is suggested.
const SIMILAR: f64 = 0.8;

/// `; did you mean 'NAME'?` with the known name most similar to `given`; empty when none is similar. Capitals count for nothing.
///
/// ```
/// use planesman_text::did_you_mean;
///
/// assert_eq!(did_you_mean("analyze", ["locus", "analyse"]), "; did you mean 'analyse'?");
/// assert_eq!(did_you_mean("depth.P", ["depth.i", "depth.p"]), "; did you mean 'depth.p'?");
/// assert_eq!(did_you_mean("ot", ["out", "set"]), "; did you mean 'out'?");
/// assert_eq!(did_you_mean("colour", ["locus", "analyse"]), "");
/// ```
#[must_use]
pub fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let given = given.to_lowercase();
    known
        .into_iter()
        .map(|name| (similarity(&given, &name.to_lowercase()), name))
        .filter(|(similarity, _)| *similarity >= SIMILAR)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, name)| format!("; did you mean '{name}'?"))
        .unwrap_or_default()
}

/// How similar two names are, 0 to 1; more than 1 where one slip of the hand lies between them, or none.
fn similarity(given: &str, name: &str) -> f64 {
    let slips = match strsim::osa_distance(given, name) {
        0 => 2.0,
        1 if given.chars().count() > 1 => 1.0,
        _ => 0.0,
    };
    slips + strsim::jaro_winkler(given, name)
}
