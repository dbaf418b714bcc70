//! Removes output of the compiler that drivers should not read.
//!
//! The compiler drops debug lines, but keeps the instructions that end them: one in fifty bytes, without content. A function that
//! entry points share carries the hint not to inline it, so that the compiler itself does not. NVIDIA's driver obeys that hint
//! and makes code of more than twice the size and time. The code has calls, and every lobe and texture that the scene lacks.

use anyhow::{Context, ensure};
use rspirv::spirv::{FunctionControl, Op};

/// Words before the first instruction of a module.
const HEADER: usize = 5;

/// Returns the module without `OpNoLine`, and with the hint to inline each function that had the opposite hint.
pub fn for_drivers(module: &[u8]) -> anyhow::Result<Vec<u8>> {
    let (header, mut rest) = split(module, 4 * HEADER)?;
    let mut kept = header.to_vec();
    while !rest.is_empty() {
        let first = word(rest)?;
        let (instruction, behind) = split(rest, 4 * (first >> 16) as usize)?;
        rest = behind;
        match Op::from_u32(first & 0xffff) {
            Some(Op::NoLine) => {}
            Some(Op::Function) => {
                // Skip the words of the opcode, the result type and the result id.
                let (start, end) = split(instruction, 12)?;
                let mut control = FunctionControl::from_bits_retain(word(end)?);
                if control.contains(FunctionControl::DONT_INLINE) {
                    control.toggle(FunctionControl::DONT_INLINE | FunctionControl::INLINE);
                }
                kept.extend(start);
                kept.extend(control.bits().to_le_bytes());
                kept.extend(&end[4..]);
            }
            _ => kept.extend(instruction),
        }
    }
    Ok(kept)
}

/// Reads the first word.
fn word(bytes: &[u8]) -> anyhow::Result<u32> {
    Ok(u32::from_le_bytes(split(bytes, 4)?.0.try_into()?))
}

fn split(bytes: &[u8], at: usize) -> anyhow::Result<(&[u8], &[u8])> {
    ensure!(at > 0, "an instruction has no words");
    bytes.split_at_checked(at).context("an instruction ends behind the module")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(words: &[u32]) -> Vec<u8> {
        words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    #[test]
    fn other_instructions_stay_unchanged() {
        let header = [0x0723_0203, 0x0001_0500, 0, 9, 0];
        let no_line = 1 << 16 | Op::NoLine as u32;
        let (label, other) = ([2 << 16 | Op::Label as u32, no_line], [3 << 16 | Op::Name as u32, 7, no_line]);
        let module = [&header[..], &other, &[no_line], &label, &[no_line, no_line]].concat();
        let expected = [&header[..], &other, &label].concat();
        assert_eq!(for_drivers(&bytes(&module)).expect("a module"), bytes(&expected));
    }

    #[test]
    fn shared_functions_ask_to_be_inlined() {
        let function = |control| [5 << 16 | Op::Function as u32, 3, 4, control, 6];
        let module = |shared, own| [&[0; HEADER][..], &function(shared), &function(own)].concat();
        for own in [0, FunctionControl::PURE.bits()] {
            let made = for_drivers(&bytes(&module(FunctionControl::DONT_INLINE.bits() | own, own)));
            let inlined = module(FunctionControl::INLINE.bits() | own, own);
            assert_eq!(made.expect("a module"), bytes(&inlined));
        }
    }

    #[test]
    fn truncated_module_is_refused() {
        let header = [0x0723_0203, 0x0001_0500, 0, 9, 0];
        for rest in [&[3 << 16 | Op::Name as u32, 7][..], &[0], &[2 << 16 | Op::Function as u32, 3]] {
            assert!(for_drivers(&bytes(&[&header[..], rest].concat())).is_err());
        }
        assert!(for_drivers(&bytes(&header[..3])).is_err());
        assert_eq!(for_drivers(&bytes(&header)).expect("an empty module"), bytes(&header));
    }
}
