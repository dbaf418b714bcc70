//! Pastes commands into the shells of this machine, through pseudoterminals.

use std::io::{Read, Write};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::Child;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use pty_process::blocking::{Command, Pty, open};

use super::*;

/// Maximum wait for a shell.
const PATIENCE: Duration = Duration::from_secs(60);
/// File that a successful attack creates.
const OWNED: &str = "OWNED";

/// Names that run `touch OWNED` if quoting fails, and some that are hard to quote.
const NAMES: [&[u8]; 26] = [
    b"a\x03\ntouch OWNED\n#",
    b"a\x1b[201~\x03\ntouch OWNED\n#",
    b"\x1b[201~\ntouch OWNED\n",
    b"\ntouch OWNED\n",
    b"a'\rtouch OWNED\r'",
    b"\x15touch OWNED\x0a",
    b"\x1ctouch OWNED\x0a\x04",
    b"\x18\x05\x1b#\x0f\x0etouch OWNED\x0d",
    // Ctrl-J and Ctrl-M with the eighth bit: in the locale C, Readline reads them as keys with Alt.
    b"\x8a\x8addi touch OWNED\x8a\x8d",
    "\u{85}touch OWNED\u{85}\u{9b}201~\u{2028}touch OWNED\u{2029}".as_bytes(),
    "\u{202e}DENWO hcuot\u{2066}\u{200b}\u{feff}\u{e0041}\u{3164}".as_bytes(),
    "K\u{fc}che \u{4e16}\u{754c} \u{1f600}".as_bytes(),
    b"\xff\xfe\xc3",
    b"'; touch OWNED; '",
    b"\"; touch OWNED; \"",
    b"\\'; touch OWNED; #",
    b"it's $(touch OWNED)",
    b"it's `touch OWNED`",
    b"$(touch OWNED)",
    b"!touch !! !$ it's !-1",
    b"it's a camera",
    b"-e; touch OWNED",
    b"=touch",
    b"#touch OWNED",
    b"~ * ? [a] {b,c} <d >e |f &g (h)",
    b"",
];

/// A shell in a terminal.
#[derive(Clone, Copy, Debug)]
struct Shell {
    words: &'static [&'static str],
    /// `TERM` of the terminal. Readline brackets pastes unless it is `dumb`.
    terminal: &'static str,
    locale: &'static str,
    /// Whether the terminal brackets pastes for shells that request it.
    brackets: bool,
    /// Whether the shell reads `$'...'`.
    reads_escapes: bool,
}

/// Quotes a word in single quotes, which keep control characters.
fn in_single_quotes(name: &[u8]) -> Vec<u8> {
    let name = name.iter().flat_map(|byte| match byte {
        b'\'' => b"'\\''".to_vec(),
        _ => vec![*byte],
    });
    [b"'".to_vec(), name.collect(), b"'".to_vec()].concat()
}

impl Shell {
    /// Returns the shells of this machine. bash and sh are required.
    fn all() -> Vec<Shell> {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let is_there = |name: &str| std::env::split_paths(&path).any(|folder| folder.join(name).is_file());
        let known: [(&[&str], bool); 4] = [
            (&["bash", "--norc", "--noprofile", "-i"], true),
            (&["bash", "--norc", "--noprofile", "--noediting", "-i"], true),
            (&["sh", "-i"], false),
            (&["zsh", "-f", "-i"], true),
        ];
        assert!(is_there("bash") && is_there("sh"));
        let mut shells = Vec::new();
        for (words, reads_escapes) in known.into_iter().filter(|(words, _)| is_there(words[0])) {
            for (terminal, brackets) in [("xterm", true), ("xterm", false), ("dumb", false)] {
                for locale in ["C", "C.UTF-8"] {
                    shells.push(Shell { words, terminal, locale, brackets, reads_escapes });
                }
            }
        }
        shells
    }

