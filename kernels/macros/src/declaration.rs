//! Declarations of passes: the arguments of `#[pass]`, and the roles of the parameters below it.

use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::spanned::Spanned;
use syn::{
    Attribute, Error, Expr, ExprArray, FnArg, GenericArgument, Ident, ItemFn, Lit, Meta, Pat, PathArguments,
    PathSegment, Result, Token, Type, TypeParamBound, bracketed,
};

/// The arguments of the attribute.
pub struct Arguments {
    pub name: String,
    pub over: Expr,
    pub work: Ident,
    pub limit: Option<Expr>,
    pub hardware: bool,
    /// Whether several passes share its entry point.
    pub shared_entry: bool,
}

impl Parse for Arguments {
    fn parse(input: ParseStream) -> Result<Self> {
        let (mut name, mut over, mut work, mut limit) = (None, None, None, None);
        let (mut hardware, mut shared_entry) = (false, false);
        while !input.is_empty() {
            let key: Ident = input.parse()?;
            if key == "hardware" {
                hardware = true;
            } else if key == "shared_entry" {
                shared_entry = true;
            } else {
                input.parse::<Token![=]>()?;
                match key.to_string().as_str() {
                    "name" => name = Some(parse_name(input)?),
                    "over" => over = Some(input.parse()?),
                    "work" => work = Some(input.parse()?),
                    "limit" => limit = Some(input.parse()?),
                    _ => {
                        return Err(Error::new(
                            key.span(),
                            "a pass has name, over, work, limit, hardware, shared_entry",
                        ));
                    }
                }
            }
            if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        let missing = |what| input.error(format!("a pass says its {what}"));
        Ok(Arguments {
            name: name.ok_or_else(|| missing("name"))?,
            over: over.ok_or_else(|| missing("over"))?,
            work: work.ok_or_else(|| missing("work"))?,
            limit,
            hardware,
            shared_entry,
        })
    }
}

/// Passes of a shared entry point: the `bool` parameter of each, and the name of the pass.
pub struct Passes(pub Vec<(Ident, String)>);

impl Parse for Passes {
    fn parse(input: ParseStream) -> Result<Self> {
        let pass = |input: ParseStream| {
            let parameter: Ident = input.parse()?;
            input.parse::<Token![=]>()?;
            Ok((parameter, parse_name(input)?))
        };
        Ok(Passes(input.parse_terminated(pass, Token![,])?.into_iter().collect()))
    }
}

/// Parses a literal, or pieces in brackets that are joined: a macro that stamps passes has identifiers, no literals.
fn parse_name(input: ParseStream) -> Result<String> {
    if !input.peek(syn::token::Bracket) {
        return Ok(input.parse::<syn::LitStr>()?.value());
    }
    let content;
    bracketed!(content in input);
    let pieces: Punctuated<Expr, Token![,]> = Punctuated::parse_terminated(&content)?;
    pieces.iter().map(piece).collect()
}

fn piece(expression: &Expr) -> Result<String> {
    match expression {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Str(text) => Ok(text.value()),
            other => Err(Error::new(other.span(), "a piece of a name is a text or an identifier")),
        },
        Expr::Path(path) => Ok(path.path.require_ident()?.to_string()),
        Expr::Group(group) => piece(&group.expr),
        Expr::Array(ExprArray { .. }) | _ => {
            Err(Error::new(expression.span(), "a piece of a name is a text or an identifier"))
        }
    }
}

/// Role of a parameter, by its type.
pub enum Role {
    Index,
    Params,
    Dispatch,
    Features,
    /// Whether this pass of a shared entry point runs.
    Runs,
    Scene,
    Tracer,
    Counters,
    Read(Type),
    Slots(Type),
    Words,
    Structure,
}

/// A parameter of the function.
pub struct Parameter {
    pub name: Ident,
    pub role: Role,
    /// Number of elements of its buffer, where `#[len = ...]` gives it.
    pub len: Option<Expr>,
}

/// A function with the roles of its parameters.
pub struct Declaration {
    pub parameters: Vec<Parameter>,
    /// The function without the attributes of its parameters.
    pub function: ItemFn,
}

