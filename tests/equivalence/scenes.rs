//! Scenes that together need everything the kernel has, and one by one need little.

use crate::renders::Set;
use octolux::estimate::bmc::Points;
use octolux::scene::{
    Bsdf, Channel, ConductorFresnel, DeltaLight, Environment, EnvironmentImage, Gather, GatherLights, GatherMethod,
    GatherPdf, GatherWeights, Image, Integrator, IntegratorKind, LightPaths, Maps, Masking, Material, NO_TEXCOORD,
    Scene, Texels, Texture,
};
use std::f64::consts::TAU;

pub const SIDE: u32 = 20;

/// Name and scene.
pub fn all() -> Vec<(&'static str, Scene)> {
    vec![
        ("everything", everything()),
        ("lambert room", lambert_room()),
        ("spheres under a sky", spheres_under_a_sky()),
        ("many triangles", many_triangles()),
        ("mirror room", mirror_room()),
        ("stage lights", stage_lights(true)),
        ("lambert stage", lambert_stage()),
        ("images", images()),
        ("crumpled ball", crumpled_ball(true)),
        ("light paths", with_light_paths(crate::light_paths::shop(true))),
        ("light paths beside light samples", crate::light_paths::shop(false)),
        ("light paths, stage", with_light_paths(stage_lights(true))),
        ("light paths, images", with_light_paths(crate::light_paths::flat_images())),
        ("light paths, lambert room", with_light_paths(lambert_room())),
        ("gather", with_gather(spheres_under_a_sky(), 1, Gather::default())),
        ("gather, paths go on", with_gather(everything(), 4, Gather { samples: 9, ..Gather::default() })),
        ("gather, at each hit", with_gather(lambert_room(), 1, per_hit(Points::Owen, GatherMethod::BmcIs))),
        ("gather, random points", with_gather(everything(), 1, per_hit(Points::Random, GatherMethod::McIs))),
        ("gather, lights sampled", with_gather(stage_lights(true), 2, sampled(Points::Fibonacci))),
        ("gather, lobes", with_gather(everything(), 1, Gather { pdf: GatherPdf::Lobe, ..Gather::default() })),
        (
            "gather, lobes at each hit",
            with_gather(stage_lights(true), 2, lobes(per_hit(Points::Owen, GatherMethod::BmcIs))),
        ),
        ("gather, images", with_gather(images(), 1, per_hit(Points::Fibonacci, GatherMethod::BmcIs))),
        ("gather, smooth normals", with_gather(crumpled_ball(true), 2, Gather { samples: 17, ..Gather::default() })),
        ("phong", phong(stage_lights(true))),
        ("phong, images", phong(images())),
        ("black", Set::new([0.0, 0.0, 3.0], [0.0; 3], 40.0, SIDE).finish()),
    ]
}

pub fn with_light_paths(mut scene: Scene) -> Scene {
    scene.integrator.light_paths = LightPaths::On;
    scene
}

fn with_gather(mut scene: Scene, bounces: u32, gather: Gather) -> Scene {
    scene.integrator =
        Integrator { kind: IntegratorKind::Gather, max_bounces: bounces, gather, ..Integrator::default() };
    scene
}

fn per_hit(points: Points, method: GatherMethod) -> Gather {
    Gather { samples: 11, points, method, weights: GatherWeights::PerHit, ..Gather::default() }
}

fn lobes(gather: Gather) -> Gather {
    Gather { pdf: GatherPdf::Lobe, ..gather }
}

fn sampled(points: Points) -> Gather {
    Gather { lights: GatherLights::Sampled, ..per_hit(points, GatherMethod::McIs) }
}

fn phong(mut scene: Scene) -> Scene {
    scene.delta_lights.push(DeltaLight::Point { position: [0.5, 3.0, 2.0], intensity: [2.0, 3.0, 4.0] });
    scene.integrator = Integrator { kind: IntegratorKind::Phong, ambient: [0.1, 0.2, 0.3], ..Integrator::default() };
    scene
}

