//! Placed cameras show the whole scene, and their names reproduce them.

use super::*;

/// Bounds of every kind: a room, a speck, a country, a rectangle in each plane, a line, a point, far away.
fn kinds() -> Vec<[DVec3; 2]> {
    let around = |centre: DVec3, size: DVec3| [centre - 0.5 * size, centre + 0.5 * size];
    let room = DVec3::new(4.0, 2.0, 3.0);
    let sheets = [DVec3::new(2.0, 1.0, 0.0), DVec3::new(0.0, 1.0, 2.0), DVec3::new(2.0, 0.0, 1.0)];
    let mut kinds = vec![
        around(DVec3::ZERO, room),
        around(DVec3::new(3e5, -2.0, 7e6), room),
        around(DVec3::ZERO, 1e-7 * room),
        around(DVec3::ONE, 1e8 * room),
        around(DVec3::ONE, DVec3::X),
        around(DVec3::ONE, DVec3::ZERO),
    ];
    kinds.extend(sheets.map(|size| around(DVec3::NEG_X, size)));
    kinds
}

/// Distance of a position from the image's centre, in half widths and half heights; `None` behind the eye.
fn seen(whole: &Whole, position: DVec3, aspect: f64) -> Option<(f64, f64)> {
    let forward = (whole.look_at.0 - whole.from.0).normalize();
    let (right, up) = axes(forward);
    let p = position - whole.from.0;
    let depth = p.dot(forward) * (0.5 * whole.field).to_radians().tan();
    (depth > 0.0).then(|| (p.dot(right) / (depth * aspect), p.dot(up) / depth))
}

/// Largest distance of a corner from the centre.
fn extent(whole: &Whole, [lower, upper]: [DVec3; 2], aspect: f64) -> f64 {
    let corners = (0..8).map(|corner| {
        let pick = |bit: u32, low: f64, high: f64| if corner & bit == 0 { low } else { high };
        DVec3::new(pick(1, lower.x, upper.x), pick(2, lower.y, upper.y), pick(4, lower.z, upper.z))
    });
    corners
        .map(|corner| seen(whole, corner, aspect).map_or(f64::INFINITY, |(x, y)| x.abs().max(y.abs())))
        .fold(0.0, f64::max)
}

#[test]
fn default_view_shows_bounds_of_any_kind_with_a_margin() {
    for bounds in kinds() {
        for aspect in [16.0 / 9.0, 1.0, 0.2] {
            let orbit = |azimuth, elevation| Orbit { azimuth, elevation, distance: None };
            let ways = [orbit(30.0, 20.0), orbit(-135.0, -80.0), orbit(0.0, 90.0), orbit(720.0, 0.0)];
            let placed = ways.map(|orbit| Viewpoint { eye: Some(Eye::On(orbit)), ..Viewpoint::default() });
            for viewpoint in placed.into_iter().chain([
                Viewpoint::default(),
                Viewpoint { field: Some(5.0), ..Viewpoint::default() },
                Viewpoint { field: Some(120.0), ..Viewpoint::default() },
                Viewpoint { look_at: Some(Position(bounds[1])), ..Viewpoint::default() },
            ]) {
                let whole = viewpoint.whole(bounds, aspect);
                let extent = extent(&whole, bounds, aspect);
                // The margin of a tenth covers the rounding to five digits.
                assert!(extent < FILLED + 1e-3, "{whole} of {bounds:?} at {aspect}: {extent}");
                // The camera is not farther away than needed, if the scene has an extent.
                let has_size = bounds[0].distance(bounds[1]) > 0.0 && viewpoint.look_at.is_none();
                assert!(!has_size || extent > 0.3 * FILLED, "{whole} of {bounds:?} at {aspect}: {extent}");
            }
        }
    }
}

#[test]
fn detects_a_view_that_is_too_near() {
    let bounds = kinds()[0];
    let near = Viewpoint {
        eye: Some(Eye::On(Orbit { distance: Some(3.0), ..THREE_QUARTER })),
        ..Viewpoint::default()
    };
    assert!(extent(&near.whole(bounds, 1.0), bounds, 1.0) > 1.0);
}

#[test]
fn orbit_starts_at_plus_z_and_turns_to_plus_x_and_up() {
    let to_eye = |azimuth, elevation| Orbit { azimuth, elevation, distance: None }.to_eye();
    assert!((to_eye(0.0, 0.0) - DVec3::Z).length() < 1e-12);
    assert!((to_eye(90.0, 0.0) - DVec3::X).length() < 1e-12);
    assert!(to_eye(0.0, 45.0).y > 0.7 && to_eye(0.0, 45.0).z > 0.7);
    let default = Viewpoint::default().whole([DVec3::NEG_ONE, DVec3::ONE], 1.0).from.0;
    assert!(default.min_element() > 0.0 && default.z > default.x, "{default}");
}

