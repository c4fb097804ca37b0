//! A brick wall, a plant of leaf cards and a neon sign: every kind of image in a small scene.

use crate::mesh::{Obj, Vec3};
use std::error::Error;
use std::fs::File;
use std::path::Path;

const LEAVES: usize = 36;
/// Bricks across and up one repeat of the wall's image.
const BRICKS: [f64; 2] = [4.0, 8.0];
/// How deep the joints are, as a fraction of the repeat.
const DEPTH: f64 = 0.008;

pub fn write(folder: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::write(folder.join("courtyard.obj"), obj())?;
    image(&folder.join("brick.png"), 128, |u, v| brick(u, v).to_vec())?;
    image(&folder.join("brick_normal.png"), 128, |u, v| normal(u, v).to_vec())?;
    image(&folder.join("leaf.png"), 64, |u, v| leaf(u, v).to_vec())?;
    image(&folder.join("sign.png"), 64, |u, v| sign(u, v).to_vec())?;
    image(&folder.join("rough.png"), 32, |u, v| vec![if checks(u, v) { 0.7 } else { 0.15 }])?;
    image(&folder.join("metal.png"), 32, |_, v| vec![if (4.0 * v) as i32 % 2 == 0 { 1.0 } else { 0.0 }])
}

fn obj() -> String {
    let mut obj = Obj::new("Made by tools/make_scenes: ground, wall, sign and leaves.", "courtyard.mtl");
    for [u, v] in [[0, 0], [1, 0], [1, 1], [0, 1], [3, 0], [3, 1], [0, 1]] {
        obj.line(&format!("vt {u} {v}"));
    }
    let wide = [1, 5, 6, 7];
    obj.line("o ground");
    card(&mut obj, "ground", [1, 2, 3, 4], [[-6.0, 0.0, 6.0], [6.0, 0.0, 6.0], [6.0, 0.0, -2.0], [-6.0, 0.0, -2.0]]);
    obj.line("o wall");
    card(&mut obj, "brick", wide, [[-6.0, 0.0, -2.0], [6.0, 0.0, -2.0], [6.0, 4.0, -2.0], [-6.0, 4.0, -2.0]]);
    obj.line("o sign");
    card(
        &mut obj,
        "sign",
        [1, 2, 3, 4],
        [[-0.6, 1.7, -1.85], [0.6, 1.7, -1.85], [0.6, 2.9, -1.85], [-0.6, 2.9, -1.85]],
    );
    obj.line("o plant");
    for i in 0..LEAVES {
        // The golden angle keeps leaves apart.
        let (s, c) = (i as f64 * 2.399_963).sin_cos();
        let foot = [1.9 + 0.12 * s, 0.1 + 0.05 * i as f64, -0.9 + 0.12 * c];
        let (across, along) = ([0.26 * c, 0.0, -0.26 * s], [0.3 * s, 0.4, 0.3 * c]);
        let corner = |a: f64, b: f64| -> Vec3 { std::array::from_fn(|k| foot[k] + a * across[k] + b * along[k]) };
        card(
            &mut obj,
            "leaf",
            [1, 2, 3, 4],
            [corner(-1.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        );
    }
    obj.finish()
}

/// A quad with texture coordinates, counter-clockwise from the lower left.
fn card(obj: &mut Obj, material: &str, uv: [usize; 4], corners: [Vec3; 4]) {
    let [a, b, c, d] = corners.map(|p| obj.vertex(p));
    obj.line(&format!("usemtl {material}"));
    obj.line(&format!("f {a}/{} {b}/{} {c}/{} {d}/{}", uv[0], uv[1], uv[2], uv[3]));
}

/// How far from the joints, in bricks' thickness; and which brick.
fn bond(u: f64, v: f64) -> (f64, usize) {
    let row = (v * BRICKS[1]).floor();
    let x = u * BRICKS[0] + 0.5 * row.rem_euclid(2.0);
    let [fx, fy] = [x.rem_euclid(1.0), (v * BRICKS[1]).rem_euclid(1.0)];
    let across = 2.0 * fx.min(1.0 - fx);
    let up = fy.min(1.0 - fy);
    let brick = row.rem_euclid(BRICKS[1]) as usize * 7 + x.rem_euclid(BRICKS[0]) as usize * 3;
    ((across.min(up) / 0.12).min(1.0), brick)
}

fn brick(u: f64, v: f64) -> [f64; 3] {
    let (inside, brick) = bond(u, v);
    let shade = (brick % 5) as f64;
    if inside < 0.5 { [0.75, 0.72, 0.68] } else { [0.6 + 0.05 * shade, 0.3 + 0.03 * shade, 0.22] }
}

/// Central differences of the height; green is up.
fn normal(u: f64, v: f64) -> [f64; 3] {
    let step = 1.0 / 256.0;
    let slope = |du: f64, dv: f64| DEPTH * (bond(u + du, v + dv).0 - bond(u - du, v - dv).0) / (2.0 * step);
    let n = crate::mesh::normalize([-slope(step, 0.0), -slope(0.0, step), 1.0]);
    n.map(|c| 0.5 + 0.5 * c)
}

fn leaf(u: f64, v: f64) -> [f64; 4] {
    let x = (2.0 * u - 1.0).abs();
    let width = 0.85 * (std::f64::consts::PI * v).sin().powf(0.7) * (1.0 - 0.4 * v);
    let vein = 0.12 * (40.0 * (v + 0.5 * x)).sin().abs();
    [0.25 + vein, 0.5 + vein, 0.15, if x < width { 1.0 } else { 0.0 }]
}

fn sign(u: f64, v: f64) -> [f64; 3] {
    let ring = ((u - 0.5).hypot(v - 0.5) - 0.32).abs() < 0.06;
    let bar = (u - 0.5).abs() < 0.05 && (0.5..0.94).contains(&v);
    if bar {
        [0.15, 0.6, 1.0]
    } else if ring {
        [1.0, 0.3, 0.12]
    } else {
        [0.0; 3]
    }
}

fn checks(u: f64, v: f64) -> bool {
    ((8.0 * u) as i32 + (8.0 * v) as i32) % 2 == 0
}

/// Writes a square 8-bit PNG from encoded values in [0, 1], as many as it has channels; v = 0 is its lower edge.
fn image(path: &Path, side: u32, texel: impl Fn(f64, f64) -> Vec<f64>) -> Result<(), Box<dyn Error>> {
    let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let mut bytes = Vec::new();
    for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
        bytes.extend(texel(centre(column), 1.0 - centre(row)).iter().map(|c| (255.0 * c).round() as u8));
    }
    let mut encoder = png::Encoder::new(File::create(path)?, side, side);
    encoder.set_color(match bytes.len() / (side * side) as usize {
        1 => png::ColorType::Grayscale,
        3 => png::ColorType::Rgb,
        _ => png::ColorType::Rgba,
    });
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(&bytes)?;
    Ok(())
}

/// A ball of quads whose coordinates go round it twice.
pub fn ball() -> String {
    const AROUND: usize = 32;
    const UP: usize = 16;
    let mut obj = Obj::new("Made by tools/make_scenes: a ball, smooth, with texture coordinates.", "ball.mtl");
    let angle = |i: usize, of: usize| std::f64::consts::PI * i as f64 / of as f64;
    for (j, i) in (0..=UP).flat_map(|j| (0..=AROUND).map(move |i| (j, i))) {
        let ((s, c), (across, down)) = ((2.0 * angle(i, AROUND)).sin_cos(), angle(j, UP).sin_cos());
        let n = [across * s, -down, across * c];
        obj.vertex([-1.15 + 0.6 * n[0], 0.6 + 0.6 * n[1], 0.1 + 0.6 * n[2]]);
        obj.normal(n);
        obj.line(&format!("vt {} {}", 2.0 * i as f64 / AROUND as f64, j as f64 / UP as f64));
    }
    obj.line("usemtl ball");
    let index = |i: usize, j: usize| j * (AROUND + 1) + i + 1;
    for (j, i) in (0..UP).flat_map(|j| (0..AROUND).map(move |i| (j, i))) {
        let corners = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
        obj.line(&format!("f {}", corners.map(|k| format!("{k}/{k}/{k}")).join(" ")));
    }
    obj.finish()
}
