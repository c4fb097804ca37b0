//! Russian roulette over lanes.

use super::path::Paths;
use super::probe::{Probe, Stage};
use super::world::World;
use crate::lane::{Mask, Real, Vec3};
use crate::scene::Integrator;

/// No path survives roulette more surely than this, unless it carries more than it started with.
const MAX_SURVIVAL: f32 = 0.95;

/// Russian roulette as the scene has it ([`Roulette`](crate::scene::Roulette)), by the largest channel of what is carried,
/// times η². Returns what it multiplied the paths by that go on.
///
/// With the cap alone, also above what the scene calls little, β would grow by 1/0.95 an event in a white room: almost every
/// path ends early, few carry nearly everything, and the variance has no bound (`check --numerics`, white cavity, prints what that gives).
#[inline(always)]
pub(super) fn roulette<R: Real, P: Probe>(
    world: &World,
    paths: &mut Paths<R>,
    carried: Vec3<R>,
    u: R,
    probe: &mut P,
) -> R {
    let carried = carried.max_component() * paths.eta_squared;
    let Some((plays, survival)) = world.roulette.survival(paths.bounce + R::one(), carried, paths.alive) else {
        return R::one();
    };
    let survival = probe.tap(Stage::Roulette, paths.lanes(plays), survival);
    let survives = u.lt(survival);
    paths.alive = paths.alive & (survives | !plays);
    let factor = R::select(plays & survives, survival.recip(), R::one());
    paths.beta = paths.beta * factor;
    factor
}

/// The scene's [`Roulette`](crate::scene::Roulette) as lanes use it.
#[derive(Clone, Copy, Debug)]
pub struct Roulette {
    after: f32,
    /// 1/`below`.
    scale: f32,
}

impl Roulette {
    pub(super) fn of(integrator: &Integrator) -> Self {
        let crate::scene::Roulette { after, below } = integrator.roulette;
        Roulette { after: after as f32, scale: below.recip() }
    }

    /// Lanes that play after `events` scattering events, and their probability to survive; `None` where none does.
    #[inline(always)]
    pub(super) fn survival<R: Real>(&self, events: R, carried: R, alive: R::Mask) -> Option<(R::Mask, R)> {
        let plays = alive & events.ge(R::splat(self.after));
        let carried = carried * R::splat(self.scale);
        let survival = R::select(carried.gt(R::one()), R::one(), carried.min_or(R::splat(MAX_SURVIVAL)));
        plays.any().then_some((plays, survival))
    }
}
