//! Available memory, and estimates of the memory that parsing takes.

use std::fmt;
use std::path::Path;

/// Memory that estimates may not use (bytes): for stacks of threads and small allocations.
const RESERVE: u64 = 4 << 20;

/// Returns the memory that this process can still take (bytes), less a reserve for small allocations. It is the minimum
/// over the machine, every control group around the process (a container's limit), and the address space. `None` where the
/// system does not report it.
pub fn available() -> Option<u64> {
    available_in(Path::new("/")).map(|bytes| bytes.saturating_sub(RESERVE))
}

/// Returns the memory that a process can still take (bytes), read from the system's files below `root`.
fn available_in(root: &Path) -> Option<u64> {
    let read = |path: &Path| std::fs::read_to_string(root.join(path)).ok();
    let proc = |name: &str| read(&Path::new("proc").join(name));
    let machine = proc("meminfo").and_then(|text| field(&text, "MemAvailable:")).map(|kib| kib << 10);
    let space = proc("self/limits").and_then(|text| field(&text, "Max address space"));
    let mapped = proc("self/status").and_then(|text| field(&text, "VmSize:")).map(|kib| kib << 10);
    let space = space.zip(mapped).map(|(limit, used)| limit.saturating_sub(used));
    let groups = proc("self/cgroup").unwrap_or_default();
    let groups = groups.lines().filter_map(|line| Group::find(line)?.available(&read));
    machine.into_iter().chain(space).chain(groups).min()
}

/// Control group of a process: its path, and the names of its files in this version of the interface.
struct Group<'a> {
    root: &'static str,
    path: &'a Path,
    limit: &'static str,
    used: &'static str,
    /// Page cache, which the kernel reclaims when memory is short.
    files: [&'static str; 2],
}

impl<'a> Group<'a> {
    /// Parses a line of /proc/self/cgroup. `None` unless the line names a group of memory.
    fn find(line: &'a str) -> Option<Group<'a>> {
        let (_, rest) = line.split_once(':')?;
        let (controllers, path) = rest.split_once(':')?;
        let path = Path::new(path.trim_start_matches('/'));
        if controllers.is_empty() {
            let files = ["inactive_file ", "active_file "];
            let (limit, used) = ("memory.max", "memory.current");
            Some(Group { root: "sys/fs/cgroup", path, limit, used, files })
        } else if controllers.split(',').any(|name| name == "memory") {
            let files = ["total_inactive_file ", "total_active_file "];
            let (limit, used) = ("memory.limit_in_bytes", "memory.usage_in_bytes");
            Some(Group { root: "sys/fs/cgroup/memory", path, limit, used, files })
        } else {
            None
        }
    }

    /// Returns the memory that this group and all groups around it leave (bytes). A container sees its own group at the
    /// root, whatever the group's path.
    fn available(&self, read: &impl Fn(&Path) -> Option<String>) -> Option<u64> {
        let left = |path: &Path| {
            let file = |name: &str| read(&Path::new(self.root).join(path).join(name));
            // A version 2 group without a limit says "max".
            let limit: u64 = file(self.limit)?.trim().parse().ok()?;
            let used: u64 = file(self.used)?.trim().parse().ok()?;
            let stat = file("memory.stat").unwrap_or_default();
            let files: u64 = self.files.iter().filter_map(|name| field(&stat, name)).sum();
            Some(limit.saturating_sub(used.saturating_sub(files)))
        };
        self.path.ancestors().filter_map(left).min()
    }
}

/// Returns the number behind a name at the beginning of a line.
pub fn field(text: &str, name: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
    rest.split_whitespace().next()?.parse().ok()
}

/// Budget of memory: the bytes that were available at the start, less the estimates that were taken.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    left: u64,
}

/// Error: an estimate exceeds the available memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Short {
    /// Estimated need (bytes).
    pub needed: u64,
    /// Available memory (bytes).
    pub available: u64,
}

impl Budget {
    /// Starts with all available memory. The budget is unlimited where the system does not report it.
    pub fn new() -> Budget {
        Budget { left: available().unwrap_or(u64::MAX) }
    }

    /// Takes bytes from the budget.
    pub fn take(&mut self, bytes: u64) -> Result<(), Short> {
        let short = Short { needed: bytes, available: self.left };
        self.left = self.left.checked_sub(bytes).ok_or(short)?;
        Ok(())
    }
}

