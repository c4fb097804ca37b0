//! Which method is best at 40 directions an estimate, and where it is not.

use super::{fresh, gather, gathered, smooth_sky, sphere_scene};
use crate::renders::{self, Set};
use octolux::estimate::bmc::Points;
use octolux::film::Film;
use octolux::scene::{Bsdf, Gather, GatherLights, GatherMethod, IntegratorKind, Scene};

/// RMSE over pixels and channels.
pub fn rmse(film: &Film, reference: &Film) -> f64 {
    let pixels = || (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
    let squares = pixels().flat_map(|(x, y)| {
        let (a, b) = (film.mean(x, y), reference.mean(x, y));
        [0, 1, 2].map(|c| (a[c] - b[c]).powi(2))
    });
    let count = f64::from(3 * film.width() * film.height());
    (squares.sum::<f64>() / count).sqrt()
}

/// 64 estimates a pixel of 1,024 Owen points each: without bias, and nearer to the truth under a smooth sky than as many
/// light samples.
fn truth(scene: &Scene) -> Film {
    let settings = fresh(GatherMethod::McIs, Points::Owen, GatherLights::Seen, 1024);
    renders::film(&renders::world(&gathered(scene, settings), 99), 64)
}

/// Errors of mc, mc-is, bmc and bmc-is at 40 directions. Random points for the first two, as the course has them.
fn errors(scene: &Scene) -> [f64; 4] {
    let reference = truth(scene);
    use GatherMethod::{Bmc, BmcIs, Mc, McIs};
    [Mc, McIs, Bmc, BmcIs].map(|method| {
        let points = if method.is_bayesian() { Points::Fibonacci } else { Points::Random };
        let settings = Gather { points, ..gather(method) };
        rmse(&renders::film(&renders::world(&gathered(scene, settings), 3), 1), &reference)
    })
}

/// A plane seen from near, so that no pixel holds a silhouette; half of its sky behind a sphere if wanted.
pub fn plane(half_hidden: bool) -> Scene {
    let mut set = Set::new([1.2, 1.0, 1.6], [0.9, 0.0, 0.6], 12.0, 24).bounces(1).environment(smooth_sky());
    let ground = set.material(Bsdf::Diffuse { reflectance: [0.6, 0.5, 0.4] }, [0.0; 3]);
    set.quad(ground, [[-6.0, 0.0, 6.0], [6.0, 0.0, 6.0], [6.0, 0.0, -6.0], [-6.0, 0.0, -6.0]]);
    if half_hidden {
        set.sphere(ground, [0.0, 1.0, -0.6], 1.0);
    }
    set.finish()
}

/// Nothing but the sky, which is smooth: BMC-IS errs by a tenth of MC-IS or less.
#[test]
fn bmc_is_wins_under_a_smooth_sky() {
    let [mc, mc_is, bmc, bmc_is] = errors(&plane(false));
    println!("smooth sky: mc {mc:.5}, mc-is {mc_is:.5}, bmc {bmc:.5}, bmc-is {bmc_is:.5}");
    assert!(mc_is < mc && bmc < mc_is, "{mc} {mc_is} {bmc}");
    assert!(bmc_is < bmc && bmc_is < 0.1 * mc_is, "{mc_is} {bmc} {bmc_is}");
}

/// The edge of what stands in the way is no part of the belief: BMC-IS is still the best, by less.
#[test]
fn bmc_is_wins_at_an_edge_by_less() {
    let [mc, mc_is, bmc, bmc_is] = errors(&plane(true));
    println!("an edge: mc {mc:.5}, mc-is {mc_is:.5}, bmc {bmc:.5}, bmc-is {bmc_is:.5}");
    assert!(bmc_is < bmc && bmc < mc_is && mc_is < mc, "{mc} {mc_is} {bmc} {bmc_is}");
    assert!(bmc_is > 0.1 * mc_is, "{mc_is} {bmc_is}");
}

/// A lamp is a discontinuity that few of 40 directions meet: the process models nothing of it, and better points give
/// what is left to gain. Light samples are what lamps need.
#[test]
fn no_gather_wins_under_a_lamp() {
    let mut scene = sphere_scene(24, true).finish();
    scene.environment = None;
    let [.., mc_is, _, bmc_is] = errors(&scene);
    let mut direct = scene.clone();
    direct.integrator.kind = IntegratorKind::Direct;
    let reference = renders::film(&renders::world(&direct, 99), 4096);
    let path = rmse(&renders::film(&renders::world(&direct, 4), 40), &reference);
    println!("lamp: mc-is {mc_is:.5}, bmc-is {bmc_is:.5}, direct at 40 samples {path:.5}");
    assert!(bmc_is > 0.25 * mc_is && path < bmc_is, "{mc_is} {bmc_is} {path}");
}
