//! All numeric fields of a message type, by path.

use std::collections::BTreeMap;

use planesman_rosidl::TypeName;
use planesman_rosidl::definition::{Arity, EMPTY_MESSAGE_FIELD, Element, Field};

use crate::decoder::derived_names;
use crate::{FieldPath, Types};

/// Number of listed elements of a list of numbers, and of a list of messages.
const NUMBERS: u32 = 16;
const MESSAGES: u32 = 4;

/// The numeric fields of a message type.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Catalogue {
    /// Paths in the order of the definition: the first sixteen elements of a list of numbers, the first four of a list of messages; angles of
    /// quaternions and norms of vectors follow their components.
    pub fields: Vec<FieldPath>,
    /// Whether there are more fields than requested.
    pub is_cut: bool,
}

impl Catalogue {
    /// The first `most` numeric fields of the root type.
    ///
    /// ```
    /// use planesman_decode::{Catalogue, schema};
    ///
    /// let types = schema::read("demo_msgs/msg/Rates", "ros2msg", "string name\nfloat64[2] rates\n")?;
    /// let fields: Vec<String> = Catalogue::of(&types, 100).fields.iter().map(ToString::to_string).collect();
    /// assert_eq!(fields, ["rates[0]", "rates[1]"]);
    /// # Ok::<(), planesman_decode::schema::SchemaError>(())
    /// ```
    #[must_use]
    pub fn of(types: &Types, most: usize) -> Self {
        let mut listing = Listing {
            types,
            most,
            barren: BTreeMap::new(),
            catalogue: Self::default(),
        };
        listing.message(types.root(), &FieldPath { steps: Vec::new() });
        listing.catalogue
    }
}

struct Listing<'t> {
    types: &'t Types,
    most: usize,
    /// Whether a message contains no number at any depth. Fields of such types are skipped; otherwise a type that nests only texts could be walked
    /// forever.
    barren: BTreeMap<&'t TypeName, bool>,
    catalogue: Catalogue,
}

impl<'t> Listing<'t> {
    fn fields(&self, name: &TypeName) -> impl Iterator<Item = &'t Field> + use<'t> {
        let fields = self.types.message(name).map_or(&[][..], |it| &it.fields);
        fields.iter().filter(|it| it.name != EMPTY_MESSAGE_FIELD)
    }

    fn is_barren(&mut self, name: &'t TypeName) -> bool {
        if let Some(known) = self.barren.get(name) {
            return *known;
        }
        let is_barren = self
            .fields(name)
            .all(|field| match &field.field_type.element {
                Element::Primitive(_) => false,
                Element::String { .. } => true,
                Element::Message(name) => self.is_barren(name),
            });
        self.barren.insert(name, is_barren);
        is_barren
    }

    fn message(&mut self, name: &'t TypeName, path: &FieldPath) {
        if self.is_barren(name) {
            return;
        }
        for field in self.fields(name) {
            if self.catalogue.is_cut {
                return;
            }
            let path = path.field(&field.name);
            let element = &field.field_type.element;
            let listed = match element {
                Element::Message(_) => MESSAGES,
                _ => NUMBERS,
            };
            match field.field_type.arity {
                Arity::One => self.element(element, &path),
                Arity::Sequence => self.elements(element, &path, listed),
                Arity::Array(count) | Arity::BoundedSequence(count) => {
                    self.elements(element, &path, listed.min(count));
                }
            }
        }
        for derived in derived_names(self.types, name) {
            self.push(path.field(derived));
        }
    }

    fn elements(&mut self, element: &'t Element, path: &FieldPath, count: u32) {
        for index in 0..count as usize {
            self.element(element, &path.element(index));
        }
    }

    fn element(&mut self, element: &'t Element, path: &FieldPath) {
        match element {
            Element::Primitive(_) => self.push(path.clone()),
            Element::String { .. } => {}
            Element::Message(name) => self.message(name, path),
        }
    }

    fn push(&mut self, path: FieldPath) {
        if self.catalogue.fields.len() < self.most {
            self.catalogue.fields.push(path);
        } else {
            self.catalogue.is_cut = true;
        }
    }
}
