//! Reflection of SPIR-V: the bindings of each entry point of a module, by name.
//!
//! Entry points of a module share binding numbers, so that bindings are read per entry point. Since SPIR-V 1.4,
//! `OpEntryPoint` lists every global variable that it uses.

use std::collections::{BTreeMap, HashMap};

use rspirv::dr::{Instruction, Module as Source, Operand};
use rspirv::spirv::{Capability, Decoration, ExecutionMode, Op, StorageClass};

use super::error::VulkanError;

/// Kind of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// Storage buffer.
    Buffer,
    /// Uniform buffer.
    Uniform,
    /// Acceleration structure.
    Structure,
}

/// Parameter of an entry point in descriptor set 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Binding number.
    pub binding: u32,
    /// Name of the parameter and of its buffer.
    pub name: String,
    /// Kind of the binding.
    pub kind: BindingKind,
    /// Size of an element of a buffer that is an array (bytes); 0 for all others.
    pub stride: u32,
}

/// Compute entry point of one pass. Several passes may share it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryPoint {
    /// Name of the pass.
    pub name: String,
    /// Name of the entry point: the names of the passes that share it, joined by `+`.
    pub symbol: String,
    /// Index of the pass among them.
    pub pass_index: u32,
    /// Number of invocations of a workgroup, all on x.
    pub workgroup_size: u32,
    /// Size of the push constants (bytes); 0 without any.
    pub push_constant_bytes: u32,
    /// Parameters of all passes that share the entry point, in order of binding number.
    pub bindings: Vec<Binding>,
}

impl EntryPoint {
    /// Whether several passes share the entry point.
    pub fn is_joint(&self) -> bool {
        self.symbol != self.name
    }
}

/// Capabilities and entry points of a module.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reflection {
    /// Capabilities that the module declares.
    pub capabilities: Vec<Capability>,
    /// Entry points, by the name of the pass.
    pub entry_points: BTreeMap<String, EntryPoint>,
}

impl Reflection {
    /// Reads a module. Errors contain `name`.
    pub fn new(name: &str, words: &[u32]) -> Result<Reflection, VulkanError> {
        Reflection::from_source(name, &load(name, words)?)
    }

    /// Reads a parsed module. Errors contain `name`.
    pub fn from_source(name: &str, source: &Source) -> Result<Reflection, VulkanError> {
        let failed = |reason: String| VulkanError::Module { name: name.into(), reason };
        if source.header.as_ref().is_none_or(|header| header.version() < (1, 4)) {
            return Err(failed(
                "it is older than SPIR-V 1.4, so entry points do not list what they bind".into(),
            ));
        }

        let ids = source.types_global_values.iter().filter_map(|i| Some((i.result_id?, i))).collect();
        let reader = Reader { source, ids };
        let capabilities = source.capabilities.iter().filter_map(|i| match i.operands[..] {
            [Operand::Capability(capability)] => Some(capability),
            _ => None,
        });
        let mut reflection = Reflection { capabilities: capabilities.collect(), ..Reflection::default() };
        for instruction in &source.entry_points {
            if let [_, Operand::IdRef(function), Operand::LiteralString(name), interface @ ..] =
                &instruction.operands[..]
            {
                let entry = reader
                    .entry_point(*function, name, interface)
                    .map_err(|reason| failed(format!("entry point `{name}`: {reason}")))?;
                for (pass_index, pass) in (0..).zip(name.split('+')) {
                    let entry = EntryPoint { name: pass.into(), pass_index, ..entry.clone() };
                    reflection.entry_points.insert(pass.into(), entry);
                }
            }
        }
        Ok(reflection)
    }
}

/// Parses a module. Errors contain `name`.
pub fn load(name: &str, words: &[u32]) -> Result<Source, VulkanError> {
    rspirv::dr::load_words(words)
        .map_err(|state| VulkanError::Module { name: name.into(), reason: state.to_string() })
}

struct Reader<'a> {
    source: &'a Source,
    ids: HashMap<u32, &'a Instruction>,
}

