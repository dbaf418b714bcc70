//! The values of options that take a variant, each with what it is.

use clap::builder::{PossibleValue, PossibleValuesParser};

macro_rules! values {
    ($($function:ident: $all:expr;)*) => {
        $(
            pub fn $function() -> PossibleValuesParser {
                let value = |name, about| PossibleValue::new(name).help(about);
                PossibleValuesParser::new($all.iter().map(|variant| value(variant.name, variant.about)))
            }
        )*
    };
}
values! {
    methods: caustics_kernels::method::ALL;
    gathers: caustics_kernels::gather::variant::ALL;
    histories: caustics_kernels::history::ALL;
    denoisers: caustics_kernels::denoiser::ALL;
}
