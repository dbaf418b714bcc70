//! Ray queries of the compiled module. A committed hit is read only where its type is known to be a triangle, a
//! candidate only while the query stands at one. Other reads are undefined in Vulkan, and drivers return stale or wild
//! values.
//!
//! A forward analysis of each function: a fact holds in a block if it holds at the end of all its predecessors. Facts begin at
//! branches on the type or on `OpRayQueryProceedKHR`, and end where the query proceeds, starts anew or is passed on.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rspirv::dr::{Block, Function, Instruction, Module, Operand};
use rspirv::spirv::{Op, Word};

/// Triangle, of `RayQueryCommittedIntersection`; the others are none (0) and generated (2).
const TRIANGLE: u32 = 1;
const TYPES: [u32; 3] = [0, TRIANGLE, 2];
/// Operand `Intersection` of a read of the committed hit.
const COMMITTED: u32 = 1;

/// A fact about a query, identified by its pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fact {
    /// The query stands at a candidate.
    Candidate(Word),
    /// A triangle is committed.
    Triangle(Word),
    /// A result of `OpRayQueryGetIntersectionTypeKHR` or `OpRayQueryProceedKHR` still describes the query.
    Fresh(Word, Word),
}

impl Fact {
    fn query(self) -> Word {
        match self {
            Fact::Candidate(query) | Fact::Triangle(query) | Fact::Fresh(query, _) => query,
        }
    }
}

type Facts = BTreeSet<Fact>;

/// Reads of one kind of data.
#[derive(Debug, Default, PartialEq)]
struct Reads {
    count: usize,
    /// Reads without a check before them, by function and instruction.
    unguarded: Vec<String>,
}

#[derive(Debug, Default, PartialEq)]
struct Found {
    committed: Reads,
    candidates: Reads,
}

/// A value that depends on the committed type alone: the value for each type, and the query.
struct OfType {
    query: Word,
    result: Word,
    values: [Option<u32>; 3],
}

/// A function with lookup tables of its instructions and blocks.
struct Flow<'a> {
    function: &'a Function,
    constants: &'a BTreeMap<Word, u32>,
    results: BTreeMap<Word, &'a Instruction>,
    /// Labels of the blocks that lead to a block.
    predecessors: BTreeMap<Word, BTreeSet<Word>>,
}

fn id(instruction: &Instruction, operand: usize) -> Option<Word> {
    instruction.operands.get(operand)?.id_ref_any()
}

fn label(block: &Block) -> Word {
    block.label_id().expect("blocks have labels")
}

/// Labels of the blocks that a block leads to.
fn successors(block: &Block) -> Vec<Word> {
    let Some(last) = block.instructions.last() else { return Vec::new() };
    let from = match last.class.opcode {
        Op::Branch => 0,
        Op::BranchConditional | Op::Switch => 1,
        _ => return Vec::new(),
    };
    last.operands[from..].iter().filter_map(Operand::id_ref_any).collect()
}

/// Label that a switch takes for this value of its selector.
fn target(switch: &Instruction, value: u32) -> Option<Word> {
    let cases = switch.operands[2..].chunks_exact(2);
    let case = cases.into_iter().find(|case| case[0] == Operand::LiteralBit32(value));
    case.map_or(id(switch, 1), |case| case[1].id_ref_any())
}

