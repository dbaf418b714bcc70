//! Figures that most drivers report, under each driver's names.

use caustics::vulkan::executable::{Executable, StatisticValue};
use serde::Serialize;

/// Costs of a program; of several programs of one pipeline, the worst. None where the driver does not report them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Registers per invocation.
    pub registers: Option<u64>,
    /// Registers that were spilled.
    pub spilled: Option<u64>,
    /// Memory for spilled registers and arrays (bytes): per subgroup on AMD, per invocation elsewhere.
    pub scratch_bytes: Option<u64>,
    /// Concurrent subgroups per SIMD unit.
    pub waves: Option<u64>,
    /// Machine code (bytes).
    pub code_bytes: Option<u64>,
}

/// Names in Mesa's RADV, AMD's own driver, NVIDIA's driver and Mesa's ANV.
const REGISTERS: [&str; 4] = ["VGPRs", "NumUsedVgprs", "Register Count", "GRF registers"];
const SPILLED: [&str; 2] = ["Spilled VGPRs", "Spill count"];
const SCRATCH: [&str; 4] =
    ["Scratch size", "ScratchMemUsageInBytes", "Local Memory Size", "Scratch Memory Size"];
const WAVES: [&str; 1] = ["Subgroups per SIMD"];
const CODE: [&str; 2] = ["Code size", "Binary Size"];

impl Figures {
    /// Returns the figures of all programs of a pipeline.
    pub fn from_executables(executables: &[Executable]) -> Figures {
        let all = |names: &[&str]| -> Vec<u64> {
            let statistics = executables.iter().flat_map(|executable| &executable.statistics);
            let known = statistics.filter(|s| names.iter().any(|name| name.eq_ignore_ascii_case(&s.name)));
            let count = |value| match value {
                StatisticValue::Count(count) => Some(count),
                StatisticValue::Integer(count) => u64::try_from(count).ok(),
                StatisticValue::Flag(_) | StatisticValue::Number(_) => None,
            };
            known.filter_map(|statistic| count(statistic.value)).collect()
        };
        let largest = |names: &[&str]| all(names).into_iter().max();
        Figures {
            registers: largest(&REGISTERS),
            spilled: largest(&SPILLED),
            // NVIDIA's driver sets bit 36 of this value; mask it off.
            scratch_bytes: largest(&SCRATCH).map(|bytes| bytes & u64::from(u32::MAX)),
            waves: all(&WAVES).into_iter().min(),
            code_bytes: largest(&CODE),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics::vulkan::executable::Statistic;

    fn executable(statistics: &[(&str, StatisticValue)]) -> Executable {
        let statistics =
            statistics.iter().map(|&(name, value)| Statistic { name: name.into(), value }).collect();
        Executable { name: "compute".into(), subgroup_size: 32, statistics }
    }

    #[test]
    fn known_names_are_read_and_others_ignored() {
        let radv = executable(&[
            ("SGPRs", StatisticValue::Count(128)),
            ("VGPRs", StatisticValue::Count(144)),
            ("Spilled VGPRs", StatisticValue::Count(0)),
            ("Scratch size", StatisticValue::Count(16384)),
            ("Subgroups per SIMD", StatisticValue::Count(7)),
            ("Code size", StatisticValue::Count(51234)),
            ("Latency", StatisticValue::Number(0.5)),
        ]);
        let figures = Figures {
            registers: Some(144),
            spilled: Some(0),
            scratch_bytes: Some(16384),
            waves: Some(7),
            code_bytes: Some(51234),
        };
        assert_eq!(Figures::from_executables(&[radv]), figures);
        assert_eq!(Figures::from_executables(&[]), Figures::default());
        let nvidia = executable(&[("Local Memory Size", StatisticValue::Count((1 << 36) + 2160))]);
        assert_eq!(Figures::from_executables(&[nvidia]).scratch_bytes, Some(2160));
        let odd =
            executable(&[("VGPRs", StatisticValue::Integer(-1)), ("Code size", StatisticValue::Flag(true))]);
        assert_eq!(Figures::from_executables(&[odd]), Figures::default());
    }

    #[test]
    fn of_several_programs_the_worst_counts() {
        let wide = executable(&[
            ("Register Count", StatisticValue::Integer(64)),
            ("Subgroups per SIMD", StatisticValue::Count(8)),
        ]);
        let narrow = executable(&[
            ("Register Count", StatisticValue::Integer(96)),
            ("Subgroups per SIMD", StatisticValue::Count(5)),
        ]);
        let figures = Figures::from_executables(&[wide, narrow]);
        assert_eq!((figures.registers, figures.waves), (Some(96), Some(5)));
    }
}
