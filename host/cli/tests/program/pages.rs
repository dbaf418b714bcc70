//! `completions` and `man`: options for shells and for man.

use std::path::Path;
use std::process::Command;

use crate::test_dir::TestDir;

/// Completions of bash for the last of some words.
fn offered(script: &Path, words: &[&str]) -> String {
    let (last, index) = (words[words.len() - 1], words.len() - 1);
    let (words, before) = (words.join(" "), words[index - 1]);
    let run = format!(
        "source {}; COMP_WORDS=({words}); COMP_CWORD={index}; _caustics caustics '{last}' '{before}'; echo \"${{COMPREPLY[@]}}\"",
        script.display()
    );
    let output = Command::new("bash").args(["--norc", "-c", &run]).output().unwrap();
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn shells_complete_commands_options_and_values() {
    let dir = TestDir::new();
    dir.write("caustics.bash", dir.succeeds(&["completions", "bash"]).stdout);
    let script = dir.path("caustics.bash");
    assert_eq!(offered(&script, &["caustics", "ren"]).trim(), "render");
    assert_eq!(offered(&script, &["caustics", "render", "--light-p"]).trim(), "--light-paths");
    assert_eq!(offered(&script, &["caustics", "render", "--aov", "al"]).trim(), "albedo");
    for shell in ["zsh", "fish", "elvish", "powershell"] {
        let script = dir.succeeds(&["completions", shell]).stdout;
        assert!(script.contains("light-paths"), "{shell}");
    }
    dir.refuses(&["completions", "sh"], 2, &["fish"]);
}

#[test]
fn every_command_has_a_man_page() {
    let dir = TestDir::new();
    assert_eq!(dir.succeeds(&["man", "share/man1"]).stdout, "");
    let page = |name: &str| std::fs::read_to_string(dir.path("share/man1").join(name)).unwrap();
    assert!(page("caustics.1").contains("caustics\\-render(1)"));
    assert!(page("caustics-render.1").contains("\\-\\-light\\-paths"));
    assert!(page("caustics-scene-info.1").contains("\\-\\-json"));
    // Pages are written all or none, and none is overwritten.
    std::fs::remove_file(dir.path("share/man1/caustics.1")).unwrap();
    dir.refuses(&["man", "share/man1"], 2, &["--force"]);
    assert!(!dir.path("share/man1/caustics.1").exists());
    dir.succeeds(&["man", "share/man1", "--force"]);
    assert!(page("caustics.1").contains("caustics"));
}
