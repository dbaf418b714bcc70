//! `caustics view` from outside: access control, and pages that misbehave.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use super::bad_input::Scene;
use crate::test_dir::{BINARY, Run, TestDir};

const TOKEN: &str = "0123456789abcdef0123456789abcdef";
/// Maximum wait of a test.
const PATIENCE: Duration = Duration::from_secs(60);

/// A program that serves a page, and ends with its test.
struct Program {
    child: Child,
    port: u16,
    stderr: Arc<Mutex<String>>,
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Program {
    fn start() -> Program {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        Program::serve(Command::new(BINARY).current_dir(root), "mirror-room")
    }

    /// Serves a scene with a command that starts the program.
    fn serve(command: &mut Command, scene: &str) -> Program {
        let options = ["--port", "0", "--width", "32", "--height", "18", "--runner", "cpu"];
        let mut child = command
            .args(["view", scene])
            .args(options)
            .env("CAUSTICS_VIEW_TOKEN", TOKEN)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap());
        let mut stderr = String::new();
        let port = loop {
            let from = stderr.len();
            assert!(lines.read_line(&mut stderr).unwrap() > 0, "no address in {stderr:?}");
            let port = stderr[from..].split("127.0.0.1:").nth(1).and_then(|rest| rest.split('/').next());
            if let Some(port) = port {
                break port.parse().unwrap();
            }
        };
        // Keep reading stderr, so that the program never blocks.
        let stderr = Arc::new(Mutex::new(stderr));
        let more = Arc::clone(&stderr);
        std::thread::spawn(move || {
            for line in lines.lines().map_while(Result::ok) {
                *more.lock().unwrap() += &(line + "\n");
            }
        });
        Program { child, port, stderr }
    }

    /// Returns the program's stderr so far.
    fn stderr(&self) -> String {
        self.stderr.lock().unwrap().clone()
    }

    fn stream(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Returns status and head of the answer to a request.
    fn get(&self, path: &str, headers: &[(&str, &str)]) -> (u16, String) {
        let mut stream = self.stream();
        let mut request = format!("GET {path} HTTP/1.1\r\nConnection: close\r\n");
        for (name, value) in headers {
            request += &format!("{name}: {value}\r\n");
        }
        stream.write_all((request + "\r\n").as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let answer = String::from_utf8_lossy(&answer).into_owned();
        (answer.split(' ').nth(1).unwrap().parse().unwrap(), answer)
    }

    /// Opens the connection of a page, or returns the status of the refusal.
    fn page(&self, query: &str, origin: Option<&str>) -> Result<Page, u16> {
        let mut request =
            format!("ws://127.0.0.1:{}/connection{query}", self.port).into_client_request().unwrap();
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().unwrap());
        }
        match tungstenite::client(request, self.stream()) {
            Ok((socket, _)) => Ok(Page(socket)),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                Err(answer.status().as_u16())
            }
            Err(error) => panic!("{error}"),
        }
    }

    /// Opens a page as a browser does.
    fn own_page(&self) -> Page {
        let origin = format!("http://127.0.0.1:{}", self.port);
        self.page(&format!("?token={TOKEN}"), Some(&origin)).unwrap()
    }
}

/// Client side of a page's connection.
struct Page(WebSocket<TcpStream>);

impl Page {
    fn send(&mut self, word: &Value) {
        self.0.send(Message::text(word.to_string())).unwrap();
    }

    /// Reads messages, and confirms images, until `find` accepts a message.
    fn until<T>(&mut self, mut find: impl FnMut(&Value) -> Option<T>) -> T {
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            match self.0.read().unwrap() {
                Message::Binary(bytes) => {
                    let head = head(&bytes);
                    self.send(&json!({ "do": "shown", "serial": head["serial"] }));
                }
                Message::Text(text) => {
                    if let Some(found) = find(&serde_json::from_str(&text).unwrap()) {
                        return found;
                    }
                }
                _ => {}
            }
        }
        panic!("nothing is found");
    }

    /// Returns head and bytes of the next image.
    fn image(&mut self) -> (Value, Vec<u8>) {
        loop {
            if let Message::Binary(bytes) = self.0.read().unwrap() {
                let head = head(&bytes);
                self.send(&json!({ "do": "shown", "serial": head["serial"] }));
                let start = 4 + u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
                return (head, bytes[start..].to_vec());
            }
        }
    }

    /// Returns the message of the next error.
    fn error(&mut self) -> String {
        self.until(|word| (word["is"] == "error").then(|| word["what"].as_str().unwrap().to_string()))
    }
}

