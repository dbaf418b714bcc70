//! Refuses modules that crash the compilers of real drivers: those in which a loop or a branch carries a value with pointers.
//!
//! Such a module is valid, and software Vulkan runs it. RADV of Mesa 25.0 ends the process on an `OpPhi` of a struct with slices
//! in it. A Rust value that holds a slice and changes in a loop compiles to such an `OpPhi`.

use anyhow::{Context, bail};
use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Op, Word};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Refuses a module in which any entry point has an `OpPhi` or `OpSelect` of a type with a pointer in it.
pub fn refuse_carried(module: &[u8]) -> anyhow::Result<()> {
    let found = carried(module)?;
    if found.is_empty() {
        return Ok(());
    }
    let lines: Vec<String> = found
        .iter()
        .map(|(entry, carried)| {
            let functions: Vec<&str> = carried.functions.iter().map(String::as_str).collect();
            let location =
                if functions.is_empty() { String::new() } else { format!(" (in {})", functions.join(", ")) };
            format!("  {entry}: {}{location}", carried.count)
        })
        .collect();
    bail!(
        "{} entry points carry pointers through loops or branches (OpPhi or OpSelect):\n{}\n\
         keep slices out of values that change in a loop: hold sums there, and pass tables beside them \
         (see \"Avoid in kernels\" in CONTRIBUTING.md)",
        found.len(),
        lines.join("\n")
    )
}

/// Instructions of an entry point that carry pointers.
#[derive(Debug, Default, PartialEq)]
struct Carried {
    count: usize,
    /// Names of the functions that hold the instructions, where the module keeps names.
    functions: BTreeSet<String>,
}

/// Finds the carried pointers of each entry point that has any, by the name of the entry point.
fn carried(module: &[u8]) -> anyhow::Result<BTreeMap<String, Carried>> {
    let module = rspirv::dr::load_bytes(module).map_err(|error| anyhow::anyhow!("no SPIR-V: {error}"))?;
    let pointers = types_with_pointers(&module);
    let names: HashMap<Word, &str> = module.debug_names.iter().filter_map(name).collect();
    let mut found = BTreeMap::new();
    for entry in &module.entry_points {
        let [_, Operand::IdRef(main), Operand::LiteralString(entry), ..] = &entry.operands[..] else {
            bail!("an entry point without a name");
        };
        let mut carried = Carried::default();
        let (mut seen, mut left) = (HashSet::new(), vec![*main]);
        while let Some(id) = left.pop() {
            if !seen.insert(id) {
                continue;
            }
            let function = module.functions.iter().find(|function| function.def_id() == Some(id));
            let function = function.with_context(|| format!("function %{id} is missing"))?;
            for instruction in function.blocks.iter().flat_map(|block| &block.instructions) {
                match (instruction.class.opcode, instruction.operands.first()) {
                    (Op::FunctionCall, Some(Operand::IdRef(callee))) => left.push(*callee),
                    (Op::Phi | Op::Select, _)
                        if instruction.result_type.is_some_and(|id| pointers.contains(&id)) =>
                    {
                        carried.count += 1;
                        carried.functions.extend(names.get(&id).map(|&name| name.to_string()));
                    }
                    _ => {}
                }
            }
        }
        if carried.count > 0 {
            found.insert(entry.clone(), carried);
        }
    }
    Ok(found)
}

/// Pointer types, and structs, arrays and vectors that hold one at any depth. A module declares types before their use.
fn types_with_pointers(module: &Module) -> HashSet<Word> {
    let mut pointers = HashSet::new();
    for instruction in &module.types_global_values {
        let holds = match instruction.class.opcode {
            Op::TypePointer | Op::TypeUntypedPointerKHR => true,
            Op::TypeStruct | Op::TypeArray | Op::TypeRuntimeArray | Op::TypeVector => instruction
                .operands
                .iter()
                .any(|operand| matches!(operand, Operand::IdRef(member) if pointers.contains(member))),
            _ => false,
        };
        if let (true, Some(id)) = (holds, instruction.result_id) {
            pointers.insert(id);
        }
    }
    pointers
}

