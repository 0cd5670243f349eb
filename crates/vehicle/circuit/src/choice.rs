//! Names of choices in circuit files.

use planesman_parameters::Choice;
use planesman_text::did_you_mean;
use serde::Deserializer;
use serde::de::Visitor;
use std::fmt;
use std::marker::PhantomData;

/// The choice with this name.
pub(crate) fn named<T: Choice>(name: &str) -> Result<T, String> {
    T::named(name).ok_or_else(|| {
        let suggestion = did_you_mean(name, T::NAMES.iter().copied());
        format!("it must be one of {}{suggestion}", T::NAMES.join(", "))
    })
}

/// Reads the name of a choice.
pub(crate) fn choice<'de, D: Deserializer<'de>, T: Choice>(from: D) -> Result<T, D::Error> {
    struct Name<T>(PhantomData<T>);

    impl<T: Choice> Visitor<'_> for Name<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a string")
        }

        fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<T, E> {
            named(name).map_err(|rule| E::custom(format!("{name} refused: {rule}")))
        }
    }

    from.deserialize_str(Name(PhantomData))
}