fn head(bytes: &[u8]) -> Value {
    let size = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[4..4 + size]).unwrap()
}

#[test]
fn requests_without_the_token_or_from_other_pages_are_refused() {
    let program = Program::start();
    let host = format!("127.0.0.1:{}", program.port);
    let own = [("Host", &*host)];
    let (status, page) = program.get(&format!("/?token={TOKEN}"), &own);
    assert_eq!(status, 200);
    let page_lower = page.to_lowercase();
    for header in [
        "content-security-policy: default-src 'none'",
        "cache-control: no-store",
        "referrer-policy: no-referrer",
    ] {
        assert!(page_lower.contains(header), "{header}");
    }
    let zeros = "0".repeat(TOKEN.len());
    for path in ["/", "/?token=", &format!("/?token={zeros}"), "/image.exr", "/connection"] {
        let (status, answer) = program.get(path, &own);
        assert_eq!(status, 403, "{path}");
        assert!(!answer.contains(TOKEN) && !answer.contains("canvas"), "{answer}");
    }
    for path in
        ["/../../etc/passwd", "/..%2f..%2fetc/passwd", "//etc/passwd", "/scenes/mirror-room/scene.gltf"]
    {
        assert_eq!(program.get(&format!("{path}?token={TOKEN}"), &own).0, 404, "{path}");
    }
    for other in ["evil.example", "evil.example:80", "127.0.0.1.evil.example"] {
        assert_eq!(program.get(&format!("/?token={TOKEN}"), &[("Host", other)]).0, 421, "{other}");
    }
    let crossed = [own[0], ("Origin", "http://evil.example")];
    assert_eq!(program.get(&format!("/?token={TOKEN}"), &crossed).0, 403);
    let long = "a".repeat(1 << 20);
    let (status, _) = program.get(&format!("/?token={TOKEN}"), &[own[0], ("X-Long", &long)]);
    assert!((400..500).contains(&status), "{status}");

    let origin = format!("http://{host}");
    let token = format!("?token={TOKEN}");
    assert!(program.page(&token, Some(&origin)).is_ok());
    for (query, origin) in [
        ("", Some(&*origin)),
        (&*format!("?token={zeros}"), Some(&*origin)),
        (&token, Some("http://evil.example")),
        (&token, Some("null")),
        (&token, None),
    ] {
        assert_eq!(program.page(query, origin).err(), Some(403), "{query} {origin:?}");
    }
}

