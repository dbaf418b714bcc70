//! Aimed and guided emission: samples against their density, and flux against that of emission by power.

use std::f64::consts::PI;

use caustics::render_config::RenderConfig;
use caustics_kernels::interface::caster::{Caster, Casters};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::guide::{GuideMap, LightGroups};
use caustics_kernels::interface::light::Light;
use caustics_kernels::light::aimed::{Aimed, BY_POWER};
use caustics_kernels::light::density_map::{Node, from_polar};
use caustics_kernels::light::emission_cone::EmissionCone;
use caustics_kernels::light::emit::{EmissionSample, Emit};
use caustics_kernels::light::guided::{EVENLY, Guided, GuidingPyramid, KNOWN, map_count};
use caustics_kernels::light::light_pyramid::{LightNode, LightPyramid};
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_tests::chi_square::{Fit, SphereCells};
use caustics_tests::direct::World;
use caustics_tests::scenes::*;
use caustics_tests::statistics::Mean;
use glam::{DVec3, Vec3};

const SAMPLES: u32 = 600_000;
const CELLS: SphereCells = SphereCells { rows: 32, columns: 32 };

/// Spheres as seen from the origin: two that overlap, a small distant one, and a hidden one. One is too near to have a
/// cone, and one holds the origin.
fn casters() -> Casters {
    let spheres = [
        (Vec3::new(0.0, -2.0, 0.3), 0.9),
        (Vec3::new(0.6, -2.5, 0.0), 0.8),
        (Vec3::new(-8.0, -9.0, 3.0), 0.7),
        (Vec3::new(1.0, 1.0, 1.0), 0.0),
        (Vec3::new(0.5, -1.2, 0.5), 1.3),
        (Vec3::new(0.0, 0.4, 0.0), 0.6),
    ];
    let mut casters = Casters { count: spheres.len() as u32, ..Casters::default() };
    let weights = [1.0, 0.3].into_iter().cycle();
    for ((slot, (centre, radius)), weight) in casters.spheres.iter_mut().zip(spheres).zip(weights) {
        *slot = Caster { centre, radius, weight };
    }
    casters
}

