//! Skies: their exact values, and lanes against f64.

use crate::stats::quadrature::{Adaptive, Rect};
use octolux::estimate::points::{Points, lane_unit, unit};
use octolux::estimate::problems::{
    Density, Field, Learned, Problem, Sky, cube, hemisphere, hemisphere_of_image, integrate,
};
use octolux::kernel::Width;
use octolux::lane::{Bits, Real, Vec3, f32x8};
use octolux::scene::EnvironmentImage;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

fn direction(u: f64, phi: f64) -> [f64; 3] {
    let s = ((1.0 - u) * (1.0 + u)).max(0.0).sqrt();
    [s * phi.cos(), s * phi.sin(), u]
}

/// Against adaptive quadrature over (cosθ, φ): edges and suns cost it digits, which it says.
#[test]
fn exact_values_are_integrals() {
    for seed in 0..4 {
        for (sky, tolerance) in [
            (Sky::random(seed), 1e-9),
            (Sky::random(seed).with_edge(seed), 3e-4),
            (Sky::random(seed).with_sun(seed), 3e-4),
        ] {
            let field = Field::Sky(sky);
            let f = |u: f64, phi: f64| field.at(direction(u, phi), false);
            let (expected, error) = Adaptive::new(tolerance, f).integrate(Rect { x: [0.0, 1.0], y: [0.0, TAU] }, 4);
            let exact = field.exact();
            assert!(
                (exact - expected).abs() < 4.0 * error + 4.0 * tolerance,
                "{seed}: {exact} for {expected} ± {error}"
            );
        }
    }
}

#[test]
fn caps_above_and_below_the_horizon_are_integrated() {
    // A cap by itself about the normal; half a sphere about an axis in the horizon: π/2 of cosine, π of solid angle.
    let cosine = |w: [f64; 3]| w[2];
    let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-9, "{value} for {expected}");
    near(integrate(Some(([0.0, 0.0, 1.0], 0.6)), cosine), PI * (1.0 - 0.36));
    near(integrate(None, |_| 1.0), TAU);
    near(integrate(Some(([1.0, 0.0, 0.0], 0.0)), |_| 1.0), PI);
    near(integrate(Some(([0.6, 0.0, 0.8], 0.9)), |_| 1.0), TAU * 0.1);
    near(integrate(Some(([0.6, 0.0, -0.8], -1.0)), |_| 1.0), TAU);
    // A cap wholly below sees nothing; the whole cap about an axis 30° up, cut by the horizon: closed form for cosine.
    near(integrate(Some(([0.0, 0.0, -1.0], 0.5)), |_| 1.0), 0.0);
    near(integrate(Some(([0.6, 0.0, 0.8], 0.5)), |_| 1.0) + integrate(Some(([-0.6, 0.0, -0.8], -0.5)), |_| 1.0), TAU);
}

/// Second moments behind predicted variances: against the mean of F²/p² under p by many stratified samples.
#[test]
fn densities_are_normalised_and_sampled() {
    let sky = Sky::random(1).with_sun(1);
    let (axis, cos, _) = sky.sun.unwrap();
    for density in [
        Density::Uniform,
        Density::Cosine,
        Density::Phong(0.0),
        Density::Phong(30.0),
        Density::Ggx(0.3),
        Density::Mis(axis, cos),
        Density::Learned(Arc::new(Learned::new(&Field::Sky(sky.clone())))),
    ] {
        let jump = if let Density::Mis(..) | Density::Learned(_) = density { 2e-3 } else { 1e-8 };
        let f = |u: f64, phi: f64| density.at(direction(u, phi));
        let (total, error) =
            Adaptive::new(1e-9f64.max(jump / 10.0), f).integrate(Rect { x: [0.0, 1.0], y: [0.0, TAU] }, 4);
        assert!((total - 1.0).abs() < jump + 4.0 * error, "{density:?}: {total} ± {error}");
        // ∫ cos²θ·p by sampling from p, 65,536 stratified points, against the integral.
        let plan = Points::Owen.plan(1 << 16, 2).unwrap();
        let mut bits = vec![Vec::new(); 2];
        plan.fill(Width::Eight, 3, &mut bits);
        let (mut mean, mut worst) = (0.0, 0.0f64);
        for first in (0..1 << 16).step_by(8) {
            let u = [0, 1].map(|d| lane_unit::<f32x8>(<f32x8 as Real>::Bits::load(&bits[d][first..])));
            let (w, pdf): (Vec3<f32x8>, f32x8) = density.sample(u);
            for lane in 0..8 {
                let w64 = [w.x, w.y, w.z].map(|c| f64::from(c.lane(lane)));
                mean += w64[2] * w64[2] / 65536.0;
                let at_edge = matches!(density, Density::Learned(_)) && near_a_cell_edge(w64)
                    || (axis[0] * w64[0] + axis[1] * w64[1] + axis[2] * w64[2] - cos).abs() < 1e-5;
                if !at_edge {
                    worst = worst.max((f64::from(pdf.lane(lane)) / density.at(w64) - 1.0).abs());
                }
            }
        }
        let square = |w: [f64; 3]| w[2] * w[2] * density.at(w);
        let expected = match density {
            Density::Mis(..) => {
                0.5 * integrate(None, |w| w[2].powi(3) / PI)
                    + 0.5 * integrate(Some((axis, cos)), |w| w[2] * w[2]) / (TAU * (1.0 - cos))
            }
            _ => integrate(None, square),
        };
        assert!((mean - expected).abs() < 1e-3, "{density:?}: {mean} for {expected}");
        assert!(worst < 3e-4, "{density:?}: pdf off by {worst:e}");
    }
}

