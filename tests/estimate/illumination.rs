//! The illumination integral at a pixel: closed forms, and all techniques agreeing.

use super::study;
use crate::renders::{Set, world};
use crate::stats::z_bound;
use octolux::estimate::problems::{Problem, illumination};
use octolux::kernel::Width;
use octolux::scene::{Bsdf, Masking};

const ALL: [&str; 6] = ["mc:uniform", "mc:cosine", "mc:bsdf", "mc:light", "mc:mis", "owen:mis"];

fn sphere(bsdf: Bsdf) -> Set {
    let mut set = Set::new([0.0, 0.0, 4.0], [0.0; 3], 20.0, 16).bounces(1).uniform_light();
    let material = set.material(bsdf, [0.0; 3]);
    set.sphere(material, [0.0; 3], 1.0);
    set
}

fn at(set: Set, pixel: [u32; 2]) -> impl Problem {
    illumination(world(&set.finish(), 1), "test", pixel, Width::Eight).unwrap()
}

/// Lambert in a uniform sky of radiance 1: ρ; the cosine density has no variance, the uniform one ρ²/3.
#[test]
fn a_furnace_shows_the_reflectance() {
    let problem = at(sphere(Bsdf::Diffuse { reflectance: [0.6; 3] }), [7, 8]);
    assert!((problem.quantity().exact - 0.6).abs() < 1e-5);
    let s = study(&problem, &ALL, &[64], 1000, 1);
    for row in &s.rows {
        let c = &row.cells[0];
        assert!(
            (c.mean.value - 0.6).abs() < z_bound(6) * c.mean.standard_error + 1e-5,
            "{}: {}",
            row.method,
            c.mean.value
        );
    }
    let variance = |name: &str| s.rows.iter().find(|r| r.method == name).unwrap().cells[0].variance * 64.0;
    assert!(variance("mc:cosine") < 1e-10 && variance("mc:bsdf") < 1e-10);
    // √(2/1000) = 4.5 % of spread.
    assert!((variance("mc:uniform") / 0.12 - 1.0).abs() < 0.045 * z_bound(1), "{}", variance("mc:uniform"));
}

/// A glossy ball between a lamp and a wall: five techniques, one number.
#[test]
fn techniques_agree() {
    let mut set = sphere(Bsdf::Phong { diffuse: [0.3, 0.4, 0.2], specular: [0.4; 3], exponent: 12.0 });
    let lamp = set.material(Bsdf::Diffuse { reflectance: [0.0; 3] }, [9.0, 8.0, 7.0]);
    let wall = set.material(Bsdf::Diffuse { reflectance: [0.5; 3] }, [0.0; 3]);
    set.sphere(lamp, [2.0, 2.5, 2.0], 0.5);
    set.sphere(wall, [-3.0, 0.0, 1.0], 1.5);
    let problem = at(set, [9, 6]);
    let s = study(&problem, &ALL, &[256], 1000, 2);
    for row in &s.rows {
        let (c, exact) = (&row.cells[0], s.quantity.exact);
        let allowed = z_bound(6) * c.mean.standard_error + s.quantity.exact_error;
        assert!((c.mean.value - exact).abs() < allowed, "{}: {} for {exact}", row.method, c.mean.value);
        assert!(c.mean.standard_error < 0.02 * exact, "{}: no power", row.method);
    }
}

/// The same bits at any width.
#[test]
fn widths_agree() {
    let bits = |width| {
        let set = sphere(Bsdf::Phong { diffuse: [0.3, 0.4, 0.2], specular: [0.4; 3], exponent: 12.0 });
        let problem = illumination(world(&set.finish(), 1), "test", [9, 6], width).unwrap();
        let s = study(&problem, &ALL, &[5, 64], 10, 2);
        s.rows.iter().flat_map(|r| &r.cells).map(|c| c.mean.value.to_bits()).collect::<Vec<_>>()
    };
    let one = bits(Width::One);
    assert!(one == bits(Width::Eight) && one == bits(Width::Sixteen));
}

/// What no density but the material's own finds would be missing from four of the techniques.
#[test]
fn surfaces_with_a_delta_are_refused() {
    let refused = |bsdf: Bsdf| {
        let problem = illumination(world(&sphere(bsdf).finish(), 1), "test", [7, 8], Width::Eight);
        problem.err().is_some_and(|why| why.to_string().contains("no density but its own"))
    };
    let coated = |alpha: f32| Bsdf::Coated { reflectance: [0.5; 3], ior: 1.5, alpha, masking: Masking::Separable };
    let glass = |ior: f32, alpha: f32| Bsdf::Dielectric { ior, alpha, masking: Masking::Separable };
    assert!(refused(coated(0.0)) && refused(glass(1.5, 0.0)) && refused(glass(1.0, 0.3)));
    assert!(!refused(coated(0.2)) && !refused(glass(1.5, 0.3)));
}
