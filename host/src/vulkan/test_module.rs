//! Test modules: SPIR-V assembled by hand, for testing the runner without the kernels; and the rule for skipping.

use rspirv::binary::Assemble;
use rspirv::dr::{Builder, Operand};
use rspirv::spirv::{
    AddressingModel, BuiltIn, Capability, Decoration, ExecutionMode, ExecutionModel, FunctionControl,
    LoopControl, MemoryModel, SelectionControl, StorageClass, Word,
};

use super::error::VulkanError;

/// Prints why a test is skipped. Fails with CAUSTICS_REQUIRE_GPU=1, or if the error is more than an absent device.
pub(crate) fn skip(error: &VulkanError) {
    assert!(error.is_no_device() || matches!(error, VulkanError::NoValidationLayer), "{error}");
    assert!(
        std::env::var("CAUSTICS_REQUIRE_GPU").as_deref() != Ok("1"),
        "CAUSTICS_REQUIRE_GPU=1, but {error}"
    );
    eprintln!("skipped: {error}");
}

/// Returns a module with entry points `fill`: `values[i] = i + dispatch.first + features`, and `twice`:
/// `doubled[i] = 2 values[i]`. The two parameters of `twice` have their binding numbers in reverse order.
pub(crate) fn base() -> Vec<u32> {
    let mut assembler = Assembler::new(false);
    let values_at_0 = assembler.buffer("values", 0);
    let values_at_1 = assembler.buffer("values", 1);
    let doubled = assembler.buffer("doubled", 0);
    let first = assembler.push_constant(0);
    let features = assembler.features();

    assembler.entry("fill", &[values_at_0, first], |a, index| {
        let (uint, pointer) = (a.uint, a.b.type_pointer(None, StorageClass::PushConstant, a.uint));
        let zero = a.constant(0);
        let address = a.b.access_chain(pointer, None, first, [zero]).unwrap();
        let first = a.b.load(uint, None, address, None, []).unwrap();
        let sum = a.b.i_add(uint, None, index, first).unwrap();
        let sum = a.b.i_add(uint, None, sum, features).unwrap();
        a.store(values_at_0, index, sum);
    });
    assembler.entry("twice", &[values_at_1, doubled], |a, index| {
        let value = a.load(values_at_1, index);
        let sum = a.b.i_add(a.uint, None, value, value).unwrap();
        a.store(doubled, index, sum);
    });
    assembler.b.module().assemble()
}

/// Returns a module with entry points `trace.scene` and `trace.points`, and `fill`, which writes 7. The first two trace a
/// ray along z from (i + 1/2, 1/2, -1):
/// `values[i] = 16 boxes met + kind of the nearest triangle (0: none, 1: there is one)`.
pub(crate) fn rayquery() -> Vec<u32> {
    let mut assembler = Assembler::new(true);
    let values = assembler.buffer("values", 1);
    for (pass, name) in [("trace.scene", "scene_structure"), ("trace.points", "neighbour_structure")] {
        let structure = assembler.structure(name, 0);
        assembler.trace(pass, structure, values);
    }
    assembler.entry("fill", &[values], |a, index| {
        let seven = a.constant(7);
        a.store(values, index, seven);
    });
    assembler.b.module().assemble()
}

struct Assembler {
    b: Builder,
    void: Word,
    boolean: Word,
    uint: Word,
    index: Word,
    block: Word,
}