/// All materials, both kinds of emitters, an image environment, smooth normals, a tree.
pub fn everything() -> Scene {
    let mut set = Set::new([0.3, 1.4, 4.0], [0.0, 0.5, 0.0], 45.0, SIDE).bounces(9).environment(sky());
    let ground = set.material(Bsdf::Diffuse { reflectance: [0.6, 0.5, 0.4] }, [0.0; 3]);
    let lamp = set.material(Bsdf::Diffuse { reflectance: [0.1; 3] }, [9.0, 8.0, 7.0]);
    let bulb = set.material(Bsdf::Diffuse { reflectance: [0.0; 3] }, [3.0, 4.0, 5.0]);
    let ring = set.material(Bsdf::Diffuse { reflectance: [0.2, 0.5, 0.7] }, [0.0; 3]);
    set.quad(ground, [[-4.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, -4.0], [-4.0, 0.0, -4.0]]);
    set.quad(lamp, [[-0.5, 3.0, -0.5], [0.5, 3.0, -0.5], [0.5, 3.0, 0.5], [-0.5, 3.0, 0.5]]);
    set.sphere(bulb, [2.0, 1.7, 0.5], 0.2);
    for (i, bsdf) in glossy().into_iter().enumerate() {
        let material = set.material(bsdf, [0.0; 3]);
        let x = i as f64;
        set.sphere(material, [-2.0 + 0.62 * x, 0.3, 0.9 - 0.3 * (x - 3.0).abs()], 0.3);
    }
    for (i, bsdf) in layered().into_iter().enumerate() {
        let material = set.material(bsdf, [0.0; 3]);
        set.sphere(material, [-1.1 + 0.7 * i as f64, 0.2, 1.6], 0.2);
    }
    cylinder(&mut set, ring, 24, 3);
    set.finish()
}

fn glossy() -> [Bsdf; 7] {
    use ConductorFresnel::{Constant, Exact, Schlick};
    let metal = |alpha, masking, fresnel| Bsdf::Conductor { alpha, masking, fresnel };
    let glass = |alpha, masking, ior| Bsdf::Dielectric { alpha, masking, ior };
    let gold = Exact { eta: [0.1431, 0.3749, 1.4424], k: [3.9831, 2.3857, 1.6032] };
    [
        metal(0.15, Masking::Separable, gold),
        metal(0.5, Masking::Correlated, Schlick { f0: [0.9, 0.6, 0.3] }),
        metal(0.0, Masking::Correlated, Constant { reflectance: [0.95, 0.9, 0.85] }),
        glass(0.0, Masking::Correlated, 1.5),
        glass(0.2, Masking::Separable, 1.33),
        glass(0.6, Masking::Correlated, 1.8),
        metal(1.0, Masking::Correlated, gold),
    ]
}

/// A base and a lobe each; the last coat is a delta lobe above a base that is none.
fn layered() -> [Bsdf; 4] {
    let coat = |alpha, masking| Bsdf::Coated { reflectance: [0.5, 0.2, 0.1], alpha, masking, ior: 1.5 };
    [
        Bsdf::Phong { diffuse: [0.3, 0.3, 0.2], specular: [0.4, 0.5, 0.6], exponent: 40.0 },
        Bsdf::Phong { diffuse: [0.0, 0.1, 0.0], specular: [0.9, 0.8, 0.9], exponent: 3.0 },
        coat(0.2, Masking::Separable),
        coat(0.0, Masking::Correlated),
    ]
}

/// An upright open cylinder behind the spheres, smooth.
fn cylinder(set: &mut Set, material: u32, around: usize, up: usize) {
    let place = |i: usize, j: usize| {
        let (s, c) = (i as f64 / around as f64 * TAU).sin_cos();
        let normal = [s, 0.0, c];
        ([0.8 * s, j as f64 / up as f64, 0.8 * c - 1.2], normal)
    };
    for (i, j) in (0..around).flat_map(|i| (0..up).map(move |j| (i, j))) {
        let [(a, na), (b, nb), (c, nc), (d, nd)] = [place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)];
        set.smooth_triangle(material, [a, b, c], [na, nb, nc]);
        set.smooth_triangle(material, [a, c, d], [na, nc, nd]);
    }
}