fn name(instruction: &Instruction) -> Option<(Word, &str)> {
    match &instruction.operands[..] {
        [Operand::IdRef(id), Operand::LiteralString(name)] => Some((*id, name)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rspirv::binary::Assemble;
    use rspirv::dr::Builder;
    use rspirv::spirv::{ExecutionModel, FunctionControl, SelectionControl, StorageClass};

    /// Reduced from a gather that RADV of Mesa 25.0 crashes on: a loop carries a struct with slices.
    const CRASHES_RADV: &[u8] = include_bytes!("../tests/crashes-radv.spv");

    #[test]
    fn refuses_the_module_that_crashes_radv() {
        let error = refuse_carried(CRASHES_RADV).expect_err("it carries slices through a loop").to_string();
        assert!(error.contains("gather.brute"), "{error}");
        assert!(error.contains("CONTRIBUTING"), "{error}");
    }

    #[test]
    fn bytes_that_are_no_module_are_refused() {
        let error = refuse_carried(b"no module at all").expect_err("no module");
        assert!(error.to_string().contains("no SPIR-V"), "{error}");
    }

    /// Type of the value that a branch chooses.
    #[derive(Clone, Copy, Debug)]
    enum Kind {
        Number,
        Pointer,
        /// A struct of an array of structs with a pointer.
        Nested,
    }

    /// A module whose entry point calls a function that chooses between two values, by a phi or by a select.
    fn module(kind: Kind, by_phi: bool) -> Vec<u8> {
        let mut b = Builder::new();
        let (void, bool_type, number) = (b.type_void(), b.type_bool(), b.type_int(32, 0));
        let pointer = b.type_pointer(None, StorageClass::StorageBuffer, number);
        let value_type = match kind {
            Kind::Number => b.type_struct([number, number]),
            Kind::Pointer => pointer,
            Kind::Nested => {
                let two = b.constant_bit32(number, 2);
                let inner = b.type_struct([number, pointer]);
                let array = b.type_array(inner, two);
                b.type_struct([number, array])
            }
        };
        let always = b.constant_true(bool_type);
        let value = b.undef(value_type, None);
        let signature = b.type_function(void, []);
        let callee = b.begin_function(void, None, FunctionControl::NONE, signature).expect("a function");
        b.name(callee, "chooses");
        let first = b.begin_block(None).expect("a block");
        if by_phi {
            let (other, merge) = (b.id(), b.id());
            b.selection_merge(merge, SelectionControl::NONE).expect("a merge");
            b.branch_conditional(always, other, merge, []).expect("a branch");
            b.begin_block(Some(other)).expect("a block");
            b.branch(merge).expect("a branch");
            b.begin_block(Some(merge)).expect("a block");
            b.phi(value_type, None, [(value, first), (value, other)]).expect("a phi");
        } else {
            b.select(value_type, None, always, value, value).expect("a select");
        }
        b.ret().expect("an end");
        b.end_function().expect("an end");
        let main = b.begin_function(void, None, FunctionControl::NONE, signature).expect("a function");
        b.begin_block(None).expect("a block");
        b.function_call(void, None, callee, []).expect("a call");
        b.ret().expect("an end");
        b.end_function().expect("an end");
        b.entry_point(ExecutionModel::GLCompute, main, "calls", []);
        b.module().assemble().into_iter().flat_map(u32::to_le_bytes).collect()
    }

    #[test]
    fn finds_pointers_at_any_depth_and_behind_calls() {
        for by_phi in [true, false] {
            assert_eq!(carried(&module(Kind::Number, by_phi)).expect("a module"), BTreeMap::new());
            for kind in [Kind::Pointer, Kind::Nested] {
                let found = carried(&module(kind, by_phi)).expect("a module");
                let expected = Carried { count: 1, functions: ["chooses".to_string()].into() };
                assert_eq!(found, [("calls".to_string(), expected)].into(), "{kind:?}, phi {by_phi}");
            }
        }
    }
}
