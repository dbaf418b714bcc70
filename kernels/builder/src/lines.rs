//! The compiler drops debug lines, and leaves instructions that end them: one in fifty bytes, which say nothing.

use anyhow::{Context, ensure};
use rspirv::spirv::Op;

/// Words before the first instruction of a module.
const HEADER: usize = 5;

/// The module without `OpNoLine`.
pub fn without(module: &[u8]) -> anyhow::Result<Vec<u8>> {
    let (header, mut rest) = split(module, 4 * HEADER)?;
    let mut kept = header.to_vec();
    while !rest.is_empty() {
        let first = u32::from_le_bytes(split(rest, 4)?.0.try_into()?);
        let (instruction, behind) = split(rest, 4 * (first >> 16) as usize)?;
        if first & 0xffff != Op::NoLine as u32 {
            kept.extend(instruction);
        }
        rest = behind;
    }
    Ok(kept)
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
    fn all_else_stays_as_it_is() {
        let header = [0x0723_0203, 0x0001_0500, 0, 9, 0];
        let no_line = 1 << 16 | Op::NoLine as u32;
        let (label, other) = ([2 << 16 | Op::Label as u32, no_line], [3 << 16 | Op::Name as u32, 7, no_line]);
        let module = [&header[..], &other, &[no_line], &label, &[no_line, no_line]].concat();
        let expected = [&header[..], &other, &label].concat();
        assert_eq!(without(&bytes(&module)).expect("a module"), bytes(&expected));
    }

    #[test]
    fn what_ends_too_early_is_refused() {
        let header = [0x0723_0203, 0x0001_0500, 0, 9, 0];
        for rest in [&[3 << 16 | Op::Name as u32, 7][..], &[0]] {
            assert!(without(&bytes(&[&header[..], rest].concat())).is_err());
        }
        assert!(without(&bytes(&header[..3])).is_err());
        assert_eq!(without(&bytes(&header)).expect("an empty module"), bytes(&header));
    }
}