impl Default for Budget {
    fn default() -> Budget {
        Budget::new()
    }
}

impl std::error::Error for Short {}

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of memory, but {} are available", shown(self.needed), shown(self.available))
    }
}

/// Size below which an estimate is not compared with the available memory (bytes). Querying the system takes about 50 us.
const SMALL: u64 = 1 << 18;

/// Checks an estimate of a need (bytes) against the available memory, before anything is allocated.
///
/// # Errors
///
/// If less memory is available. Where the system does not report it, all needs pass.
pub fn check(bytes: u64) -> Result<(), Short> {
    if bytes < SMALL { Ok(()) } else { Budget::new().take(bytes) }
}

/// Memory that a token takes while a text is parsed as TOML (bytes), rounded up. Measured as the growth of a process's peak
/// with texts of one kind of line. The maximum is 115 for dots and 78 for lists of numbers.
const TOML_TOKEN_BYTES: u64 = 120;
/// Memory that a key takes beside its tokens, and each table that dots make (bytes). Measured in the same way: 714 to 927
/// for keys of inline tables, 685 for lines, 895 for headers.
const TOML_TABLE_BYTES: u64 = 930;

/// Upper estimate of the memory that parsing a text as TOML takes (bytes).
pub fn toml_parse_bytes(text: &str) -> u64 {
    let text = text.as_bytes();
    let is_next = |mut at: usize, wanted: u8| {
        while matches!(text.get(at), Some(b' ' | b'\t')) {
            at += 1;
        }
        text.get(at) == Some(&wanted)
    };
    let (mut tables, mut is_header, mut at) = (0, is_next(0, b'['), 0);
    while at < text.len() {
        let start = at;
        let mut dots = 0;
        while at < text.len() && (CLASS[usize::from(text[at])] == WORD || text[at] == b'.') {
            dots += u64::from(text[at] == b'.');
            at += 1;
        }
        if at > start {
            // A number has one dot and is neither a key nor the name of a table.
            let is_number = dots == 1 && matches!(text[start], b'0'..=b'9' | b'+' | b'-');
            tables += if is_number && !is_header && !is_next(at, b'=') { 0 } else { dots };
            continue;
        }
        tables += u64::from(text[at] == b'=');
        at += 1;
        if text[start] == b'\n' {
            is_header = is_next(at, b'[');
        }
    }
    tokens(text) * TOML_TOKEN_BYTES + tables * TOML_TABLE_BYTES + 2 * text.len() as u64
}

/// Memory that a token takes while a text is parsed as JSON of a known structure (bytes), rounded up. Measured as for TOML:
/// at most 36 for lists of numbers and 45 for keys.
const JSON_TOKEN_BYTES: u64 = 50;

/// Upper estimate of the memory that parsing a text as JSON of a known structure takes (bytes).
pub fn json_parse_bytes(text: &[u8]) -> u64 {
    tokens(text) * JSON_TOKEN_BYTES + 2 * text.len() as u64
}

/// Upper estimate of the memory that a text takes as a tree of JSON values (bytes). The smallest node that holds an
/// object's members has 632 bytes, a value 32.
pub fn json_tree_bytes(text: &[u8]) -> u64 {
    let (mut objects, mut values) = (0, 0);
    for byte in text {
        objects += u64::from(*byte == b'{');
        values += u64::from(matches!(byte, b',' | b'['));
    }
    700 * objects + 64 * values + text.len() as u64
}

/// Class of the bytes that form words.
const WORD: u8 = 1;

/// Class of each byte; signs and white space are 0.
const CLASS: [u8; 256] = {
    let mut classes = [WORD; 256];
    let mut byte = 0;
    while byte < 128 {
        let letter = byte as u8;
        let is_word = letter.is_ascii_alphanumeric() || matches!(letter, b'_' | b'-' | b'+');
        classes[byte] = if is_word { WORD } else { 0 };
        byte += 1;
    }
    classes
};

/// Returns the maximum number of tokens of a text: each sign and each word.
fn tokens(text: &[u8]) -> u64 {
    let (mut count, mut before) = (0, 0);
    for &byte in text {
        let class = CLASS[usize::from(byte)];
        // Count a word at its first byte.
        count += u64::from(class != WORD || before != WORD);
        before = class;
    }
    count
}

