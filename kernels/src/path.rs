//! Camera paths and light paths: the two loops of the algorithm. Passes say which paths are traced and what becomes of them. Imports
//! `interface`, `platform`, `math`, `texture`, `trace`, `surface` and `light`.
//!
//! | step | function |
//! |---|---|
//! | camera path, its loop | [`camera_path::trace_camera_path`] |
//! | light path, its loop | [`light_path::trace_light_path`] |
//! | absorption, surfaces that a medium covers | [`trace_through_media`](crate::trace::through_media::trace_through_media) |
//! | emission by MIS | [`emission::surface_emission`], [`emission::environment_radiance`] |
//! | light sampling (NEE) by MIS, shadow rays | [`direct_light::choose_light_samples`], [`direct_light::trace_shadow_rays`] |
//! | end of the prefix, collection point | [`prefix::collection_point`] |
//! | Russian roulette | [`camera_path::CameraPath::roulette`], [`light_path::survival_probability`] |
//! | photon stored | [`photon_sink::PhotonSink::store_photon`] |
//! | contribution of a photon to a collection point | [`Receiver::contribution`](crate::gather::contribution::Receiver::contribution) |
//! | memory and registers of a GPU | [`scratch`] |

pub mod camera_pass;
pub mod camera_path;
pub mod camera_ray;
pub mod direct_light;
pub mod emission;
pub mod ledger;
pub mod light_path;
pub mod observer;
pub mod photon_sink;
pub mod prefix;
pub mod scratch;

use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::scene::SceneTables;

/// The scene and the settings in which paths are traced.
#[derive(Clone, Copy)]
pub struct PathContext<'a> {
    /// Settings of the frame.
    pub params: &'a FrameParams,
    /// Code that is compiled in.
    pub features: Features,
    /// Tables of the scene.
    pub scene: SceneTables<'a>,
}
