//! `completions` and `man`: what shells and man are told of the options.

use std::path::Path;
use std::process::Command;

fn caustics(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_caustics")).current_dir(folder).args(arguments).output().unwrap();
    let text = if output.status.success() { output.stdout } else { output.stderr };
    (output.status.code().unwrap(), String::from_utf8(text).unwrap())
}

/// What bash offers for the last of some words.
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
    let desk = tempfile::tempdir().unwrap();
    let (code, bash) = caustics(desk.path(), &["completions", "bash"]);
    assert_eq!(code, 0);
    let script = desk.path().join("caustics.bash");
    std::fs::write(&script, bash).unwrap();
    assert_eq!(offered(&script, &["caustics", "ren"]).trim(), "render");
    assert_eq!(offered(&script, &["caustics", "render", "--light-p"]).trim(), "--light-paths");
    assert_eq!(offered(&script, &["caustics", "render", "--aov", "al"]).trim(), "albedo");
    for shell in ["zsh", "fish", "elvish", "powershell"] {
        let (code, script) = caustics(desk.path(), &["completions", shell]);
        assert!(code == 0 && script.contains("light-paths"), "{shell}");
    }
    let (code, message) = caustics(desk.path(), &["completions", "sh"]);
    assert!(code == 2 && message.contains("fish"), "{message}");
}

#[test]
fn every_command_has_a_man_page() {
    let desk = tempfile::tempdir().unwrap();
    assert_eq!(caustics(desk.path(), &["man", "share/man1"]), (0, String::new()));
    let page = |name: &str| std::fs::read_to_string(desk.path().join("share/man1").join(name)).unwrap();
    assert!(page("caustics.1").contains("caustics\\-render(1)"));
    assert!(page("caustics-render.1").contains("\\-\\-light\\-paths"));
    assert!(page("caustics-scene-info.1").contains("\\-\\-json"));
    // All or none, and nothing is overwritten.
    std::fs::remove_file(desk.path().join("share/man1/caustics.1")).unwrap();
    let (code, message) = caustics(desk.path(), &["man", "share/man1"]);
    assert!(code == 2 && message.contains("--force"), "{message}");
    assert!(!desk.path().join("share/man1/caustics.1").exists());
    assert_eq!(caustics(desk.path(), &["man", "share/man1", "--force"]).0, 0);
    assert!(page("caustics.1").contains("caustics"));
}