/// A world with one light and these casters, whose spheres are empty.
fn world(b: Builder, test: impl FnOnce(&World<'_>)) {
    let mut b = b;
    b.camera(DVec3::ZERO, DVec3::Z, 1.0);
    let scene = b.build();
    let mut world = World::new(&scene, &RenderConfig::default());
    world.params.casters = casters();
    world.params.light_groups = LightGroups::new(world.params.light_count, world.params.casters.count);
    world.features = world.features | Features::LIGHT_PYRAMIDS;
    test(&world);
}

fn far_floor() -> Builder {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    b.panel(floor, DVec3::new(0.0, -20.0, 0.0), 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b
}

/// Density (1/sr) of directions from `from`, for a light that samples them with the density `by_power`; in f64,
/// independent of the kernels.
fn density(casters: &Casters, from: DVec3, direction: DVec3, by_power: f64) -> f64 {
    let count = casters.count as usize;
    let (mut whole, mut aimed, mut weights) = (0.0, 0.0, 0.0);
    for sphere in casters.spheres[..count].iter().filter(|sphere| sphere.radius > 0.0) {
        let along = sphere.centre.as_dvec3() - from;
        let cos = (1.0 - (f64::from(sphere.radius) / along.length()).powi(2)).sqrt();
        // It holds the position (no root), or is wider than a quarter of all directions.
        let has_cone = !cos.is_nan() && cos >= 0.5;
        let weight = f64::from(sphere.weight) * if has_cone { (1.0 - cos).sqrt() } else { 1.0 };
        weights += weight;
        if !has_cone {
            whole += weight;
        } else if direction.dot(along.normalize()) >= cos {
            aimed += weight / (2.0 * PI * (1.0 - cos));
        }
    }
    let by = f64::from(BY_POWER);
    (by + (1.0 - by) * whole / weights) * by_power + (1.0 - by) * aimed / weights
}

/// Maps of guided emission.
struct Maps {
    maps: Vec<GuideMap>,
    pyramid: Vec<f32>,
}

impl Maps {
    /// Fills texels by their map and index, shares by their map, and leaves of the light pyramids as the texels. All are scaled to
    /// what they must sum to.
    fn new(world: &World<'_>, texel: impl Fn(u32, u32) -> f32, share: impl Fn(u32) -> f32) -> Maps {
        let count = map_count(&world.params);
        let offset = LightPyramid::offset(&world.params);
        let mut pyramid = vec![0.0f32; (offset + LightPyramid::max_nodes(&world.params)) as usize];
        if world.params.light_groups.share_maps() {
            let layout = LightPyramid::new(&world.params);
            for level in 0..=layout.top {
                for index in 0..layout.count(level, count) {
                    let LightNode { slot, below } = layout.node(level, index);
                    let leaf = index % (1 << layout.top);
                    pyramid[(offset + slot) as usize] = match level {
                        0 => texel(index >> layout.top, leaf),
                        _ => below.map(|child| pyramid[(offset + child) as usize]).iter().sum(),
                    };
                }
            }
        }
        for level in 0..=GuidingPyramid::TOP {
            for index in 0..GuidingPyramid::count(level, count) {
                let Node { slot, below } = GuidingPyramid::node(level, index);
                pyramid[slot as usize] = match level {
                    0 => texel(index / GuidingPyramid::TEXELS, index % GuidingPyramid::TEXELS),
                    _ => below.map(|child| pyramid[child as usize]).iter().sum(),
                };
            }
        }
        let total: f32 = (0..count).map(&share).sum();
        let mut below = 0.0;
        let maps = (0..count).map(|map| {
            let (share, sum) = (share(map) / total, GuidingPyramid::total(&pyramid, map));
            let scale = if sum > 0.0 { GuidingPyramid::TEXELS as f32 / sum } else { 0.0 };
            below += share;
            GuideMap { below: below - share, share, unit: 1.0, scale }
        });
        Maps { maps: maps.collect(), pyramid }
    }

    /// Random maps. Half of the texels are empty, the others have any size; shares have any size, and one map is never
    /// sampled.
    fn any(world: &World<'_>) -> Maps {
        let number = |a: u32, b: u32| Rng::new(Stream::Camera, 5, a, b).next4();
        let texel = |map: u32, texel: u32| {
            let u = number(map, texel);
            if u.x < 0.5 { 0.0 } else { 0.05 / (u.y + 0.05) }
        };
        Maps::new(world, texel, |map| if map == 1 { 0.0 } else { number(map, u32::MAX).x })
    }

    fn emission<'a>(&'a self, world: &'a World<'a>) -> Guided<'a> {
        Guided { power: world.by_power(), maps: &self.maps, pyramid: &self.pyramid }
    }

    /// Density (1/sr) of a direction from the origin under a single point light; in f64, independent of the search for
    /// a texel.
    fn density(&self, casters: &Casters, direction: Vec3, cones: f64) -> f64 {
        let light = Light::default();
        let maps = f64::from(casters.count + 1);
        let (mut closed_even, mut closed_known, mut aimed) = (0.0, 0.0, 0.0);
        for caster in 0..=casters.count as usize {
            let cone = match casters.spheres[..casters.count as usize].get(caster) {
                Some(sphere) => EmissionCone::at(sphere, &light, Vec3::ZERO),
                None => EmissionCone::everywhere(&light),
            };
            let map = &self.maps[caster];
            let (mut even, mut known) = (f64::from(EVENLY) / maps, f64::from(KNOWN) * f64::from(map.share));
            if !cone.is_open() {
                closed_even += even;
                closed_known += known;
            } else if cone.holds(direction) {
                let texel = GuidingPyramid::texel_at(from_polar(cone.polar(&light, direction)));
                let value = self.pyramid[caster * GuidingPyramid::NODES as usize + texel as usize];
                if caster == casters.count as usize {
                    even += closed_even;
                    known += closed_known;
                }
                let density = even + known * f64::from(value) * f64::from(map.scale);
                aimed += density / (2.0 * PI * f64::from(cone.reach));
            }
        }
        f64::from(BY_POWER) * 0.25 / PI + aimed * cones
    }
}

