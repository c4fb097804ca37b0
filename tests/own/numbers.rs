//! Random numbers of a program's own.

use super::{same_bits, table, with_lamp};
use crate::equivalence::assert_same;
use octolux::Renderer;
use octolux::own::Numbers;
use octolux::sampling::dimensions::{BOUNCE, CAMERA};

/// A Kronecker sequence of the golden ratio, shifted by a hash of pixel and dimension.
struct Golden;

impl Numbers for Golden {
    fn number(&self, pixel: u32, sample: u32, dimension: u32) -> f32 {
        let mut h = pixel.wrapping_mul(0x9e37_79b9) ^ dimension.wrapping_mul(0x85eb_ca6b);
        h = (h ^ h >> 16).wrapping_mul(0x7feb_352d);
        h = (h ^ h >> 15).wrapping_mul(0x846c_a68b);
        let turned = (h ^ h >> 16).wrapping_add(sample.wrapping_mul(0x9e37_79b9));
        (turned >> 8) as f32 / 16_777_216.0
    }
}

/// The same number whatever is asked.
struct Always(f32);

impl Numbers for Always {
    fn number(&self, _pixel: u32, _sample: u32, _dimension: u32) -> f32 {
        self.0
    }
}

#[test]
fn own_numbers_give_the_same_bits_at_any_width() {
    for balls in [8, 70] {
        let scene = with_lamp(table(balls).0).build().expect("a scene");
        same_bits("golden ratio", |renderer| renderer.clone().numbers(Golden).render(&scene).expect("a film"));
    }
}

/// Without chance all samples of a pixel are one; what is no number in [0, 1) is held to it.
#[test]
fn numbers_are_used_and_held_to_their_range() {
    let scene = with_lamp(table(8).0).build().expect("a scene");
    let render = |u| Renderer::new(4).numbers(Always(u)).render(&scene).expect("a film");
    let film = render(0.5);
    for (x, y) in [(20, 15), (10, 20), (30, 25)] {
        assert_eq!(film.variance_of_mean(x, y), Some([0.0; 3]), "pixel {x}, {y}");
    }
    for (wrong, right) in [(f32::NAN, 0.0), (-3.0, 0.0), (1.0, 1.0 - f32::EPSILON / 2.0), (f32::INFINITY, 0.99999994)] {
        assert_same(&format!("{wrong}"), &render(wrong), &render(right));
    }
}

/// The camera's numbers come first, then twelve a bounce, of the pixel and sample that the film counts.
#[test]
fn dimensions_are_numbered_as_documented() {
    use std::collections::BTreeSet;
    use std::sync::{Arc, Mutex};
    type Asked = Arc<Mutex<BTreeSet<(u32, u32, u32)>>>;
    struct Seen(Asked);
    impl Numbers for Seen {
        fn number(&self, pixel: u32, sample: u32, dimension: u32) -> f32 {
            self.0.lock().expect("no panic").insert((pixel, sample, dimension));
            0.5
        }
    }
    let asked = Asked::default();
    let scene = table(8).0.build().expect("a scene");
    Renderer::new(3).numbers(Seen(asked.clone())).threads(1).render(&scene).expect("a film");
    let asked = asked.lock().expect("no panic");
    for pixel in 0..40 * 30 {
        for sample in 0..3 {
            assert!((0..CAMERA as u32).all(|d| asked.contains(&(pixel, sample, d))), "camera, pixel {pixel}");
        }
    }
    // The floor in the middle of the film is hit: its first bounce draws all its numbers.
    let middle = 20 * 40 + 20;
    assert!((0..BOUNCE).all(|d| asked.contains(&(middle, 2, (CAMERA + d) as u32))));
    assert!(asked.iter().all(|&(pixel, sample, d)| pixel < 40 * 30 && sample < 3 && d < (CAMERA + 8 * BOUNCE) as u32));
}