    /// Starts the shell in a folder and waits for its prompt.
    fn open(self, folder: &Path) -> Session {
        let (terminal, slave) = open().unwrap();
        let path = std::env::var_os("PATH").unwrap_or_default();
        let command = Command::new(self.words[0]).args(&self.words[1..]).current_dir(folder).env_clear();
        let command = command.envs([("TERM", self.terminal), ("LC_ALL", self.locale), ("PS1", "READY> ")]);
        let child = command.env("PATH", path).env("HOME", folder).spawn(slave).unwrap();
        let terminal = Arc::new(terminal);
        let (send, shown) = channel();
        let reader = Arc::clone(&terminal);
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            // Reading fails once the terminal's program has ended.
            while let Ok(count @ 1..) = (&*reader).read(&mut bytes) {
                let _ = send.send(bytes[..count].to_vec());
            }
        });
        let mut session = Session { shell: self, child, terminal, shown, is_asked: false };
        let seen = session.wait_for(b"READY> ");
        session.is_asked = seen.windows(8).any(|window| window == b"\x1b[?2004h");
        session
    }
}

/// Running shell in a terminal.
struct Session {
    shell: Shell,
    child: Child,
    terminal: Arc<Pty>,
    shown: Receiver<Vec<u8>>,
    /// Whether the shell has requested bracketed pastes.
    is_asked: bool,
}

impl Session {
    /// Waits for a text in the terminal's output and returns all output until then.
    fn wait_for(&mut self, text: &[u8]) -> Vec<u8> {
        let (mut seen, end) = (Vec::new(), Instant::now() + PATIENCE);
        while !seen.windows(text.len()).any(|window| window == text) {
            match self.shown.recv_timeout(end.saturating_duration_since(Instant::now())) {
                Ok(bytes) => seen.extend(bytes),
                Err(_) => panic!("{:?}: {:?} never comes", self.shell, String::from_utf8_lossy(&seen)),
            }
        }
        seen
    }