impl Declaration {
    pub fn new(mut function: ItemFn) -> Result<Self> {
        let mut parameters = Vec::new();
        for (index, input) in function.sig.inputs.iter_mut().enumerate() {
            let FnArg::Typed(typed) = input else {
                return Err(Error::new(input.span(), "a pass is no method"));
            };
            let Pat::Ident(name) = &*typed.pat else {
                return Err(Error::new(typed.pat.span(), "a parameter of a pass is a name"));
            };
            let role = if index == 0 { Role::Index } else { role(&typed.ty)? };
            let name = name.ident.clone();
            let len = take_len(&mut typed.attrs)?;
            if len.is_some() && !matches!(role, Role::Read(_) | Role::Slots(_) | Role::Words) {
                return Err(Error::new(name.span(), "only a buffer has a length"));
            }
            parameters.push(Parameter { name, role, len });
        }
        if parameters.is_empty() {
            return Err(Error::new(function.sig.span(), "the first parameter of a pass is its index"));
        }
        Ok(Declaration { parameters, function })
    }

    /// First parameter of a role, if there is one.
    pub fn find(&self, is: impl Fn(&Role) -> bool) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| is(&parameter.role))
    }

    /// Whether any parameter has a role.
    pub fn has(&self, is: impl Fn(&Role) -> bool) -> bool {
        self.find(is).is_some()
    }
}

/// Takes `#[len = ...]` out of attributes and returns its expression.
fn take_len(attributes: &mut Vec<Attribute>) -> Result<Option<Expr>> {
    let mut len = None;
    for attribute in attributes.drain(..) {
        match attribute.meta {
            Meta::NameValue(meta) if meta.path.is_ident("len") => len = Some(meta.value),
            other => return Err(Error::new(other.span(), "a parameter of a pass has `#[len = ...]` alone")),
        }
    }
    Ok(len)
}

fn role(ty: &Type) -> Result<Role> {
    let unknown = || Error::new(ty.span(), "no parameter of a pass has this type; see `pass`");
    match ty {
        Type::Reference(reference) => match (&*reference.elem, reference.mutability) {
            (Type::Slice(slice), None) => Ok(Role::Read((*slice.elem).clone())),
            (Type::ImplTrait(traits), Some(_)) => {
                let bound = traits.bounds.iter().find_map(|bound| match bound {
                    TypeParamBound::Trait(bound) => bound.path.segments.last(),
                    _ => None,
                });
                match bound.ok_or_else(unknown)?.ident.to_string().as_str() {
                    "Tracer" => Ok(Role::Tracer),
                    "Atomics" => Ok(Role::Counters),
                    _ => Err(unknown()),
                }
            }
            (other, None) => match last(other).ok_or_else(unknown)?.ident.to_string().as_str() {
                "FrameParams" => Ok(Role::Params),
                "AccelerationStructure" => Ok(Role::Structure),
                _ => Err(unknown()),
            },
            _ => Err(unknown()),
        },
        Type::Group(group) => role(&group.elem),
        other => {
            let segment = last(other).ok_or_else(unknown)?;
            match segment.ident.to_string().as_str() {
                "Dispatch" => Ok(Role::Dispatch),
                "Features" => Ok(Role::Features),
                "bool" => Ok(Role::Runs),
                "SceneTables" => Ok(Role::Scene),
                "AtomicWords" => Ok(Role::Words),
                "Slots" => Ok(Role::Slots(element(segment).ok_or_else(unknown)?)),
                _ => Err(unknown()),
            }
        }
    }
}

fn last(ty: &Type) -> Option<&PathSegment> {
    match ty {
        Type::Path(path) => path.path.segments.last(),
        _ => None,
    }
}

/// Type in the angle brackets of a segment.
fn element(segment: &PathSegment) -> Option<Type> {
    let PathArguments::AngleBracketed(arguments) = &segment.arguments else { return None };
    arguments.args.iter().find_map(|argument| match argument {
        GenericArgument::Type(ty) => Some(ty.clone()),
        _ => None,
    })
}

impl Role {
    /// Type of the elements of its buffer; `None` without a buffer.
    pub fn element(&self) -> Option<TokenStream> {
        match self {
            Role::Read(ty) | Role::Slots(ty) => Some(quote!(#ty)),
            Role::Words | Role::Counters => Some(quote!(u32)),
            _ => None,
        }
    }
}