fn sample(emit: &(impl Emit + ?Sized), path: u32) -> EmissionSample {
    let mut rng = Rng::new(Stream::Light, 16, path, 0);
    emit.sample(&mut rng)
}

/// Directions of a point light fall into cells by their density, and each carries its intensity over that density. A
/// density whose cones are off by 5 % does not fit.
#[test]
fn aimed_directions_follow_the_density_that_divides_their_flux() {
    let mut b = far_floor();
    b.light(DVec3::ZERO, 3.0);
    world(b, |world| {
        let emit = Aimed { power: world.by_power() };
        let mut seen = vec![0; CELLS.count()];
        let (mut inverse, mut off) = (Vec::new(), 0);
        for path in 0..SAMPLES {
            let emission = sample(&emit, path);
            let direction = emission.ray.direction;
            seen[CELLS.cell_index(direction)] += 1;
            let p = density(&world.params.casters, DVec3::ZERO, direction.as_dvec3(), 0.25 / PI);
            // At a rim f32 and f64 may differ in whether a cone holds the direction.
            off += u32::from((f64::from(emission.flux.x) * p / 3.0 - 1.0).abs() > 1e-4);
            assert!((emission.solid_angle / emission.flux.x * 3.0 - 1.0).abs() < 1e-5);
            inverse.push(f64::from(emission.flux.x) / 3.0);
        }
        assert!(off < 10, "{off} starts carry another flux");
        let sphere = Mean::from_samples(&inverse);
        println!("sum of 1/p: {:.4} +- {:.4}, the sphere {:.4}", sphere.value, sphere.error, 4.0 * PI);
        assert!((sphere.value - 4.0 * PI).abs() < 3.0 * sphere.error);
        let fit = |cones: f64| {
            let expected = CELLS.integrate([24, 24], |d| {
                let base = 0.25 / PI;
                let p = density(&world.params.casters, DVec3::ZERO, d.as_dvec3(), base);
                let power = density(&world.params.casters, DVec3::ZERO, DVec3::Y, base);
                (power + cones * (p - power)) * f64::from(SAMPLES)
            });
            Fit::new(&seen, &expected)
        };
        println!("{:?}", fit(1.0));
        assert!(fit(1.0).passes() && !fit(1.05).passes());
    });
}

/// Directions of guided starts by random maps follow their density in the same way.
#[test]
fn guided_directions_follow_the_density_that_divides_their_flux() {
    let mut b = far_floor();
    b.light(DVec3::ZERO, 3.0);
    world(b, |world| {
        let maps = Maps::any(world);
        let emit = maps.emission(world);
        let casters = &world.params.casters;
        let mut seen = vec![0; CELLS.count()];
        let (mut inverse, mut off) = (Vec::new(), 0);
        for path in 0..SAMPLES {
            let emission = sample(&emit, path);
            seen[CELLS.cell_index(emission.ray.direction)] += 1;
            let p = maps.density(casters, emission.ray.direction, 1.0);
            // At borders of texels a direction may fall to either side.
            off += u32::from((f64::from(emission.flux.x) * p / 3.0 - 1.0).abs() > 1e-4);
            inverse.push(f64::from(emission.flux.x) / 3.0);
            assert!(
                emission.score > 0.0
                    && emission.start_code < map_count(&world.params) * GuidingPyramid::TEXELS
            );
        }
        assert!(off < 100, "{off} starts carry another flux");
        let sphere = Mean::from_samples(&inverse);
        println!("sum of 1/p: {:.4} +- {:.4}, the sphere {:.4}", sphere.value, sphere.error, 4.0 * PI);
        assert!((sphere.value - 4.0 * PI).abs() < 3.0 * sphere.error);
        let fit = |cones: f64| {
            let expected =
                CELLS.integrate([128, 128], |d| maps.density(casters, d, cones) * f64::from(SAMPLES));
            Fit::new(&seen, &expected)
        };
        println!("{:?}", fit(1.0));
        assert!(fit(1.0).passes() && !fit(1.05).passes());
    });
}