impl<'a> Flow<'a> {
    fn new(function: &'a Function, constants: &'a BTreeMap<Word, u32>) -> Flow<'a> {
        let instructions = function.blocks.iter().flat_map(|block| &block.instructions);
        let results =
            instructions.filter_map(|instruction| Some((instruction.result_id?, instruction))).collect();
        let mut predecessors = BTreeMap::<Word, BTreeSet<Word>>::new();
        for block in &function.blocks {
            for successor in successors(block) {
                predecessors.entry(successor).or_default().insert(label(block));
            }
        }
        Flow { function, constants, results, predecessors }
    }

    fn block(&self, block_label: Word) -> Option<&'a Block> {
        self.function.blocks.iter().find(|block| label(block) == block_label)
    }

    /// A value as a function of the committed type: the type itself, or a constant for each type by a switch.
    fn of_type(&self, value: Word) -> Option<OfType> {
        let instruction = *self.results.get(&value)?;
        match instruction.class.opcode {
            Op::RayQueryGetIntersectionTypeKHR if self.is_committed(instruction) => {
                let query = id(instruction, 0)?;
                Some(OfType { query, result: value, values: TYPES.map(Some) })
            }
            Op::Phi => {
                // All predecessors are cases of one switch on the type.
                let pairs: Vec<(Word, Word)> = instruction
                    .operands
                    .chunks_exact(2)
                    .filter_map(|pair| Some((pair[0].id_ref_any()?, pair[1].id_ref_any()?)))
                    .collect();
                let heads: BTreeSet<Word> = pairs
                    .iter()
                    .flat_map(|(_, from)| self.predecessors.get(from))
                    .flatten()
                    .copied()
                    .collect();
                let mut heads = heads.into_iter();
                let (Some(head), None) = (heads.next(), heads.next()) else { return None };
                let switch = self.block(head)?.instructions.last()?;
                if switch.class.opcode != Op::Switch {
                    return None;
                }
                let selector = self.of_type(id(switch, 0)?)?;
                let values = selector.values.map(|value| {
                    let to = target(switch, value?)?;
                    let (constant, _) = pairs.iter().find(|(_, from)| *from == to)?;
                    self.constants.get(constant).copied()
                });
                Some(OfType { values, ..selector })
            }
            _ => None,
        }
    }

    fn is_committed(&self, read: &Instruction) -> bool {
        id(read, 1).and_then(|id| self.constants.get(&id)) == Some(&COMMITTED)
    }

    /// Facts that a condition implies when it has this value, as far as its sources are fresh.
    fn implied(&self, condition: Word, holds: bool, facts: &Facts) -> Facts {
        let none = Facts::new();
        let Some(&instruction) = self.results.get(&condition) else { return none };
        match instruction.class.opcode {
            Op::LogicalNot => id(instruction, 0).map_or(none, |inner| self.implied(inner, !holds, facts)),
            Op::RayQueryProceedKHR if holds => match id(instruction, 0) {
                Some(query) if facts.contains(&Fact::Fresh(query, condition)) => {
                    Facts::from([Fact::Candidate(query)])
                }
                _ => none,
            },
            Op::IEqual | Op::INotEqual => {
                let (Some(a), Some(b)) = (id(instruction, 0), id(instruction, 1)) else { return none };
                let sides = [(a, b), (b, a)].into_iter();
                let known = sides.filter_map(|(a, b)| Some((self.of_type(a)?, *self.constants.get(&b)?)));
                let equals = holds == (instruction.class.opcode == Op::IEqual);
                // Keep the types that agree with the condition; an unknown value may be anything.
                let implied = known.filter(|(by_type, value)| {
                    let remains = |(_, found): &(u32, Option<u32>)| {
                        found.is_none_or(|found| (found == *value) == equals)
                    };
                    let all = TYPES.into_iter().zip(by_type.values);
                    all.filter(remains).map(|(kind, _)| kind).eq([TRIANGLE])
                        && facts.contains(&Fact::Fresh(by_type.query, by_type.result))
                });
                implied.map(|(by_type, _)| Fact::Triangle(by_type.query)).collect()
            }
            _ => none,
        }
    }

    /// Facts at the end of a block, for each of its successors; counts reads into `found`.
    fn run(&self, block: &Block, mut facts: Facts, found: &mut Found) -> Vec<(Word, Facts)> {
        let name = self.function.def_id().unwrap_or(0);
        for instruction in &block.instructions {
            let query = id(instruction, 0);
            match (instruction.class.opcode, query, instruction.result_id) {
                (Op::RayQueryInitializeKHR | Op::RayQueryTerminateKHR, Some(query), _) => {
                    facts.retain(|fact| fact.query() != query);
                }
                (Op::RayQueryProceedKHR, Some(query), Some(result)) => {
                    facts.retain(|fact| fact.query() != query);
                    facts.insert(Fact::Fresh(query, result));
                }
                // From here on another hit is committed.
                (
                    Op::RayQueryConfirmIntersectionKHR | Op::RayQueryGenerateIntersectionKHR,
                    Some(query),
                    _,
                ) => {
                    facts.retain(|fact| fact.query() != query || *fact == Fact::Candidate(query));
                }
                (Op::RayQueryGetIntersectionTypeKHR, Some(query), Some(result))
                    if self.is_committed(instruction) =>
                {
                    facts.insert(Fact::Fresh(query, result));
                }
                (opcode, Some(query), _) if reads_intersection(opcode) => {
                    let (reads, needs) = if self.is_committed(instruction) {
                        (&mut found.committed, Fact::Triangle(query))
                    } else {
                        (&mut found.candidates, Fact::Candidate(query))
                    };
                    reads.count += 1;
                    if !facts.contains(&needs) {
                        reads.unguarded.push(format!("{opcode:?} of %{query} in function %{name}"));
                    }
                }
                (Op::FunctionCall | Op::Store | Op::CopyMemory, ..) => {
                    let passed: Vec<Word> =
                        instruction.operands.iter().filter_map(Operand::id_ref_any).collect();
                    facts.retain(|fact| !passed.contains(&fact.query()));
                }
                _ => {}
            }
        }
        let last = block.instructions.last();
        let branch = last.filter(|last| last.class.opcode == Op::BranchConditional);
        let to = successors(block);
        match branch.and_then(|branch| id(branch, 0)) {
            // A branch with one target for both outcomes implies nothing.
            Some(condition) if to[0] != to[1] => [(to[0], true), (to[1], false)]
                .map(|(to, holds)| (to, &facts | &self.implied(condition, holds, &facts)))
                .to_vec(),
            _ => to.into_iter().map(|to| (to, facts.clone())).collect(),
        }
    }

    /// Counts the function's reads.
    fn count(&self, found: &mut Found) {
        let Some(entry) = self.function.blocks.first() else { return };
        // Nothing is known at the entry; elsewhere everything is, until a predecessor does not know it.
        let mut at = BTreeMap::from([(label(entry), Facts::new())]);
        let mut left = vec![label(entry)];
        while let Some(block) = left.pop().and_then(|next| self.block(next)) {
            let facts = at[&label(block)].clone();
            for (to, facts) in self.run(block, facts, &mut Found::default()) {
                let known = at.get(&to);
                let both = known.map_or(facts.clone(), |known| known & &facts);
                if known != Some(&both) {
                    at.insert(to, both);
                    left.push(to);
                }
            }
        }
        // Skip blocks that no block leads to: they never run.
        for block in &self.function.blocks {
            if let Some(facts) = at.get(&label(block)) {
                self.run(block, facts.clone(), found);
            }
        }
    }
}

