//! Writes three bare models of different origin, to render without a scene file: an export as Blender makes it, with
//! images; a scan; a part as CAD programs make it.
//!
//! `cargo run --release --example make_models FOLDER`. Nothing of it is committed.

use std::error::Error;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("name the folder to write to")?);
    for name in ["blender", "scan", "cad"] {
        std::fs::create_dir_all(folder.join(name))?;
    }
    blender(&folder.join("blender"))?;
    std::fs::write(folder.join("scan/scan.obj"), scan(700, 700)?)?;
    std::fs::write(folder.join("cad/gear.obj"), gear(48)?)?;
    Ok(())
}

const BLENDER_MTL: &str = "# Blender MTL File: 'None'
newmtl Bricks worn
Ns 250.0\nKa 1 1 1\nKd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nKe 0 0 0\nNi 1.45\nd 1\nillum 2
map_Kd -s 3 2 1 brick.png\nmap_Bump -bm 1.0 -s 3 2 1 brick_normal.png
newmtl Leaf.001
Ns 10\nKd 1 1 1\nKs 0 0 0\nd 1\nillum 1\nmap_Kd leaf.png\nmap_d leaf.png
newmtl Rusty_Metal
Kd 0.9 0.6 0.3\nKe 0 0 0\nNi 1.5\nd 1\nillum 3\nPr 0.35\nPm 1.0\nPs 0\nPc 0\naniso 0\nmap_Pr rough.png\nmap_Pm metal.png
";

/// Objects and smoothing groups, names with spaces, images with options, physically based keys.
fn blender(folder: &Path) -> Result<(), Box<dyn Error>> {
    let images = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/courtyard");
    for image in ["brick.png", "brick_normal.png", "leaf.png", "rough.png", "metal.png"] {
        std::fs::copy(Path::new(images).join(image), folder.join(image))?;
    }
    std::fs::write(folder.join("untitled model.mtl"), BLENDER_MTL)?;
    let mut obj = "# Blender 4.2.0\n# www.blender.org\nmtllib untitled model.mtl\n".to_string();
    obj += "o Wall\nv -2 0 -1\nv 2 0 -1\nv 2 2.5 -1\nv -2 2.5 -1\nv -2 0 1.5\nv 2 0 1.5\n";
    obj += "vn 0 0 1\nvn 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\ns 0\nusemtl Bricks worn\n";
    obj += "f 1/1/1 2/2/1 3/3/1 4/4/1\nf 5/1/2 6/2/2 2/3/2 1/4/2\n";
    obj += "o Plane.002\nv -1.6 0.1 0.4\nv -0.4 0.1 0.8\nv -0.4 1.3 0.6\nv -1.6 1.3 0.2\nusemtl Leaf.001\nf 7/1 8/2 9/3 10/4\n";
    obj += "o Sphere\n";
    let (rows, columns) = (32, 64);
    for row in 0..=rows {
        for column in 0..=columns {
            let (theta, phi) = (TAU / 2.0 * row as f64 / rows as f64, TAU * column as f64 / columns as f64);
            let n = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
            writeln!(obj, "v {} {} {}", 0.8 + 0.6 * n[0], 0.6 + 0.6 * n[1], 0.3 + 0.6 * n[2])?;
            writeln!(obj, "vn {} {} {}", n[0], n[1], n[2])?;
            writeln!(obj, "vt {} {}", column as f64 / columns as f64, 1.0 - row as f64 / rows as f64)?;
        }
    }
    obj += "s 1\nusemtl Rusty_Metal\n";
    for row in 0..rows {
        for column in 0..columns {
            let at = |r: i32, c: i32| (row + r) * (columns + 1) + column + c;
            let corner = |i: i32| format!("{}/{}/{}", i + 11, i + 5, i + 3);
            let [a, b, c, d] = [at(0, 0), at(0, 1), at(1, 1), at(1, 0)].map(corner);
            writeln!(obj, "f {a} {b} {c} {d}")?;
        }
    }
    std::fs::write(folder.join("untitled model.obj"), obj)?;
    Ok(())
}

