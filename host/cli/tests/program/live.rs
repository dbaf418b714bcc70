//! Display of an image while it converges: `--refresh` and `--tev`.

use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use caustics::image_file::Channels;

use crate::test_dir::{BINARY, Run, TestDir};

const VIEW: [&str; 8] = ["render", "mirror-room", "--width", "32", "--height", "18", "--runner", "cpu"];
const PIXELS: usize = 32 * 18;

/// Runs a render to its end.
fn run(dir: &TestDir, options: &[&str]) -> Run {
    let mut command = dir.command(&[&VIEW, options].concat());
    Run::from_output(command.env("SOURCE_DATE_EPOCH", "0").output().unwrap())
}

/// Runs a render, which must end with this exit code and print every word to stderr.
#[track_caller]
fn refuses(dir: &TestDir, options: &[&str], code: i32, words: &[&str]) {
    run(dir, options).expect_refusal(options, code, words);
}

/// A process that ends with its test.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn the_png_is_whole_during_the_run_and_changes_no_bit() {
    let dir = TestDir::new();
    let endless = ["-o", "endless.exr", "--png", "endless.png", "--refresh", "0", "--frames", "1000000"];
    let mut command = Command::new(BINARY);
    command.current_dir(dir.folder()).args(VIEW).args(endless).stderr(Stdio::piped());
    let mut child = Ended(command.env("SOURCE_DATE_EPOCH", "0").spawn().unwrap());
    let (path, begin) = (dir.path("endless.png"), Instant::now());
    let mut seen = Vec::<Vec<u8>>::new();
    while seen.len() < 4 {
        assert!(begin.elapsed() < Duration::from_secs(120), "{} images", seen.len());
        assert!(child.0.try_wait().unwrap().is_none(), "it is not done");
        if let Ok(bytes) = std::fs::read(&path)
            && seen.last() != Some(&bytes)
        {
            assert_eq!(Channels::decode(&bytes).unwrap().width, 32);
            seen.push(bytes);
        }
    }
    drop(child);

    let finite = |name: &str, options: &[&str]| {
        let (exr, png) = (format!("{name}.exr"), format!("{name}.png"));
        let files = ["-o", &exr, "--png", &png, "--frames", "3"];
        run(&dir, &[&files, options].concat()).expect_success(options);
        [exr, png].map(|file| std::fs::read(dir.path(&file)).unwrap())
    };
    assert!(finite("plain", &[]) == finite("shown", &["--refresh", "0"]));

    for (options, words) in
        [(&["--refresh", "1"][..], "--png or --tev"), (&["--png", "a.png", "--refresh", "-1"], "--refresh")]
    {
        refuses(&dir, &[&["-o", "a.exr"], options].concat(), 2, &[words]);
    }
    // A PNG of another origin is not overwritten either.
    refuses(&dir, &["-o", "b.exr", "--png", "plain.png", "--refresh", "0"], 2, &["--force"]);
}

/// A packet as tev reads it, in the order of its fields (tev: include/tev/Ipc.h, src/Ipc.cpp).
struct Packet(std::vec::IntoIter<u8>);

impl Packet {
    /// Reads the next packet of a connection: its length, which counts itself, and its contents.
    fn read(stream: &mut TcpStream) -> Option<Packet> {
        let mut length = [0; 4];
        stream.read_exact(&mut length).ok()?;
        let mut bytes = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut bytes).ok()?;
        Some(Packet(bytes.into_iter()))
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        std::array::from_fn(|_| self.0.next().expect("the packet goes on"))
    }

    fn int(&mut self) -> i32 {
        i32::from_le_bytes(self.bytes())
    }

    fn long(&mut self) -> i64 {
        i64::from_le_bytes(self.bytes())
    }

    fn text(&mut self) -> String {
        String::from_utf8(self.0.by_ref().take_while(|byte| *byte != 0).collect()).unwrap()
    }

    fn texts(&mut self, count: i32) -> Vec<String> {
        (0..count).map(|_| self.text()).collect()
    }
}

/// Reads the packets of a run, which must create an image and then update its pixels. Returns the pixels of each update,
/// three values a pixel.
fn images(stream: &mut TcpStream) -> Vec<Vec<f32>> {
    let mut created = Packet::read(stream).expect("a packet");
    assert_eq!((created.bytes(), created.bytes()), ([4], [1]), "a new image comes to the front");
    assert_eq!((created.text().as_str(), created.int(), created.int()), ("a.exr", 32, 18));
    let count = created.int();
    assert_eq!((created.texts(count), created.0.len()), (["R", "G", "B"].map(String::from).to_vec(), 0));
    let mut images = Vec::new();
    while let Some(mut update) = Packet::read(stream) {
        assert_eq!((update.bytes(), update.bytes()), ([6], [0]), "an updated image does not");
        assert_eq!((update.text().as_str(), update.int()), ("a.exr", 3));
        assert_eq!(update.texts(3), ["R", "G", "B"]);
        assert_eq!([(); 4].map(|()| update.int()), [0, 0, 32, 18]);
        assert_eq!([(); 6].map(|()| update.long()), [0, 1, 2, 3, 3, 3]);
        assert_eq!(update.0.len(), 3 * PIXELS * 4);
        images.push((0..3 * PIXELS).map(|_| f32::from_le_bytes(update.bytes())).collect());
    }
    images
}

#[test]
fn tev_receives_the_image_while_it_converges() {
    let dir = TestDir::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let viewer = thread::spawn(move || images(&mut listener.accept().unwrap().0));
    let options = ["-o", "a.exr", "--frames", "3", "--tev", &address, "--refresh", "0"];
    run(&dir, &options).expect_success(&options);
    let images = viewer.join().unwrap();
    // Updates come after each frame, and at the end.
    assert_eq!(images.len(), 4);
    assert!(images[0] != images[1] && images[1] != images[2] && images[2] == images[3]);
    let file = Channels::read(&dir.path("a.exr")).unwrap();
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        assert!(images[3].iter().skip(channel).step_by(3).eq(&file.channels[name]), "{name}");
    }
}

#[test]
fn a_missing_viewer_is_an_error_and_a_lost_one_ends_no_run() {
    let dir = TestDir::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let viewer = thread::spawn(move || {
        let mut stream = listener.accept().unwrap().0;
        Packet::read(&mut stream).expect("a packet");
    });
    let options = ["-o", "a.exr", "--frames", "40", "--tev", &address, "--refresh", "0"];
    let run = run(&dir, &options);
    viewer.join().unwrap();
    let stderr = run.expect_success(&options).stderr;
    assert!(stderr.contains("tev is sent no more"), "{stderr}");
    assert!(dir.path("a.exr").exists());
    // The viewer has gone.
    refuses(&dir, &["-o", "b.exr", "--tev", &address], 1, &["start tev"]);
    assert!(!dir.path("b.exr").exists());
}
