//! `#[derive(Parameters)]`.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{
    Data, DeriveInput, Error, Expr, Field, Fields, Ident, LitStr, RangeLimits, Result, Type,
};

/// A field of the struct.
struct Entry<'a> {
    ident: &'a Ident,
    ty: &'a Type,
    name: String,
    /// Description, from the doc comment.
    description: String,
    kind: Kind,
}

/// The contents of `#[parameter(...)]`.
enum Kind {
    Leaf {
        default: Box<Expr>,
        unit: Option<LitStr>,
        positive: Option<LitStr>,
        range: Option<Box<(Expr, Expr)>>,
        read_only: bool,
    },
    /// A field without a default is a group: a struct of parameters with this name and a dot as prefix.
    Group,
}

pub(crate) fn expand(input: &DeriveInput) -> Result<TokenStream> {
    let name = &input.ident;
    let Data::Struct(data) = &input.data else {
        return Err(Error::new_spanned(
            name,
            "Parameters can be derived only for a struct",
        ));
    };
    let Fields::Named(fields) = &data.fields else {
        return Err(Error::new_spanned(name, "each parameter needs a name"));
    };
    let entries = fields
        .named
        .iter()
        .map(entry)
        .collect::<Result<Vec<Entry<'_>>>>()?;
    let declared = entries.iter().map(declared);
    let read = entries.iter().map(|entry| {
        let (ident, name) = (entry.ident, &entry.name);
        match entry.kind {
            Kind::Leaf { .. } => quote! {
                #ident: values.read(&::planesman_parameters::dotted(under, #name))?
            },
            Kind::Group => quote! {
                #ident: ::planesman_parameters::Parameters::read(
                    &::planesman_parameters::dotted(under, #name),
                    values,
                )?
            },
        }
    });
    let defaults = entries.iter().map(|entry| {
        let ident = entry.ident;
        match &entry.kind {
            Kind::Leaf { default, .. } if is_string(entry.ty) => {
                quote! { #ident: ::std::string::String::from(#default) }
            }
            Kind::Leaf { default, .. } => quote! { #ident: #default },
            Kind::Group => quote! { #ident: ::core::default::Default::default() },
        }
    });
    Ok(quote! {
        impl ::core::default::Default for #name {
            fn default() -> Self {
                Self { #(#defaults),* }
            }
        }

        impl ::planesman_parameters::Parameters for #name {
            fn declare(
                &self,
                under: &str,
                declarations: &mut ::std::vec::Vec<::planesman_parameters::Declaration>,
            ) {
                #(#declared)*
            }

            fn read(
                under: &str,
                values: &::planesman_parameters::Values,
            ) -> ::core::result::Result<Self, ::planesman_parameters::Refusal> {
                ::core::result::Result::Ok(Self { #(#read),* })
            }
        }
    })
}

/// Code of an entry's declaration.
fn declared(entry: &Entry<'_>) -> TokenStream {
    let Entry {
        ident,
        name,
        description,
        kind,
        ..
    } = entry;
    match kind {
        Kind::Leaf {
            unit,
            positive,
            range,
            read_only,
            ..
        } => {
            let unit = unit.iter().map(|unit| quote! { .unit(#unit) });
            let positive = positive.iter().map(|it| quote! { .positive(#it) });
            let range = range.iter().map(|range| {
                let (low, high) = range.as_ref();
                quote! { .range(#low, #high) }
            });
            let read_only = read_only.then(|| quote! { .read_only() });
            quote! {
                declarations.push(
                    ::planesman_parameters::Declaration::of(
                        ::planesman_parameters::dotted(under, #name),
                        &self.#ident,
                        #description,
                    )
                        #(#unit)*
                        #(#positive)*
                        #(#range)*
                        #read_only,
                );
            }
        }
        Kind::Group => quote! {
            ::planesman_parameters::Parameters::declare(
                &self.#ident,
                &::planesman_parameters::dotted(under, #name),
                declarations,
            );
        },
    }
}

fn entry(field: &Field) -> Result<Entry<'_>> {
    let Some(ident) = &field.ident else {
        return Err(Error::new_spanned(field, "each parameter needs a name"));
    };
    let (mut default, mut unit, mut positive, mut range) = (None, None, None, None);
    let mut read_only = false;
    for attribute in &field.attrs {
        if !attribute.path().is_ident("parameter") {
            continue;
        }
        attribute.parse_nested_meta(|meta| {
            if meta.path.is_ident("default") {
                default = Some(Box::new(meta.value()?.parse::<Expr>()?));
            } else if meta.path.is_ident("unit") {
                unit = Some(meta.value()?.parse::<LitStr>()?);
            } else if meta.path.is_ident("positive") {
                positive = Some(meta.value()?.parse::<LitStr>()?);
            } else if meta.path.is_ident("range") {
                range = Some(Box::new(bounds(meta.value()?.parse::<Expr>()?)?));
            } else if meta.path.is_ident("read_only") {
                read_only = true;
            } else {
                let known = "default, unit, positive, range, read_only";
                return Err(meta.error(format!("one of {known} is expected")));
            }
            Ok(())
        })?;
    }
    let description = doc_text(&field.attrs);
    let kind = match default {
        Some(default) if !description.is_empty() => Kind::Leaf {
            default,
            unit,
            positive,
            range,
            read_only,
        },
        Some(_) => {
            return Err(Error::new_spanned(
                field,
                "a parameter needs a doc comment: users read it as its description",
            ));
        }
        None if unit.is_some() || positive.is_some() || range.is_some() || read_only => {
            return Err(Error::new_spanned(field, "a parameter needs a default"));
        }
        None => Kind::Group,
    };
    Ok(Entry {
        ident,
        ty: &field.ty,
        name: ident.to_string().trim_start_matches("r#").to_owned(),
        description,
        kind,
    })
}

fn is_string(ty: &Type) -> bool {
    matches!(ty, Type::Path(path) if path.path.is_ident("String"))
}

/// Ends of a closed interval `low..=high`.
fn bounds(range: Expr) -> Result<(Expr, Expr)> {
    match range {
        Expr::Range(syn::ExprRange {
            start: Some(low),
            limits: RangeLimits::Closed(_),
            end: Some(high),
            ..
        }) => Ok((*low, *high)),
        other => Err(Error::new_spanned(
            other,
            "a closed interval is expected: low..=high",
        )),
    }
}

/// The doc comment among the attributes, with its lines joined by spaces.
fn doc_text(attributes: &[syn::Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| {
        let syn::Meta::NameValue(pair) = &attribute.meta else {
            return None;
        };
        let syn::Expr::Lit(syn::ExprLit {
            lit: syn::Lit::Str(line),
            ..
        }) = &pair.value
        else {
            return None;
        };
        pair.path
            .is_ident("doc")
            .then(|| line.value().trim().to_owned())
    });
    lines.collect::<Vec<_>>().join(" ").trim().to_owned()
}