/// Directions in f32 may round into the neighbouring cell of a histogram of 16 × 32.
fn near_a_cell_edge(w: [f64; 3]) -> bool {
    let near = |x: f64| (x - x.round()).abs() < 1e-4;
    near(16.0 * w[2]) || near(32.0 * w[1].atan2(w[0]) / TAU)
}

/// Lanes against the f64 twin of the same function at the same points.
#[test]
fn lanes_compute_what_f64_does() {
    for name in ["sine", "linear", "diagonal", "corner"] {
        let problem = cube(name, 5, Width::Eight).unwrap();
        let plan = Points::Independent.plan(1000, 5).unwrap();
        let mut bits = vec![Vec::new(); 5];
        plan.fill(Width::Eight, 1, &mut bits);
        let mut values = vec![0.0; 1000];
        problem.integrand.fill(Width::Eight, &bits, &mut values);
        let differ = (0..1000).filter(|&i| {
            let x: Vec<f64> = bits.iter().map(|row| unit(row[i])).collect();
            let exact = problem.integrand.at(&x);
            // A coordinate is off by up to 2⁻²⁴, the steepest function by π(π/2)⁵ times that along each of five axes.
            (values[i] - exact).abs() > 5.0 * PI * (0.5 * PI).powi(5) * f64::powi(2.0, -24)
        });
        assert_eq!(differ.count(), 0, "{name}");
    }
}

#[test]
fn names_that_are_none_are_refused() {
    let problem = hemisphere("sky", 1.0, 0, Width::Eight).unwrap();
    for bad in ["mc:mis", "mc:phong-1", "mc:ggx0", "bmc-foo", "bmc-se0", "bmc-sobolev3", "owen:", ":cosine", ""] {
        assert!(problem.method(bad).is_err(), "{bad:?}");
    }
    assert!(hemisphere("moon", 1.0, 0, Width::Eight).is_err() && hemisphere("cosine", -1.0, 0, Width::Eight).is_err());
    assert!(hemisphere("cosine", f64::NAN, 0, Width::Eight).is_err());
}

/// A learned density is unbiased, its measured variance is the predicted ∫F²/p − I², and it beats the cosine. 2,000
/// estimates of 16 samples: a bias of a tenth of a standard deviation, and a variance off by a fifth, would be seen.
#[test]
fn a_learned_density_has_the_variance_that_theory_gives_it() {
    for name in ["cos3", "sky", "edge", "sun"] {
        let problem = hemisphere(name, 1.0, 3, Width::Eight).unwrap();
        let s = super::study(&problem, &["mc:learned", "mc-is"], &[16], 2000, 7);
        let [learned, cosine] = [0, 1].map(|i| &s.rows[i].cells[0]);
        let ratio = learned.variance_ratio.unwrap();
        println!(
            "{name}: variance {:.2e}, {ratio:?} of the predicted, cosine {:.2e}",
            learned.variance, cosine.variance
        );
        assert!(!learned.biased, "{name}: z = {:?}", learned.z);
        // Four standard errors, eight such tests.
        assert!((ratio.value - 1.0).abs() < 4.0 * ratio.standard_error, "{name}: {ratio:?}");
        assert!(ratio.standard_error < 0.05, "{name}: {ratio:?}");
        assert!(learned.variance < cosine.variance, "{name}: {} {}", learned.variance, cosine.variance);
    }
}

/// Under a constant image, π; under one that is linear in the height, 2π/3 of it; with lanes as without.
#[test]
fn images_are_skies() {
    let image = |radiance: fn(f64) -> f64| {
        let (width, height) = (256, 128);
        let texel = |i: usize| [radiance((PI * ((i / width) as f64 + 0.5) / height as f64).cos()) as f32; 3];
        EnvironmentImage { width, height, texels: (0..width * height).map(texel).collect(), rotation: 0.0 }
    };
    let constant = hemisphere_of_image(&image(|_| 1.0), Width::Eight).unwrap();
    assert!((constant.quantity().exact - PI).abs() < 1e-6);
    // Chords of the cosine between texels lie below it by (π/128)²/8 at most, and its kink at 0 is a texel wide.
    let linear = hemisphere_of_image(&image(|c| c.max(0.0)), Width::Eight).unwrap();
    let exact = linear.quantity().exact;
    assert!((exact / (TAU / 3.0) - 1.0).abs() < 2e-4, "{exact}");
    let one = super::study(&linear, &["owen", "bmc-is"], &[64], 20, 1);
    let wide = hemisphere_of_image(&image(|c| c.max(0.0)), Width::Sixteen).unwrap();
    let two = super::study(&wide, &["owen", "bmc-is"], &[64], 20, 1);
    for (a, b) in one.rows.iter().zip(&two.rows) {
        assert_eq!(a.cells[0].mean.value.to_bits(), b.cells[0].mean.value.to_bits());
        assert!(a.cells[0].rmse.value < 0.01 * exact, "{}: {}", a.method, a.cells[0].rmse.value);
    }
    assert!(hemisphere_of_image(&image(|_| 0.0), Width::Eight).is_err());
}
