//! `#[derive(Choice)]`.

use heck::ToSnakeCase as _;
use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Error, Fields, Result};

pub(crate) fn expand(input: &DeriveInput) -> Result<TokenStream> {
    let name = &input.ident;
    let Data::Enum(data) = &input.data else {
        return Err(Error::new_spanned(
            name,
            "Choice can be derived only for an enum",
        ));
    };
    for variant in &data.variants {
        if !matches!(variant.fields, Fields::Unit) {
            return Err(Error::new_spanned(
                variant,
                "the variants must not have fields",
            ));
        }
    }
    let variants: Vec<_> = data.variants.iter().map(|v| &v.ident).collect();
    let names: Vec<_> = variants
        .iter()
        .map(|variant| variant.to_string().to_snake_case())
        .collect();
    Ok(quote! {
        impl ::planesman_parameters::Choice for #name {
            const NAMES: &'static [&'static str] = &[#(#names),*];

            fn name(self) -> &'static str {
                match self {
                    #(Self::#variants => #names,)*
                }
            }

            fn named(name: &str) -> ::core::option::Option<Self> {
                match name {
                    #(#names => ::core::option::Option::Some(Self::#variants),)*
                    _ => ::core::option::Option::None,
                }
            }
        }

        impl ::planesman_parameters::ParameterType for #name {
            const CHOICES: &'static [&'static str] = <Self as ::planesman_parameters::Choice>::NAMES;

            fn to_value(&self) -> ::planesman_parameters::Value {
                ::planesman_parameters::Value::from(::planesman_parameters::Choice::name(*self))
            }

            fn from_value(value: &::planesman_parameters::Value) -> ::core::option::Option<Self> {
                match value {
                    ::planesman_parameters::Value::String(name) => {
                        ::planesman_parameters::Choice::named(name)
                    }
                    _ => ::core::option::Option::None,
                }
            }
        }
    })
}