impl Reader<'_> {
    fn entry_point(&self, function: u32, name: &str, interface: &[Operand]) -> Result<EntryPoint, String> {
        let workgroup_size = self.workgroup_size(function)?;
        let mut push_constant_bytes = 0;
        let mut bindings = BTreeMap::new();
        for variable in interface.iter().filter_map(Operand::id_ref_any) {
            let (class, pointee) = self.variable(variable)?;
            match class {
                StorageClass::PushConstant => push_constant_bytes = self.size(pointee)?.next_multiple_of(4),
                StorageClass::StorageBuffer | StorageClass::UniformConstant | StorageClass::Uniform => {
                    let found = self.binding(variable, class, pointee)?;
                    if let Some(other) = bindings.insert(found.binding, found.clone()) {
                        let (number, a, b) = (found.binding, other.name, found.name);
                        return Err(format!("`{a}` and `{b}` share binding {number}"));
                    }
                }
                _ => {}
            }
        }
        let bindings = bindings.into_values().collect();
        let (name, symbol) = (name.into(), name.into());
        Ok(EntryPoint { name, symbol, pass_index: 0, workgroup_size, push_constant_bytes, bindings })
    }

    fn workgroup_size(&self, function: u32) -> Result<u32, String> {
        let size = self.source.execution_modes.iter().find_map(|mode| match mode.operands[..] {
            [
                Operand::IdRef(id),
                Operand::ExecutionMode(ExecutionMode::LocalSize),
                Operand::LiteralBit32(x),
                Operand::LiteralBit32(y),
                Operand::LiteralBit32(z),
            ] if id == function => Some((x, y, z)),
            _ => None,
        });
        match size {
            Some((x, 1, 1)) if x > 0 => Ok(x),
            Some((x, y, z)) => Err(format!("workgroups are {x} x {y} x {z}, but must be N x 1 x 1")),
            None => Err("it has no workgroup size".into()),
        }
    }

    fn binding(&self, variable: u32, class: StorageClass, pointee: u32) -> Result<Binding, String> {
        let name = self.name(variable).ok_or("a parameter has no name (build with NameVariables)")?;
        let number = |decoration| {
            let found =
                self.decorations(variable).find(|operands| operands[0] == Operand::Decoration(decoration));
            found.and_then(|operands| literal(operands.get(1)?))
        };
        if number(Decoration::DescriptorSet) != Some(0) {
            return Err(format!("`{name}` is not in descriptor set 0"));
        }
        let binding = number(Decoration::Binding).ok_or(format!("`{name}` has no binding number"))?;
        let kind = match (class, self.ids.get(&pointee).map(|i| i.class.opcode)) {
            (StorageClass::StorageBuffer, Some(Op::TypeStruct)) => BindingKind::Buffer,
            (StorageClass::Uniform, Some(Op::TypeStruct)) => BindingKind::Uniform,
            (_, Some(Op::TypeAccelerationStructureKHR)) => BindingKind::Structure,
            _ => return Err(format!("`{name}` is neither a buffer nor an acceleration structure")),
        };
        let stride = if kind == BindingKind::Buffer { self.stride(pointee).unwrap_or(0) } else { 0 };
        Ok(Binding { binding, name: name.into(), kind, stride })
    }

    /// Returns the size of an element of a struct whose only member is a runtime array (bytes).
    fn stride(&self, structure: u32) -> Option<u32> {
        let [Operand::IdRef(array)] = self.ids.get(&structure)?.operands[..] else { return None };
        let kind = Operand::Decoration(Decoration::ArrayStride);
        literal(self.decorations(array).find(|operands| operands[0] == kind)?.get(1)?)
    }

    /// Returns the storage class of a global variable and the type that it points to.
    fn variable(&self, variable: u32) -> Result<(StorageClass, u32), String> {
        let pointer = self.ids.get(&variable).and_then(|i| self.ids.get(&i.result_type?));
        match pointer.map(|i| &i.operands[..]) {
            Some(&[Operand::StorageClass(class), Operand::IdRef(pointee)]) => Ok((class, pointee)),
            _ => Err(format!("variable %{variable} has no pointer type")),
        }
    }

    /// Returns the size of a type with an explicit layout (bytes).
    fn size(&self, id: u32) -> Result<u32, String> {
        let unknown = || format!("push constants of an unknown type %{id}");
        let instruction = self.ids.get(&id).ok_or_else(unknown)?;
        match (instruction.class.opcode, &instruction.operands[..]) {
            (Op::TypeInt | Op::TypeFloat, [Operand::LiteralBit32(bits), ..]) => Ok(bits / 8),
            (Op::TypeVector, &[Operand::IdRef(element), Operand::LiteralBit32(count)]) => {
                Ok(self.size(element)? * count)
            }
            (Op::TypeArray, &[Operand::IdRef(element), Operand::IdRef(length)]) => {
                let length = self.ids.get(&length).and_then(|i| literal(i.operands.first()?));
                Ok(self.size(element)? * length.ok_or_else(unknown)?)
            }
            (Op::TypeStruct, members) => {
                let mut ends = members.iter().enumerate().map(|(index, member)| {
                    let member = member.id_ref_any().ok_or_else(unknown)?;
                    Ok(self.member_offset(id, index as u32).ok_or_else(unknown)? + self.size(member)?)
                });
                ends.try_fold(0, |largest, end: Result<u32, String>| Ok(largest.max(end?)))
            }
            _ => Err(unknown()),
        }
    }

    fn member_offset(&self, structure: u32, member: u32) -> Option<u32> {
        let offset = Operand::Decoration(Decoration::Offset);
        self.source.annotations.iter().find_map(|i| match &i.operands[..] {
            [Operand::IdRef(id), Operand::LiteralBit32(index), kind, Operand::LiteralBit32(bytes)]
                if i.class.opcode == Op::MemberDecorate
                    && (*id, *index) == (structure, member)
                    && *kind == offset =>
            {
                Some(*bytes)
            }
            _ => None,
        })
    }

    fn decorations(&self, target: u32) -> impl Iterator<Item = &[Operand]> {
        let of_target = move |i: &&Instruction| i.operands.first() == Some(&Operand::IdRef(target));
        let decorations = self.source.annotations.iter().filter(|i| i.class.opcode == Op::Decorate);
        decorations.filter(of_target).map(|i| &i.operands[1..])
    }

    fn name(&self, target: u32) -> Option<&str> {
        self.source.debug_names.iter().find_map(|i| match &i.operands[..] {
            [Operand::IdRef(id), Operand::LiteralString(name)]
                if i.class.opcode == Op::Name && *id == target =>
            {
                Some(name.as_str())
            }
            _ => None,
        })
    }
}