/// In [0, 1), by the place.
fn noise(i: usize, j: usize) -> f64 {
    let mut h = (i as u32).wrapping_mul(0x9e37_79b9) ^ (j as u32).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 16).wrapping_mul(0x7feb_352d);
    h = (h ^ h >> 15).wrapping_mul(0x846c_a68b);
    f64::from((h ^ h >> 16) >> 8) / 16_777_216.0
}

/// A lumpy body without normals or materials: a colour a vertex, holes, jitter, slivers, vertices of no face.
fn scan(rows: usize, columns: usize) -> Result<String, std::fmt::Error> {
    let mut obj = "# scan, millimetres\n".to_string();
    for i in 0..=rows {
        for j in 0..columns {
            let (theta, phi) = (TAU / 2.0 * i as f64 / rows as f64, TAU * j as f64 / columns as f64);
            let lumps = (5.0 * phi).sin() * (4.0 * theta).sin() + 0.5 * (9.0 * phi + 7.0 * theta).cos();
            let r = 90.0 + 9.0 * theta.sin() * lumps + 0.12 * (noise(i, j) - 0.5);
            let [x, y, z] = [theta.sin() * phi.cos(), 1.3 * theta.cos(), theta.sin() * phi.sin()].map(|c| r * c);
            writeln!(obj, "v {x:.4} {y:.4} {z:.4} 0.{} 0.6 0.5", i % 10)?;
        }
    }
    for i in 0..rows {
        for j in 0..columns {
            if noise(i / 12, j / 12) < 0.01 {
                continue;
            }
            let at = |r: usize, c: usize| (i + r) * columns + (j + c) % columns + 1;
            writeln!(obj, "f {} {} {}\nf {} {} {}", at(0, 0), at(0, 1), at(1, 1), at(0, 0), at(1, 1), at(1, 0))?;
        }
    }
    Ok(obj)
}

/// A gear with a bore, far from the origin: concave caps of many corners, long thin walls, indices counted from the end, no
/// material.
fn gear(teeth: usize) -> Result<String, std::fmt::Error> {
    let mut obj = "# exported part, mm\ng gear\n".to_string();
    let corners = 4 * teeth;
    for z in [0.0, 25.0] {
        for i in 0..corners {
            let r = if i % 4 < 2 { 100.0 } else { 86.0 };
            let angle = TAU * (i as f64 + 0.2 * f64::from(u8::from(i % 4 == 1))) / corners as f64;
            writeln!(obj, "v {:.6} {:.6} {:.6}", 1000.0 + r * angle.cos(), 2000.0 + r * angle.sin(), z - 500.0)?;
        }
        for i in 0..corners {
            let angle = TAU * i as f64 / corners as f64;
            writeln!(obj, "v {:.6} {:.6} {:.6}", 1000.0 + 30.0 * angle.cos(), 2000.0 + 30.0 * angle.sin(), z - 500.0)?;
        }
    }
    let all = 4 * corners as i64;
    let back = |ring: usize, i: usize| (ring * corners + i % corners) as i64 - all;
    let (half, top) = (corners / 2, 2);
    // Each cap in two halves, so that none needs a hole.
    for part in 0..2 {
        let along: Vec<usize> = (part * half..=(part + 1) * half).collect();
        let outer = along.iter().map(|&i| back(top, i));
        let inner = along.iter().rev().map(|&i| back(top + 1, i));
        let cap: Vec<String> = outer.chain(inner).map(|i| i.to_string()).collect();
        writeln!(obj, "f {}", cap.join(" "))?;
        let outer = along.iter().rev().map(|&i| back(0, i));
        let cap: Vec<String> = outer.chain(along.iter().map(|&i| back(1, i))).map(|i| i.to_string()).collect();
        writeln!(obj, "f {}", cap.join(" "))?;
    }
    for i in 0..corners {
        writeln!(obj, "f {} {} {} {}", back(0, i), back(0, i + 1), back(2, i + 1), back(2, i))?;
        writeln!(obj, "f {} {} {} {}", back(3, i), back(3, i + 1), back(1, i + 1), back(1, i))?;
    }
    Ok(obj)
}
