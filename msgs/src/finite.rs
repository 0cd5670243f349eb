//! The search for numbers that are not finite; no node accepts or publishes such numbers.

/// A value that may contain floating-point numbers.
pub(crate) trait Finite {
    /// The path of the first number that is NaN or infinite; empty if the value itself is this number.
    fn first_non_finite_path(&self) -> Option<String>;
}

impl Finite for f64 {
    fn first_non_finite_path(&self) -> Option<String> {
        (!self.is_finite()).then(String::new)
    }
}

impl Finite for f32 {
    fn first_non_finite_path(&self) -> Option<String> {
        (!self.is_finite()).then(String::new)
    }
}

impl<T: Finite> Finite for [T] {
    fn first_non_finite_path(&self) -> Option<String> {
        let (index, within) = self
            .iter()
            .enumerate()
            .find_map(|(index, item)| Some((index, item.first_non_finite_path()?)))?;
        Some(join(&format!("[{index}]"), &within))
    }
}

impl<T: Finite> Finite for Vec<T> {
    fn first_non_finite_path(&self) -> Option<String> {
        self.as_slice().first_non_finite_path()
    }
}

impl<T: Finite, const N: usize> Finite for [T; N] {
    fn first_non_finite_path(&self) -> Option<String> {
        self.as_slice().first_non_finite_path()
    }
}

/// The path of the first such number in `value`, relative to the message whose field `name` it is.
pub(crate) fn field<T: Finite>(name: &str, value: &T) -> Option<String> {
    Some(join(name, &value.first_non_finite_path()?))
}

fn join(outer: &str, inner: &str) -> String {
    let joint = if inner.is_empty() || inner.starts_with('[') {
        ""
    } else {
        "."
    };
    format!("{outer}{joint}{inner}")
}