fn literal(operand: &Operand) -> Option<u32> {
    match operand {
        Operand::LiteralBit32(value) => Some(*value),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vulkan::test_module;

    fn names(entry: &EntryPoint) -> Vec<(u32, &str, BindingKind)> {
        entry.bindings.iter().map(|b| (b.binding, b.name.as_str(), b.kind)).collect()
    }

    #[test]
    fn each_entry_point_lists_only_its_own_bindings() {
        let base = Reflection::new("base", &test_module::base()).unwrap();
        let (fill, twice) = (&base.entry_points["fill"], &base.entry_points["twice"]);
        assert_eq!(names(fill), [(0, "values", BindingKind::Buffer)]);
        assert_eq!(names(twice), [(0, "doubled", BindingKind::Buffer), (1, "values", BindingKind::Buffer)]);
        assert_eq!((fill.workgroup_size, fill.push_constant_bytes), (64, 4));
        assert_eq!(fill.bindings[0].stride, 4);
        assert_eq!(twice.push_constant_bytes, 0);
    }

    #[test]
    fn passes_that_share_an_entry_point_are_listed_separately() {
        let mut module = load("base", &test_module::base()).unwrap();
        for operand in module.entry_points.iter_mut().flat_map(|entry| &mut entry.operands) {
            if *operand == Operand::LiteralString("fill".into()) {
                *operand = Operand::LiteralString("pour+fill".into());
            }
        }
        let mut shared = Reflection::from_source("base", &module).unwrap().entry_points;
        let twice = shared.remove("twice").unwrap();
        assert!(!twice.is_joint() && twice.symbol == "twice", "{twice:?}");
        let [fill, pour] = &shared.into_values().collect::<Vec<_>>()[..] else { panic!("two passes") };
        assert_eq!(
            (pour.name.as_str(), pour.pass_index, fill.name.as_str(), fill.pass_index),
            ("pour", 0, "fill", 1)
        );
        assert!(pour.is_joint() && fill.is_joint() && fill.symbol == "pour+fill", "{fill:?}");
        assert_eq!((names(fill), names(pour)), (vec![(0, "values", BindingKind::Buffer)], names(fill)));
    }

    #[test]
    fn structures_and_buffers_have_different_kinds() {
        let module = Reflection::new("rayquery", &test_module::rayquery()).unwrap();
        assert!(module.capabilities.contains(&Capability::RayQueryKHR));
        assert_eq!(
            names(&module.entry_points["trace.points"]),
            [(0, "neighbour_structure", BindingKind::Structure), (1, "values", BindingKind::Buffer)]
        );
    }

    #[test]
    fn errors_of_invalid_modules_contain_their_name() {
        for words in [&[][..], &[1, 2, 3, 4, 5, 6], &test_module::base()[..40]] {
            assert!(Reflection::new("base.spv", words).unwrap_err().to_string().contains("base.spv"));
        }
    }
}
