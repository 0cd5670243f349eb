/// A number with six significant digits, without trailing zeros.
#[must_use]
pub fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e6).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let decimals = (5.0 - libm::log10(value.abs()).floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// A count with commas between groups of three digits: `27,141`.
#[must_use]
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let groups = digits.as_bytes().rchunks(3).rev();
    let groups = groups.map(|it| String::from_utf8_lossy(it));
    groups.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_of_a_count_are_apart() {
        for (count, text) in [
            (0, "0"),
            (999, "999"),
            (27_141, "27,141"),
            (1_000_000, "1,000,000"),
        ] {
            assert_eq!(grouped(count), text);
        }
    }

    #[test]
    fn numbers_are_written_in_six_digits_or_fewer() {
        for (value, text) in [
            (2.600_410_8, "2.60041"),
            (-0.854_145, "-0.854145"),
            (543.0, "543"),
            (0.002_513_463, "0.00251346"),
            (125_000.0, "125000"),
            (1.54e-6, "1.540e-6"),
            (0.0, "0"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
