//! Applies messages of a page from bytes, for the target `message` of `fuzz/` and for tests that replay its corpus.

use caustics::exposure::Exposure;
use caustics::scene::CameraChoice;
use caustics_bench::limits::{check_rays, check_size};
use caustics_bench::run_config::RunConfig;
use caustics_kernels::method::basic::BASIC;

use super::look::{Layer, Look};
use super::request::{Against, MAX_EDITS, Message, NodeEdits, RATES, ViewRequest};

fn start() -> ViewRequest {
    let run_config = RunConfig::new(&BASIC);
    ViewRequest {
        camera: CameraChoice::default(),
        at: 0.0,
        time: 0.0,
        playing: None,
        size: [960, 540],
        target_fps: 30.0,
        run_configs: [run_config.clone(), run_config],
        against: Against::Nothing,
        look: Look { layer: Layer::Beauty, exposure: Exposure::Stops(0.0) },
        moves_until: None,
        nodes: NodeEdits::default(),
        records: false,
        paused: false,
    }
}

/// Returns the number of messages that are accepted, one per line. The view request stays one that can be rendered,
/// whatever the bytes.
pub fn take(bytes: &[u8]) -> usize {
    let mut request = start();
    let mut taken = 0;
    for line in bytes.split(|&byte| byte == b'\n') {
        let message = Message::parse(line);
        taken += usize::from(message.is_ok_and(|message| request.take(&message).is_ok()));
        let line = String::from_utf8_lossy(line);
        let [width, height] = request.size;
        assert!(check_size(width, height).is_ok(), "{line}");
        assert!(
            request
                .run_configs
                .iter()
                .all(|run_config| check_rays(&run_config.config, width, height).is_ok()),
            "{line}"
        );
        assert!(request.nodes.len() <= MAX_EDITS && request.time.is_finite(), "{line}");
        assert!(RATES.contains(&request.target_fps), "{line}");
    }
    taken
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Number of random changes to each file of the corpus.
    const DEALS: u32 = 2000;

    /// Names and contents of the files in `fuzz/corpus/message`.
    fn corpus() -> Vec<(String, Vec<u8>)> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/message");
        let mut files: Vec<_> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        let name = |path: &Path| path.file_stem().unwrap().to_string_lossy().into_owned();
        files.iter().map(|path| (name(path), std::fs::read(path).unwrap())).collect()
    }

    #[test]
    fn messages_of_the_corpus_are_taken_or_refused_as_their_files_say() {
        for (name, bytes) in corpus() {
            let lines = bytes.split(|&byte| byte == b'\n').filter(|line| !line.is_empty()).count();
            let taken = take(&bytes);
            match &name[..] {
                name if name.starts_with("whole") => assert_eq!(taken, lines, "{name}"),
                name if name.starts_with("broken") => assert_eq!(taken, 0, "{name}"),
                // Files found by cargo-fuzz may be accepted or refused.
                _ => {}
            }
        }
    }

    #[test]
    fn changed_messages_are_taken_or_refused_without_a_panic() {
        let mut corpus = corpus();
        corpus.retain(|(name, _)| name.starts_with("whole") || name.starts_with("broken"));
        let pieces: Vec<&[u8]> = corpus
            .iter()
            .flat_map(|(_, bytes)| bytes.split(|byte| b":,\n".contains(byte)))
            .chain([
                &b"1e999"[..],
                b"-1",
                b"18446744073709551616",
                b"4294967295",
                b"null",
                b"[[[[",
                b"\"\\ud800\"",
                b"1e-320",
            ])
            .collect();
        let mut state = 1_u64;
        let mut next = |below: usize| {
            // Linear congruential generator [Knuth 1997, MMIX].
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below.max(1)
        };
        let mut taken = 0;
        for (_, bytes) in &corpus {
            for _ in 0..DEALS {
                let mut bytes = bytes.clone();
                for _ in 0..1 + next(4) {
                    let start = next(bytes.len() + 1);
                    let end = (start + next(12)).min(bytes.len());
                    match next(3) {
                        0 => drop(bytes.drain(start..end)),
                        1 => bytes[start..end].iter_mut().for_each(|byte| *byte ^= 1 << next(8)),
                        _ => drop(bytes.splice(start..end, pieces[next(pieces.len())].iter().copied())),
                    }
                }
                taken += take(&bytes);
            }
        }
        assert!(taken > 1000, "only {taken} changed messages are taken");
    }
}