#[test]
fn pages_that_misbehave_are_answered_and_the_others_go_on() {
    let program = Program::start();
    let mut controller = program.own_page();
    assert!(controller.until(|word| (word["is"] == "control").then(|| word["has_control"] == true)));

    for (wrong, what) in [
        ("", "unknown message"),
        ("{", "unknown message"),
        ("[]", "unknown message"),
        (r#"{"do":"shutdown"}"#, "unknown message"),
        (r#"{"do":"look","from":[0,0,0],"look_at":[0,0,1e999],"fov":40}"#, "unknown message"),
        (r#"{"do":"look","from":[0,0,0],"look_at":[0,0,1],"fov":0}"#, "fov 0"),
        (r#"{"do":"time","seconds":1,"playing":1}"#, "unknown message"),
        (r#"{"do":"axis","side":0,"key":"nothing","value":"1"}"#, "no parameter"),
        (r#"{"do":"axis","side":2,"key":"method","value":"basic"}"#, "two sides"),
        (r#"{"do":"axis","side":0,"key":"method","value":"magic"}"#, "no method is called magic"),
        (r#"{"do":"axis","side":0,"key":"paths_per_pixel","value":"1e9"}"#, "paths/px"),
        (r#"{"do":"size","width":0,"height":1}"#, "each side"),
        (r#"{"do":"size","width":16384,"height":16384}"#, "area"),
        (r#"{"do":"rate","fps":-1}"#, "frames a second"),
        (r#"{"do":"exposure","stops":"bright"}"#, "stops"),
    ] {
        controller.0.send(Message::text(wrong)).unwrap();
        let error = controller.error();
        assert!(error.contains(what), "{wrong}: {error}");
    }
    // A camera that looks at its own position fails; the next camera works.
    controller.send(&json!({ "do": "look", "from": [0, 1, 0], "look_at": [0, 1, 0], "fov": 40 }));
    let failure = controller.until(|word| word["failure"].as_str().map(String::from));
    assert!(failure.contains("looks at where it is"), "{failure}");
    controller.send(&json!({ "do": "camera", "name": "main" }));
    controller.until(|word| {
        (word["is"] == "status" && word["failure"].is_null() && word["moves"] == false).then_some(())
    });

    // A page without control cannot steer. A message that is too long closes its page, and a page that never reads harms no
    // other.
    let mut onlooker = program.own_page();
    onlooker.send(&json!({ "do": "size", "width": 64, "height": 36 }));
    assert!(onlooker.error().contains("another page has control"));
    let long = format!(r#"{{"do":"camera","name":"{}"}}"#, "a".repeat(1 << 20));
    let _ = onlooker.0.send(Message::text(long));
    let end = Instant::now() + PATIENCE;
    while onlooker.0.read().is_ok() {
        assert!(Instant::now() < end, "the page is not closed");
    }
    let _deaf = program.own_page();

    // The last of many view requests counts.
    for step in 1..=3000 {
        let x = 0.0001 * f64::from(step);
        controller.send(&json!({ "do": "look", "from": [x, 1.5, 2.0], "look_at": [0, 1, 0], "fov": 40 }));
    }
    let from = controller.until(|word| {
        let is_still = word["is"] == "status" && word["moves"] == false && word["failure"].is_null();
        word["camera"]["from"][0].as_f64().filter(|x| is_still && (x - 0.3).abs() < 1e-6)
    });
    assert!((from - 0.3).abs() < 1e-6);
    let (head, bytes) = controller.image();
    assert_eq!((head["width"].as_u64(), head["height"].as_u64()), (Some(32), Some(18)));
    assert!(!bytes.is_empty());
}

#[test]
fn taken_ports_and_invalid_options_are_errors() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let dir = TestDir::new();
    let run = |options: &[&str], token: &str| {
        let mut command = dir.command(&[&["view", "mirror-room"], options].concat());
        Run::from_output(command.env("CAUSTICS_VIEW_TOKEN", token).output().unwrap())
    };
    let options = ["--port", &port];
    run(&options, TOKEN).expect_refusal(&options, 1, &[&format!("--port {port}")]);
    for (options, token, what) in [
        (&["--target-fps", "0"][..], TOKEN, "--target-fps 0"),
        (&["--width", "0"], TOKEN, "--width 0"),
        (&["--time", "NaN"], TOKEN, "--time NaN"),
        (&[], "short", "CAUSTICS_VIEW_TOKEN"),
        (&["--camera", "nobody", "--port", "0"], TOKEN, "nobody"),
    ] {
        run(options, token).expect_refusal(options, 2, &[what]);
    }
}

/// Returns the command that a page of a scene copies once there is an image; none where no command exists.
fn command_of(scene: &Scene) -> Option<String> {
    let mut command = Command::new(BINARY);
    let program = Program::serve(command.current_dir(scene.write().dir.folder()), "scene.gltf");
    program.own_page().until(|word| {
        let is_there =
            word["is"] == "status" && word["moves"] == false && word["image"]["samples"].as_u64() > Some(0);
        is_there.then(|| word["command"].as_str().map(String::from))
    })
}

#[test]
#[cfg(unix)]
fn a_copied_command_says_the_name_of_a_hostile_camera_and_runs_nothing_else() {
    for name in
        ["a\u{3}\ntouch OWNED\n#", "it's '; touch OWNED; $(touch OWNED) \\'; touch OWNED #", "--force"]
    {
        let mut scene = Scene::new("ring");
        scene.json["cameras"][0]["name"] = json!(name);
        for node in scene.json["nodes"].as_array_mut().unwrap() {
            if node["camera"] == 0 {
                node["name"] = json!(name);
            }
        }
        let command = command_of(&scene).unwrap();
        assert!(command.bytes().all(|byte| (b' '..=b'~').contains(&byte)), "{command:?}");
        let run = |line: String| {
            let path = Path::new(BINARY).parent().unwrap();
            let path = format!("{}:{}", path.display(), std::env::var("PATH").unwrap());
            Command::new("bash")
                .args(["-c", &line])
                .current_dir(scene.dir.folder())
                .env("PATH", path)
                .output()
                .unwrap()
        };
        // Read the arguments as the program gets them.
        let arguments = run(format!("caustics() {{ printf '%s\\0' \"$@\"; }}; {command}")).stdout;
        let arguments = String::from_utf8(arguments).unwrap();
        let arguments: Vec<&str> = arguments.split('\0').collect();
        let joined = format!("--camera={name}");
        let is_named = |pair: &[&str]| pair == ["--camera", name] || pair[0] == joined;
        assert!(arguments.windows(2).any(is_named), "{arguments:?}");
        let render = run(command);
        assert!(render.status.success(), "{}", String::from_utf8_lossy(&render.stderr));
        assert!(scene.dir.path("image.exr").exists() && !scene.dir.path("OWNED").exists());
    }
    // No argument can hold a NUL, and another name would be another camera.
    let mut scene = Scene::new("ring");
    scene.json["cameras"][0]["name"] = json!("main\0");
    for node in scene.json["nodes"].as_array_mut().unwrap() {
        if node["camera"] == 0 {
            node["name"] = json!("main\0");
        }
    }
    assert_eq!(command_of(&scene), None);
}

/// Whether the other side has closed a connection.
fn is_closed(mut stream: &TcpStream) -> bool {
    stream.set_nonblocking(true).unwrap();
    let read = stream.read(&mut [0; 1024]);
    stream.set_nonblocking(false).unwrap();
    match read {
        Ok(count) => count == 0,
        Err(error) => error.kind() != std::io::ErrorKind::WouldBlock,
    }
}

fn wait_for(what: &str, mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !holds() {
        assert!(Instant::now() < end, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn idle_connections_without_a_token_keep_no_page_out_and_are_closed() {
    // This process holds one end of each connection too.
    rlimit::increase_nofile_limit(4096).unwrap();
    let program = Program::start();
    let mut first = program.own_page();
    first.image();
    // The renderer works in single precision.
    let is_at = |word: &Value, z: f64| word["camera"]["from"][2].as_f64().filter(|is| (is - z).abs() < 1e-6);
    let mut idle: Vec<TcpStream> = (0..1100).map(|_| program.stream()).collect();
    for (id, mut stream) in idle.iter().enumerate().skip(1080) {
        // Some connections send an incomplete head. Writing fails on a connection that is already closed.
        let _ = stream.write_all(format!("GET /?{id} HTTP/1.1\r\nHost: ").as_bytes());
    }
    // The open page continues, and another one opens.
    first.send(&json!({ "do": "look", "from": [0, 1.5, 2], "look_at": [0, 1, 0], "fov": 40 }));
    first.until(|word| is_at(word, 2.0));
    let host = format!("127.0.0.1:{}", program.port);
    assert_eq!(program.get(&format!("/?token={TOKEN}"), &[("Host", &host)]).0, 200);
    program.own_page().image();
    wait_for("at most 64 stay", || idle.iter().filter(|stream| !is_closed(stream)).count() <= 64);
    idle.drain(..idle.len() - 64);
    wait_for("none stays that says nothing", || idle.iter().all(is_closed));
    first.send(&json!({ "do": "look", "from": [0, 1.5, 3], "look_at": [0, 1, 0], "fov": 40 }));
    first.until(|word| is_at(word, 3.0));
    assert_eq!(program.stderr().matches("have not shown the token").count(), 1, "{}", program.stderr());
}

#[test]
#[cfg(unix)]
fn a_page_opens_while_connections_take_all_files_that_may_be_open() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut shell = Command::new("sh");
    shell.current_dir(root).args(["-c", "ulimit -n 48; exec \"$0\" \"$@\"", BINARY]);
    let program = Program::serve(&mut shell, "mirror-room");
    let idle: Vec<TcpStream> = (0..100).map(|_| program.stream()).collect();
    wait_for("it says so", || program.stderr().contains("cannot be accepted"));
    program.own_page().image();
    assert_eq!(program.stderr().matches("cannot be accepted").count(), 1, "{}", program.stderr());
    drop(idle);
}

#[test]
fn a_refused_request_ends_its_connection_and_no_body_is_waited_for() {
    let program = Program::start();
    let right = format!("/?token={TOKEN}");
    for (path, method, status) in [
        ("/", "GET", "403"),
        ("/nothing", "GET", "403"),
        ("/connection", "POST", "403"),
        (&*right, "GET", "200"),
        (&*right, "POST", "405"),
    ] {
        let mut stream = program.stream();
        let head =
            format!("{method} {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000000\r\n\r\nsome");
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = Vec::new();
        // Unread data makes the end of the connection an error.
        let _ = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer);
        assert!(answer.starts_with(&format!("HTTP/1.1 {status} ")), "{method} {path}: {answer}");
        wait_for("it is closed", || is_closed(&stream));
    }
}

#[test]
#[cfg(unix)]
fn a_signal_ends_the_program_in_every_state() {
    for (state, signal) in
        [("nobody", "TERM"), ("moving", "TERM"), ("still", "INT"), ("paused", "TERM"), ("records", "HUP")]
    {
        let mut program = Program::start();
        let mut page = (state != "nobody").then(|| program.own_page());
        if let Some(page) = &mut page {
            page.image();
            match state {
                "moving" => page.send(&json!({ "do": "time", "seconds": 0, "playing": true })),
                "paused" => page.send(&json!({ "do": "pause", "paused": true })),
                "records" => page.send(&json!({ "do": "record", "on": true })),
                _ => {}
            }
            page.until(|word| match state {
                "moving" => (word["playing"] == true).then_some(()),
                "paused" => (word["paused"] == true).then_some(()),
                "records" => (word["records"] == true).then_some(()),
                _ => (word["moves"] == false).then_some(()),
            });
        }
        Command::new("sh").args(["-c", &format!("kill -{signal} {}", program.child.id())]).status().unwrap();
        let mut status = None;
        wait_for(state, || {
            status = program.child.try_wait().unwrap();
            status.is_some()
        });
        assert_eq!(status.unwrap().code(), Some(0), "{state}");
    }
}

#[test]
fn a_recording_holds_what_changed_and_is_read_again() {
    let program = Program::start();
    let mut page = program.own_page();
    page.send(&json!({ "do": "record", "on": true }));
    for step in 0..20 {
        let x = 0.1 * f64::from(step);
        page.send(&json!({ "do": "look", "from": [x, 1.5, 2], "look_at": [0, 1, 0], "fov": 40 }));
        page.until(|word| word["camera"]["from"][0].as_f64().filter(|is| (is - x).abs() < 1e-6));
    }
    page.until(|word| (word["is"] == "status" && word["moves"] == false).then_some(()));
    let host = format!("127.0.0.1:{}", program.port);
    let (status, answer) = program.get(&format!("/animation.toml?token={TOKEN}"), &[("Host", &host)]);
    assert_eq!(status, 200, "{answer}");
    // The body comes in chunks, each after its length.
    let text: String = answer.split("\r\n\r\n").nth(1).unwrap().split("\r\n").skip(1).step_by(2).collect();
    let edits = caustics::scene::Edits::parse(&text).unwrap();
    assert!((2..=42).contains(&edits.keys.len()), "{text}");
    let cameras: Vec<_> = edits.keys.iter().filter_map(|key| key.camera).collect();
    assert!(cameras.windows(3).all(|three| !(three[0] == three[1] && three[1] == three[2])), "{text}");
}
