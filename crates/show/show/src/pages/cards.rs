//! The top of a page: cards with the verdict and its main numbers, and findings for and against.

use std::fmt::Display;

use maud::{Markup, html};
use planesman_identification::analysis::{Standing, Verdict};

/// Colour of a card; the words of the card say the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tone {
    #[default]
    Plain,
    Good,
    Fair,
    Bad,
}

impl Tone {
    const fn class(self) -> &'static str {
        match self {
            Self::Plain => "card",
            Self::Good => "card good",
            Self::Fair => "card fair",
            Self::Bad => "card bad",
        }
    }
}

impl From<Standing> for Tone {
    fn from(standing: Standing) -> Self {
        match standing {
            Standing::Good => Self::Good,
            Standing::Usable | Standing::UsableWithCare => Self::Fair,
            Standing::NotValidated | Standing::NotUsable => Self::Bad,
        }
    }
}

/// A label, its value, and a line below it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Card {
    label: String,
    value: String,
    note: String,
    tone: Tone,
}

impl Card {
    pub(crate) fn new(label: impl Into<String>, value: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            value: value.into(),
            ..Self::default()
        }
    }

    /// A card with the verdict and the next step.
    pub(crate) fn verdict(verdict: Verdict, next: &str) -> Self {
        Self::new("verdict", verdict.words())
            .toned(verdict.standing().into())
            .note(format!("Next: {next}"))
    }

    pub(crate) fn toned(self, tone: Tone) -> Self {
        Self { tone, ..self }
    }

    pub(crate) fn note(self, note: impl Into<String>) -> Self {
        Self {
            note: note.into(),
            ..self
        }
    }
}

/// Cards side by side; a first card with a note is twice as wide.
pub(crate) fn cards(cards: &[Card]) -> Markup {
    html! {
        div.cards {
            @for card in cards {
                div class=(card.tone.class()) {
                    div.label { (card.label) }
                    div.value { (card.value) }
                    @if !card.note.is_empty() { div.note { (card.note) } }
                }
            }
        }
    }
}

/// A list of findings, each with whether it is negative.
pub(crate) fn findings(findings: impl IntoIterator<Item = (impl Display, bool)>) -> Markup {
    html! {
        ul.findings {
            @for (text, is_against) in findings {
                @if is_against { li.against { (text.to_string()) } } @else { li { (text.to_string()) } }
            }
        }
    }
}
