//! Files of edits: parsing, round trips to the bit, and refused values.

use super::*;

const FILE: &str = r#"
[camera]
from = [1.5, 1, -3]
look_at = [0, 0.5, 0]
fov = 40

[[nodes]]
node = 3
name = "lamp"
translation = [0.25, 2, 0]

[[nodes]]
node = 5

[[keys]]
time = 0

[[keys.nodes]]
node = 7
rotation = [0, 0, 0, 1]

[[keys]]
time = 1.5
camera = { from = [2, 1, -3], look_at = [0, 0.5, 0], fov = 35 }
nodes = [{ node = 7, rotation = [0, 1, 0, 0], scale = [1, 2, 3] }]
"#;

fn refused(text: &str) -> String {
    Edits::parse(text).unwrap_err().to_string()
}

#[test]
fn file_of_edits_sets_cameras_nodes_and_keys() {
    let edits = Edits::parse(FILE).unwrap();
    let camera = CameraEdit { from: [1.5, 1.0, -3.0], look_at: [0.0, 0.5, 0.0], fov: 40.0 };
    assert_eq!(edits.camera, Some(camera));
    let light = NodeEdit {
        node: 3,
        name: Some("lamp".into()),
        translation: Some([0.25, 2.0, 0.0]),
        ..NodeEdit::default()
    };
    assert_eq!(edits.nodes, [light, NodeEdit { node: 5, ..NodeEdit::default() }]);
    assert_eq!((edits.keys[0].time, &edits.keys[0].camera), (0.0, &None));
    assert_eq!(edits.keys[1].nodes[0].scale, Some([1.0, 2.0, 3.0]));
    assert_eq!(edits.grabbed(), BTreeSet::from([3, 5, 7]));
    assert!(edits.has_camera() && Edits::parse("").unwrap() == Edits::default());
}

#[test]
fn written_edits_are_read_back_to_the_bit() {
    let edits = Edits::parse(FILE).unwrap();
    assert_eq!(Edits::parse(&edits.to_toml().unwrap()).unwrap(), edits);
    // Numbers of all sizes and signs, by a linear congruential generator [Knuth, MMIX].
    let mut state = 1_u64;
    let mut number = || loop {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let value = f64::from_bits(state);
        if value.abs() <= 1e30 {
            return value;
        }
    };
    let special = [0.0, -0.0, 5e-324, f64::MIN_POSITIVE, 1e30, -1e30, 0.1, 1.0 / 3.0, 123_456_789.0];
    let mut values = special.into_iter().chain(std::iter::from_fn(|| Some(number())));
    for _ in 0..400 {
        let mut three = || [0; 3].map(|_| values.next().unwrap());
        let edit =
            NodeEdit { node: 0, translation: Some(three()), scale: Some(three()), ..NodeEdit::default() };
        let edits = Edits { nodes: vec![edit], ..Edits::default() };
        let text = edits.to_toml().unwrap();
        let back = Edits::parse(&text).unwrap();
        let bits = |edits: &Edits| {
            let NodeEdit { translation, scale, .. } = &edits.nodes[0];
            [translation, scale].map(|three| three.unwrap().map(f64::to_bits))
        };
        assert_eq!(bits(&back), bits(&edits), "{text}");
    }
}

#[test]
fn edits_with_values_out_of_range_are_refused() {
    let node = |what: &str| format!("nodes = [{{ node = 1, {what} }}]");
    for (text, words) in [
        (node("translation = [nan, 0, 0]"), "nodes[0] has a number that is not finite"),
        (node("scale = [0, 0, -1e31]"), "nodes[0] has a number that is not finite or beyond 1e30"),
        (node("rotation = [0, 0, 0, 0]"), "nodes[0] has a rotation of no length"),
        (node("translation = [0, 0]"), "translation"),
        (node("translation = [0, 0, 0, 0]"), "invalid length 4, expected an array of 3"),
        (node("scale = [1, 1, 1, 1]"), "invalid length 4"),
        (node("rotation = [0, 0, 0]"), "invalid length 3, expected an array of 4"),
        (node("rotation = [0, 0, 0, 1, 0]"), "invalid length 5"),
        ("camera = { from = [0, 0, 0, 9], look_at = [0, 0, 1], fov = 40 }".into(), "invalid length 4"),
        ("camera = { from = [0, 0, 0], look_at = [0, 0, 1, 9], fov = 40 }".into(), "invalid length 4"),
        (node("turn = 3"), "unknown field `turn`"),
        ("nodes = [{ node = -1 }]".into(), "-1"),
        ("nodes = [{ node = 5000000000 }]".into(), "an index that no node has"),
        ("nodes = [{ node = 1 }, { node = 1 }]".into(), "nodes[1] is of a node that another one is of"),
        ("camera = { from = [0, 0, 0], look_at = [0, 0, 0], fov = 40 }".into(), "looks at where it is"),
        ("camera = { from = [0, 0, 0], look_at = [0, 0, 1], fov = 180 }".into(), "fov"),
        ("camera = { from = [0, 0, 0], look_at = [0, inf, 1], fov = 40 }".into(), "not finite"),
        ("keys = [{ time = -1 }]".into(), "keys[0] has a time that is negative"),
        ("keys = [{ time = nan }]".into(), "keys[0] has a time"),
        ("keys = [{ time = 1 }, { time = 1 }]".into(), "keys[1] has a time that is not after"),
        ("keys = [{ time = 1, nodes = [{ node = 1, scale = [inf, 1, 1] }] }]".into(), "keys[0].nodes[0]"),
        ("camera = 3".into(), "camera"),
    ] {
        let error = refused(&text);
        assert!(error.contains(words), "{text}: {error}");
    }
    // Such edits cannot be written either.
    let key = Keyframe { time: f64::NAN, camera: None, nodes: Vec::new() };
    assert!(Edits { keys: vec![key], ..Edits::default() }.to_toml().is_err());
}

#[test]
fn errors_of_edits_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("moved.toml");
    let error = || Edits::load(&path).unwrap_err().to_string();
    assert!(error().contains("moved.toml: cannot be read"), "{}", error());
    std::fs::write(&path, b"[camera]\nfrom = 1\n\xFF").unwrap();
    assert!(error().contains("moved.toml: no edits of a scene: it is no UTF-8"), "{}", error());
    std::fs::write(&path, "[camera]\nfrom = 1").unwrap();
    assert!(error().contains("moved.toml") && error().contains("line 2"), "{}", error());
    std::fs::File::create(&path).unwrap().set_len(MAX_BYTES + 1).unwrap();
    assert!(error().contains("it has more than 67108864 bytes"), "{}", error());
    std::fs::write(&path, FILE).unwrap();
    assert_eq!(Edits::load(&path).unwrap(), Edits::parse(FILE).unwrap());
}
