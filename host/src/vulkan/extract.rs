//! Extraction of one entry point with everything that it uses. Drivers and the validation layer parse a module again for
//! each pipeline, and an entry point is a small part of it.

use std::collections::{HashMap, HashSet};

use rspirv::binary::Assemble;
use rspirv::dr::{Function, Instruction, Module, Operand};
use rspirv::spirv::Op;

/// Returns the words of a module with only this entry point. `None` if the module has no such entry point.
pub fn extract(source: &Module, name: &str) -> Option<Vec<u32>> {
    let entry = source.entry_points.iter().find(|entry| entry.operands.get(2) == Some(&literal(name)))?;
    let functions: HashMap<u32, &Function> =
        source.functions.iter().filter_map(|function| Some((function.def_id()?, function))).collect();
    let globals: HashMap<u32, &Instruction> = source
        .types_global_values
        .iter()
        .chain(&source.debug_string_source)
        .filter_map(|instruction| Some((instruction.result_id?, instruction)))
        .collect();

    let mut reached = HashSet::new();
    let mut left: Vec<u32> = ids(entry).collect();
    while let Some(id) = left.pop() {
        if !reached.insert(id) {
            continue;
        }
        if let Some(function) = functions.get(&id) {
            left.extend(function.all_inst_iter().flat_map(ids));
        } else if let Some(global) = globals.get(&id) {
            left.extend(ids(global));
        }
    }

    let has = |id: Option<u32>| id.is_some_and(|id| reached.contains(&id));
    let target = |instruction: &Instruction| match instruction.operands.first() {
        Some(&Operand::IdRef(id)) => has(Some(id)),
        _ => false,
    };
    let module = Module {
        header: source.header.clone(),
        capabilities: source.capabilities.clone(),
        extensions: source.extensions.clone(),
        ext_inst_imports: source.ext_inst_imports.clone(),
        memory_model: source.memory_model.clone(),
        entry_points: vec![entry.clone()],
        execution_modes: kept(&source.execution_modes, target),
        debug_string_source: kept(&source.debug_string_source, |instruction| {
            instruction.class.opcode != Op::String || has(instruction.result_id)
        }),
        debug_names: kept(&source.debug_names, target),
        debug_module_processed: source.debug_module_processed.clone(),
        annotations: kept(&source.annotations, target),
        // A forward pointer has no result: its target is an operand.
        types_global_values: kept(&source.types_global_values, |instruction| match instruction.result_id {
            Some(_) => has(instruction.result_id),
            None => target(instruction),
        }),
        functions: source.functions.iter().filter(|function| has(function.def_id())).cloned().collect(),
    };
    Some(module.assemble())
}

/// Returns the instructions that `is_kept` selects.
fn kept(all: &[Instruction], is_kept: impl Fn(&Instruction) -> bool) -> Vec<Instruction> {
    all.iter().filter(|instruction| is_kept(instruction)).cloned().collect()
}

fn literal(name: &str) -> Operand {
    Operand::LiteralString(name.into())
}

/// Returns the ids that an instruction refers to.
fn ids(instruction: &Instruction) -> impl Iterator<Item = u32> {
    instruction.result_type.into_iter().chain(instruction.operands.iter().filter_map(Operand::id_ref_any))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vulkan::reflection::Reflection;

    fn load(words: &[u32]) -> Module {
        rspirv::dr::load_words(words).expect("SPIR-V")
    }

    /// Every extracted entry point has the same bindings as in its module, and is small.
    #[test]
    fn extracted_entry_points_keep_their_bindings() {
        let base = include_bytes!("../../../kernels/base.spv");
        let rayquery = include_bytes!("../../../kernels/rayquery.spv");
        for bytes in [&base[..], rayquery] {
            let words: &[u32] = &bytemuck::pod_collect_to_vec(bytes);
            let (source, whole) = (load(words), Reflection::new("whole", words).expect("a module"));
            let mut sizes = Vec::new();
            for (name, entry) in &whole.entry_points {
                let alone = extract(&source, &entry.symbol).expect("the entry point is there");
                sizes.push(alone.len());
                let found = Reflection::new(name, &alone).expect("a module");
                assert_eq!(found.entry_points.len(), entry.symbol.split('+').count());
                assert_eq!(&found.entry_points[name], entry);
                // The module is complete: every id that it refers to is defined.
                let defined: HashSet<u32> =
                    load(&alone).all_inst_iter().filter_map(|instruction| instruction.result_id).collect();
                for instruction in load(&alone).all_inst_iter() {
                    let unknown = ids(instruction).find(|id| !defined.contains(id));
                    assert_eq!(unknown, None, "{name}: {instruction:?}");
                }
            }
            sizes.sort_unstable();
            assert!(sizes[0] * 30 < words.len(), "the smallest of {} words: {}", words.len(), sizes[0]);
            assert_eq!(extract(&source, "nothing"), None);
        }
    }
}