/// Few triangles, Lambert, one lamp: no tree, no glossy code, no spheres, no environment.
pub fn lambert_room() -> Scene {
    let mut set = Set::new([0.3, 0.2, 0.9], [-0.4, -0.1, -1.0], 80.0, SIDE);
    let [white, red, green] = [[0.7, 0.7, 0.7], [0.6, 0.1, 0.1], [0.1, 0.5, 0.1]]
        .map(|reflectance| set.material(Bsdf::Diffuse { reflectance }, [0.0; 3]));
    let lamp = set.material(Bsdf::Diffuse { reflectance: [0.0; 3] }, [9.0, 8.0, 7.0]);
    set.room([red, green, white, white, white, white], [-1.0, -0.8, -1.5], [1.2, 0.9, 1.1]);
    set.quad(lamp, [[-0.2, 0.89, -0.5], [0.3, 0.89, -0.5], [0.3, 0.89, 0.1], [-0.2, 0.89, 0.1]]);
    set.block(white, [-0.7, -0.8, -0.9], [-0.2, 0.1, -0.4]);
    set.finish()
}

/// No mesh at all.
pub fn spheres_under_a_sky() -> Scene {
    let mut set = Set::new([0.0, 1.0, 5.0], [0.0, 0.3, 0.0], 40.0, SIDE).bounces(12).environment(sky());
    let stone = set.grey(0.4, 0.0);
    let glass = set.material(Bsdf::Dielectric { alpha: 0.0, masking: Masking::Correlated, ior: 1.5 }, [0.0; 3]);
    set.sphere(stone, [0.0, -100.0, 0.0], 100.0);
    set.sphere(glass, [-0.6, 0.5, 0.0], 0.5);
    set.sphere(stone, [0.6, 0.5, -0.2], 0.5);
    set.finish()
}

/// Lambert, but past the size up to which no tree is built.
fn many_triangles() -> Scene {
    let mut set = Set::new([0.2, 1.1, 3.0], [0.0, 0.4, -1.0], 50.0, SIDE).uniform_light();
    let material = set.material(Bsdf::Diffuse { reflectance: [0.8, 0.6, 0.2] }, [0.0; 3]);
    cylinder(&mut set, material, 40, 6);
    set.finish()
}

