//! How much memory there is, and what would take more.

use std::fmt;
use std::path::Path;

/// Memory that no estimate may give out (bytes): for stacks of threads, and for what is too small to be estimated.
const RESERVE: u64 = 4 << 20;

/// Memory that this process can still take (bytes): of the machine, of every control group around it (a container's limit),
/// and of its address space, without a reserve for small allocations. None where the system does not say.
pub fn available() -> Option<u64> {
    available_in(Path::new("/")).map(|bytes| bytes.saturating_sub(RESERVE))
}

/// Memory that a process can still take (bytes), as a file system with these root folders tells it.
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

/// A control group's path and the names of what it tells, by the version of the interface.
struct Group<'a> {
    root: &'static str,
    path: &'a Path,
    limit: &'static str,
    used: &'static str,
    /// Pages of files, which the kernel takes back when memory is short.
    files: [&'static str; 2],
}

impl<'a> Group<'a> {
    /// The group of a line of /proc/self/cgroup, if it is one of memory.
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

    /// What it and all groups around it leave (bytes). A container sees its own group at the root, whatever its path.
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

/// The number behind a name at the beginning of a line.
pub fn field(text: &str, name: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
    rest.split_whitespace().next()?.parse().ok()
}

/// Memory that was there and is given out by estimates, before any of it is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    left: u64,
}

/// More would be taken than is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Short {
    /// Wanted (bytes).
    pub needed: u64,
    /// Left (bytes).
    pub available: u64,
}

impl Budget {
    /// All that is available; endless where the system does not say.
    pub fn new() -> Budget {
        Budget { left: available().unwrap_or(u64::MAX) }
    }

    /// Gives out some bytes.
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

/// Needs below this are not compared with the memory that is there (bytes): asking the system takes some 50 us.
const SMALL: u64 = 1 << 18;

/// Checks that there are so many bytes, before they are asked for.
///
/// # Errors
///
/// If there are not; where the system does not say, all is let through.
pub fn check(bytes: u64) -> Result<(), Short> {
    if bytes < SMALL { Ok(()) } else { Budget::new().take(bytes) }
}

/// Memory that a token of a text takes while it is read as TOML (bytes). Measured as the growth of the peak of a process with texts
/// of one kind of line: 115 of dots, 78 of lists of numbers, at most.
const TOML_TOKEN_BYTES: u64 = 120;
/// Memory that a key takes beside its tokens, and each table that dots make (bytes). Measured the same way: 714 to 927 of keys of inline
/// tables, 685 of lines, 895 of headers.
const TOML_TABLE_BYTES: u64 = 930;

/// Memory that a text takes while it is read as TOML, at most about (bytes).
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
            // A number has one dot, and is neither a key nor the name of a table.
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

/// Memory that a token of a text takes while it is read as JSON of a known structure (bytes). Measured as that of TOML: 36 of lists of
/// numbers, 45 of keys, at most.
const JSON_TOKEN_BYTES: u64 = 50;

/// Memory that a text takes while it is read as JSON of a known structure, at most about (bytes).
pub fn json_parse_bytes(text: &[u8]) -> u64 {
    tokens(text) * JSON_TOKEN_BYTES + 2 * text.len() as u64
}

/// Memory that a text takes as a tree of all its JSON, at most about (bytes): the least node of the tree that holds an object's members
/// has 632, any value 32.
pub fn json_tree_bytes(text: &[u8]) -> u64 {
    let (mut objects, mut values) = (0, 0);
    for byte in text {
        objects += u64::from(*byte == b'{');
        values += u64::from(matches!(byte, b',' | b'['));
    }
    700 * objects + 64 * values + text.len() as u64
}

/// Class of bytes that words are made of.
const WORD: u8 = 1;

/// Classes of bytes: signs and white space are 0.
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

/// Tokens of a text, at most: each sign, and each word.
fn tokens(text: &[u8]) -> u64 {
    let (mut count, mut before) = (0, 0);
    for &byte in text {
        let class = CLASS[usize::from(byte)];
        // A word begins where none was.
        count += u64::from(class != WORD || before != WORD);
        before = class;
    }
    count
}

/// A number of bytes as people say it.
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

    /// A machine of these files.
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
    fn the_least_of_machine_container_and_address_space_counts() {
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
    fn groups_of_both_versions_count_with_all_around_them() {
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
        // In a container, the group's path is not to be seen.
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
    fn texts_count_by_what_they_make() {
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
    fn this_machine_says_how_much_there_is_and_a_budget_ends() {
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
