//! The name that was probably meant.

/// Similarity, 0 to 1, from which on a name is suggested.
const SIMILAR: f64 = 0.8;

/// `; did you mean 'NAME'?` with the known name most similar to `given`; empty when none is similar.
///
/// ```
/// use planesman_text::did_you_mean;
///
/// assert_eq!(did_you_mean("analyze", ["locus", "analyse"]), "; did you mean 'analyse'?");
/// assert_eq!(did_you_mean("colour", ["locus", "analyse"]), "");
/// ```
#[must_use]
pub fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(given, name), name))
        .filter(|(similarity, _)| *similarity >= SIMILAR)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, name)| format!("; did you mean '{name}'?"))
        .unwrap_or_default()
}