/// Lights without extent on glossy spheres, through a lens, with a lamp, and a sky that is turned.
pub fn stage_lights(sky_too: bool) -> Scene {
    let mut set = Set::new([0.2, 1.2, 3.0], [0.0, 0.3, 0.0], 45.0, SIDE).bounces(6).lens(0.04, 2.6);
    if sky_too {
        let Environment::Image(image) = sky() else { unreachable!() };
        set = set.environment(Environment::Image(EnvironmentImage { rotation: 130.0, ..image }));
    }
    let ground = set.material(Bsdf::Diffuse { reflectance: [0.5, 0.5, 0.4] }, [0.0; 3]);
    let lamp = set.material(Bsdf::Diffuse { reflectance: [0.0; 3] }, [2.0, 3.0, 4.0]);
    set.quad(ground, [[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [3.0, 0.0, -3.0], [-3.0, 0.0, -3.0]]);
    set.quad(lamp, [[-0.5, 2.0, -0.5], [0.5, 2.0, -0.5], [0.5, 2.0, 0.5], [-0.5, 2.0, 0.5]]);
    for (i, bsdf) in layered().into_iter().enumerate() {
        let material = set.material(bsdf, [0.0; 3]);
        set.sphere(material, [-0.9 + 0.6 * i as f64, 0.3, 0.2 - 0.3 * (i % 2) as f64], 0.29);
    }
    lit(set).finish()
}

fn lit(set: Set) -> Set {
    set.light(DeltaLight::Point { position: [-1.0, 1.5, 1.0], intensity: [1.5, 1.0, 0.5] })
        .light(DeltaLight::Directional { direction: [0.48, -0.8, -0.36], irradiance: [0.4, 0.6, 0.8] })
        .light(DeltaLight::Spot {
            position: [1.2, 1.4, 0.5],
            direction: [-0.64, -0.6, -0.48],
            intensity: [3.0, 3.0, 4.0],
            angle: 18.0,
        })
}

/// The same lights and lens in a scene of few Lambert triangles.
fn lambert_stage() -> Scene {
    let mut set = Set::new([0.2, 1.2, 3.0], [0.0, 0.3, 0.0], 45.0, SIDE).bounces(3).lens(0.1, 3.0);
    let grey = set.grey(0.6, 0.0);
    set.quad(grey, [[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [3.0, 0.0, -3.0], [-3.0, 0.0, -3.0]]);
    set.block(grey, [-0.6, 0.0, -0.3], [-0.1, 0.7, 0.3]);
    lit(set).finish()
}

/// A closed mesh whose vertex normals point anywhere, outside and in, lit by everything.
pub fn crumpled_ball(outside: bool) -> Scene {
    let eye = if outside { [0.0, 0.7, 3.0] } else { [0.3, 0.2, -0.4] };
    let mut set = Set::new(eye, [0.0; 3], 50.0, SIDE).bounces(4).environment(sky());
    let lamp = set.grey(0.3, 5.0);
    set.sphere(lamp, [0.2, 0.1, 0.1], 0.2);
    let mut bsdfs = layered().to_vec();
    bsdfs.extend([Bsdf::Diffuse { reflectance: [0.8, 0.7, 0.6] }, glossy()[1]]);
    let materials: Vec<u32> = bsdfs.into_iter().map(|bsdf| set.material(bsdf, [0.0; 3])).collect();
    ball(&mut set, &materials, 6, 77);
    set.light(DeltaLight::Point { position: [-0.3, 0.3, 0.2], intensity: [0.3; 3] })
        .light(DeltaLight::Directional { direction: [0.6, 0.0, -0.8], irradiance: [1.0; 3] })
        .finish()
}

/// A unit sphere of 8n² triangles, from an octahedron, watertight, with random vertex normals.
pub fn ball(set: &mut Set, materials: &[u32], n: usize, seed: u64) {
    let mut rng = crate::stats::Rng::new(seed);
    let mut normals = std::collections::HashMap::new();
    let mut i = 0;
    for octant in 0..8 {
        let sign = |k: usize| if octant >> k & 1 == 1 { -1.0 } else { 1.0 };
        let corner = |a: usize, b: usize| -> [f64; 3] {
            let p = [a as f64 * sign(0), b as f64 * sign(1), (n - a - b) as f64 * sign(2)];
            let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
            p.map(|x| x / length + 0.0)
        };
        let mut face = |mut p: [[f64; 3]; 3]| {
            if sign(0) * sign(1) * sign(2) < 0.0 {
                p.swap(1, 2);
            }
            let key = |p: [f64; 3]| p.map(|x| (x as f32).to_bits());
            let n = p.map(|p| *normals.entry(key(p)).or_insert_with(|| rng.sphere()));
            set.smooth_triangle(materials[i % materials.len()], p, n);
            i += 1;
        };
        for (a, b) in (0..n).flat_map(|a| (0..n - a).map(move |b| (a, b))) {
            face([corner(a, b), corner(a + 1, b), corner(a, b + 1)]);
            if a + b + 1 < n {
                face([corner(a + 1, b), corner(a + 1, b + 1), corner(a, b + 1)]);
            }
        }
    }
}

/// Only deltas: light sampling has nothing to do.
fn mirror_room() -> Scene {
    let mut set = Set::new([0.3, 0.2, 0.9], [-0.4, -0.1, -1.0], 80.0, SIDE).bounces(40);
    let fresnel = ConductorFresnel::Constant { reflectance: [0.9, 0.8, 0.7] };
    let wall = set.material(Bsdf::Conductor { alpha: 0.0, masking: Masking::Correlated, fresnel }, [1.0, 0.5, 0.25]);
    set.room([wall; 6], [-1.0, -0.8, -1.5], [1.2, 0.9, 1.1]);
    set.finish()
}

/// Every kind of map, on triangles and spheres, beside surfaces without; foliage before a patterned lamp.
pub fn images() -> Scene {
    let mut set = Set::new([0.3, 1.4, 4.0], [0.0, 0.5, 0.0], 45.0, SIDE).bounces(6).environment(sky());
    let metal = |alpha| Bsdf::Conductor {
        alpha,
        masking: Masking::Correlated,
        fresnel: ConductorFresnel::Schlick { f0: [0.9, 0.7, 0.5] },
    };
    let shiny = Bsdf::Phong { diffuse: [1.0, 0.9, 0.8], specular: [0.9; 3], exponent: 30.0 };
    let ground = set.material(shiny, [0.0; 3]);
    let leaf = set.material(Bsdf::Diffuse { reflectance: [0.2, 0.7, 0.1] }, [0.0; 3]);
    let lamp = set.material(Bsdf::Diffuse { reflectance: [0.3; 3] }, [9.0, 8.0, 7.0]);
    let ball = set.material(metal(1.0), [0.0; 3]);
    let coat = |reflectance| Bsdf::Coated { reflectance, alpha: 0.1, masking: Masking::Correlated, ior: 1.5 };
    let patches = set.material(coat([0.6, 0.5, 0.4]), [0.0; 3]);
    let plain = set.material(Bsdf::Diffuse { reflectance: [0.5; 3] }, [0.0; 3]);
    let materials = &mut set.scene_mut().materials;
    let maps = |materials: &mut Vec<Material>, index: u32, maps: Maps| materials[index as usize].maps = maps;
    maps(
        materials,
        ground,
        Maps {
            colour: noise(3, 16, 9),
            specular: noise(3, 4, 3),
            normal: noise(3, 8, 8),
            strength: [0.5; 2],
            ..Maps::default()
        },
    );
    maps(materials, leaf, Maps { opacity: noise(1, 5, 5), colour: noise(3, 3, 3), ..Maps::default() });
    maps(materials, lamp, Maps { emission: noise(3, 6, 2), opacity: noise(4, 4, 4), ..Maps::default() });
    maps(
        materials,
        ball,
        Maps { roughness: noise(1, 9, 4), normal: noise(4, 7, 5), strength: [0.3; 2], ..Maps::default() },
    );
    maps(materials, patches, Maps { metallic: noise(1, 4, 4), metal_alpha: 0.3, ..Maps::default() });
    materials[patches as usize].opacity = 0.8;
    set.quad(ground, [[-4.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, -4.0], [-4.0, 0.0, -4.0]]);
    set.quad(lamp, [[-0.5, 3.0, -0.5], [0.5, 3.0, -0.5], [0.5, 3.0, 0.5], [-0.5, 3.0, 0.5]]);
    for i in 0..30 {
        let (x, y, z) = (-1.5 + 0.1 * f64::from(i), 0.4 + 0.05 * f64::from(i % 7), 1.2 - 0.07 * f64::from(i % 5));
        let material = if i % 9 == 8 { plain } else { leaf };
        set.triangle(material, [[x, y, z], [x + 0.4, y + 0.1, z - 0.1], [x, y + 0.5, z + 0.2]]);
    }
    for (i, material) in [ball, patches, lamp, plain].into_iter().enumerate() {
        set.sphere(material, [-1.4 + 0.9 * i as f64, 0.4, -0.4], 0.4);
    }
    let mesh = &mut set.scene_mut().mesh;
    let corner = |i: usize| [(i * 7 % 11) as f32 * 0.2, (i * 5 % 13) as f32 * 0.15];
    mesh.texcoords = (0..40).map(corner).collect();
    let index = |i: usize| if i % 17 == 3 { NO_TEXCOORD } else { (i * 3 % 40) as u32 };
    mesh.texcoord_indices = (0..mesh.triangles.len()).map(|t| [index(t), index(t + 7), index(t + 15)]).collect();
    set.finish()
}

/// An image of bytes without a pattern.
fn noise(channels: usize, width: u32, height: u32) -> Option<Texture> {
    let mut rng = crate::stats::Rng::new(u64::from(width * 100 + height));
    let texels = (0..(width * height) as usize * channels).map(|_| (rng.f64() * 256.0) as u8).collect();
    let image = Image { width, height, channels, texels: Texels::Bytes(texels) };
    Some(Texture {
        file: octolux::scene::FileName::default(),
        channel: if channels == 4 { Channel::Alpha } else { Channel::Mean },
        ..Texture::new(image.into(), true)
    })
}

/// Uneven in both directions, with a bright spot.
fn sky() -> Environment {
    let (width, height) = (16, 8);
    let texel = |i: usize| {
        let (x, y) = ((i % width) as f32, (i / width) as f32);
        if (x, y) == (11.0, 2.0) { [60.0, 55.0, 40.0] } else { [0.2 + 0.02 * x, 0.3 + 0.01 * x, 0.9 - 0.1 * y] }
    };
    Environment::Image(EnvironmentImage {
        width,
        height,
        texels: (0..width * height).map(texel).collect(),
        rotation: 0.0,
    })
}