/// Reads the options in a name, like the command line.
fn read(name: &str) -> Viewpoint {
    let words: Vec<&str> = name.split(' ').collect();
    let value = |option: &str| words[words.iter().position(|word| *word == option).unwrap() + 1];
    let position = |option| Some(value(option).parse::<Position>().unwrap());
    let choice = CameraChoice::from_options(
        None,
        position("--from"),
        position("--look-at"),
        value("--fov").parse().ok(),
    );
    let CameraChoice::Placed(viewpoint) = choice.unwrap() else { panic!("{name} places a camera") };
    viewpoint
}

#[test]
fn camera_name_as_options_gives_the_same_camera_to_the_bit() {
    for [lower, upper] in kinds() {
        let origin = 0.5 * (lower + upper);
        let bounds = [lower, upper].map(|corner| (corner - origin).as_vec3());
        let mut scene = Scene { origin, bounds, ..Scene::default() };
        let first = scene.place_camera(&Viewpoint::default(), 1.5).unwrap().clone();
        // The second image may have another aspect ratio.
        let again = scene.place_camera(&read(&first.name), 0.7).unwrap();
        assert_eq!(*again, first);
        assert!(first.position.is_finite() && first.position.length() > 0.0);
        assert!((first.right.cross(first.up) + first.forward).length() < 1e-5);
    }
}

#[test]
fn each_viewpoint_option_works_alone() {
    let bounds = [DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 2.0, 1.0)];
    let whole = |viewpoint: Viewpoint| viewpoint.whole(bounds, 1.0);
    let from = whole(Viewpoint { eye: Some(Eye::At(Position(DVec3::X * 9.0))), ..Viewpoint::default() });
    assert_eq!((from.from.0, from.look_at.0, from.field), (DVec3::X * 9.0, DVec3::Y, FIELD));
    // From the centre itself the view goes along -z.
    let inside = whole(Viewpoint { eye: Some(Eye::At(Position(DVec3::Y))), ..Viewpoint::default() });
    assert!(inside.look_at.0.z < -1.0 && inside.look_at.0.y == 1.0, "{inside}");
    let at = whole(Viewpoint { look_at: Some(Position(DVec3::X)), ..Viewpoint::default() });
    assert_eq!(at.look_at.0, DVec3::X);
    let wide = whole(Viewpoint { field: Some(90.0), ..Viewpoint::default() });
    assert!(wide.from.0.length() < whole(Viewpoint::default()).from.0.length());
}

#[test]
fn contradicting_viewpoint_options_are_refused() {
    let position = Some(Position(DVec3::ONE));
    for (camera, from, look_at, field, word) in [
        (Some("orbit:1,2"), position, None, None, "one"),
        (Some("main"), position, None, None, "leave one out"),
        (Some("main"), None, None, Some(40.0), "leave one out"),
        (None, None, None, Some(0.0), "170"),
        (None, None, None, Some(f64::NAN), "170"),
        (Some("orbit:1"), None, None, None, "azimuth"),
        (Some("orbit:1,100"), None, None, None, "-90"),
        (Some("orbit:1,2,0"), None, None, None, "above zero"),
        (Some("orbit:1,2,3,4"), None, None, None, "azimuth"),
        (Some("orbit:inf,2"), None, None, None, "azimuth"),
    ] {
        let error = CameraChoice::from_options(camera, from, look_at, field).unwrap_err();
        assert!(error.contains(word), "{error}");
    }
    assert_eq!(CameraChoice::from_options(None, None, None, None), Ok(CameraChoice::First));
    assert_eq!(
        CameraChoice::from_options(Some("main"), None, None, None),
        Ok(CameraChoice::Named("main".into()))
    );
    for wrong in ["1,2", "1,2,3,4", "a,b,c", "1,2,NaN", ""] {
        assert!(wrong.parse::<Position>().is_err(), "{wrong}");
    }
    let mut scene = Scene::default();
    let here = Viewpoint { eye: position.map(Eye::At), look_at: position, field: None };
    assert!(scene.place_camera(&here, 1.0).unwrap_err().to_string().contains("looks at where it is"));
    let far = Viewpoint { eye: Some(Eye::At(Position(DVec3::X * 1e30))), ..Viewpoint::default() };
    assert!(scene.place_camera(&far, 1.0).unwrap_err().to_string().contains("too far"));
    assert!(scene.camera(None).unwrap_err().to_string().contains("place_camera"));
}
