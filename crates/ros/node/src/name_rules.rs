//! Rules of ROS names.

use crate::bad_argument::BadArgument;

/// Letters, digits and single underscores, not beginning with a digit.
pub(crate) fn is_token(token: &str) -> bool {
    token.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && token.chars().next().is_some_and(|c| !c.is_ascii_digit())
        && !token.contains("__")
}

/// Checks that a name is an absolute ROS name.
pub(crate) fn check(absolute: &str) -> Result<(), BadArgument> {
    let tokens = absolute.strip_prefix('/').unwrap_or(absolute);
    if tokens.split('/').all(is_token) {
        return Ok(());
    }
    Err(BadArgument::new(
        absolute,
        "a name consists of tokens between slashes: letters, digits and single underscores, \
         not beginning with a digit",
    ))
}

/// Checks that a name is an absolute ROS namespace; enclaves have the same form.
pub(crate) fn check_namespace(name: &str) -> Result<(), BadArgument> {
    match name {
        "/" => Ok(()),
        _ if name.starts_with('/') => check(name),
        _ => Err(BadArgument::new(name, "the name must start with a slash")),
    }
}