/// Compares the flux of all emissions in every cell of directions or, for parallel light, of positions; and the total.
fn is_the_same(what: &str, b: Builder, cell: impl Fn(&EmissionSample) -> usize, count: usize) {
    world(b, |world| {
        let sums = |emit: &dyn Fn(u32) -> EmissionSample| {
            let mut moments = vec![[0.0f64; 2]; count + 1];
            for path in 0..SAMPLES {
                let emission = emit(path);
                let flux = f64::from(emission.flux.x);
                for cell in [cell(&emission), count] {
                    moments[cell][0] += flux;
                    moments[cell][1] += flux * flux;
                }
            }
            let n = f64::from(SAMPLES);
            moments
                .into_iter()
                .map(|[sum, squares]| (sum / n, (squares / n - (sum / n).powi(2)) / n))
                .collect::<Vec<_>>()
        };
        // Put all weight of the maps where no caster is.
        let poisoned = Maps::new(world, |_, texel| f32::from(texel == 0), |map| f32::from(map == 0) + 1e-6);
        let (aimed, any) = (Aimed { power: world.by_power() }, Maps::any(world));
        let emissions: [(&str, &dyn Emit); 3] = [
            ("aimed", &aimed),
            ("guided by anything", &any.emission(world)),
            ("guided to nothing", &poisoned.emission(world)),
        ];
        let b = sums(&|path| sample(&world.by_power(), SAMPLES + path));
        for (name, emit) in emissions {
            let a = sums(&|path| sample(emit, path));
            let z: Vec<f64> = a
                .iter()
                .zip(&b)
                .filter(|(a, b)| a.1 + b.1 > 1e-6 * b.0 * b.0)
                .map(|(a, b)| (a.0 - b.0) / (a.1 + b.1).sqrt())
                .collect();
            let worst = z.iter().fold(0.0f64, |worst, z| worst.max(z.abs()));
            let whole = (a[count].0 / b[count].0 - 1.0).abs();
            println!("{what}, {name}: {} cells, worst {worst:.2} sigma; in all {whole:.5} apart", z.len());
            assert!(worst < 4.5 && z.len() > 20, "{what}, {name}");
            // No start weighs more than 8 times its weight by power.
            let heaviest = (0..SAMPLES).map(|path| sample(emit, path).flux.x).fold(0.0, f32::max);
            let max_flux = (0..1000).map(|path| sample(&world.by_power(), path).flux.x).fold(0.0, f32::max);
            assert!(heaviest <= max_flux / BY_POWER * 1.0001, "{what}, {name}: {heaviest} of {max_flux}");
        }
    });
}