/// Whether an instruction reads data that only one kind of intersection has.
fn reads_intersection(opcode: Op) -> bool {
    let name = format!("{opcode:?}");
    name.starts_with("RayQueryGetIntersection") && opcode != Op::RayQueryGetIntersectionTypeKHR
}

/// All reads of a module.
fn reads(module: &Module) -> Found {
    let constant = |instruction: &Instruction| match (instruction.class.opcode, instruction.operands.first())
    {
        (Op::Constant, Some(Operand::LiteralBit32(value))) => Some((instruction.result_id?, *value)),
        _ => None,
    };
    let constants = module.types_global_values.iter().filter_map(constant).collect();
    let mut found = Found::default();
    for function in &module.functions {
        Flow::new(function, &constants).count(&mut found);
    }
    found
}

fn module() -> Module {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernels/rayquery.spv");
    rspirv::dr::load_bytes(std::fs::read(file).expect("the committed module")).expect("a module")
}

#[test]
fn every_read_of_a_ray_query_hit_follows_a_check_of_its_type() {
    let Found { committed, candidates } = reads(&module());
    println!("{} reads of what is committed, {} of candidates", committed.count, candidates.count);
    assert!(committed.count > 10 && candidates.count > 10, "the test has nothing to check");
    assert_eq!([committed.unguarded, candidates.unguarded], [const { Vec::<String>::new() }; 2]);
}

/// Changes the instructions of a copy of the module, and counts reads without a check before them.
fn unguarded(change: impl Fn(&mut Block)) -> [usize; 2] {
    let mut module = module();
    module.functions.iter_mut().flat_map(|function| &mut function.blocks).for_each(change);
    let Found { committed, candidates } = reads(&module);
    [committed.unguarded.len(), candidates.unguarded.len()]
}

#[test]
fn detects_reads_with_a_missing_or_wrong_check() {
    let all = reads(&module());
    let all = [all.committed.count, all.candidates.count];
    let swaps = |last: &mut Instruction| last.operands.swap(1, 2);

    // Swap the targets of every branch.
    let swapped = unguarded(|block| {
        let last = block.instructions.last_mut();
        last.filter(|last| last.class.opcode == Op::BranchConditional).into_iter().for_each(swaps);
    });
    assert_eq!(swapped, all);

    // Let the query proceed once more between check and reads.
    let proceeded = unguarded(|block| {
        let is_read = |instruction: &Instruction| reads_intersection(instruction.class.opcode);
        let Some(read) = block.instructions.iter().position(is_read) else { return };
        let query = block.instructions[read].operands[0].clone();
        let again = Instruction::new(Op::RayQueryProceedKHR, Some(1), Some(u32::MAX), vec![query]);
        block.instructions.insert(read, again);
    });
    assert_eq!(proceeded, all);

    // Check the types of candidates in place of those of committed hits: any operand other than the constant 1.
    let other = unguarded(|block| {
        for instruction in &mut block.instructions {
            if instruction.class.opcode == Op::RayQueryGetIntersectionTypeKHR {
                instruction.operands[1] = Operand::IdRef(0);
            }
        }
    });
    assert_eq!(other, [all[0], 0]);
}