impl Assembler {
    fn new(hardware: bool) -> Assembler {
        let mut b = Builder::new();
        b.set_version(1, 5);
        b.capability(Capability::Shader);
        b.capability(Capability::VulkanMemoryModel);
        if hardware {
            b.capability(Capability::RayQueryKHR);
            b.extension("SPV_KHR_ray_query");
        }
        b.memory_model(AddressingModel::Logical, MemoryModel::Vulkan);
        let (void, boolean, uint) = (b.type_void(), b.type_bool(), b.type_int(32, 0));
        let vector = b.type_vector(uint, 3);
        let pointer = b.type_pointer(None, StorageClass::Input, vector);
        let index = b.variable(pointer, None, StorageClass::Input, None);
        b.decorate(index, Decoration::BuiltIn, [Operand::BuiltIn(BuiltIn::GlobalInvocationId)]);
        let array = b.type_runtime_array(uint);
        b.decorate(array, Decoration::ArrayStride, [Operand::LiteralBit32(4)]);
        let block = b.type_struct([array]);
        b.decorate(block, Decoration::Block, []);
        b.member_decorate(block, 0, Decoration::Offset, [Operand::LiteralBit32(0)]);
        Assembler { b, void, boolean, uint, index, block }
    }

    fn constant(&mut self, value: u32) -> Word {
        self.b.constant_bit32(self.uint, value)
    }

    fn bound(&mut self, name: &str, binding: u32, class: StorageClass, pointee: Word) -> Word {
        let pointer = self.b.type_pointer(None, class, pointee);
        let variable = self.b.variable(pointer, None, class, None);
        self.b.name(variable, name);
        self.b.decorate(variable, Decoration::DescriptorSet, [Operand::LiteralBit32(0)]);
        self.b.decorate(variable, Decoration::Binding, [Operand::LiteralBit32(binding)]);
        variable
    }

    fn buffer(&mut self, name: &str, binding: u32) -> Word {
        self.bound(name, binding, StorageClass::StorageBuffer, self.block)
    }

    fn structure(&mut self, name: &str, binding: u32) -> Word {
        let structure = self.b.type_acceleration_structure_khr();
        self.bound(name, binding, StorageClass::UniformConstant, structure)
    }

    /// Declares a push constant of one u32 at an offset.
    fn push_constant(&mut self, offset: u32) -> Word {
        let block = self.b.type_struct_id(None, [self.uint]);
        self.b.decorate(block, Decoration::Block, []);
        self.b.member_decorate(block, 0, Decoration::Offset, [Operand::LiteralBit32(offset)]);
        let pointer = self.b.type_pointer(None, StorageClass::PushConstant, block);
        self.b.variable(pointer, None, StorageClass::PushConstant, None)
    }

    fn features(&mut self) -> Word {
        let features = self.b.spec_constant_bit32(self.uint, 0);
        self.b.decorate(features, Decoration::SpecId, [Operand::LiteralBit32(0)]);
        features
    }

    fn element(&mut self, buffer: Word, index: Word) -> Word {
        let pointer = self.b.type_pointer(None, StorageClass::StorageBuffer, self.uint);
        let zero = self.constant(0);
        self.b.access_chain(pointer, None, buffer, [zero, index]).unwrap()
    }

    fn load(&mut self, buffer: Word, index: Word) -> Word {
        let element = self.element(buffer, index);
        self.b.load(self.uint, None, element, None, []).unwrap()
    }

    /// Writes an element if the index is within the buffer.
    fn store(&mut self, buffer: Word, index: Word, value: Word) {
        let length = self.b.array_length(self.uint, None, buffer, 0).unwrap();
        let inside = self.b.u_less_than(self.boolean, None, index, length).unwrap();
        let (write, end) = (self.b.id(), self.b.id());
        self.b.selection_merge(end, SelectionControl::NONE).unwrap();
        self.b.branch_conditional(inside, write, end, []).unwrap();
        self.b.begin_block(Some(write)).unwrap();
        let element = self.element(buffer, index);
        self.b.store(element, value, None, []).unwrap();
        self.b.branch(end).unwrap();
        self.b.begin_block(Some(end)).unwrap();
    }