    fn paste(&mut self, line: &[u8]) {
        let brackets: [&[u8]; 2] = [b"\x1b[200~", b"\x1b[201~"];
        let [before, after] = if self.shell.brackets && self.is_asked { brackets } else { [&b""[..]; 2] };
        (&*self.terminal).write_all(&[before, line, after, b"\n"].concat()).unwrap();
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns the file `got.ID`, into which a pasted line redirects the output of `printf`.
fn got(folder: &Path, id: usize) -> Vec<u8> {
    std::fs::read(folder.join(format!("got.{id}"))).unwrap_or_default()
}

#[test]
fn a_name_in_single_quotes_runs_code_when_it_is_pasted() {
    // Attack bash and sh, to show that the tests below would detect an injection.
    for shell in Shell::all().into_iter().filter(|shell| ["bash", "sh"].contains(&shell.words[0])) {
        let folder = tempfile::tempdir().unwrap();
        let mut session = shell.open(folder.path());
        session.paste(&[&b"printf %s "[..], &in_single_quotes(NAMES[1])].concat());
        let end = Instant::now() + PATIENCE;
        while !folder.path().join(OWNED).exists() {
            assert!(Instant::now() < end, "{shell:?}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

#[test]
fn a_quoted_name_that_is_pasted_runs_nothing_and_arrives_byte_for_byte() {
    for shell in Shell::all() {
        let folder = tempfile::tempdir().unwrap();
        let mut session = shell.open(folder.path());
        for (id, name) in NAMES.into_iter().enumerate() {
            let word = quoted(OsStr::from_bytes(name)).unwrap();
            // The terminal's echo of the line contains the first text of `printf`, not the second.
            session.paste(format!("printf %s -- {word} >got.{id}; printf 'do%s' ne.{id}.").as_bytes());
            session.wait_for(format!("done.{id}.").as_bytes());
            let arrived = got(folder.path(), id);
            let is_whole = arrived == [b"--", name].concat();
            // A shell without `$'...'` reads another word, which names no file.
            let is_another = !shell.reads_escapes && word.starts_with('$') && arrived.starts_with(b"--$");
            assert!(is_whole || is_another, "{shell:?}: {word}: {:?}", String::from_utf8_lossy(&arrived));
        }
        assert!(!folder.path().join(OWNED).exists(), "{shell:?}");
    }
}

#[test]
fn random_words_are_printable_ascii_and_arrive_byte_for_byte() {
    // A linear congruential generator [Knuth, MMIX].
    let mut state = 1_u64;
    let mut random = |bound: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % bound
    };
    let rare = b"'\"\\$`!\n\t\r\x03\x1b\x7f -=#~";
    let mut word = || -> Vec<u8> {
        let (length, kind) = (random(24), random(3));
        let byte = |_| match kind {
            0 => 1 + random(255) as u8,
            1 => rare[random(rare.len())],
            _ => b' ' + random(95) as u8,
        };
        (0..length).map(byte).collect()
    };
    let words: Vec<Vec<u8>> = (0..4000).map(|_| word()).collect();
    for name in ["bash", "zsh", "mksh", "ksh93"] {
        let mut script = String::from("printf '%s\\0'");
        for word in &words {
            let quoted = quoted(OsStr::from_bytes(word)).unwrap();
            assert!(quoted.bytes().all(|byte| (b' '..=b'~').contains(&byte)), "{quoted:?}");
            script += &format!(" {quoted}");
        }
        let output = match std::process::Command::new(name).args(["-c", &script]).output() {
            Err(error) if name != "bash" && error.kind() == std::io::ErrorKind::NotFound => continue,
            output => output.unwrap(),
        };
        let arrived: Vec<&[u8]> = output.stdout.split(|byte| *byte == 0).collect();
        assert_eq!(arrived.len(), words.len() + 1, "{name}");
        for (arrived, word) in arrived.iter().zip(&words) {
            assert_eq!(arrived, word, "{name}");
        }
    }
}

#[test]
fn words_get_the_weakest_quotes_that_protect_them() {
    for (word, text) in [
        ("main", "main"),
        ("scenes/a-b_c.glb", "scenes/a-b_c.glb"),
        ("0.5,-1,+2", "0.5,-1,+2"),
        ("", "''"),
        ("=ls", "'=ls'"),
        ("#1", "'#1'"),
        ("Camera 1", "'Camera 1'"),
        ("a & b", "'a & b'"),
        ("it's", "\"it's\""),
        ("it's $5", r"$'it\047s $5'"),
        ("a\\b", r"$'a\134b'"),
        ("wow!", r"$'wow\041'"),
        ("a\n7", r"$'a\0127'"),
        ("\u{fc}", r"$'\303\274'"),
    ] {
        assert_eq!(quoted(word).as_deref(), Some(text));
    }
    assert_eq!(quoted("a\0b"), None);
}

#[test]
fn names_that_begin_with_a_dash_are_no_options() {
    assert_eq!(option("camera", "main").as_deref(), Some("--camera main"));
    assert_eq!(option("camera", "--force").as_deref(), Some("--camera=--force"));
    assert_eq!(option("camera", "-\n").as_deref(), Some(r"--camera=$'-\012'"));
    assert_eq!(path("-x.glb").as_deref(), Some("./-x.glb"));
    assert_eq!(path("/a b").as_deref(), Some("'/a b'"));
}

#[test]
fn a_commit_is_7_to_64_hexadecimal_digits() {
    for hash in ["303b2dc", &"a".repeat(40), &"0".repeat(64)] {
        assert_eq!(commit(hash), Some(hash));
    }
    for text in ["", "303b2d", "main; touch OWNED #", "-303b2dc", "303b2dc ", "303b2dg", &"0".repeat(65)] {
        assert_eq!(commit(text), None, "{text:?}");
    }
}
