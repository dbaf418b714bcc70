//! A process with few threads renders with those, or says why it cannot.

use super::{TINY, shell};
use crate::test_dir::{Run, TestDir};

/// Runs a command in 4 GiB of address space, with stacks of this size for its threads (MiB).
fn run_with_stacks(dir: &TestDir, stack: u64, arguments: &str) -> Run {
    let line = format!("ulimit -v 4194304; export RUST_MIN_STACK={}; exec \"$0\" {arguments}", stack << 20);
    shell(dir, &line)
}

/// Sizes of stacks (MiB) of which none, one or two fit.
const STACKS: [u64; 3] = [8192, 2500, 1300];

#[test]
#[cfg(target_os = "linux")]
fn a_process_without_further_threads_computes_with_one() {
    let dir = TestDir::new();
    dir.succeeds(&[&["render", "ring", "-o", "whole.exr"], &TINY[..]].concat());
    for stack in STACKS {
        for threads in [0, 1] {
            let render = format!("render ring -o part.exr --force --threads {threads} {}", TINY.join(" "));
            let run = run_with_stacks(&dir, stack, &render);
            assert_eq!(run.code, Some(0), "{stack} MiB: {}", run.stderr);
            if stack == STACKS[0] {
                assert!(
                    run.stderr.contains("start 0 of") && run.stderr.contains("ulimit -u"),
                    "{}",
                    run.stderr
                );
                assert!(run.stderr.contains("Ctrl-C ends at once"), "{}", run.stderr);
            }
            let compare = "compare part.exr whole.exr --fail-above mse=0";
            let compared = run_with_stacks(&dir, stack, compare);
            assert_eq!(compared.code, Some(0), "{stack} MiB: {}{}", compared.stdout, compared.stderr);
        }
        let info = run_with_stacks(&dir, stack, "scene info ring");
        assert_eq!(info.code, Some(0), "{stack} MiB: {}", info.stderr);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_page_without_threads_names_their_number() {
    let dir = TestDir::new();
    let run = run_with_stacks(&dir, STACKS[0], "view ring --port 0 --runner cpu");
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    for words in ["error: a page takes threads of its own", "start 0 of 7 threads", "pids"] {
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    }
}