    /// Adds an entry point with workgroups of 64; `body` receives the index of the invocation.
    fn entry(&mut self, name: &str, interface: &[Word], body: impl FnOnce(&mut Assembler, Word)) {
        let signature = self.b.type_function(self.void, []);
        let function = self.b.begin_function(self.void, None, FunctionControl::NONE, signature).unwrap();
        self.b.begin_block(None).unwrap();
        let vector = self.b.type_vector(self.uint, 3);
        let id = self.b.load(vector, None, self.index, None, []).unwrap();
        let x = self.b.composite_extract(self.uint, None, id, [0]).unwrap();
        let y = self.b.composite_extract(self.uint, None, id, [1]).unwrap();
        let row = self.constant(super::pipeline::INVOCATIONS_PER_ROW);
        let offset = self.b.i_mul(self.uint, None, y, row).unwrap();
        let index = self.b.i_add(self.uint, None, x, offset).unwrap();
        body(self, index);
        self.b.ret().unwrap();
        self.b.end_function().unwrap();
        let interface: Vec<_> = interface.iter().copied().chain([self.index]).collect();
        self.b.entry_point(ExecutionModel::GLCompute, function, name, interface);
        self.b.execution_mode(function, ExecutionMode::LocalSize, [64, 1, 1]);
    }

    fn trace(&mut self, pass: &str, structure: Word, values: Word) {
        // Keep the query in private memory: variables of a function would have to be declared in its first block.
        let query_type = self.b.type_ray_query_khr();
        let query_pointer = self.b.type_pointer(None, StorageClass::Private, query_type);
        let query = self.b.variable(query_pointer, None, StorageClass::Private, None);
        let count_pointer = self.b.type_pointer(None, StorageClass::Private, self.uint);
        let count = self.b.variable(count_pointer, None, StorageClass::Private, None);
        let structure_type = self.b.type_acceleration_structure_khr();
        let float = self.b.type_float(32, None);
        let vector = self.b.type_vector(float, 3);
        let [zero, half, one, far] =
            [0.0f32, 0.5, 1.0, 9.0].map(|value| self.b.constant_bit32(float, value.to_bits()));
        let minus_one = self.b.constant_bit32(float, (-1.0f32).to_bits());

        self.entry(pass, &[structure, values, query, count], |a, index| {
            let [none, first, all, step] = [0, 1, 0xff, 16].map(|value| a.constant(value));
            let x = a.b.convert_u_to_f(float, None, index).unwrap();
            let x = a.b.f_add(float, None, x, half).unwrap();
            let origin = a.b.composite_construct(vector, None, [x, half, minus_one]).unwrap();
            let direction = a.b.composite_construct(vector, None, [zero, zero, one]).unwrap();
            let target = a.b.load(structure_type, None, structure, None, []).unwrap();
            a.b.ray_query_initialize_khr(query, target, none, all, origin, zero, direction, far).unwrap();
            a.b.store(count, none, None, []).unwrap();

            // Count the candidates while the query proceeds.
            let [head, test, body, again, end] = [(); 5].map(|()| a.b.id());
            a.b.branch(head).unwrap();
            a.b.begin_block(Some(head)).unwrap();
            a.b.loop_merge(end, again, LoopControl::NONE, []).unwrap();
            a.b.branch(test).unwrap();
            a.b.begin_block(Some(test)).unwrap();
            let more = a.b.ray_query_proceed_khr(a.boolean, None, query).unwrap();
            a.b.branch_conditional(more, body, end, []).unwrap();
            a.b.begin_block(Some(body)).unwrap();
            let seen = a.b.load(a.uint, None, count, None, []).unwrap();
            let seen = a.b.i_add(a.uint, None, seen, step).unwrap();
            a.b.store(count, seen, None, []).unwrap();
            a.b.branch(again).unwrap();
            a.b.begin_block(Some(again)).unwrap();
            a.b.branch(head).unwrap();
            a.b.begin_block(Some(end)).unwrap();

            let kind = a.b.ray_query_get_intersection_type_khr(a.uint, None, query, first).unwrap();
            let seen = a.b.load(a.uint, None, count, None, []).unwrap();
            let sum = a.b.i_add(a.uint, None, seen, kind).unwrap();
            a.store(values, index, sum);
        });
    }
}
