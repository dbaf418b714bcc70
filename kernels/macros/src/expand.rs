//! Expands a declaration to items: the entry points, the description, and the call on the CPU.

use proc_macro2::{Span, TokenStream};
use quote::{format_ident, quote};
use syn::{Ident, LitInt};

use crate::declaration::{Arguments, Declaration, Parameter, Passes, Role};

/// Tables of `SceneTables` beside those of textures: name and type.
const SCENE: [(&str, &str); 9] = [
    ("triangles", "triangle::Triangle"),
    ("surfaces", "triangle::TriangleSurface"),
    ("materials", "material::Material"),
    ("instances", "instance::Instance"),
    ("lights", "light::Light"),
    ("light_bvh", "light_bvh::LightBvhNode"),
    ("environment", "environment::Environment"),
    ("environment_texels", "environment::EnvironmentTexel"),
    ("environment_cdf", "environment::EnvironmentSum"),
];
/// Tables of `TextureTables`: name and type, or none for words.
const TEXTURES: [(&str, &str); 7] = [
    ("textures", "texture::Texture"),
    ("material_textures", "texture::MaterialTextures"),
    ("texture_coordinates", "texture::TextureCoordinates"),
    ("texels_0", ""),
    ("texels_1", ""),
    ("texels_2", ""),
    ("texels_3", ""),
];
/// Tables of the software tracer.
const BVH: [(&str, &str); 2] = [("nodes", "bvh::BvhNode"), ("blocks", "bvh::TriangleBlock")];

/// Access to a bound buffer.
#[derive(Clone, Copy, PartialEq)]
enum Access {
    Read,
    Slots,
    Words,
    Counters,
}

/// A buffer that the pass binds.
struct Bound {
    name: Ident,
    element: TokenStream,
    access: Access,
    /// Number of elements, where the pass gives it.
    len: Option<TokenStream>,
}

/// A tracer that an entry point is compiled with.
#[derive(Clone, Copy, PartialEq)]
enum Tracer {
    Software,
    RayQuery,
}