/// Formats a number of bytes with a unit.
pub fn shown(bytes: u64) -> String {
    match bytes {
        0..0x40_0000 => format!("{} KiB", bytes.div_ceil(1 << 10)),
        0x40_0000..0x1_0000_0000 => format!("{} MiB", bytes >> 20),
        _ => format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the available memory of a machine with these files.
    fn machine(files: &[(&str, &str)]) -> Option<u64> {
        let root = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = root.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        available_in(root.path())
    }

    const MEMINFO: (&str, &str) =
        ("proc/meminfo", "MemTotal: 9000 kB\nMemFree: 1 kB\nMemAvailable: 8000 kB\n");

    #[test]
    fn available_memory_is_the_minimum_of_machine_container_and_address_space() {
        assert_eq!(machine(&[]), None);
        assert_eq!(machine(&[MEMINFO]), Some(8000 << 10));

        let limits =
            ("proc/self/limits", "Limit Soft Hard Units\nMax address space 4096000 unlimited bytes\n");
        let status = ("proc/self/status", "Name: a\nVmPeak: 9 kB\nVmSize:  1000 kB\n");
        assert_eq!(machine(&[MEMINFO, limits, status]), Some(3000 << 10));
        let unlimited = ("proc/self/limits", "Max address space unlimited unlimited bytes\n");
        assert_eq!(machine(&[MEMINFO, unlimited, status]), Some(8000 << 10));
    }

    #[test]
    fn control_groups_of_both_versions_limit_memory_with_all_their_ancestors() {
        let of_v2 = ("proc/self/cgroup", "0::/a/b\n");
        let inner = [
            MEMINFO,
            of_v2,
            ("sys/fs/cgroup/a/b/memory.max", "max\n"),
            ("sys/fs/cgroup/a/b/memory.current", "500\n"),
            ("sys/fs/cgroup/a/memory.max", "3000\n"),
            ("sys/fs/cgroup/a/memory.current", "1000\n"),
            ("sys/fs/cgroup/a/memory.stat", "anon 1\nactive_file 100\ninactive_file 200\n"),
        ];
        assert_eq!(machine(&inner), Some(2300));
        // A container does not see the folder of its group's path.
        let container = [of_v2, ("sys/fs/cgroup/memory.max", "700"), ("sys/fs/cgroup/memory.current", "800")];
        assert_eq!(machine(&container), Some(0));

        let of_v1 = ("proc/self/cgroup", "5:cpu,cpuacct:/x\n4:memory:/docker/x\n");
        let v1 = [
            MEMINFO,
            of_v1,
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "5000"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "4000"),
            ("sys/fs/cgroup/memory/memory.stat", "inactive_file 7\ntotal_inactive_file 300\n"),
        ];
        assert_eq!(machine(&v1), Some(1300));
    }

    #[test]
    fn parse_estimates_count_tokens_tables_and_objects() {
        let [line, dotted, number] = ["a = 1\n", "a.b = 1\n", "a = 0.1\n"].map(toml_parse_bytes);
        assert_eq!(dotted - line, 2 * TOML_TOKEN_BYTES + TOML_TABLE_BYTES + 4);
        assert_eq!(number - line, 2 * TOML_TOKEN_BYTES + 4);
        assert_eq!(
            toml_parse_bytes("[1.1]\n") - toml_parse_bytes("[1]\n"),
            2 * TOML_TOKEN_BYTES + TOML_TABLE_BYTES + 4
        );
        assert!(toml_parse_bytes("x={1.1=0}") > toml_parse_bytes("x=[1.1,0]"));
        assert_eq!(json_parse_bytes(b"[0,0]"), 5 * JSON_TOKEN_BYTES + 10);
        assert_eq!(json_tree_bytes(b"[{},0]"), 700 + 128 + 6);
    }

    #[test]
    fn this_machine_reports_its_memory_and_a_budget_runs_out() {
        #[cfg(target_os = "linux")]
        assert!(available().unwrap() > 1 << 20);
        let mut budget = Budget { left: 10 };
        assert_eq!(budget.take(7), Ok(()));
        assert_eq!(budget.take(4), Err(Short { needed: 4, available: 3 }));
        assert_eq!(budget.take(3), Ok(()));
        assert_eq!((shown(1), shown(5 << 20)), ("1 KiB".into(), "5 MiB".into()));
        assert_eq!(shown(24_400_000_000), "22.7 GiB");
    }
}