/// Tests every type of light with the same casters.
#[test]
fn aimed_and_guided_emission_carry_the_flux_of_emission_by_power() {
    let directions = |emission: &EmissionSample| CELLS.cell_index(emission.ray.direction);
    let mut point = far_floor();
    point.light(DVec3::ZERO, 3.0);
    is_the_same("point", point, directions, CELLS.count());
    let mut spot = far_floor();
    spot.spot(DVec3::ZERO, DVec3::new(0.2, -1.0, 0.1), 0.3, 0.8, 3.0);
    is_the_same("spot", spot, directions, CELLS.count());
    for (what, material) in [("area light", emitter(2.0)), ("two-sided light", emitter_both(2.0))] {
        let mut area = far_floor();
        let light = area.material(material);
        // It reaches into the sphere that holds the origin, and beyond.
        area.panel(light, DVec3::new(0.3, 0.0, 0.0), DVec3::Z, DVec3::new(0.7, 0.2, 0.0).cross(DVec3::Z));
        is_the_same(what, area, directions, CELLS.count());
    }
    let mut parallel = far_floor();
    parallel.directional(DVec3::new(0.1, -1.0, 0.0), 2.0);
    let positions = |emission: &EmissionSample| {
        let along = emission.ray.origin
            + emission.ray.direction * (-emission.ray.origin.y / emission.ray.direction.y);
        let cell = |x: f32| ((x + 4.0) * 3.0).clamp(0.0, 23.0) as usize;
        24 * cell(along.x) + cell(along.z)
    };
    is_the_same("directional", parallel, positions, 24 * 24);
    // Two hundred lights of very different power, in groups.
    let mut many = far_floor();
    for id in 0..200 {
        let at = DVec3::new(f64::from(id % 7) * 0.02, f64::from(id % 5) * 0.02, f64::from(id % 3) * 0.02);
        many.light(at, 10.0f32.powi(id % 4));
    }
    is_the_same("many", many.clone(), directions, CELLS.count());
    let lights = |emission: &EmissionSample| {
        let at = |along: f32| (along / 0.02 + 0.5) as usize;
        let origin = emission.ray.origin;
        15 * at(origin.x) + 3 * at(origin.y) + at(origin.z)
    };
    is_the_same("each of many", many, lights, 7 * 15);
}

/// Without casters, and where no caster has a cone, aimed emission is emission by power.
#[test]
fn aimed_emission_without_casters_or_cones_is_by_power() {
    let mut b = far_floor();
    let light = b.material(emitter(2.0));
    b.panel(light, DVec3::ZERO, DVec3::X, DVec3::Z);
    b.camera(DVec3::ZERO, DVec3::Z, 1.0);
    let scene = b.build();
    let mut world = World::new(&scene, &RenderConfig::default());
    for count in [0, 3] {
        world.params.casters = Casters { count, ..Casters::default() };
        let (aimed, power) = (Aimed { power: world.by_power() }, world.by_power());
        for path in 0..1000 {
            let (a, b) = (sample(&aimed, path), sample(&power, path));
            assert!(
                (a.flux - b.flux).abs().max_element() < 1e-5 * b.flux.x && a.ray.direction == b.ray.direction
            );
        }
    }
}

/// A wall that light passes casts by what it reflects alone: it has a sphere without other casters, and a smaller weight.
#[test]
fn thin_walls_that_light_passes_have_spheres_of_smaller_weight() {
    let mut b = far_floor();
    let (pane, ball) = (b.material(pane(1.5)), b.material(metal(0.9, 0.0)));
    b.panel(pane, DVec3::new(0.0, -10.0, 0.0), 2.0 * DVec3::Z, 2.0 * DVec3::X);
    b.sphere(ball, DVec3::new(0.0, -9.9, 0.0), 0.05, 16, 8);
    b.camera(DVec3::ZERO, DVec3::Z, 1.0);
    let scene = b.build();
    let weights = |passes| {
        let Casters { spheres, count } = scene.casters(0.25, passes);
        let size_and_weight = |caster: &Caster| (caster.radius > 1.0, caster.weight);
        let mut weights: Vec<(bool, f32)> = spheres[..count as usize].iter().map(size_and_weight).collect();
        weights.sort_by_key(|(is_wide, _)| *is_wide);
        weights
    };
    assert_eq!(weights(false), [(false, 1.0), (true, 1.0)]);
    let passed = weights(true);
    assert_eq!(passed[0], (false, 1.0));
    // 2 r / (1 + r) of the light, r = 0.04
    assert!((passed[1].1.powi(2) - 0.08 / 1.04).abs() < 1e-3, "{passed:?}");
}
