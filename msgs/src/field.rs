//! Access to the fields of a decoded message by their names.

/// A field of a message, an element of a list, or a message itself.
pub trait Field {
    /// The field of this name; `None` if this is not a message or has no such field.
    fn field(&self, _name: &str) -> Option<&dyn Field> {
        None
    }

    /// The element with this number, from 0; `None` if this is not a list or is shorter.
    fn element(&self, _number: usize) -> Option<&dyn Field> {
        None
    }

    /// A text.
    fn text(&self) -> Option<&str> {
        None
    }

    /// Appends the number, or every number of a list; false and true become 0 and 1.
    fn append_to(&self, _numbers: &mut Vec<f64>) {}

    /// Appends the numbers of a list of fields of this type.
    fn append_all(list: &[Self], numbers: &mut Vec<f64>)
    where
        Self: Sized,
    {
        for field in list {
            field.append_to(numbers);
        }
    }
}

macro_rules! numbers {
    ($($number:ty as $taken:expr;)*) => {$(
        impl Field for $number {
            fn append_to(&self, numbers: &mut Vec<f64>) {
                let taken: fn($number) -> f64 = $taken;
                numbers.push(taken(*self));
            }
        }
    )*};
}

numbers! {
    bool as |it| f64::from(u8::from(it));
    i8 as f64::from;
    i16 as f64::from;
    i32 as f64::from;
    i64 as |it| it as f64;
    u8 as f64::from;
    u16 as f64::from;
    u32 as f64::from;
    u64 as |it| it as f64;
    f32 as f64::from;
}

impl Field for f64 {
    fn append_to(&self, numbers: &mut Vec<f64>) {
        numbers.push(*self);
    }

    fn append_all(list: &[Self], numbers: &mut Vec<f64>) {
        numbers.extend_from_slice(list);
    }
}

impl Field for String {
    fn text(&self) -> Option<&str> {
        Some(self)
    }
}

/// JSON numbers, strings, arrays and objects.
impl Field for serde_json::Value {
    fn field(&self, name: &str) -> Option<&dyn Field> {
        self.as_object()?.get(name).map(|it| it as &dyn Field)
    }

    fn element(&self, number: usize) -> Option<&dyn Field> {
        self.as_array()?.get(number).map(|it| it as &dyn Field)
    }

    fn text(&self) -> Option<&str> {
        self.as_str()
    }

    fn append_to(&self, numbers: &mut Vec<f64>) {
        match self {
            Self::Array(list) => Self::append_all(list, numbers),
            Self::Bool(is_so) => numbers.push(f64::from(u8::from(*is_so))),
            other => numbers.extend(other.as_f64()),
        }
    }
}

impl<T: Field> Field for Vec<T> {
    fn element(&self, number: usize) -> Option<&dyn Field> {
        self.get(number).map(|it| it as &dyn Field)
    }

    fn append_to(&self, numbers: &mut Vec<f64>) {
        T::append_all(self, numbers);
    }
}

impl<T: Field, const N: usize> Field for [T; N] {
    fn element(&self, number: usize) -> Option<&dyn Field> {
        self.get(number).map(|it| it as &dyn Field)
    }

    fn append_to(&self, numbers: &mut Vec<f64>) {
        T::append_all(self, numbers);
    }
}
