//! Shards: parts of a run for several processes.

use std::fmt;
use std::ops::Range;

/// Part `index` of `count`, from 0 on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Index of the part.
    pub index: u32,
    /// Number of parts.
    pub count: u32,
}

impl Shard {
    /// The whole run.
    pub const WHOLE: Shard = Shard { index: 0, count: 1 };

    /// Parses a text such as 2/8.
    pub fn parse(text: &str) -> Option<Shard> {
        let (index, count) = text.split_once('/')?;
        let (index, count): (u32, u32) = (index.parse().ok()?, count.parse().ok()?);
        (1..=count).contains(&index).then(|| Shard { index: index - 1, count })
    }

    /// Reads the shard from `--shard i/n`, or else from the environment. A Slurm array sets `SLURM_ARRAY_TASK_ID`, `_MIN`,
    /// `_STEP` and `_COUNT`. With `--shards n`, GNU parallel's `PARALLEL_SEQ` is read too (jobs from 1 on).
    /// Without `--shards`, `PARALLEL_SEQ` is ignored, since parallel sets it for jobs of any kind.
    pub fn find(
        given: Option<&str>,
        count: Option<u32>,
        environment: &dyn Fn(&str) -> Option<String>,
    ) -> Result<Shard, String> {
        if let Some(text) = given {
            let wrong = || format!("--shard {text}: give i/n with i from 1 to n, such as 2/8");
            return Shard::parse(text).ok_or_else(wrong);
        }
        let number = |name: &str| -> Result<Option<u32>, String> {
            let parse = |text: String| text.parse().map_err(|_| format!("{name}={text} is no whole number"));
            environment(name).filter(|text| !text.is_empty()).map(parse).transpose()
        };
        if let Some(id) = number("SLURM_ARRAY_TASK_ID")? {
            let first = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(1);
            let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
            let tasks = number("SLURM_ARRAY_TASK_COUNT")?;
            // Restarted tasks form an array of their own, which counts from its first task.
            if let (Some(count), Some(tasks)) = (count, tasks)
                && count != tasks
            {
                return Err(format!(
                    "--shards {count}: the Slurm array has {tasks} tasks; give --shard $SLURM_ARRAY_TASK_ID/{count}"
                ));
            }
            let count = count.or(tasks).ok_or(
                "SLURM_ARRAY_TASK_ID is set, but SLURM_ARRAY_TASK_COUNT is not: give --shard i/n or --shards n",
            )?;
            let index = id.checked_sub(first).map(|offset| offset / step).filter(|index| *index < count);
            let wrong = || format!("SLURM_ARRAY_TASK_ID={id} is none of {count} tasks from {first} on");
            return index.map(|index| Shard { index, count }).ok_or_else(wrong);
        }
        let Some(count) = count else { return Ok(Shard::WHOLE) };
        match number("PARALLEL_SEQ")? {
            Some(job) if (1..=count).contains(&job) => Ok(Shard { index: job - 1, count }),
            Some(job) => Err(format!("PARALLEL_SEQ={job} is none of --shards {count}")),
            None => Err(format!(
                "--shards {count}: nothing says which one this is; give --shard i/{count}, or run it by GNU parallel or a \
                 Slurm array"
            )),
        }
    }

    /// Returns the shard's name in files. The names sort in the order of the shards.
    pub fn name(&self) -> String {
        let digits = self.count.to_string().len();
        format!("shard-{:0digits$}-of-{}", self.index + 1, self.count)
    }

    /// Whether the shard is a part of a run instead of the whole.
    pub fn is_part(&self) -> bool {
        self.count > 1
    }

    /// Returns the shard's frames of a run. An error if there are fewer frames than parts.
    pub fn frames(&self, all: Range<u32>) -> Result<Range<u32>, String> {
        if self.count as usize > all.len() {
            let (Shard { count, .. }, frames) = (self, all.len());
            return Err(format!(
                "there are {frames} frames for {count} shards; give at most {frames} shards"
            ));
        }
        let part = self.part(all.len());
        Ok(all.start + part.start as u32..all.start + part.end as u32)
    }

    /// Returns the shard's range of a list. Neighbours stay together, since they share references and take turns.
    pub fn part(&self, length: usize) -> Range<usize> {
        let at = |index: u32| (length as u64 * u64::from(index) / u64::from(self.count)) as usize;
        at(self.index)..at(self.index + 1)
    }
}

/// Writes the format that [`Shard::parse`] reads.
impl fmt::Display for Shard {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.index + 1, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn find(given: Option<&str>, count: Option<u32>, set: &[(&str, &str)]) -> Result<Shard, String> {
        let get = |name: &str| set.iter().find(|(known, _)| *known == name).map(|(_, text)| text.to_string());
        Shard::find(given, count, &get)
    }

    #[test]
    fn shards_are_found_in_options_and_environments() {
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "14"),
            ("SLURM_ARRAY_TASK_MIN", "10"),
            ("SLURM_ARRAY_TASK_STEP", "2"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
        ];
        let parallel = [("PARALLEL_SEQ", "3"), ("PARALLEL_JOBSLOT", "1")];
        assert_eq!(find(None, None, &[]), Ok(Shard::WHOLE));
        assert_eq!(Shard::parse("2/3").map(|shard| shard.to_string()).as_deref(), Some("2/3"));
        assert_eq!(Shard { index: 2, count: 100 }.name(), "shard-003-of-100");
        assert_eq!(find(Some("2/3"), None, &slurm), Ok(Shard { index: 1, count: 3 }));
        assert_eq!(find(None, None, &slurm), Ok(Shard { index: 2, count: 4 }));
        assert_eq!(find(None, None, &parallel), Ok(Shard::WHOLE));
        assert_eq!(find(None, Some(4), &parallel), Ok(Shard { index: 2, count: 4 }));
        for (given, count, set) in [
            (Some("0/3"), None, &[][..]),
            (Some("4/3"), None, &[]),
            (Some("1"), None, &[]),
            (None, Some(2), &parallel),
            (None, Some(2), &[]),
            (None, None, &slurm[..1]),
            (None, Some(2), &slurm[..3]),
            (None, Some(8), &slurm),
            (None, None, &[("SLURM_ARRAY_TASK_ID", "x")]),
        ] {
            assert!(find(given, count, set).is_err(), "{given:?} {count:?} {set:?}");
        }
    }

    #[test]
    fn parts_are_disjoint_and_cover_the_list() {
        for length in [0, 1, 7, 64] {
            for count in 1..9 {
                let parts = (0..count).map(|index| Shard { index, count }.part(length));
                assert_eq!(parts.flatten().collect::<Vec<_>>(), (0..length).collect::<Vec<_>>());
                let frames = (0..count).map(|index| Shard { index, count }.frames(10..10 + length as u32));
                match frames.collect::<Result<Vec<_>, _>>() {
                    Ok(parts) => assert!(parts.into_iter().flatten().eq(10..10 + length as u32)),
                    Err(_) => assert!(length < count as usize),
                }
            }
        }
    }
}