/// Expands a pass to all of its items.
pub fn expand(arguments: &Arguments, declaration: &Declaration) -> TokenStream {
    let function = &declaration.function;
    let gate = arguments.hardware.then(|| quote!(#[cfg(feature = "ray-query")]));
    let mut entries = TokenStream::new();
    if !arguments.shared_entry {
        let (name, limit) = (&arguments.name, limit(arguments));
        if !arguments.hardware {
            entries.extend(entry(declaration, name, &[], &limit, Tracer::Software));
        }
        if arguments.hardware || traces(declaration) {
            entries.extend(entry(declaration, name, &[], &limit, Tracer::RayQuery));
        }
    }
    let (described, entries) = (described(arguments, declaration), module(declaration, &entries));
    quote! {
        #gate
        #[inline(always)]
        // A parameter for each buffer.
        #[allow(clippy::too_many_arguments)]
        #function

        #entries

        #described
    }
}

/// Expands a shared function to its entry points. Their name is the names of the passes, joined.
pub fn expand_joint(Passes(passes): &Passes, declaration: &Declaration) -> TokenStream {
    let function = &declaration.function;
    let (runs, names): (Vec<_>, Vec<_>) = passes.iter().cloned().unzip();
    let (name, limit) = (names.join("+"), quote!(dispatch.count));
    let entries = [Tracer::Software, Tracer::RayQuery]
        .map(|tracer| entry(declaration, &name, &runs, &limit, tracer))
        .into_iter()
        .collect();
    let entries = module(declaration, &entries);
    quote! {
        #[inline(always)]
        // A parameter for each buffer, and each pass.
        #[allow(clippy::too_many_arguments, clippy::fn_params_excessive_bools)]
        #function

        #entries
    }
}

/// Module of the entry points of a function.
fn module(declaration: &Declaration, entries: &TokenStream) -> TokenStream {
    let module = format_ident!("{}_entry", declaration.function.sig.ident);
    quote! {
        #[cfg(target_arch = "spirv")]
        #[doc(hidden)]
        pub mod #module {
            #[allow(unused_imports)]
            use super::*;
            #entries
        }
    }
}

fn traces(declaration: &Declaration) -> bool {
    declaration.has(|role| matches!(role, Role::Tracer))
}

fn features(declaration: &Declaration) -> bool {
    traces(declaration) || declaration.has(|role| matches!(role, Role::Features))
}

/// Buffers that a pass binds, each once: first its own, then the tables of scene and tracer.
fn bound(declaration: &Declaration, tracer: Tracer) -> Vec<Bound> {
    let mut all: Vec<Bound> = declaration
        .parameters
        .iter()
        .filter_map(|Parameter { name, role, len }| {
            let access = match role {
                Role::Read(_) => Access::Read,
                Role::Slots(_) => Access::Slots,
                Role::Words => Access::Words,
                Role::Counters => Access::Counters,
                _ => return None,
            };
            let len = match access {
                Access::Counters => {
                    Some(quote!(::caustics_kernels::interface::counters::COUNTER_COUNT as u32))
                }
                _ => len.as_ref().map(|len| quote!(#len)),
            };
            Some(Bound { name: buffer(name), element: role.element()?, access, len })
        })
        .collect();
    let mut add = |tables: &[(&str, &str)]| {
        for (name, ty) in tables {
            if all.iter().any(|bound| bound.name == name) {
                continue;
            }
            let element = if ty.is_empty() {
                quote!(u32)
            } else {
                let path: syn::Path =
                    syn::parse_str(&format!("::caustics_kernels::interface::{ty}")).expect("a path");
                quote!(#path)
            };
            all.push(Bound { name: ident(name), element, access: Access::Read, len: None });
        }
    };
    if declaration.has(|role| matches!(role, Role::Scene)) {
        add(&SCENE);
        add(&TEXTURES);
    }
    if traces(declaration) {
        add(&SCENE[1..4]);
        add(&TEXTURES);
        if tracer == Tracer::Software {
            add(&BVH);
        }
    }
    all
}

/// Builds the values that consist of several tables: texture tables, scene tables, and the tracer.
fn composed(declaration: &Declaration, tracer: Tracer) -> TokenStream {
    let mut composed = TokenStream::new();
    let scene = declaration.has(|role| matches!(role, Role::Scene));
    if scene || traces(declaration) {
        let tables = TEXTURES.map(|(name, _)| ident(name));
        composed.extend(quote! {
            let texture_tables = ::caustics_kernels::interface::scene::TextureTables { #(#tables),* };
        });
    }
    if scene {
        let tables = SCENE.map(|(name, _)| ident(name));
        composed.extend(quote! {
            let scene_tables = ::caustics_kernels::interface::scene::SceneTables {
                #(#tables,)* textures: texture_tables
            };
        });
    }
    if traces(declaration) {
        composed.extend(quote! {
            let cut_outs = ::caustics_kernels::texture::cut_out::CutOuts {
                instances, surfaces, materials, textures: texture_tables, features
            };
        });
        composed.extend(match tracer {
            Tracer::Software => quote! {
                let tracer = ::caustics_kernels::trace::bvh::BvhTracer { nodes, blocks, cut_outs };
            },
            Tracer::RayQuery => quote! {
                use ::spirv_std::ray_tracing::RayQuery;
                ::spirv_std::ray_query!(let mut query);
                let tracer = ::caustics_kernels::trace::ray_query::RayQueryTracer {
                    scene: scene_structure, cut_outs, query
                };
            },
        });
    }
    composed
}

/// Call of the function, with its arguments in order.
fn call(declaration: &Declaration, module: &TokenStream) -> TokenStream {
    let function = &declaration.function.sig.ident;
    let arguments = declaration.parameters.iter().map(|Parameter { name, role, .. }| match role {
        Role::Index => quote!(index),
        Role::Params => quote!(params),
        Role::Dispatch => quote!(dispatch),
        Role::Features => quote!(features),
        Role::Runs => quote!(#name),
        Role::Scene => quote!(scene_tables),
        Role::Tracer => quote!(&mut tracer),
        Role::Counters => quote!(&mut #name),
        Role::Read(_) | Role::Slots(_) | Role::Words | Role::Structure => {
            let name = buffer(name);
            quote!(#name)
        }
    });
    quote!(#module::#function(#(#arguments),*))
}

fn limit(arguments: &Arguments) -> TokenStream {
    arguments.limit.as_ref().map_or(quote!(dispatch.count), |limit| quote!(#limit))
}

/// Entry point for a tracer. In a shared one, specialisation constant 1 is the index of the pass that runs.
fn entry(
    declaration: &Declaration,
    name: &str,
    runs: &[Ident],
    limit: &TokenStream,
    tracer: Tracer,
) -> TokenStream {
    let gate = match tracer {
        Tracer::Software => quote!(#[cfg(not(feature = "ray-query"))]),
        Tracer::RayQuery => quote!(#[cfg(feature = "ray-query")]),
    };
    let entry = match tracer {
        Tracer::Software => ident("software"),
        Tracer::RayQuery => ident("ray_query"),
    };
    let bound = bound(declaration, tracer);
    let constant =
        features(declaration).then(|| quote!(#[spirv(spec_constant(id = 0, default = 0))] features: u32,));
    let which = (!runs.is_empty()).then(|| quote!(#[spirv(spec_constant(id = 1, default = 0))] which: u32,));
    let indices = 0u32..;
    let runs = runs.iter().zip(indices).map(|(runs, index)| quote!(let #runs = which == #index;));
    let mut number = 0;
    let mut next = || {
        number += 1;
        LitInt::new(&(number - 1).to_string(), Span::call_site())
    };
    let params = next();
    let buffers: Vec<TokenStream> = bound
        .iter()
        .map(|Bound { name, element, access, .. }| {
            let number = next();
            let mutable = (*access != Access::Read).then(|| quote!(mut));
            quote!(#[spirv(storage_buffer, descriptor_set = 0, binding = #number)] #name: &#mutable [#element],)
        })
        .collect();
    let mut structures: Vec<Ident> = declaration
        .parameters
        .iter()
        .filter(|parameter| matches!(parameter.role, Role::Structure))
        .map(|parameter| parameter.name.clone())
        .collect();
    if traces(declaration) && tracer == Tracer::RayQuery {
        structures.push(ident("scene_structure"));
    }
    let structures = structures.iter().map(|name| {
        let number = next();
        quote! {
            #[spirv(descriptor_set = 0, binding = #number)]
            #name: &::spirv_std::ray_tracing::AccelerationStructure,
        }
    });
    let wrapped = bound.iter().filter_map(|Bound { name, access, .. }| match access {
        Access::Read => None,
        Access::Slots => Some(quote!(let #name = ::caustics_kernels::platform::Slots(#name);)),
        Access::Words => Some(quote!(let #name = ::caustics_kernels::platform::AtomicWords(#name);)),
        Access::Counters => Some(quote! {
            let mut #name =
                ::caustics_kernels::platform::Counts::<{ ::caustics_kernels::interface::counters::COUNTER_COUNT }>(#name);
        }),
    });
    let features = features(declaration)
        .then(|| quote!(let features = ::caustics_kernels::interface::features::Features(features);));
    let tracer_of_this = traces(declaration).then(|| quote!(let mut tracer = tracer;));
    let (composed, call) = (composed(declaration, tracer), call(declaration, &quote!(super)));
    quote! {
        #gate
        #[::spirv_std::spirv(compute(threads(64), entry_point_name = #name))]
        pub fn #entry(
            #[spirv(global_invocation_id)] id: ::spirv_std::glam::UVec3,
            #constant
            #which
            #[spirv(push_constant)] dispatch: &::caustics_kernels::interface::frame::Dispatch,
            #[spirv(uniform, descriptor_set = 0, binding = #params)]
            params: &::caustics_kernels::interface::frame::FrameParams,
            #(#buffers)*
            #(#structures)*
        ) {
            let dispatch = *dispatch;
            let index = id.x + id.y * ::caustics_kernels::interface::frame::INVOCATIONS_PER_ROW;
            if index < #limit {
                #features
                #(#runs)*
                #composed
                #tracer_of_this
                #(#wrapped)*
                #call;
            }
        }
    }
}

/// Description of the pass, with its call on the CPU.
fn described(arguments: &Arguments, declaration: &Declaration) -> TokenStream {
    let function = &declaration.function.sig.ident;
    let constant = Ident::new(&function.to_string().to_uppercase(), function.span());
    let docs = declaration.function.attrs.iter().filter(|attribute| attribute.path().is_ident("doc"));
    let (name, over, work, traces) = (&arguments.name, &arguments.over, &arguments.work, traces(declaration));
    let mut bound = bound(declaration, Tracer::Software);
    for written in bound.iter_mut().filter(|bound| bound.access != Access::Read) {
        written.len.get_or_insert(quote!(#over));
    }
    let buffers = bound.iter().map(|Bound { name, element, access, len }| {
        let name = name.to_string();
        let mut tables = SCENE.iter().chain(&TEXTURES).chain(&BVH);
        let kind = match access {
            Access::Read if tables.any(|(table, _)| *table == name) => quote!(Table),
            Access::Read => quote!(Read),
            Access::Slots => quote!(Slots),
            Access::Words | Access::Counters => quote!(Words),
        };
        let len = len.as_ref().map_or(quote!(0), |len| len.clone());
        quote! {
            ::caustics_kernels::declare::Bound {
                name: #name,
                stride: ::core::mem::size_of::<#element>(),
                access: ::caustics_kernels::declare::Access::#kind,
                len: |params| { let _ = params; #len },
            }
        }
    });
    let cpu = if arguments.hardware {
        quote!(None)
    } else {
        let on_cpu = on_cpu(arguments, declaration, &bound);
        quote!({ #on_cpu; Some(on_cpu) })
    };
    let lens = bound.iter().filter_map(|bound| bound.len.as_ref());
    quote! {
        // Never called: uses the expressions of the description, so that both targets need the same imports.
        #[cfg(target_arch = "spirv")]
        const _: () = {
            #[allow(dead_code)]
            fn sizes(params: &::caustics_kernels::interface::frame::FrameParams) {
                let _ = (params, #over);
                #(let _ = #lens;)*
            }
        };

        #[cfg(not(target_arch = "spirv"))]
        #(#docs)*
        pub static #constant: ::caustics_kernels::declare::Pass = ::caustics_kernels::declare::Pass {
            name: #name,
            work: ::caustics_kernels::declare::Work::#work,
            traces: #traces,
            over: |params| { let _ = params; #over },
            buffers: &[#(#buffers),*],
            cpu: #cpu,
        };
    }
}

/// Call on the CPU: borrows the buffers and maps the function over chunks of indices.
fn on_cpu(arguments: &Arguments, declaration: &Declaration, bound: &[Bound]) -> TokenStream {
    let borrowed = bound.iter().map(|Bound { name, element, access, .. }| {
        let key = name.to_string();
        let borrow = format_ident!("borrowed_{name}");
        match access {
            Access::Read => quote! {
                let #borrow = call.buffers.read::<#element>(#key)?;
                let #name = &#borrow[..];
            },
            Access::Slots => quote! {
                let mut #borrow = call.buffers.edit::<#element>(#key)?;
                let #name = ::caustics_kernels::platform::Slots::new(&mut #borrow);
            },
            Access::Words | Access::Counters => quote! {
                let mut #borrow = call.buffers.edit::<#element>(#key)?;
                let #name = ::caustics_kernels::platform::AtomicWords::new(&mut #borrow);
            },
        }
    });
    let of_chunk = bound.iter().filter(|bound| bound.access == Access::Counters).map(
        |Bound { name, .. }| quote!(let mut #name = ::caustics_kernels::declare::LocalCounters::new(#name);),
    );
    let tracer_of_chunk = traces(declaration)
        .then(|| quote!(let mut tracer = ::caustics_kernels::trace::on_cpu::CpuTracer::new(tracer, bvh8);));
    let bvh8 = traces(declaration).then(|| quote!(let bvh8 = call.buffers.bvh8(nodes, instances);));
    let (composed, limit, function) =
        (composed(declaration, Tracer::Software), limit(arguments), call(declaration, &quote!(self)));
    let body = quote! {
        let (dispatch, params, features) = (call.dispatch, call.params, call.features);
        #(#borrowed)*
        #composed
        #bvh8
        call.for_chunks(#limit, |indices| {
            #tracer_of_chunk
            #(#of_chunk)*
            for index in indices {
                #function;
            }
        });
        Ok(())
    };
    let parameters = quote!(call: &::caustics_kernels::declare::Call<'_>);
    let result = quote!(::core::result::Result<(), ::caustics_kernels::declare::BufferError>);
    // A closure is compiled for the instructions of the function around it, so both functions hold the whole body. The second
    // one's instructions are those that `trace::on_cpu::has_avx2` checks for.
    quote! {
        #[allow(unused_variables)]
        fn any(#parameters) -> #result { #body }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
        #[allow(unused_variables)]
        fn avx2(#parameters) -> #result { #body }

        let on_cpu = ::caustics_kernels::declare::OnCpu {
            any,
            #[cfg(target_arch = "x86_64")]
            avx2,
        };
    }
}

/// Name of a parameter's buffer: without the underscore of a parameter that only `limit` reads.
fn buffer(parameter: &Ident) -> Ident {
    let name = parameter.to_string();
    Ident::new(name.strip_prefix('_').unwrap_or(&name), parameter.span())
}

fn ident(name: &str) -> Ident {
    Ident::new(name, Span::call_site())
}
