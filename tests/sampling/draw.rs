//! Values drawn eight at a time, as the kernel does, handed out one at a time.

use octolux::lane::f32x8;
use octolux::sampling::Xoshiro;

/// One value at a time of what `draw` makes eight at a time.
pub fn one_by_one<T>(seed: u64, mut draw: impl FnMut(&mut Xoshiro<f32x8>) -> [T; 8]) -> impl FnMut() -> T {
    let mut rng = Xoshiro::from_keys(|lane| seed << 8 | lane as u64);
    let mut left = Vec::new();
    move || {
        if left.is_empty() {
            left.extend(draw(&mut rng));
            left.reverse();
        }
        left.pop().unwrap()
    }
}
