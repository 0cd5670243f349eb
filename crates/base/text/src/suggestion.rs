//! Suggestion of the nearest known name.

/// Smallest similarity (0 to 1) for a suggestion.
const SIMILAR: f64 = 0.8;

/// `; did you mean 'NAME'?` with the known name most similar to `given`; empty if none is similar. Ignores case.
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

/// Similarity of two names, 0 to 1; more than 1 if they differ by one typing error or not at all.
fn similarity(given: &str, name: &str) -> f64 {
    let slips = match strsim::osa_distance(given, name) {
        0 => 2.0,
        1 if given.chars().count() > 1 => 1.0,
        _ => 0.0,
    };
    slips + strsim::jaro_winkler(given, name)
}
